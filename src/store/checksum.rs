//! The checksums by which changes of files are noticed.

/// The checksum of a file's bytes, as other files hold it: CRC-32, not CRC-32C, of which every chunk would have the same, since chunks
/// end with their own CRC-32C.
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}
