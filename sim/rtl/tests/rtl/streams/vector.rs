//! The vector unit under random traffic.

use potamoi_cycles::{Exponents, VectorInputs, VectorModel};
use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_units::vector_unit::vector_unit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::pins::Pins;

/// Clocks in which nothing moves after which a unit stands still: more than any
/// operation takes.
const STILL: u32 = 400;
const OPERATION: u64 = 1 << 0;
const ROUNDING: u64 = 1 << 1;
const BEYOND: u64 = 1 << 3;

/// A vector, and what must come of it.
struct Vector {
    data: Vec<u32>,
    keep: Vec<bool>,
    last: bool,
    user: u64,
    exponent: u32,
    flags: u64,
    results: Vec<u32>,
}

/// Lanes of any pattern: none, all, some; whatever the others hold.
fn vector(
    random: &mut Pcg64Mcg,
    config: &Config,
    twin: &ReferenceVectorUnit,
    wrong: bool,
) -> Vector {
    let lanes = config.vu.lanes as usize;
    let code = config.vu.ops[random.random_range(0..config.vu.ops.len())];
    let input = config.vu.exp.input;
    let op = VectorOp {
        code,
        shift: random.random_range(0..32),
        rounding: [Rounding::Floor, Rounding::HalfEven, Rounding::HalfUp]
            [random.random_range(0..3)],
    };
    let density = random.random_range(0..3);
    let keep: Vec<bool> = (0..lanes)
        .map(|_| match density {
            0 => false,
            1 => true,
            _ => random.random(),
        })
        .collect();
    let (mut data, mut results, mut kept) = (vec![], vec![], vec![]);
    let mut pairs = vec![];
    for kept_here in &keep {
        let is_exponential = !matches!(
            code,
            OpCode::Pass | OpCode::Relu | OpCode::Add | OpCode::Multiply | OpCode::SquareSum
        );
        let a: i32 = match is_exponential {
            true => random
                .random_range(input.min() as i32..=input.max() as i32)
                .max(0),
            false => random.random_range(-30_000..30_000),
        };
        let b: i32 = random.random_range(-30_000..30_000);
        data.extend([a as u32, b as u32]);
        if *kept_here {
            kept.push(a);
            pairs.push((a, b));
        }
        results.push(match kept_here {
            true => twin.element(op, a, b).unwrap() as u32,
            false => 0,
        });
    }
    let mut user = u64::from(op.field());
    let mut flags = 0;
    if wrong {
        user = random.random_range(0..1 << 12);
        let built = config
            .vu
            .ops
            .iter()
            .any(|op| u64::from(op.code()) == user & 15);
        flags |= if built { 0 } else { OPERATION };
        if built || user >> 10 == 3 {
            user |= 3 << 10;
            flags |= ROUNDING;
        }
    }
    let asked = config
        .vu
        .ops
        .iter()
        .find(|op| u64::from(op.code()) == user & 15);
    let beyond = |op: OpCode| pairs.iter().any(|(a, b)| twin.is_beyond(op, *a, *b));
    if asked.is_some_and(|op| beyond(*op)) {
        flags |= BEYOND;
    }
    Vector {
        data,
        keep,
        last: random.random(),
        user,
        exponent: Exponents::of(config).least(code, &kept),
        flags,
        results,
    }
}

/// `tkeep` of lanes of so many bytes.
fn bits(keep: &[bool], bytes: usize) -> Vec<u32> {
    let word = |part: &[bool]| part.iter().rev().fold(0, |w, k| w << 1 | u32::from(*k));
    let keep: Vec<bool> = keep.iter().flat_map(|k| vec![*k; bytes]).collect();
    keep.chunks(32).map(word).collect()
}

fn offer(pins: &mut Pins, vector: Option<&Vector>) {
    pins.set("s_axis_vec_tvalid", u64::from(vector.is_some()));
    let Some(v) = vector else { return };
    pins.set_words("s_axis_vec_tdata", &v.data);
    pins.set_words("s_axis_vec_tkeep", &bits(&v.keep, 8));
    pins.set("s_axis_vec_tlast", u64::from(v.last));
    pins.set("s_axis_vec_tuser", v.user);
}

fn into_reset(pins: &mut Pins, first: &Vector, clocks: u32) -> Result<(), String> {
    pins.set("rst_n", 0);
    offer(pins, Some(first));
    for _ in 0..clocks {
        pins.settle();
        if pins.is("s_axis_vec_tready") {
            return Err("s_axis_vec_tready is high in reset".to_owned());
        }
        pins.edge();
    }
    pins.set("rst_n", 1);
    Ok(())
}

/// Vectors that a reset cuts off, vectors of which some ask for what is not built, and
/// right ones: these come back in every bit and cycle.
pub(crate) fn traffic(config: &Config, seed: u64) -> Result<(), String> {
    let mut random = Pcg64Mcg::seed_from_u64(3000 + seed);
    let twin = ReferenceVectorUnit::new(&config.vu);
    let module = vector_unit(config).map_err(|e| e.to_string())?;
    let mut pins = Pins::new(&module, seed);
    for phase in ["cut off", "wrong", "right"] {
        let wrong = |random: &mut Pcg64Mcg| phase == "wrong" && random.random_range(0..6) == 0;
        let vectors: Vec<_> = (0..12)
            .map(|_| {
                let wrong = wrong(&mut random);
                vector(&mut random, config, &twin, wrong)
            })
            .collect();
        into_reset(&mut pins, &vectors[0], random.random_range(1..4))?;
        let clocks = (phase == "cut off").then(|| random.random_range(0..200));
        run(&mut pins, config, &vectors, &mut random, clocks)
            .map_err(|why| format!("{phase}: {why}"))?;
    }
    Ok(())
}

fn run(
    pins: &mut Pins,
    config: &Config,
    vectors: &[Vector],
    random: &mut Pcg64Mcg,
    clocks: Option<u32>,
) -> Result<(), String> {
    let mut model = VectorModel::new(config).map_err(|e| e.to_string())?;
    let gaps = [0, 0, 5][random.random_range(0..3)];
    let sink_gaps = [0, 5, 8][random.random_range(0..3)];
    let takes_back: bool = random.random();
    let (mut sent, mut taken, mut still, mut valid, mut flags) = (0, 0, 0, false, 0);
    for clock in 0.. {
        if clocks == Some(clock) || taken == vectors.len() {
            return Ok(());
        }
        let at = |what: String| format!("clock {clock}: {what}");
        valid = random.random_range(0..10) >= gaps || valid && !takes_back;
        let next = vectors.get(sent).filter(|_| valid);
        let ready = random.random_range(0..10) >= sink_gaps;
        offer(pins, next);
        pins.set("m_axis_vec_tready", u64::from(ready));
        pins.settle();
        let idle = model.is_idle();
        if flags & !BEYOND == 0 && pins.is("idle") != idle {
            return Err(at(format!("idle is {}, by the model {idle}", !idle)));
        }
        let said = model.step(&VectorInputs {
            op: next.map(|v| (v.user & 15) as u8),
            exponent: next.map_or(0, |v| v.exponent),
            ready,
        });
        let [accepts, offers] = ["s_axis_vec_tready", "m_axis_vec_tvalid"].map(|p| pins.is(p));
        // What is not built takes as long as it will. An operand beyond its width changes no cycle.
        if flags & !BEYOND == 0 && [accepts, offers] != [said.ready, said.valid] {
            let said = [said.ready, said.valid];
            return Err(at(format!(
                "ready and valid {accepts} {offers}, by the model {said:?}"
            )));
        }
        if pins.get("stat_errors") != flags {
            let found = pins.get("stat_errors");
            return Err(at(format!("flags {found}, expected {flags}")));
        }
        if offers {
            let v = &vectors[taken];
            let keep = pins.words("m_axis_vec_tkeep");
            if keep != bits(&v.keep, 4) || pins.is("m_axis_vec_tlast") != v.last {
                return Err(at(format!("vector {taken}: keep {keep:x?}, or tlast")));
            }
            let data = pins.words("m_axis_vec_tdata");
            if (v.flags | flags) & !BEYOND == 0 && data != v.results {
                return Err(at(format!(
                    "vector {taken}: {data:x?}, expected {:x?}",
                    v.results
                )));
            }
        }
        let accepted = next.is_some() && accepts;
        if accepted {
            flags |= vectors[sent].flags;
            sent += 1;
            valid = false;
        }
        let gives = offers && ready;
        taken += usize::from(gives);
        still = if accepted || gives { 0 } else { still + 1 };
        if still > STILL {
            return Err(at(format!(
                "stands still, {taken} of {} came back",
                vectors.len()
            )));
        }
        pins.edge();
    }
    Ok(())
}
