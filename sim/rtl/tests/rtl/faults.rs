//! The comparison bites: a fault in any register that reaches a port is found,
//! at that port, and so is a wrong golden value. On the interpreter, which needs
//! no tool; the engines share the comparison.
use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_formats::units::{GATHERING_UNIT, OpCode, VECTOR_UNIT, VectorOp};
use potamoi_netlist::{Change, Fault};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_rtl::{Check, EngineKind, GatherUnit, RtlError, VectorBatch, VectorUnit};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

fn config() -> Config {
    let text = "[gu]\nbanks = 2\nports = 2\n[rit]\nentries = 4\n[mvoxel]\nrows = 8\n\
                [vu]\nlanes = 3\n[vu.exp]\niterations = 8";
    Config::from_toml(text, "test").unwrap()
}

fn check<'a>(progress: &'a mut dyn FnMut(u64)) -> Check<'a> {
    let held = |per_mille| StreamStalls {
        per_mille,
        burst: 3,
    };
    Check {
        stalls: Stalls {
            rit: held(200),
            mft: held(200),
            sink: held(400),
        },
        seed: 7,
        flags: 0,
        progress,
    }
}

/// The signal at which a comparison fails; none if it does not. The whole
/// message is shown where a test fails.
fn signal<T>(result: Result<T, RtlError>) -> Option<String> {
    match result {
        Ok(_) => None,
        Err(RtlError::Mismatch(mismatch)) => {
            println!("{mismatch}\nagain: cargo test -p potamoi-rtl --test rtl faults");
            Some(mismatch.signal.clone())
        }
        Err(other) => panic!("{other}"),
    }
}

fn fault(module: &str, register: &str, change: Change) -> Fault {
    Fault {
        module: module.to_owned(),
        register: register.to_owned(),
        change,
    }
}

fn tasks() -> Vec<GatherTask> {
    let one = |t: usize| GatherTask {
        vertices: Vertices::Four,
        channels: 3,
        rows: (0..8 * 3).map(|i| (i * 317 + t * 1000) as i16).collect(),
        entries: (0..9 + t)
            .map(|e| RitEntry {
                slot: (e * 77 + t) as u32,
                rows: std::array::from_fn(|v| ((e + v) % 8) as u16),
                weights: [8192, 8192, 8192, 8192, 0, 0, 0, 0],
            })
            .collect(),
    };
    (0..6).map(one).collect()
}

fn gathered(tasks: &[GatherTask]) -> Vec<i16> {
    let twin = ReferenceGatheringUnit::new(&config());
    let mut features = vec![];
    for task in tasks {
        assert_eq!(twin.gather(task, &mut features), Ok(0));
    }
    features
}

fn gather(fault: Option<&Fault>, tasks: &[GatherTask], features: &[i16]) -> Option<String> {
    gather_of(&config(), fault, tasks, features)
}

fn gather_of(
    config: &Config,
    fault: Option<&Fault>,
    tasks: &[GatherTask],
    features: &[i16],
) -> Option<String> {
    let mut module = gathering_unit(config).unwrap();
    if let Some(fault) = fault {
        module = fault.inject(&module).unwrap();
    }
    let unit = GatherUnit::of_module(EngineKind::Interpreter, config, &module).unwrap();
    signal(unit.check(config, tasks, features, check(&mut |_| {})))
}

/// Arbitration, crossbar, lanes, sequencer and counters of the feature-major
/// organisation.
#[test]
fn every_part_of_the_feature_major_unit_is_compared() {
    let config = Config::from_toml(
        "[gu]\norganisation = \"feature-major\"\nbanks = 2\nlanes = 4\nports = 2\n\
         [rit]\nentries = 4\n[mvoxel]\nrows = 8",
        "test",
    )
    .unwrap();
    let tasks = tasks();
    let features = gathered(&tasks);
    assert_eq!(gather_of(&config, None, &tasks, &features), None);
    let top = GATHERING_UNIT;
    let one = || Change::Reset(1.into());
    for (module, register, change, port) in [
        // A lane that was served asks again, one that waits does not.
        ("gather_lane", "pending", Change::Invert(0), ""),
        (
            "gather_lane",
            "d_bank",
            Change::Invert(0),
            "m_axis_feat_tdata",
        ),
        (
            "gather_lane",
            "x_weight",
            Change::Invert(13),
            "m_axis_feat_tdata",
        ),
        (
            "gather_lane",
            "x_first",
            Change::Invert(0),
            "m_axis_feat_tdata",
        ),
        (
            "gather_lane",
            "x_slot",
            Change::Invert(0),
            "m_axis_feat_tuser",
        ),
        (
            "gather_lane",
            "x_kept",
            Change::Invert(0),
            "m_axis_feat_tkeep",
        ),
        (top, "step_channel", Change::Invert(0), "m_axis_feat_tdata"),
        (top, "x_end", Change::Invert(0), "m_axis_feat_tlast"),
        ("feature_fifo", "count", one(), "m_axis_feat_tvalid"),
        (top, "in_flight", Change::Reset(7.into()), "idle"),
        (top, "lanes_full_0", one(), ""),
        ("mft", "write_channel", one(), ""),
        ("rit_buffer", "closed_0", one(), "s_axis_rit_tready"),
        ("mft", "loaded_0", one(), "s_axis_mft_tready"),
        (top, "stat_busy", Change::Invert(3), "stat_busy"),
        (top, "stat_stall_bank", Change::Invert(0), "stat_stall_bank"),
        (top, "stat_entries", Change::Invert(0), "stat_entries"),
        (top, "row_not_loaded", one(), "stat_errors"),
        (top, "bad_setting", one(), "stat_errors"),
    ] {
        let fault = fault(module, register, change);
        let found = gather_of(&config, Some(&fault), &tasks, &features);
        let found = found.unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(found.starts_with(port), "{fault:?} is found at {found}");
    }
}

#[test]
fn every_port_of_the_gathering_unit_is_compared() {
    let tasks = tasks();
    let features = gathered(&tasks);
    assert_eq!(gather(None, &tasks, &features), None);
    let top = GATHERING_UNIT;
    let one = || Change::Reset(1.into());
    for (module, register, change, port) in [
        ("reducer", "acc", Change::Invert(15), "m_axis_feat_tdata"),
        (
            top,
            "s2_slot",
            Change::Invert(17),
            "m_axis_feat_tuser of port 1",
        ),
        (top, "s2_keep", Change::Invert(1), "m_axis_feat_tkeep"),
        (top, "s2_end", Change::Invert(0), "m_axis_feat_tlast"),
        ("feature_fifo", "count", one(), "m_axis_feat_tvalid"),
        ("rit_buffer", "closed_0", one(), "s_axis_rit_tready"),
        ("mft", "loaded_0", one(), "s_axis_mft_tready"),
        (top, "in_flight", one(), "idle"),
        (top, "stat_busy", Change::Invert(3), "stat_busy"),
        (top, "stat_entries", Change::Invert(0), "stat_entries"),
        (top, "running_fifo", Change::Invert(0), "stat_stall_fifo"),
        (top, "running_mft", one(), "stat_stall_mft"),
        (top, "running_rit", Change::Invert(0), "stat_stall_rit"),
        (top, "row_not_loaded", one(), "stat_errors"),
        (top, "gap_in_beat", one(), "stat_errors"),
        (top, "bad_setting", one(), "stat_errors"),
    ] {
        let fault = fault(module, register, change);
        let found = gather(Some(&fault), &tasks, &features);
        let found = found.unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(found.starts_with(port), "{fault:?} is found at {found}");
    }
}

#[test]
fn every_golden_value_of_the_gathering_unit_is_compared() {
    let good = tasks();
    let features = gathered(&good);
    for at in [0, 1, 2, features.len() / 2, features.len() - 1] {
        for bit in [0, 15] {
            let mut wrong = features.clone();
            wrong[at] ^= 1 << bit;
            let found = gather(None, &good, &wrong).unwrap();
            assert!(found.starts_with("m_axis_feat_tdata"), "{at}: {found}");
        }
    }
}

fn batches<'a>(a: &'a [i32], b: &'a [i32]) -> Vec<VectorBatch<'a>> {
    [
        OpCode::Exp,
        OpCode::Add,
        OpCode::OneMinusExp,
        OpCode::Multiply,
    ]
    .into_iter()
    .map(|code| VectorBatch {
        op: VectorOp::new(code),
        a,
        b,
    })
    .collect()
}

fn compute(fault: Option<&Fault>, wrong: Option<(usize, u32)>) -> Option<String> {
    compute_on(&config(), fault, wrong)
}

fn compute_on(
    config: &Config,
    fault: Option<&Fault>,
    wrong: Option<(usize, u32)>,
) -> Option<String> {
    let mut module = vector_unit(config).unwrap();
    if let Some(fault) = fault {
        module = fault.inject(&module).unwrap();
    }
    let unit = VectorUnit::of_module(EngineKind::Interpreter, config, &module).unwrap();
    // The last vector of a batch has one element of three lanes.
    let a: Vec<i32> = (0..31).map(|i| i * 2111).collect();
    let b: Vec<i32> = (0..31).map(|i| 1000 - i * 77).collect();
    let twin = ReferenceVectorUnit::new(&config.vu);
    let mut results = vec![];
    for batch in batches(&a, &b) {
        let from = results.len();
        results.resize(from + a.len(), 0);
        twin.slice(batch.op, &a, &b, &mut results[from..]).unwrap();
    }
    if let Some((at, bit)) = wrong {
        results[at] ^= 1 << bit;
    }
    signal(unit.check(config, &batches(&a, &b), &results, check(&mut |_| {})))
}

/// Work on a unit with sigmoid and softplus, as [`compute`].
fn passes(registered: bool, knobs: &str, fault: Option<&Fault>) -> Option<String> {
    let text = format!(
        "[vu]\nlanes = 3\nregistered = {registered}\nops = [\"add\", \"exp\", \"one-minus-exp\", \"sigmoid\", \"softplus\"]\n[vu.exp]\n{knobs}"
    );
    let config = Config::from_toml(&text, "test").unwrap();
    let mut module = vector_unit(&config).unwrap();
    if let Some(fault) = fault {
        module = fault.inject(&module).unwrap();
    }
    let unit = VectorUnit::of_module(EngineKind::Interpreter, &config, &module).unwrap();
    // -10 to 10 and both ends.
    let mut a: Vec<i32> = (-15..15).map(|i| i * 5501).collect();
    a.extend([i32::MIN, i32::MAX]);
    let b: Vec<i32> = (0..32).map(|i| 1000 - i * 77).collect();
    let batches: Vec<_> = [
        OpCode::Softplus,
        OpCode::Exp,
        OpCode::Sigmoid,
        OpCode::Add,
        OpCode::OneMinusExp,
        OpCode::Sigmoid,
        OpCode::Softplus,
    ]
    .into_iter()
    .map(|code| VectorBatch {
        op: VectorOp::new(code),
        a: &a,
        b: &b,
    })
    .collect();
    let twin = ReferenceVectorUnit::new(&config.vu);
    let mut results = vec![];
    for batch in &batches {
        let from = results.len();
        results.resize(from + a.len(), 0);
        twin.slice(batch.op, &a, &b, &mut results[from..]).unwrap();
    }
    signal(unit.check(&config, &batches, &results, check(&mut |_| {})))
}

#[test]
fn faults_in_the_passes_of_sigmoid_and_softplus_are_found() {
    let top = VECTOR_UNIT;
    for knobs in [
        "iterations = 16",
        "iterations = 9\niterations_per_clock = 3\ntail = true",
    ] {
        assert_eq!(passes(false, knobs, None), None);
        for (module, register, change, port) in [
            (
                "vector_lane",
                "r_linear",
                Change::Invert(31),
                "m_axis_vec_tdata",
            ),
            (
                "vector_lane",
                "r_linear",
                Change::Invert(13),
                "m_axis_vec_tdata",
            ),
            (
                "vector_lane",
                "r_remain",
                Change::Invert(12),
                "m_axis_vec_tdata",
            ),
            (
                "vector_lane",
                "r_accum",
                Change::Invert(12),
                "m_axis_vec_tdata",
            ),
            (
                "vector_lane",
                "r_digits",
                Change::Invert(1),
                "m_axis_vec_tdata",
            ),
            (
                "vector_lane",
                "r_rescaled",
                Change::Invert(0),
                "m_axis_vec_tdata",
            ),
            (
                top,
                "result_softplus",
                Change::Invert(0),
                "s_axis_vec_tready",
            ),
            (
                top,
                "result_sigmoid",
                Change::Invert(0),
                "s_axis_vec_tready",
            ),
            (top, "phase", Change::Invert(0), "s_axis_vec_tready"),
            (top, "result_is_exp", Change::Invert(0), "m_axis_vec_tdata"),
        ] {
            let fault = fault(module, register, change);
            let found = passes(false, knobs, Some(&fault));
            let found = found.unwrap_or_else(|| panic!("{knobs}: {fault:?} is not found"));
            println!("{knobs:?}: {module}.{register} is found at {found}");
            assert!(found.starts_with(port), "{fault:?} is found at {found}");
        }
    }
}

/// Registers that only a registered unit has between the passes.
#[test]
fn faults_between_registered_passes_are_found() {
    let knobs = "iterations = 9\niterations_per_clock = 3\ntail = true";
    assert_eq!(passes(true, knobs, None), None);
    for (module, register, bit, port) in [
        ("vector_lane", "r_linear", 13, "m_axis_vec_tdata"),
        ("vector_lane", "loaded_rescaled", 0, "m_axis_vec_tdata"),
        ("vector_lane", "r_power", 12, "m_axis_vec_tdata"),
        ("vector_lane", "r_softplus", 12, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "load_log_held", 0, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "load_again_held", 0, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "take_sum_held", 0, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "log_held", 0, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "result_softplus", 1, "m_axis_vec_tdata"),
        (VECTOR_UNIT, "taken_sigmoid", 0, "s_axis_vec_tready"),
        (VECTOR_UNIT, "taken_softplus", 0, "s_axis_vec_tready"),
    ] {
        let fault = fault(module, register, Change::Invert(bit));
        let found = passes(true, knobs, Some(&fault));
        let found = found.unwrap_or_else(|| panic!("{knobs}: {fault:?} is not found"));
        println!("{knobs:?}: {module}.{register} is found at {found}");
        assert!(found.starts_with(port), "{fault:?} is found at {found}");
    }
}

/// Registers of the exponentials that can stand in the restoring form's place:
/// a result, or the cycle of one, is wrong.
#[test]
fn faults_in_every_form_of_exponential_are_found() {
    let early = "early_out = true";
    let pieces = "form = \"piecewise\"\npipelined = true";
    let radix = "form = \"radix-4\"\niterations = 4\ntail = true";
    let lane = "vector_lane";
    for (knobs, module, register, change) in [
        (early, lane, "r_running", Change::Invert(0)),
        (early, VECTOR_UNIT, "last_phase", Change::Invert(0)),
        (early, "exp_constants", "sr_mul[5]", Change::Invert(0)),
        (pieces, lane, "s_power", Change::Invert(10)),
        (pieces, lane, "s_exponent", Change::Invert(0)),
        (pieces, lane, "s_accum", Change::Invert(16)),
        (radix, "exp_constants", "sr_sub_two[3]", Change::Invert(18)),
        (
            radix,
            "exp_constants",
            "sr_sub_three[0]",
            Change::Invert(20),
        ),
        (radix, lane, "r_remain", Change::Invert(12)),
    ] {
        let text = format!("[vu]\nlanes = 3\n[vu.exp]\n{knobs}");
        let config = Config::from_toml(&text, "test").unwrap();
        assert_eq!(compute_on(&config, None, None), None, "{knobs}");
        let fault = fault(module, register, change);
        let found = compute_on(&config, Some(&fault), None);
        let found = found.unwrap_or_else(|| panic!("{knobs}: {fault:?} is not found"));
        let [data, ready] = ["m_axis_vec_tdata", "s_axis_vec_tready"].map(|p| found.starts_with(p));
        assert!(data || ready, "{fault:?} is found at {found}");
    }
}

#[test]
fn every_port_of_the_vector_unit_is_compared() {
    assert_eq!(compute(None, None), None);
    let top = VECTOR_UNIT;
    let one = || Change::Reset(1.into());
    for (module, register, change, port) in [
        (
            "vector_lane",
            "r_accum",
            Change::Invert(12),
            "m_axis_vec_tdata",
        ),
        (
            "vector_lane",
            "exact",
            Change::Invert(0),
            "m_axis_vec_tdata",
        ),
        (
            top,
            "result_keep",
            Change::Invert(2),
            "m_axis_vec_tkeep of lane 2",
        ),
        (top, "result_last", Change::Invert(0), "m_axis_vec_tlast"),
        (top, "result_valid", one(), "m_axis_vec_tvalid"),
        (top, "phase", one(), "s_axis_vec_tready"),
        (top, "stat_vectors", Change::Invert(0), "stat_vectors"),
        (top, "stat_busy", Change::Invert(0), "stat_busy"),
        (top, "stat_stall_out", Change::Invert(0), "stat_stall_out"),
        (top, "operation_not_built", one(), "stat_errors"),
        (top, "rounding_reserved", one(), "stat_errors"),
    ] {
        let fault = fault(module, register, change);
        let found = compute(Some(&fault), None);
        let found = found.unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(found.starts_with(port), "{fault:?} is found at {found}");
    }
    for at in [0, 30, 31, 92, 123] {
        for bit in [0, 31] {
            let found = compute(None, Some((at, bit))).unwrap();
            assert!(found.starts_with("m_axis_vec_tdata"), "{at}: {found}");
        }
    }
}
