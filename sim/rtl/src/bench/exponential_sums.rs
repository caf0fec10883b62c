//! Checksums of an exponential's results over all operands, which its bench and its functions in C and
//! Python are compared with.

use std::fmt::Write as _;

use potamoi_formats::config::ExpConfig;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_units::exponential::result_bits;

/// Operands of one checksum.
pub(super) const BLOCK: u32 = 256;
/// Start and factor of a checksum, those of FNV-1a over whole results.
pub(super) const FNV: [u32; 2] = [0x811c_9dc5, 0x0100_0193];
/// Their file, a checksum a line.
pub(super) const FILE: &str = "exponential_sums.hex";

/// All operands, in the order of their unsigned codes.
pub(super) fn operands(exp: &ExpConfig) -> Vec<i32> {
    let bits = exp.input.width();
    let operand = |code: u32| match exp.input.is_signed() {
        true => (code << (32 - bits)) as i32 >> (32 - bits),
        false => code as i32,
    };
    (0..1 << bits).map(operand).collect()
}

/// The bits of a result that the module has.
pub(super) const fn mask(exp: &ExpConfig) -> u32 {
    u32::MAX >> (32 - result_bits(exp))
}

/// Text of the file, by the golden reference.
pub(super) fn text(exp: &ExpConfig, operands: &[i32]) -> String {
    let reference = ReferenceExponential::new(exp);
    let mut sums = String::new();
    for block in operands.chunks(BLOCK as usize) {
        let of = block.iter().fold(FNV[0], |sum, operand| {
            (sum ^ (reference.exp(*operand) as u32 & mask(exp))).wrapping_mul(FNV[1])
        });
        // Writing to a string does not fail.
        let _ = writeln!(sums, "{of:08x}");
    }
    sums
}
