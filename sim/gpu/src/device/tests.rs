//! Device files: what is read, and what is refused.
#![allow(clippy::unwrap_used)]

use super::{Device, FIELDS, Origin};

const A6000: &str = include_str!("../../devices/a6000.toml");

fn refusal(text: &str) -> String {
    Device::from_text("own", "own.toml", text)
        .unwrap_err()
        .to_string()
}

#[test]
fn every_device_is_read_and_each_figure_has_an_origin() {
    for name in Device::names() {
        let device = Device::builtin(name).unwrap();
        assert_eq!(device.name, name);
        assert_eq!(device.origins.len(), FIELDS.len(), "{name}");
    }
    assert!(Device::names().is_sorted());
}

#[test]
fn every_file_of_the_folder_is_built_in() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/devices");
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    found.sort();
    let stems: Vec<_> = found
        .iter()
        .map(|p| p.file_stem().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(stems, Device::names());
    assert_eq!(
        Device::from_file(&found[0]).unwrap(),
        Device::builtin(stems[0]).unwrap()
    );
}

/// 1.377 GHz exists in MAXN alone; other modes are other devices.
#[test]
fn clock_memory_and_watts_belong_to_one_mode() {
    let [maxn, slow] = ["xavier-maxn", "xavier-15w"].map(|n| Device::builtin(n).unwrap());
    assert!(maxn.clock_ghz > 1.9 * slow.clock_ghz);
    assert!(maxn.dram_gb_s > 1.5 * slow.dram_gb_s);
    assert!(maxn.watts > slow.watts);
    assert_ne!(maxn.mode, slow.mode);
}

#[test]
fn origins_are_sources_or_assumptions() {
    let device = Device::builtin("a6000").unwrap();
    assert!(matches!(device.origins["dram_gb_s"], Origin::Source(_)));
    assert!(matches!(device.origins["copy_gb_s"], Origin::Assumed(_)));
}

#[test]
fn a_misspelt_name_gets_a_suggestion() {
    let message = Device::builtin("xavier-max").unwrap_err().to_string();
    assert!(message.contains("did you mean `xavier-maxn`?"), "{message}");
    let message = Device::builtin("zzzzzzzz").unwrap_err().to_string();
    assert!(!message.contains("did you mean") && message.contains("orin-nx"));
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_one() {
    let message = refusal(&A6000.replace("clock_ghz =", "clock_gz ="));
    assert!(
        message.contains("own.toml: `clock_gz` is no key"),
        "{message}"
    );
    assert!(message.contains("write `clock_ghz`"), "{message}");
}

#[test]
fn a_value_out_of_range_is_refused_with_its_unit() {
    let text = A6000.replacen(
        "clock_ghz = { value = 1.8",
        "clock_ghz = { value = 1800.0",
        1,
    );
    assert_ne!(text, A6000);
    let message = refusal(&text);
    assert!(message.contains("`clock_ghz.value` is 1800"), "{message}");
    assert!(message.contains("from 0.05 to 5 GHz"), "{message}");
}

#[test]
fn a_figure_without_an_origin_is_refused() {
    let line = A6000.lines().find(|l| l.starts_with("watts")).unwrap();
    let message = refusal(&A6000.replace(line, "watts = { value = 300 }"));
    assert!(
        message.contains("`watts` is without an origin"),
        "{message}"
    );
    let message = refusal(&A6000.replace(line, "watts = 300"));
    assert!(message.contains("`watts` is 300"), "{message}");
    let message = refusal(&A6000.replace(line, ""));
    assert!(message.contains("`watts` is missing"), "{message}");
}

#[test]
fn devices_of_the_system_and_folders_are_refused_unread() {
    for path in ["/dev/zero", "/dev"] {
        let message = Device::from_file(path).unwrap_err().to_string();
        assert!(message.contains("not a regular file"), "{message}");
    }
}

#[test]
fn what_is_no_toml_is_refused() {
    assert!(refusal("title = ").contains("own.toml: not TOML"));
    let message = Device::from_file("/nowhere.toml").unwrap_err().to_string();
    assert!(message.contains("/nowhere.toml"), "{message}");
}

/// Every kernel of every row takes half of its time on a device that is twice as fast.
#[test]
fn a_device_twice_as_fast_takes_half_of_the_time() {
    for row in crate::rows::Row::all().unwrap() {
        let counts = row.at(crate::rows::At::Mid);
        let seconds = |device: &Device| {
            let bounds = row.program.frame(&counts, device).unwrap().bounds(device);
            [bounds.max.seconds, bounds.sum.seconds]
        };
        let [plain, fast] = [&row.device, &row.device.faster(2.0)].map(seconds);
        for (plain, fast) in plain.into_iter().zip(fast) {
            assert!(
                (plain / fast - 2.0).abs() < 1e-9,
                "{}: {plain} {fast}",
                row.id
            );
        }
    }
}
