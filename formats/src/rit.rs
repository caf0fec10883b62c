//! The ray index table (RIT): content and packing of its entries.
//!
//! An entry selects the rows of the MVoxel feature table that make one feature vector (paper, Sec.
//! "Hardware Support"). A structured entry is `V` words of {32-bit id, 16-bit weight}; an
//! unstructured one is a single id. An id is {tag 16, row 16}. The tag of word 0 is opaque to the
//! unit and is returned with the features, which identifies them.

use thiserror::Error;

/// Bytes of one {id, weight} word of a structured entry.
pub const WORD_BYTES: usize = 6;
/// Bytes of an unstructured entry: one id.
pub(crate) const ID_BYTES: usize = 4;
/// Largest number of vertices of an entry.
pub const MAX_VERTICES: usize = 8;

/// Vertices of an entry, which determine its packing and its issue cycles.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(try_from = "u8", into = "u8")]
pub enum Vertices {
    /// One id without weight: a Gaussian. It bypasses the reducers.
    One,
    /// A line of a factorised tensor.
    Two,
    /// A plane of a factorised tensor.
    Four,
    /// A voxel.
    Eight,
}

impl Vertices {
    /// All sizes, smallest first.
    pub const ALL: [Self; 4] = [Self::One, Self::Two, Self::Four, Self::Eight];

    /// The number: 1, 2, 4 or 8. It is also the number of issue cycles.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }

    /// Base-2 logarithm of the number, the code on `cfg_vertices`.
    #[must_use]
    pub const fn log2(self) -> u32 {
        self.count().trailing_zeros()
    }

    /// Whether entries have weights: all but single ids.
    #[must_use]
    pub const fn is_structured(self) -> bool {
        !matches!(self, Self::One)
    }

    /// Bytes of one entry.
    #[must_use]
    pub const fn entry_bytes(self) -> usize {
        match self {
            Self::One => ID_BYTES,
            _ => self.count() * WORD_BYTES,
        }
    }
}

impl TryFrom<u8> for Vertices {
    type Error = String;
    fn try_from(count: u8) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|v| v.count() == usize::from(count))
            .ok_or_else(|| format!("{count} vertices an entry: expected 1, 2, 4 or 8"))
    }
}

impl From<Vertices> for u8 {
    fn from(v: Vertices) -> Self {
        v.count() as Self
    }
}

/// One entry: rows to read, with weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct RitEntry {
    /// Destination of the features: the ray sample's slot, or the tile number. Bits 15..0 are in
    /// the tag of word 0, bits 31..16 in that of word 1.
    pub slot: u32,
    /// Rows of the MFT; the first `V` are used.
    pub rows: [u16; MAX_VERTICES],
    /// Weights as right-aligned U1.W codes; the first `V` are used, none for `V = 1`.
    pub weights: [u16; MAX_VERTICES],
}

/// Why an entry cannot be packed or unpacked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RitError {
    /// The length is not a multiple of the entry's.
    #[error("{bytes} bytes: expected a whole number of RIT entries of {entry} bytes")]
    Ragged {
        /// Bytes given.
        bytes: usize,
        /// Bytes of an entry.
        entry: usize,
    },
    /// The slot exceeds the tag of a single-id entry.
    #[error(
        "slot {slot} does not fit the 16-bit tag of a single-id RIT entry: \
         unstructured groups hold at most 65536 slots, use a smaller ray group"
    )]
    Slot {
        /// The slot.
        slot: u32,
    },
}

impl RitEntry {
    /// Appends the packed entry, little-endian.
    ///
    /// # Errors
    /// A slot above 65,535 in an unstructured entry.
    pub fn pack(&self, vertices: Vertices, bytes: &mut Vec<u8>) -> Result<(), RitError> {
        if !vertices.is_structured() && self.slot > 0xffff {
            return Err(RitError::Slot { slot: self.slot });
        }
        for v in 0..vertices.count() {
            let tag = match v {
                0 => self.slot & 0xffff,
                1 => self.slot >> 16,
                _ => 0,
            };
            let id = tag << 16 | u32::from(self.rows[v]);
            bytes.extend_from_slice(&id.to_le_bytes());
            if vertices.is_structured() {
                bytes.extend_from_slice(&self.weights[v].to_le_bytes());
            }
        }
        Ok(())
    }

    /// Unpacks the output of [`RitEntry::pack`].
    ///
    /// # Errors
    /// A length that is no whole number of entries.
    #[cfg(test)]
    pub(crate) fn unpack_all(vertices: Vertices, bytes: &[u8]) -> Result<Vec<Self>, RitError> {
        let size = vertices.entry_bytes();
        if !bytes.len().is_multiple_of(size) {
            return Err(RitError::Ragged {
                bytes: bytes.len(),
                entry: size,
            });
        }
        let word = if vertices.is_structured() {
            WORD_BYTES
        } else {
            ID_BYTES
        };
        Ok(bytes
            .chunks_exact(size)
            .map(|entry| {
                let mut out = Self {
                    slot: 0,
                    rows: [0; MAX_VERTICES],
                    weights: [0; MAX_VERTICES],
                };
                for (v, w) in entry.chunks_exact(word).enumerate() {
                    out.rows[v] = u16::from_le_bytes([w[0], w[1]]);
                    let tag = u32::from(u16::from_le_bytes([w[2], w[3]]));
                    match v {
                        0 => out.slot |= tag,
                        1 => out.slot |= tag << 16,
                        _ => {}
                    }
                    if vertices.is_structured() {
                        out.weights[v] = u16::from_le_bytes([w[4], w[5]]);
                    }
                }
                out
            })
            .collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn entry_sizes_are_the_papers() {
        let sizes: Vec<_> = Vertices::ALL.iter().map(|v| v.entry_bytes()).collect();
        assert_eq!(sizes, [4, 12, 24, 48]);
        assert_eq!(6144 / Vertices::Eight.entry_bytes(), 128);
        assert_eq!(6144 / Vertices::One.entry_bytes(), 1536);
    }

    #[test]
    fn the_id_holds_the_row_low_and_the_tag_high() {
        let mut e = RitEntry {
            slot: 0x1_beef,
            rows: [0; 8],
            weights: [0; 8],
        };
        e.rows[0] = 0x0123;
        e.weights[0] = 0x8000;
        let mut bytes = Vec::new();
        e.pack(Vertices::Two, &mut bytes).unwrap();
        assert_eq!(
            bytes,
            [0x23, 0x01, 0xef, 0xbe, 0x00, 0x80, 0, 0, 0x01, 0, 0, 0]
        );
        assert_eq!(
            e.pack(Vertices::One, &mut bytes),
            Err(RitError::Slot { slot: 0x1_beef })
        );
    }

    proptest! {
        #[test]
        fn entries_read_back(slot in any::<u32>(), rows in any::<[u16; 8]>(), weights in any::<[u16; 8]>(), which in 0usize..4) {
            let vertices = Vertices::ALL[which];
            let mut entry = RitEntry { slot, rows, weights };
            for v in vertices.count()..8 { entry.rows[v] = 0; entry.weights[v] = 0; }
            if !vertices.is_structured() { entry.slot &= 0xffff; entry.weights = [0; 8]; }
            let mut bytes = Vec::new();
            entry.pack(vertices, &mut bytes).unwrap();
            prop_assert_eq!(bytes.len(), vertices.entry_bytes());
            prop_assert_eq!(RitEntry::unpack_all(vertices, &bytes).unwrap(), vec![entry]);
            bytes.pop();
            prop_assert!(RitEntry::unpack_all(vertices, &bytes).is_err());
        }
    }
}
