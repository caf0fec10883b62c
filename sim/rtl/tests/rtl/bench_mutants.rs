//! The standalone benches pass on what is emitted, and fail on small changes of it.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use potamoi_formats::config::Config;
use potamoi_rtl::bench::standalone;
use potamoi_soc::emit::emit;

const UNITS: [&str; 2] = ["gathering_unit", "vector_unit"];
/// Gaps and seed of the runs: none, and many.
const RUNS: &str = "RUNS=0:1 60:3";

/// A change of one file's text; `from` is in it once.
struct Mutant {
    what: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
    /// What the bench says of it, in part.
    said: &'static str,
}

const fn mutant(
    what: &'static str,
    file: &'static str,
    [from, to]: [&'static str; 2],
    said: &'static str,
) -> Mutant {
    Mutant {
        what,
        file,
        from,
        to,
        said,
    }
}

/// Changes that an integrator makes by mistake, or a synthesis tool gets wrong.
const MUTANTS: &[Mutant] = &[
    mutant(
        "a bit of the weight of single ids",
        "gathering_unit.v",
        ["single_ids ? 16'h8000", "single_ids ? 16'h8001"],
        "m_axis_feat_tdata",
    ),
    mutant(
        "two lanes swapped",
        "gathering_unit.v",
        [
            "s1_features0[16 * lane +: 16]",
            "s1_features0[16 * (lane ^ 1) +: 16]",
        ],
        "m_axis_feat_tdata",
    ),
    mutant(
        "one credit more",
        "gathering_unit.v",
        [
            "in_flight < GROUPS_IN_FLIGHT",
            "in_flight <= GROUPS_IN_FLIGHT",
        ],
        "m_axis_feat",
    ),
    mutant(
        "one credit less",
        "gathering_unit.v",
        [
            "in_flight < GROUPS_IN_FLIGHT",
            "in_flight < GROUPS_IN_FLIGHT - 3'd1",
        ],
        "cycles, expected",
    ),
    mutant(
        "idle although a table is loaded",
        "gathering_unit.v",
        ["~(rit_is_empty & mft_is_empty)", "~rit_is_empty"],
        "expected 100000000 up",
    ),
    mutant(
        "the keep of a neighbouring lane",
        "vector_unit.v",
        [
            "kept_lanes = {s_axis_vec_tkeep[24]",
            "kept_lanes = {s_axis_vec_tkeep[16]",
        ],
        "FAIL: beat",
    ),
    mutant(
        "a FIFO one word shorter",
        "feature_fifo.v",
        ["LAST_WORD = 2'd3", "LAST_WORD = 2'd2"],
        "m_axis_feat",
    ),
    mutant(
        "half-up instead of half-even",
        "reducer.v",
        ["acc[14] & (acc[15] | (|acc[13:0]))", "acc[14]"],
        "m_axis_feat_tdata",
    ),
    mutant(
        "a counter that counts twice",
        "gathering_unit.v",
        ["(running_rit + 32'd1)", "(running_rit + 32'd2)"],
        "stat_stall_rit",
    ),
    mutant(
        "a counter that cfg_clear leaves",
        "gathering_unit.v",
        [
            "stat_entries <= cfg_clear ? 32'd0 : stat_entries_sum[32]",
            "stat_entries <= stat_entries_sum[32]",
        ],
        "after cfg_clear",
    ),
    mutant(
        "ready in reset",
        "gathering_unit.v",
        ["s_axis_mft_tready = rst_n & ", "s_axis_mft_tready = "],
        "s_axis_mft_tready is 1 in reset",
    ),
    mutant(
        "no room for the last row",
        "mft.v",
        ["MVOXEL_ROWS = 10'd512", "MVOXEL_ROWS = 10'd511"],
        "FAIL",
    ),
    mutant(
        "the highest address bit lost",
        "mft.v",
        ["address0 = row0[8:0]", "address0 = {1'b0, row0[7:0]}"],
        "m_axis_feat_tdata",
    ),
    mutant(
        "a half that is never released",
        "mft.v",
        ["(loaded_0 & (~(done & other_read_half)))", "loaded_0"],
        "FAIL",
    ),
    mutant(
        "lanes that are not kept give results",
        "vector_lane.v",
        ["& {32{result_keep}}", "& {32{1'b1}}"],
        "m_axis_vec_tdata",
    ),
    mutant(
        "operands above the range of the exponential",
        "vector_lane.v",
        ["(|a[30:16]) ? 16'hffff", "(|a[30:17]) ? 16'hffff"],
        "m_axis_vec_tdata",
    ),
    mutant(
        "the last bit of a constant",
        "vector_lane.v",
        [
            "take0 ? (remain_start - 23'h2c5c86)",
            "take0 ? (remain_start - 23'h2c5c06)",
        ],
        "m_axis_vec_tdata",
    ),
    mutant(
        "a result that is not saturated",
        "vector_lane.v",
        ["(~rounded_value[65] & (|rounded_value[64:31]))", "1'b0"],
        "m_axis_vec_tdata",
    ),
    mutant(
        "a flag that a right beat takes back",
        "gathering_unit.v",
        ["(gap_in_beat | rit_errors[1])", "rit_errors[1]"],
        "stat_errors is",
    ),
    mutant(
        "a flag that cfg_clear leaves",
        "gathering_unit.v",
        [
            "setting_moved <= (setting_moved | ((settings != settings_before) & (~idle))) & (~cfg_clear)",
            "setting_moved <= (setting_moved | ((settings != settings_before) & (~idle)))",
        ],
        "stat_errors is",
    ),
    mutant(
        "stalls of a full FIFO that are not counted",
        "gathering_unit.v",
        ["(stalled & (~credit))", "1'b0"],
        "stat_stall_fifo",
    ),
    mutant(
        "a row past the MVoxel's that is written",
        "mft.v",
        ["write = write_accept & write_room", "write = write_accept"],
        "m_axis_feat_tdata",
    ),
    mutant(
        "a bit of the number of rows in the second half",
        "mft.v",
        ["rows_1 <= rows_after", "rows_1 <= rows_after & 10'h3df"],
        "m_axis_feat_tdata",
    ),
    mutant(
        "half an entry that passes as whole",
        "rit_buffer.v",
        ["row_last & 24'h820820", "row_last & 24'h820830"],
        "stat_errors is",
    ),
    mutant(
        "an end without bytes that keeps an entry",
        "rit_buffer.v",
        ["s_axis_rit_tlast ? some_bytes : 1'b1", "1'b1"],
        "m_axis_feat",
    ),
    mutant(
        "a torn lane that passes",
        "vector_unit.v",
        ["(accept & (|lane_torn))", "(accept & (|lane_torn[2:0]))"],
        "stat_errors is",
    ),
    mutant(
        "an operation that was not built and gives something",
        "vector_lane.v",
        ["{{33{a[31]}}, a} : 65'h0", "{{33{a[31]}}, a} : 65'h1"],
        "m_axis_vec_tdata",
    ),
    mutant(
        "room for one vector more",
        "vector_unit.v",
        ["room = in_flight < 5'd18", "room = in_flight < 5'd19"],
        "m_axis_vec",
    ),
];

fn small() -> Config {
    Config::preset("small").unwrap()
}

fn made(config: &Config, prefix: &str) -> BTreeMap<String, String> {
    let mut files = emit(config, prefix, "test").unwrap();
    for (name, text) in standalone(config, &UNITS, prefix).unwrap() {
        files.insert(format!("sim/{name}"), text);
    }
    files
}

fn small_files() -> &'static BTreeMap<String, String> {
    static FILES: OnceLock<BTreeMap<String, String>> = OnceLock::new();
    FILES.get_or_init(|| made(&small(), ""))
}

fn write(folder: &Path, files: &BTreeMap<String, String>) {
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// Runs make in the folder `sim`: whether it succeeds, and what it says.
fn simulate(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let done = Command::new("make")
        .arg("-C")
        .arg(folder.join("sim"))
        .args(arguments)
        .output()
        .unwrap();
    let said = [done.stdout, done.stderr].concat();
    (done.status.success(), String::from_utf8(said).unwrap())
}

fn passes(files: &BTreeMap<String, String>, arguments: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), files);
    let (well, said) = simulate(folder.path(), arguments);
    assert!(well, "{said}");
    assert_eq!(said.matches("PASS: ").count(), 4, "{said}");
    assert!(!said.to_lowercase().contains("warning"), "{said}");
}

#[test]
fn the_units_pass_with_a_prefix() {
    passes(&made(&small(), "npu0_"), &[RUNS]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_units_pass_on_both_simulators() {
    passes(small_files(), &[RUNS]);
    passes(small_files(), &["SIM=verilator", RUNS]);
}

#[test]
fn units_of_another_kind_pass() {
    kinds_pass(0..1);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn units_of_other_kinds_pass() {
    kinds_pass(1..4);
}

/// Of four kinds, those with these numbers.
fn kinds_pass(numbers: std::ops::Range<usize>) {
    let early_out = "[vu.exp]\nearly_out = true";
    // Operands of the bench go beyond these widths, and raise the flag.
    let narrow = "registered = true\n[vu.operands]\nmultiply = [12, 9]\nsquare_sum = 10";
    let kinds = [
        (
            "organisation = \"feature-major\"\nbanks = 8\nports = 2\nlanes = 6\nsegments = 2",
            early_out,
        ),
        (
            "banks = 32\nrecords_a_row = 2\nsums = \"exact\"\npipelined = true",
            early_out,
        ),
        ("banks = 8\nports = 4\nextra_ports = \"split\"", early_out),
        (
            "channels = 4\norganisation = \"parity\"\nmodes = \"structured\"\nvertices = [8]",
            narrow,
        ),
    ];
    for (text, vu) in &kinds[numbers] {
        let text = format!("[gu]\n{text}\n[rit]\nentries = 16\n[vu]\nlanes = 5\n{vu}\n");
        let config = Config::from_toml(&text, "test").unwrap();
        passes(&made(&config, ""), &[RUNS]);
    }
}

fn all_fail<'a>(mutants: impl Iterator<Item = &'a Mutant>) {
    let survivors: Vec<_> = mutants.filter_map(|m| is_found(m).err()).collect();
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

/// Some of each file.
#[test]
fn every_third_mutant_fails() {
    all_fail(MUTANTS.iter().step_by(3));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_mutant_fails() {
    all_fail(MUTANTS.iter());
}

fn is_found(m: &Mutant) -> Result<(), String> {
    let what = m.what;
    let folder = tempfile::tempdir().unwrap();
    let mut files = small_files().clone();
    let unit = UNITS
        .into_iter()
        .find(|u| files.contains_key(&format!("{u}/{}", m.file)));
    let unit = unit.ok_or_else(|| format!("{what}: no file {}", m.file))?;
    let text = files.get_mut(&format!("{unit}/{}", m.file)).unwrap();
    // The hardware comes first, its checks after it.
    let hardware = text.split("`ifdef POTAMOI_CHECKS").next();
    let places = hardware.unwrap_or_default().matches(m.from).count();
    if places != 1 {
        return Err(format!(
            "{what}: {:?} is in {} {places} times",
            m.from, m.file
        ));
    }
    *text = text.replacen(m.from, m.to, 1);
    write(folder.path(), &files);
    let (well, said) = simulate(folder.path(), &[&format!("UNITS={unit}"), RUNS]);
    match !well && said.contains("FAIL: ") && said.contains(m.said) {
        true => Ok(()),
        false => Err(format!(
            "{what}: expected a FAIL with {:?}, found {said}",
            m.said
        )),
    }
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = small_files().clone();
    files.remove("sim/gather_rit.hex");
    write(folder.path(), &files);
    let (well, said) = simulate(folder.path(), &[RUNS]);
    assert!(
        !well && said.contains("FAIL: gather_rit.hex is missing"),
        "{said}"
    );
    let (well, said) = simulate(folder.path(), &["UNITS=vector_unit", "RUNS=10:2", "DUMP=1"]);
    assert!(
        well && folder.path().join("sim/build/vector_unit.vcd").is_file(),
        "{said}"
    );
}
