//! Vectors that break promises: operations that were not built, the reserved rounding, and lanes with only
//! some of their bytes.

use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use super::beat::Beat;
use super::job::Job;
use super::script::{Clock, Script, keep_of};
use super::vector_operands::Batch;

const NOT_BUILT: u64 = 1;
const ROUNDING: u64 = 1 << 1;
const TORN: u64 = 1 << 2;
/// An operand beyond its width, where widths are below 32 bits. Operands of a script are 0.
pub(super) const BEYOND: u64 = 1 << 3;
/// Flags of every configuration.
const ALL: u64 = NOT_BUILT | ROUNDING | TORN;
/// Bytes of a lane's operands.
const LANE_BYTES: usize = 8;
/// Clocks that every operation takes at most.
const LONGEST: u32 = 200;

/// Codes of operations that were not built.
fn not_built(config: &Config) -> Vec<u32> {
    let built = |code: &u32| config.vu.ops.iter().any(|op| u32::from(op.code()) == *code);
    (0..16).filter(|code| !built(code)).collect()
}

/// The script of the unit's flags.
pub(super) fn script(config: &Config) -> Script {
    let bytes = LANE_BYTES * config.vu.lanes as usize;
    let element_wise = |op: &&OpCode| !op.is_exponential();
    let plain = config.vu.ops.iter().find(element_wise);
    let plain = plain.map_or(0, |op| u32::from(op.code()));
    let mut script = Script::default();
    script.clocks.push(Clock {
        reset: true,
        times: 2,
        down: ALL,
        ..Clock::default()
    });
    let all = |_| true;
    let mut add = |user: u32, keep: Vec<u32>, up: u64| {
        let beat = Beat::from([
            ("tuser", vec![user]),
            ("tlast", vec![user & 1]),
            ("tkeep", keep),
        ]);
        let flags = |up| Clock {
            up,
            down: ALL & !up,
            ..Clock::default()
        };
        script.clocks.push(Clock {
            beats: vec![Some(beat)],
            ..flags(up)
        });
        script.clocks.push(Clock {
            times: LONGEST,
            ..flags(up)
        });
        script.clocks.push(Clock {
            clear: true,
            ..flags(0)
        });
    };
    for code in 0..16 {
        let up = u64::from(not_built(config).contains(&code)) * NOT_BUILT;
        for rounding in 0..4 {
            let shift = 7 * code % 64;
            let reserved = u64::from(rounding == 3) * ROUNDING;
            add(
                code | shift << 4 | rounding << 10,
                keep_of(bytes, all),
                up | reserved,
            );
        }
    }
    // A byte too few and a byte too many in the first and the last lane, and one byte in each other.
    for byte in 0..bytes {
        let lane = byte / LANE_BYTES;
        let end = lane == 0 || lane + 1 == bytes / LANE_BYTES;
        if end || byte % LANE_BYTES == 1 + lane % (LANE_BYTES - 1) {
            add(plain, keep_of(bytes, |own| own != byte), TORN);
            add(plain, keep_of(bytes, |own| own == byte), TORN);
        }
    }
    for lane in 0..config.vu.lanes as usize {
        add(plain, keep_of(bytes, |own| own / LANE_BYTES == lane), 0);
    }
    add(plain, keep_of(bytes, |_| false), 0);
    // Not accepted, and accepted in the clock of the clear: no flag.
    let wrong = Beat::from([
        ("tuser", vec![0xcff]),
        ("tlast", vec![1]),
        ("tkeep", keep_of(bytes, |own| own % 3 == 1)),
    ]);
    script.clocks.push(Clock {
        clear: true,
        beats: vec![Some(wrong.clone())],
        down: ALL,
        ..Clock::default()
    });
    let up = TORN | ROUNDING | (u64::from(not_built(config).contains(&15)) * NOT_BUILT);
    script.clocks.push(Clock {
        beats: vec![Some(wrong)],
        up,
        down: ALL & !up,
        ..Clock::default()
    });
    script.clocks.push(Clock {
        reset: true,
        down: ALL,
        ..Clock::default()
    });
    script
}

/// Element-wise vectors for [`tear`] and [`strip`].
pub(super) fn batches(config: &Config, vectors: usize) -> Vec<Batch> {
    let lanes = config.vu.lanes as usize;
    let ops = config.vu.ops.iter().filter(|op| !op.is_exponential());
    let ops: Vec<_> = ops.cycle().take(vectors).collect();
    let batch = |(i, code): (usize, &&OpCode)| {
        let widths = config.vu.operand_widths(**code);
        let operand = |lane: usize, which: usize, by: i32| {
            let most = i32::MAX >> (32 - widths[which]);
            let value = by.wrapping_mul(1 + (i * lanes + lane) as i32);
            value.clamp(-most - 1, most)
        };
        Batch {
            op: VectorOp {
                code: **code,
                shift: (i % 8) as u8,
                rounding: Rounding::HalfUp,
            },
            a: (0..lanes)
                .map(|lane| operand(lane, 0, 0x0135_79bd))
                .collect(),
            b: (0..lanes)
                .map(|lane| operand(lane, 1, -0x2468_ace1))
                .collect(),
        }
    };
    ops.iter().enumerate().map(batch).collect()
}

/// Takes bytes from kept lanes and gives some to others, whose lowest byte says whether they are kept;
/// every third vector loses all lanes, whole.
pub(super) fn tear(job: &mut Job, config: &Config) {
    let lanes = config.vu.lanes as usize;
    let bytes = LANE_BYTES * lanes;
    job.title = format!(
        "{} vectors with torn lanes, and some without a lane",
        job.output.len()
    );
    let beats = job.inputs[0].iter_mut().zip(&mut job.output);
    for (i, (given, wanted)) in beats.enumerate() {
        let none = i % 3 == 2;
        let kept = |lane: usize| !none && (i + lane) % 4 != 3;
        let keep = keep_of(bytes, |byte| match (byte % LANE_BYTES, none) {
            (0, _) | (_, true) => kept(byte / LANE_BYTES),
            (low, _) => kept(byte / LANE_BYTES) != (low == 1 + i % (LANE_BYTES - 1)),
        });
        given.insert("tkeep", keep);
        wanted.insert("tkeep", keep_of(4 * lanes, |byte| kept(byte / 4)));
        let data = wanted.get_mut("tdata").into_iter().flatten();
        let dropped = data.enumerate().filter(|(lane, _)| !kept(*lane));
        dropped.for_each(|(_, word)| *word = 0);
    }
    job.stats.insert("stat_errors", TORN);
}

/// Asks for operations that were not built, whose results are 0.
pub(super) fn strip(job: &mut Job, config: &Config) {
    let codes = not_built(config);
    job.title = format!(
        "{} vectors of operations that were not built",
        job.output.len()
    );
    let beats = job.inputs[0].iter_mut().zip(&mut job.output);
    for (i, (given, wanted)) in beats.enumerate() {
        let user = given.get_mut("tuser").into_iter().flatten();
        user.for_each(|user| *user = *user & !15 | codes[i % codes.len()]);
        let data = wanted.get_mut("tdata").into_iter().flatten();
        data.for_each(|word| *word = 0);
    }
    job.stats.insert("stat_errors", NOT_BUILT);
}
