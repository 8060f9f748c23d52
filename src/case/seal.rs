//! The first 512 bytes of a case file, which HDF5 leaves to its user: length and checksum of all that follows.
//!
//! They are checked before the HDF5 library sees a byte, because that library may crash on damaged structures where we
//! have to name the file and go on. A checksum inside the HDF5 structure could only be read by trusting the structure.

use super::hash;
use std::io::Read;

/// Length of the seal: the smallest user block that HDF5 allows.
pub(super) const LENGTH: usize = 512;

/// Version of the layout of case files.
const FORMAT: u32 = 1;

const MAGIC: &str = "thinshell case file\n";

/// Writes the seal into the first bytes of `image`, a whole file with room for it.
pub(super) fn put(image: &mut [u8]) {
    let (head, body) = image.split_at_mut(LENGTH);
    head.copy_from_slice(&render(FORMAT, body.len() as u64, &hash::bytes(body)));
}

/// Reads a whole file and compares it with its seal. The inner error says what is wrong with the file.
pub(super) fn check(file: &mut impl Read) -> std::io::Result<Result<(), String>> {
    let mut head = Vec::with_capacity(LENGTH);
    file.take(LENGTH as u64).read_to_end(&mut head)?;
    let (checksum, length) = hash::stream(file)?;
    if head == render(FORMAT, length, &checksum) {
        return Ok(Ok(()));
    }
    Ok(Err(explain(&head, length)))
}

fn render(format: u32, length: u64, checksum: &str) -> [u8; LENGTH] {
    let text = format!("{MAGIC}format {format}\nbytes {length}\nxxh3-128 {checksum}\n");
    let mut head = [0; LENGTH];
    head[..text.len()].copy_from_slice(text.as_bytes());
    head
}

/// What is wrong with a file that does not agree with its seal.
fn explain(head: &[u8], length: u64) -> String {
    if head.is_empty() {
        return "is empty".into();
    }
    if head.starts_with(b"\x89HDF\r\n\x1a\n") {
        return "is an HDF5 file, but not one of this program".into();
    }
    if !head.starts_with(MAGIC.as_bytes()) {
        return if MAGIC.as_bytes().starts_with(head) { "is cut off".into() } else { "is not a file of this program".into() };
    }
    let text = String::from_utf8_lossy(head);
    let value = |key: &str| text.lines().find_map(|l| l.strip_prefix(key)).and_then(|v| v.parse::<u64>().ok());
    match (value("format "), value("bytes ")) {
        (Some(format), _) if format != u64::from(FORMAT) => {
            format!("has format version {format}; this program reads version {FORMAT}")
        }
        (_, Some(bytes)) if length < bytes => format!("is cut off: {length} of {bytes} bytes are left"),
        _ => "is damaged: its contents do not agree with its checksum".into(),
    }
}
