//! Operands of the vector unit at the edges of every operation: extreme values, ties of the
//! rounding, ends of the ranges of exponentials.

use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::vector_drive::VectorBatch;

/// An operation with its operands.
pub(super) struct Batch {
    pub(super) op: VectorOp,
    pub(super) a: Vec<i32>,
    pub(super) b: Vec<i32>,
}

impl Batch {
    pub(super) fn borrowed(&self) -> VectorBatch<'_> {
        VectorBatch {
            op: self.op,
            a: &self.a,
            b: &self.b,
        }
    }
}

/// Least elements of an exponential.
const ELEMENTS: usize = 600;
/// Most between the bits of a sum of two powers of two that is a product of two operands.
const APART: u32 = 29;
const ROUNDINGS: [Rounding; 3] = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven];

/// Batches of every job: one for each operation, and one that changes between them.
pub(super) fn jobs(config: &Config, seed: u64) -> Vec<Vec<Batch>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let lanes = config.vu.lanes as usize;
    let mut jobs = vec![];
    for &code in &config.vu.ops {
        let mut batches = vec![];
        if code.is_exponential() {
            let op = VectorOp::new(code);
            batches.push(exponential(
                &mut random,
                config,
                op,
                ELEMENTS.max(2 * lanes + 1),
            ));
        } else {
            for (i, shift) in [0, 1, 7, 16, 31, 32, 33, 62, 63].into_iter().enumerate() {
                let rounding = ROUNDINGS[i % 3];
                let op = VectorOp {
                    code,
                    shift,
                    rounding,
                };
                batches.push(element_wise(&mut random, op, lanes));
            }
        }
        jobs.push(batches);
    }
    let mut mixed = vec![];
    for i in 0..3 * config.vu.ops.len() {
        let code = config.vu.ops[random.random_range(0..config.vu.ops.len())];
        let elements = 1 + i % (lanes + 1);
        mixed.push(if code.is_exponential() {
            exponential(&mut random, config, VectorOp::new(code), elements)
        } else {
            let op = VectorOp {
                code,
                shift: random.random_range(0..40),
                rounding: ROUNDINGS[random.random_range(0..3)],
            };
            element_wise(&mut random, op, elements)
        });
    }
    jobs.push(mixed);
    let built = |code| config.vu.ops.contains(&code);
    let mut ties = ties();
    ties.retain(|batch| built(batch.op.code));
    if !ties.is_empty() {
        jobs.push(ties);
    }
    if built(OpCode::Multiply) {
        jobs.push(vec![saturation()]);
    }
    jobs
}

/// Operands that are extreme, small, powers of two, or half-way between two results.
fn element_wise(random: &mut Pcg64Mcg, op: VectorOp, elements: usize) -> Batch {
    let half = u32::from(op.shift).saturating_sub(1).min(30);
    let mut operand = |_| match random.random_range(0..10) {
        0 => i32::MIN,
        1 => i32::MAX,
        2 => random.random_range(-2..=2),
        3 => 1 << random.random_range(0..31),
        4 | 5 => random.random_range(-3i32..=3).wrapping_shl(half),
        6 => random.random_range(-(1 << 16)..=1 << 16),
        _ => random.random(),
    };
    let a = (0..elements).map(&mut operand).collect();
    let b = (0..elements).map(&mut operand).collect();
    Batch { op, a, b }
}

/// Values of two bits, of which one is a half: the other one decides the rounding to even alone. Squares
/// where both bits are even or odd, else products, as far apart as they can be.
fn ties() -> Vec<Batch> {
    let shifts = [3u8, 9, 17, 24, 31, 38, 45, 52, 59, 61].into_iter();
    let batches = shifts.flat_map(|shift| {
        let half = u32::from(shift) - 1;
        let others = (0..=60).filter(move |other| *other != half);
        let (squares, products): (Vec<u32>, Vec<u32>) =
            others.partition(|other| other.abs_diff(half) % 2 == 0);
        let squares = squares
            .into_iter()
            .map(move |other| squares_of_powers(half, other));
        let products = products
            .into_iter()
            .filter(move |other| other.abs_diff(half) <= APART);
        let products = products.map(move |other| sum_of_powers(half.min(other), half.max(other)));
        let op = |code| VectorOp {
            code,
            shift,
            rounding: Rounding::HalfEven,
        };
        [
            (op(OpCode::SquareSum), squares.unzip()),
            (op(OpCode::Multiply), products.unzip()),
        ]
    });
    batches.map(|(op, (a, b))| Batch { op, a, b }).collect()
}

/// Operands of which the sum of the squares is 2^first + 2^second, both even or both odd.
fn squares_of_powers(first: u32, second: u32) -> (i32, i32) {
    let (x, y) = (1 << (first / 2), 1 << (second / 2));
    match first % 2 {
        0 => (x, y),
        // (x + y)^2 + (x - y)^2 = 2 x^2 + 2 y^2.
        _ => (x + y, x - y),
    }
}

/// Products that one bit alone keeps from fitting into 32 bits: 2^n, and -2^n with one more bit below.
fn saturation() -> Batch {
    let of_power = |n: u32| (1i32 << n.min(30), 1i32 << (n - n.min(30)));
    let below = |n: u32| {
        let (a, b) = sum_of_powers(n.saturating_sub(APART), n);
        (-a, b)
    };
    let (a, b) = (31..61).flat_map(|n| [of_power(n), below(n)]).unzip();
    Batch {
        op: VectorOp::new(OpCode::Multiply),
        a,
        b,
    }
}

/// Factors of 2^low + 2^high, where high is at most 60, and at most `APART` above low.
fn sum_of_powers(low: u32, high: u32) -> (i32, i32) {
    let of_first = low.min(30);
    (1 << of_first, ((1 << (high - low)) + 1) << (low - of_first))
}

/// Arguments at the ends of the range and of every power of two, and between.
fn exponential(random: &mut Pcg64Mcg, config: &Config, op: VectorOp, elements: usize) -> Batch {
    let exp = &config.vu.exp;
    let bits = match op.code {
        OpCode::OneMinusExp => 4 + exp.one_minus_frac_bits,
        OpCode::Sigmoid | OpCode::Softplus => 6 + exp.input.frac_bits(),
        _ => exp.input.width(),
    };
    let top = 1i32 << bits.min(30);
    let mut edges = vec![
        0,
        1,
        -1,
        top - 1,
        top,
        top + 1,
        -top,
        1 - top,
        i32::MIN,
        i32::MAX,
    ];
    for power in (1..bits.min(30)).rev() {
        let power = 1 << power;
        edges.extend([power - 1, power, -power, power + 1, 1 - power]);
    }
    let step = edges.len().div_ceil(elements / 2 + 1);
    let chosen = edges.iter().enumerate();
    // The ends always, and as many of the others as half of the elements hold.
    let chosen = chosen.filter(|(i, _)| *i < 10 || i.is_multiple_of(step));
    let mut a: Vec<i32> = chosen.map(|(_, edge)| *edge).take(elements).collect();
    while a.len() < elements {
        a.push(match random.random_range(0..4) {
            0 => random.random_range(0..=top / 64),
            1 => -random.random_range(0..top),
            _ => random.random_range(0..top),
        });
    }
    let b = a.iter().map(|_| random.random()).collect();
    Batch { op, a, b }
}
