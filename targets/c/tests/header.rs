//! The header says what the library has.

use std::path::Path;
use std::{env, fs};

#[test]
fn the_header_is_that_of_the_source() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(directory.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in ["status.rs", "settings.rs", "prior.rs", "types.rs", "compass.rs", "functions.rs"] {
        builder = builder.with_src(directory.join("src").join(source));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    // How Rust callers would be bound is nothing to those in C.
    let text = String::from_utf8(made).unwrap();
    let file = directory.join("include/compass.h");
    if env::var_os("REGENERATE").is_some() {
        fs::write(&file, &text).unwrap();
    }
    assert_eq!(
        fs::read_to_string(file).unwrap(),
        text,
        "make it anew with REGENERATE=1 cargo test --test header"
    );
}
