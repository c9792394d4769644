//! Flash and RAM use of the image, by the symbols of cortex-m-rt's linker script.

unsafe extern "C" {
    static __stext: u32;
    static __etext: u32;
    static __srodata: u32;
    static __erodata: u32;
    static __sdata: u32;
    static __ebss: u32;
}

/// Bytes of an image.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// Instructions, in flash.
    pub code: usize,
    /// Constants, in flash, without the initial values of variables: those depend on how they are constructed.
    pub constants: usize,
    /// Static variables, in RAM.
    pub variables: usize,
}

/// The sizes of this image.
#[must_use]
pub fn sizes() -> Sizes {
    let bytes = |start: *const u32, end: *const u32| end as usize - start as usize;
    Sizes {
        code: bytes(&raw const __stext, &raw const __etext),
        constants: bytes(&raw const __srodata, &raw const __erodata),
        variables: bytes(&raw const __sdata, &raw const __ebss),
    }
}
