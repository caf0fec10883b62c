//! Encoding of values as bytes: numbers of fixed width, lengths before lists.

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use crate::node::{Binary, Ty, Unary};

/// Bytes on their way into a hash.
pub(super) struct Encoding(blake3::Hasher);

impl Encoding {
    pub(super) fn new(version: &str) -> Self {
        let mut own = Self(blake3::Hasher::new());
        own.text(version);
        own
    }

    pub(super) fn finish(self) -> blake3::Hash {
        self.0.finalize()
    }

    /// Kind of the encoded part that follows.
    pub(super) fn tag(&mut self, tag: u8) {
        self.0.update(&[tag]);
    }

    pub(super) fn flag(&mut self, flag: bool) {
        self.tag(u8::from(flag));
    }

    pub(super) fn number(&mut self, number: usize) {
        self.0.update(&(number as u64).to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.number(bytes.len());
        self.0.update(bytes);
    }

    pub(super) fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    pub(super) fn hash(&mut self, hash: blake3::Hash) {
        self.bytes(hash.as_bytes());
    }

    pub(super) fn big(&mut self, value: &BigInt) {
        self.bytes(&value.to_signed_bytes_le());
    }

    pub(super) fn ty(&mut self, ty: Ty) {
        self.number(ty.width as usize);
        self.flag(ty.signed);
    }

    pub(super) fn unary(&mut self, operator: Unary) {
        self.tag(match operator {
            Unary::Not => 0,
            Unary::Neg => 1,
            Unary::Any => 2,
            Unary::All => 3,
            Unary::Parity => 4,
        });
    }

    pub(super) fn binary(&mut self, operator: Binary) {
        self.tag(match operator {
            Binary::And => 0,
            Binary::Or => 1,
            Binary::Xor => 2,
            Binary::Add => 3,
            Binary::Sub => 4,
            Binary::Mul => 5,
            Binary::Eq => 6,
            Binary::Ne => 7,
            Binary::Lt => 8,
            Binary::Le => 9,
        });
    }

    pub(super) fn rounding(&mut self, rounding: Rounding) {
        self.tag(match rounding {
            Rounding::Floor => 0,
            Rounding::HalfUp => 1,
            Rounding::HalfEven => 2,
        });
    }
}
