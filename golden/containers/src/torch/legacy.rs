//! The format of `torch.save` before PyTorch 1.6, which it still uses for a storage pickled on its
//! own: five consecutive pickles (a constant, the version, sizes of types, the object, the keys of
//! its storages), and then the count and the numbers of each storage.

use super::pickle;
use super::value::{Kind, Value};

/// The pickles of the constant and of version 1001.
const HEAD: &[u8] = b"\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.\x80\x02M\xe9\x03.";

/// Whether a file begins with this format.
pub(super) fn is_head(bytes: &[u8]) -> bool {
    bytes.starts_with(HEAD)
}

/// The only storage of a file: kind, count, and offset of its numbers.
///
/// # Errors
/// The file is not in this format, holds something else, or has fewer numbers than it declares.
pub(super) fn storage(bytes: &[u8]) -> Result<(Kind, usize, usize), String> {
    let skip = |from: usize| pickle::read_inner(&bytes[from..]);
    if !is_head(bytes) {
        return Err("a storage without the head that PyTorch gives it".to_owned());
    }
    let mut at = HEAD.len();
    at += skip(at)?.2;
    let (arena, root, taken) = skip(at)?;
    at += taken;
    at += skip(at)?.2;
    let Value::Storage(storage) = root else {
        return Err(format!("{} where a storage is expected", root.kind()));
    };
    let storage = &arena.storages[storage];
    let from = at + 8;
    let rest = bytes.get(at..from).zip(bytes.get(from..));
    let (count, rest) = rest.ok_or("a storage that ends before its numbers")?;
    let size = storage.count.checked_mul(storage.kind.bytes());
    if count != (storage.count as u64).to_le_bytes() || size.is_none_or(|n| n > rest.len()) {
        let (told, held) = (storage.count, rest.len());
        return Err(format!(
            "a storage of {told} numbers with {held} bytes of them"
        ));
    }
    Ok((storage.kind, storage.count, from))
}
