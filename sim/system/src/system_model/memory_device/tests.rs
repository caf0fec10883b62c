//! Memory devices: what is read, what is refused, and what the figures come to.
#![allow(clippy::unwrap_used)]

use potamoi_base::content_hash::hash_of;

use super::*;

const PAPER: &str = include_str!("../../../memories/lpddr3-1600.toml");

fn refusal(text: &str) -> String {
    let read = MemoryDevice::from_text(["own", "own.toml"], "own.toml", text);
    read.unwrap_err().to_string()
}

/// The paper's file with another value for a key.
fn with(key: &str, value: &str) -> String {
    let line = PAPER
        .lines()
        .find(|line| line.starts_with(&format!("{key} =")))
        .unwrap();
    PAPER.replace(
        line,
        &format!("{key} = {{ value = {value}, assumed = \"x\" }}"),
    )
}

fn device(name: &str) -> MemoryDevice {
    MemoryDevice::builtin(name).unwrap()
}

#[test]
fn every_file_of_the_folder_is_built_in_and_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/memories");
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    found.sort();
    let mut names = MemoryDevice::names();
    assert_eq!(found.len(), names.len());
    for path in &found {
        let of_file = MemoryDevice::named(path.to_str().unwrap()).unwrap();
        let own = device(&of_file.name);
        assert_eq!(own.values, of_file.values);
        assert_eq!(own.origins.len(), FIGURES.len());
        names.retain(|name| *name != own.name);
    }
    assert!(names.is_empty(), "{names:?}");
    assert!(MemoryDevice::names().is_sorted());
}

/// Each figure decides something; those that count the package are checked against the others.
#[test]
fn every_figure_is_used() {
    let of = |own: &MemoryDevice| {
        let all = (
            own.geometry(4),
            own.timing(),
            own.currents(),
            own.interface(),
        );
        hash_of(&all)
    };
    let paper = device("lpddr3-1600");
    for figure in &FIGURES {
        if ["channels", "dies", "die_gbit", "capacity_gbit"].contains(&figure.key) {
            continue;
        }
        let mut own = paper.clone();
        let value = own.values.get_mut(figure.key).unwrap();
        *value = 2.0 * *value + f64::from(*value == 0.0);
        assert_ne!(of(&own), of(&paper), "{}", figure.key);
    }
}

#[test]
fn files_that_describe_no_memory_are_refused_in_words() {
    for (text, said) in [
        (with("ranks", "3"), ["`ranks` is 3", "a power of two"]),
        (
            with("bank_groups", "0"),
            ["`bank_groups.value` is 0", "from 1 to 8"],
        ),
        (
            with("dies", "2"),
            ["`capacity_gbit` is 16", "its dies hold 8"],
        ),
        (with("die_channels", "2"), ["`dies` is 4", "are 2 dies"]),
        (
            with("burst_length", "4096"),
            ["`burst_length.value` is 4096", "transfers"],
        ),
        (
            with("row_bytes", "16"),
            ["`row_bytes.value` is 16", "from 256"],
        ),
        (
            with("transfers_a_clock", "3"),
            ["`transfers_a_clock` is 3", "a divisor"],
        ),
        (
            with("turnaround_clocks", "1.5"),
            ["`turnaround_clocks` is 1.5", "whole"],
        ),
        (
            with("refresh_ns", "1999"),
            ["`refresh_ns` is 1999", "in turn"],
        ),
        (
            with("io_swing_volts", "1.3"),
            ["`io_swing_volts` is 1.3", "1.2 V"],
        ),
        (
            with("write_to_read_group_ns", "9"),
            ["`write_to_read_group_ns` is 9", "without bank groups"],
        ),
        (
            PAPER.replace("row_bytes =", "row_byte ="),
            [
                "`row_byte` is no key of a memory device",
                "write `row_bytes`",
            ],
        ),
        (
            PAPER.replace("\nranks =", "\n# ranks ="),
            ["`ranks` is missing", "ranks a channel"],
        ),
        (
            PAPER.replace(
                "clock_ns = { value = 1.25, source",
                "clock_ns = { value = 1.25, from",
            ),
            ["`clock_ns.from` is no key of a figure", "remove it"],
        ),
    ] {
        let message = refusal(&text);
        assert!(
            message.contains("own.toml") && said.iter().all(|part| message.contains(part)),
            "{said:?}: {message}"
        );
    }
    let message = MemoryDevice::named("lpddr5").unwrap_err().to_string();
    assert!(
        message.contains("no memory device is called `lpddr5`"),
        "{message}"
    );
    let message = MemoryDevice::named("./none.toml").unwrap_err().to_string();
    assert!(
        message.contains("sim/system/memories/lpddr3-1600.toml"),
        "{message}"
    );
}

/// Rates of the data lines, and the time that refreshes take: 3.3 % with dies of 4 Gb, 5.4 % with
/// dies of 8 Gb.
#[test]
fn peaks_and_refreshes_are_those_of_the_standards() {
    for (name, channels, gb_s, refreshed) in [
        ("lpddr3-1600", 4, 25.6, 0.0333),
        ("lpddr3-1600-8gb", 4, 25.6, 0.0538),
        ("lpddr4x-4266", 16, 136.5, 0.0718),
        ("lpddr5-6400", 4, 51.2, 0.0538),
    ] {
        let own = device(name);
        let peak = own.peak_gb_s() * f64::from(channels);
        assert!((peak / gb_s - 1.0).abs() < 1e-3, "{name}: {peak}");
        let timing = own.timing();
        let share = timing.refresh as f64 / timing.refresh_interval as f64;
        assert!((share / refreshed - 1.0).abs() < 0.01, "{name}: {share}");
        assert_eq!(own.geometry(channels).burst_bytes, 32, "{name}");
    }
}

/// The clocks that DRAMsim3 has for dies of 8 Gb.
#[test]
fn nanoseconds_are_rounded_up_to_clocks() {
    let timing = Timing {
        clock_ns: 1.25,
        read_latency: 12,
        write_latency: 9,
        burst: 4,
        activate_to_column: 15,
        precharge: 15,
        activate_to_precharge: 34,
        activate_to_activate: 8,
        four_activates: 40,
        column_to_column: 4,
        column_to_column_group: 4,
        write_to_read: 6,
        write_to_read_group: 6,
        write_recovery: 12,
        read_to_precharge: 6,
        precharge_to_precharge: 0,
        turnaround: 1,
        rank_switch: 1,
        refresh: 168,
        refresh_interval: 3120,
    };
    assert_eq!(device("lpddr3-1600-8gb").timing(), timing);
}

/// Ramulator 2's preset LPDDR5_6400, in clocks of 1.25 ns. Its burst of 4 clocks is the distance of
/// two bursts within a group.
#[test]
fn delays_of_lpddr5_are_those_of_ramulator() {
    let own = device("lpddr5-6400").timing();
    let found = [
        own.column_to_column_group,
        own.read_latency,
        own.activate_to_column,
        own.precharge,
        own.activate_to_precharge,
        own.write_recovery,
        own.read_to_precharge,
        own.write_latency,
        own.activate_to_activate,
        own.write_to_read,
        own.write_to_read_group,
        own.four_activates,
        own.precharge_to_precharge,
        own.rank_switch,
        own.refresh,
        own.refresh_interval,
    ];
    // nCCD, nCL, nRCD, nRPpb, nRAS, nWR, nRTP, nCWL, nRRD, nWTRS, nWTRL, nFAW, nPPD, nCS; of 8 Gb
    // nRFCab, nREFI.
    let ramulator = [4, 20, 15, 15, 34, 28, 4, 11, 4, 5, 10, 16, 2, 2, 168, 3124];
    assert_eq!(found, ramulator);
}

/// DRAMSys's LPDDR4-4266 of 8 Gb a channel, whose clock is 0.469 ns instead of 0.46875. It rounds
/// 7.5 ns (RTP) up to 17.
#[test]
fn delays_of_lpddr4_are_those_of_dramsys() {
    let own = device("lpddr4x-4266").timing();
    let found = [
        own.column_to_column,
        own.four_activates,
        own.precharge_to_precharge,
        own.activate_to_column,
        own.read_latency,
        own.activate_to_precharge,
        own.precharge,
        own.activate_to_activate,
        own.write_latency,
        own.write_recovery,
        own.write_to_read,
    ];
    assert_eq!(found, [8, 86, 4, 39, 36, 90, 39, 22, 18, 39, 22]);
    assert_eq!([own.read_to_precharge, own.refresh], [16, 598]);
}

/// Half of the rises of an unterminated line of 7.6 pF at 1.2 V are 2.7 pJ; terminated lines of low
/// swing take a fifth and less. Measured currents of outputs are 1.6 pJ (LPDDR4 at 1.1 V) and 0.52.
#[test]
fn energies_of_a_bit_on_a_line() {
    let near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 0.01, "{found}, {expected}");
    };
    let of = |name| device(name).interface();
    near(of("lpddr3-1600").pj_a_bit(), 2.736);
    near(of("lpddr3-1600-8gb").pj_a_bit(), 2.088);
    near(of("lpddr4x-4266").pj_a_bit(), 0.559);
    near(of("lpddr5-6400").pj_a_bit(), 0.388);
    let lpddr4 = Interface {
        volts: 1.1,
        swing_volts: 1.1 / 3.0,
        bit_ns: 0.3125,
        ..of("lpddr4x-4266")
    };
    let published = 150.0 * 1.1 / (32.0 * 3.2);
    assert!((lpddr4.pj_a_bit() / published - 1.0).abs() < 0.1);
    let published = 106.0 * 0.5 / (16.0 * 6.4);
    assert!((of("lpddr5-6400").pj_a_bit() * 1.25 / published - 1.0).abs() < 0.1);
}
