//! Checksum of the file formats, and the sink they are written to.

/// Tables of a checksum: one of 1 KiB, or 16 of them, by which 16 bytes are taken at once.
type Tables = crc::Table<{ if cfg!(feature = "large-tables") { 16 } else { 1 } }>;

/// CRC-32 ISO-HDLC, as in zip and PNG: the checksum of all file formats.
pub(crate) static CRC32: crc::Crc<u32, Tables> = crc::Crc::<u32, Tables>::new(&crc::CRC_32_ISO_HDLC);

/// Destination of written bytes.
///
/// ```
/// use compass_core::base::crc::Sink;
///
/// struct Count(usize);
///
/// impl Sink for Count {
///     type Error = core::convert::Infallible;
///     fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
///         self.0 += bytes.len();
///         Ok(())
///     }
/// }
///
/// let mut count = Count(0);
/// let Ok(()) = count.append(&[1, 2, 3]);
/// assert_eq!(count.0, 3);
/// ```
pub trait Sink {
    /// Error of a failed append.
    type Error;

    /// Appends bytes.
    ///
    /// # Errors
    /// The error of the sink.
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;
}

impl<S: Sink> Sink for &mut S {
    type Error = S::Error;
    fn append(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        (**self).append(bytes)
    }
}

/// A sink, with the checksum of all bytes appended to it.
pub(crate) struct Summed<S> {
    sink: S,
    digest: crc::Digest<'static, u32, Tables>,
}

impl<S: core::fmt::Debug> core::fmt::Debug for Summed<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Summed").field("sink", &self.sink).finish_non_exhaustive()
    }
}

impl<S: Sink> Summed<S> {
    pub(crate) fn new(sink: S) -> Self {
        Self { sink, digest: CRC32.digest() }
    }

    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        self.digest.update(bytes);
        self.sink.append(bytes)
    }

    /// Appends the checksum of all bytes before it and returns the sink.
    pub(crate) fn finish(mut self) -> Result<S, S::Error> {
        let crc = self.digest.finalize().to_le_bytes();
        self.sink.append(&crc)?;
        Ok(self.sink)
    }
}
