//! Banks in parts by row, for more than two ports.

use potamoi_cycles::Stalls;
use potamoi_formats::rit::Vertices;
use potamoi_rtl::GatherUnit;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::random::{all, check};
use super::{EIGHT, config};
use crate::cells::cells;

const SPLIT: &str = "extra_ports = \"split\"\nbanks = 8\n";

#[test]
fn ports_take_turns_at_the_parts_of_banks() {
    let sizes = Vertices::ALL.map(|v| (v, 9));
    all(&format!("[gu]\nports = 4\n{SPLIT}"), &sizes);
}

/// Eight ports: with a deeper pipeline and compact entries, and with two records a row.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn many_ports_take_turns_at_the_parts_of_banks() {
    let sizes = Vertices::ALL.map(|v| (v, 9));
    let deep = "[gu]\nports = 8\npipelined = true\nfifo_depth = 9\n";
    all(
        &format!("{deep}{SPLIT}[rit]\nentry = \"compact\"\n"),
        &sizes,
    );
    let single = "[gu]\nports = 8\nmodes = \"unstructured\"\nrecords_a_row = 2\n";
    all(
        &format!("{single}{SPLIT}"),
        &[(Vertices::One, 4), (Vertices::One, 5)],
    );
}

/// Rows that all lie in one part take `M / 2` turns, rows spread over the parts one.
#[test]
fn a_third_row_of_a_part_waits() {
    for ports in [4u32, 8] {
        let text = format!(
            "[gu]\nports = {ports}\nextra_ports = \"split\"\nbanks = 8\nmodes = \"unstructured\"\n"
        );
        let config = config(&text);
        let unit = GatherUnit::build(&config).unwrap();
        let mut random = Pcg64Mcg::seed_from_u64(2);
        let parts = ports as u16 / 2;
        let groups = 40;
        let mut task = cells(
            &mut random,
            &config,
            Vertices::One,
            (8, groups * ports as usize),
        );
        let rows = (task.rows.len() / 8) as u16;
        for (step, turns) in [(parts, u64::from(parts)), (1, 1)] {
            for (i, entry) in task.entries.iter_mut().enumerate() {
                entry.rows[0] = i as u16 * step % (rows / parts * parts);
            }
            let totals = check(&config, &unit, &[task.clone()], Stalls::NONE);
            assert_eq!(totals.busy, groups as u64);
            assert_eq!(totals.stall_bank, groups as u64 * (turns - 1));
        }
    }
}

/// The same features as from copies; random rows cost turns.
#[test]
fn parts_give_the_features_of_copies() {
    let text =
        |extra: &str| format!("[gu]\nports = 4\nbanks = 8\nextra_ports = \"{extra}\"\n{EIGHT}");
    let [copies, split] = ["copies", "split"].map(|extra| config(&text(extra)));
    let units = [&copies, &split].map(|config| GatherUnit::build(config).unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let tasks: Vec<_> = (0..3)
        .map(|_| cells(&mut random, &split, Vertices::Eight, (8, 400)))
        .collect();
    let runs = units.map(|unit| unit.run(&tasks, &Stalls::NONE, 1).unwrap());
    let [copies, split] = runs;
    assert_eq!(copies.features, split.features);
    assert_eq!(copies.slots, split.slots);
    assert_eq!(copies.totals.busy, split.totals.busy);
    assert_eq!(copies.totals.stall_bank, 0);
    // Four rows by chance in two parts: three or four meet with probability 5/8.
    let rate = split.totals.stall_bank as f64 / split.totals.busy as f64;
    assert!((rate - 0.625).abs() < 0.1, "{rate}");
}
