//! The checksums by which changes of files are noticed.

/// The checksum of a file's bytes, as other files hold it. It is CRC-32. A chunk ends with its own CRC-32C, and the CRC-32C of such
/// bytes is the same for all chunks of one length.
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}
