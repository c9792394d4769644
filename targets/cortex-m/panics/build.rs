//! A bare image: nothing but what `_start` needs.

fn main() {
    println!("cargo::rustc-link-arg-bins=--gc-sections");
}
