//! Seeded choices, and values at which readers tend to fail.

use rand::Rng as _;
use rand_pcg::Pcg64;

/// Numbers at the limits of types and meanings.
const FLOATS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    640.0,
    1e-9,
    1e9,
    1e19,
    -1e19,
    88.0,
    -104.0,
    5e-324,
    1e-40,
    f32::MIN_POSITIVE as f64,
    f32::MAX as f64,
    3.5e38,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];
const INTEGERS: [i128; 24] = [
    0,
    1,
    -1,
    2,
    3,
    4,
    5,
    7,
    127,
    128,
    255,
    256,
    65_535,
    65_536,
    i32::MAX as i128,
    i32::MIN as i128,
    1 << 31,
    u32::MAX as i128,
    1 << 32,
    (1 << 53) + 1,
    i64::MAX as i128,
    i64::MIN as i128,
    u64::MAX as i128,
    1 << 64,
];

/// Characters of a long text.
pub(crate) const LONG: usize = 5000;

/// The source of a mutant's choices, determined by name and number.
pub(crate) struct Rng(Pcg64);

impl Rng {
    pub(crate) fn new(name: &str, number: u64) -> Self {
        let stream = name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Self(Pcg64::new(number.into(), stream.into()))
    }

    /// Below `count`, which is above 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// One time in `times`.
    pub(crate) fn one_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    pub(crate) fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    /// Mostly one, seldom more: changes of a mutant.
    pub(crate) fn few(&mut self) -> usize {
        *self.pick(&[1, 1, 1, 1, 2, 2, 3])
    }

    /// An edge, or near the number.
    pub(crate) fn float(&mut self, near: f64) -> f64 {
        match self.below(8) {
            0 => -near,
            1 => near + 1.0,
            2 => near * 1000.0,
            3 => near * 1e-3,
            _ => *self.pick(&FLOATS),
        }
    }

    /// An edge, or near the number.
    pub(crate) fn integer(&mut self, near: i128) -> i128 {
        match self.below(8) {
            0 => near.saturating_neg(),
            1 => near.saturating_add(1),
            2 => near.saturating_sub(1),
            3 => near.saturating_mul(2),
            _ => *self.pick(&INTEGERS),
        }
    }

    /// An unusual text.
    pub(crate) fn text(&mut self, near: &str) -> String {
        match self.below(12) {
            0 => String::new(),
            1 => "x".repeat(LONG),
            2 => format!("{near}\u{e9}\u{1f600}\u{202e}"),
            3 => format!("\u{feff}{near}"),
            4 => near.to_uppercase(),
            5 => format!(" {near} "),
            6 => "../../x".to_owned(),
            7 => "/dev/null".to_owned(),
            8 => "nan".to_owned(),
            9 => "1".to_owned(),
            10 => near.chars().skip(1).collect(),
            _ => format!("{near}\0"),
        }
    }

    /// Damage without structure: truncated, flipped or extended bytes.
    pub(crate) fn damage(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let at = self.below(bytes.len());
        match self.below(5) {
            0 => bytes.truncate(at),
            1 => bytes[at] = self.below(256) as u8,
            2 => bytes[at] ^= 1 << self.below(8),
            3 => bytes.extend_from_within(at..),
            _ => drop(bytes.remove(at)),
        }
    }
}
