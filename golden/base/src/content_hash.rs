//! Content hashes of values.

use std::io;

use serde::Serialize;

/// A hash of a value's `MessagePack` encoding: numbers bit by bit, fields by name. Values that
/// differ in anything encoded have different hashes.
#[must_use]
pub fn hash_of(value: &(impl Serialize + ?Sized)) -> blake3::Hash {
    let mut hashed = Hashed(blake3::Hasher::new());
    let written = {
        let buffered = io::BufWriter::with_capacity(1 << 16, &mut hashed);
        let mut to = rmp_serde::Serializer::new(buffered).with_struct_map();
        let written = value.serialize(&mut to);
        let flushed = io::Write::flush(to.get_mut());
        written.is_ok() && flushed.is_ok()
    };
    if !written {
        // A value that cannot be written is like no other, itself included.
        let now = std::time::SystemTime::now();
        let since = now.duration_since(std::time::UNIX_EPOCH);
        let nanoseconds = since.unwrap_or_default().as_nanos();
        hashed.0.update(&nanoseconds.to_le_bytes());
    }
    hashed.0.finalize()
}

struct Hashed(blake3::Hasher);

impl io::Write for Hashed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_apart_by_their_bits() {
        assert_ne!(hash_of(&0.0_f32), hash_of(&-0.0_f32));
        assert_ne!(hash_of(&1.0_f32), hash_of(&1.0_f64));
        assert_ne!(hash_of(&f64::NAN), hash_of(&f64::INFINITY));
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        assert_ne!(hash_of(&1.0), hash_of(&next));
        assert_eq!(hash_of(&[1, 2]), hash_of(&vec![1, 2]));
        assert_ne!(hash_of(&(vec![1], vec![2])), hash_of(&(vec![1, 2], [0; 0])));
    }
}
