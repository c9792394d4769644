//! Passes the memory map of the board named by `COMPASS_BOARD` to the linker script of cortex-m-rt.

use std::{env, fs, path::PathBuf};

fn main() {
    println!("cargo::rerun-if-env-changed=COMPASS_BOARD");
    println!("cargo::rerun-if-changed=boards");
    let board = env::var("COMPASS_BOARD").unwrap_or_else(|_| "an500".into());
    let map = PathBuf::from("boards").join(format!("{board}.x"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(error) = fs::copy(&map, out.join("memory.x")) {
        println!("cargo::error=no memory map {} for COMPASS_BOARD={board}: {error}", map.display());
    }
    println!("cargo::rustc-env=COMPASS_BOARD={board}");
    println!("cargo::rustc-link-search={}", out.display());
    for images in ["bins", "examples"] {
        println!("cargo::rustc-link-arg-{images}=-Tlink.x");
        println!("cargo::rustc-link-arg-{images}=--nmagic");
    }
}
