//! The comparison can fail: state that a reset leaves, and a bit that leaks, are found.

use std::collections::BTreeMap;

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_rtl::EngineKind;

use super::units::{Text, Unit, verilog_of};
use super::{Engine, STATES, TINY, difference, engine, gates, jobs};

/// Takes a register's line out of the branch of the reset that has it.
fn without_reset(text: &str, register: &str) -> String {
    let begins = format!("{register} <= ");
    let mut in_reset = false;
    let mut gone = 0;
    let kept = text.lines().filter(|line| {
        let line = line.trim();
        in_reset = match line {
            "if (!rst_n) begin" => true,
            _ if line.starts_with("end") => false,
            _ => in_reset,
        };
        let goes = in_reset && line.starts_with(&begins);
        gone += u32::from(goes);
        !goes
    });
    let text = kept.collect::<Vec<_>>().join("\n");
    assert_eq!(gone, 1, "{register} has one reset");
    text
}

/// The engines that run a unit's edited Verilog. Each has all that it is compared with.
fn alone(config: &Config, unit: &str, files: &BTreeMap<String, String>) -> Vec<Engine> {
    let on = |kind, files| Unit::of(kind, config, unit, Text::Files(files));
    vec![
        engine("verilator", on(EngineKind::Verilator, files), &STATES),
        engine("icarus", on(EngineKind::Icarus, files), &[0]),
    ]
}

/// The first difference that an engine shows on a job of the seeds.
fn found(engine: Engine, config: &Config, unit: &str) -> Option<String> {
    let engines = [engine];
    let jobs = (0..2).flat_map(|seed| jobs::of(config, unit, seed));
    jobs.into_iter()
        .find_map(|job| difference(&engines, config, &job))
}

fn find(unit: &str, port: &str, edit: impl Fn(&str) -> String) {
    let config = Config::from_toml(TINY, "test").unwrap();
    let mut files = verilog_of(&config, unit);
    let text = files.get_mut(&format!("{unit}.v")).unwrap();
    let edited = edit(text);
    assert_ne!(*text, edited);
    *text = edited;
    judge(alone(&config, unit, &files), &config, unit, port);
}

fn judge(engines: Vec<Engine>, config: &Config, unit: &str, port: &str) {
    for engine in engines {
        let name = engine.name;
        let why = found(engine, config, unit);
        let why = why.unwrap_or_else(|| panic!("{unit}, {port}: not found on {name}"));
        println!("{name}: {why}");
        // An unknown bit is seen where it is, in any state; a random one where states differ.
        if name != "verilator" {
            let is_named = why.contains(&format!("{port} is "));
            assert!(is_named && why.contains('x'), "{name}: {why}");
        }
    }
}

#[test]
fn a_control_register_without_reset_is_found() {
    find(VECTOR_UNIT, "s_axis_vec_tready", |text| {
        without_reset(text, "phase")
    });
}

/// Verilog's `if` takes X for 0, so that Icarus Verilog alone does not see this one. X goes through
/// gates.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_control_register_without_reset_is_found_in_gates() {
    let config = Config::from_toml(TINY, "test").unwrap();
    let mut files = verilog_of(&config, VECTOR_UNIT);
    let text = files.get_mut("vector_unit.v").unwrap();
    *text = without_reset(text, "result_valid");
    let netlist = gates::of(VECTOR_UNIT, &files);
    let unit = Unit::of(
        EngineKind::Icarus,
        &config,
        VECTOR_UNIT,
        Text::Files(&netlist),
    );
    let engines = vec![engine("gates on icarus", unit, &[0])];
    judge(engines, &config, VECTOR_UNIT, "m_axis_vec_tvalid");
}

#[test]
fn a_counter_without_reset_is_found() {
    find(GATHERING_UNIT, "stat_busy", |text| {
        without_reset(text, "stat_busy")
    });
}

#[test]
fn a_bit_of_the_slot_of_a_port_without_an_entry_is_found() {
    find(GATHERING_UNIT, "m_axis_feat_tuser", |text| {
        let at = text.find("s1_slot <= rit_p_slot &").unwrap();
        let (before, after) = text.split_at(at);
        let leaks = "{1'b1, {15{rit_p_keep[1]}}}";
        format!(
            "{before}{}",
            after.replacen("{16{rit_p_keep[1]}}", leaks, 1)
        )
    });
}
