//! Hashes that tie a file to what it was made from.
//!
//! Each file of a case carries the hash of its inputs: `mesh.h5` that of the scene's mesh parts, `setup.h5` that of `mesh.h5`
//! and of the scene, and so on. They find accidents and outdated files; they are no defence against a forger.

use crate::error::{Error, Result};
use std::io::Read;
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

/// Hash of a list of byte strings: 128-bit xxh3 as 32 hexadecimal digits.
///
/// The length of each part enters, so that moving a byte from one part to the next changes the hash.
pub fn of(parts: &[&[u8]]) -> String {
    let mut hasher = Xxh3::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hex(hasher.digest128())
}

/// Hash of a file's bytes: 128-bit xxh3 as 32 hexadecimal digits. Errors: [`Error::Io`] if it cannot be read.
pub fn file(path: &Path) -> Result<String> {
    let mut file = std::fs::File::open(path).map_err(|e| Error::io("read", path, e))?;
    stream(&mut file).map(|(hash, _)| hash).map_err(|e| Error::io("read", path, e))
}

/// Hash of plain bytes, equal to that of a file with these contents.
pub(super) fn bytes(bytes: &[u8]) -> String {
    hex(xxhash_rust::xxh3::xxh3_128(bytes))
}

/// Hash and number of the bytes left in `source`, whatever it says of its size.
pub(super) fn stream(source: &mut impl Read) -> std::io::Result<(String, u64)> {
    let mut hasher = Xxh3::new();
    let mut buffer = vec![0; 1 << 18];
    let mut length = 0;
    loop {
        match source.read(&mut buffer) {
            Ok(0) => return Ok((hex(hasher.digest128()), length)),
            Ok(n) => {
                hasher.update(&buffer[..n]);
                length += n as u64;
            }
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}

fn hex(digest: u128) -> String {
    format!("{digest:032x}")
}
