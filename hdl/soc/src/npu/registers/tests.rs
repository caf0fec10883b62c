//! The table of every preset is sound, and its texts say what it says.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::process::Command;

use potamoi_formats::config::{Config, PRESETS};

use super::*;
use crate::npu::register_map_of;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

/// The presets, and what they leave out: further settings and counters, wide counters, all widths at
/// their ends.
fn configurations() -> Vec<Config> {
    let texts = [
        "[gu]\nrecords_a_row = 2\ncounter_bits = 64",
        "[gu]\nports = 4\nextra_ports = \"split\"\ncounter_bits = 33",
        "[gu]\nbanks = 64\nports = 8\nsegments = 64\nsums = \"exact\"\ncounter_bits = 16\n[vu]\nlanes = 256",
        "[gu]\nbanks = 1\nports = 1\nfeature_bits = 8\nweight_bits = 4\n[mvoxel]\nrows = 65536\n[vu]\nlanes = 1",
        "[gu]\nmodes = \"structured\"\nvertices = [8]\n[rit]\nslot_bits = 32",
    ];
    let own = texts.map(|text| Config::from_toml(text, "test").unwrap());
    let presets = PRESETS
        .iter()
        .map(|(name, _)| Config::preset(name).unwrap());
    presets.chain(own).collect()
}

#[test]
fn the_table_of_any_configuration_is_sound() {
    for config in configurations() {
        let map = register_map_of(&config).unwrap();
        assert_eq!(map.faults(), [""; 0], "{}", config.to_toml().unwrap());
    }
}

/// No setting, counter or flag of a unit is without its register.
#[test]
fn every_port_of_the_units_has_a_register() {
    for config in configurations() {
        let map = register_map_of(&config).unwrap();
        let bits = |name: &str| map.register(name).map_or(0, |own| own.mask().count_ones());
        for (module, short) in [
            (gathering_unit(&config).unwrap(), "GU"),
            (vector_unit(&config).unwrap(), "VU"),
        ] {
            for port in module.ports() {
                let name = port.name.to_ascii_uppercase();
                let width = port.ty.width;
                if name == "STAT_ERRORS" {
                    assert_eq!(bits(&format!("{short}_ERRORS")), width);
                } else if let Some(counter) = name.strip_prefix("STAT_") {
                    let own = format!("{short}_{counter}");
                    let high = bits(&format!("{own}_HIGH"));
                    assert_eq!(bits(&own) + high, width, "{own}");
                } else if let Some(setting) =
                    name.strip_prefix("CFG_").filter(|own| *own != "CLEAR")
                {
                    let fields = &map.register("GU_MODE").unwrap().fields;
                    let own = fields.iter().find(|own| own.name == setting);
                    assert_eq!(own.unwrap().width, width, "{setting}");
                }
            }
        }
    }
}

/// Software of one configuration finds the registers of another where it expects them.
#[test]
fn registers_keep_their_offsets_in_every_configuration() {
    let mut offsets = std::collections::BTreeMap::new();
    for config in configurations() {
        for own in register_map_of(&config).unwrap().registers {
            assert_eq!(
                *offsets.entry(own.name.clone()).or_insert(own.offset),
                own.offset,
                "{}",
                own.name
            );
        }
    }
    assert!(offsets.contains_key("GU_BUSY_HIGH") && offsets.contains_key("GU_STALL_BANK"));
}

#[test]
fn a_table_with_faults_is_found_out() {
    let map = || register_map_of(&Config::preset("small").unwrap()).unwrap();
    let mut changes: Vec<(&str, RegisterMap)> = vec![];
    for text in [
        "STATUS does not follow CONTROL",
        "STATUS lies at 0x1000",
        "CONTROL occurs twice",
        "STATUS.VU_RUNNING has bits that it cannot have",
        "STATUS.GU_RUNNING has a reset value of too many bits",
        "CONTROL.GU_START is a pulse with a reset value",
        "STATUS.GU_RUNNING occurs twice",
        "STATUS has no field",
    ] {
        let mut own = map();
        let at = own
            .registers
            .iter()
            .position(|own| own.name == "CONTROL")
            .unwrap();
        let (control, status) = own.registers.split_at_mut(at + 1);
        let (control, status) = (&mut control[at], &mut status[0]);
        match text {
            "STATUS does not follow CONTROL" => status.offset = control.offset,
            "STATUS lies at 0x1000" => status.offset = 0x1000,
            "CONTROL occurs twice" => status.name = "CONTROL".to_owned(),
            "STATUS.VU_RUNNING has bits that it cannot have" => status.fields[0].width = 2,
            "STATUS.GU_RUNNING has a reset value of too many bits" => status.fields[0].reset = 2,
            "CONTROL.GU_START is a pulse with a reset value" => control.fields[0].reset = 1,
            "STATUS.GU_RUNNING occurs twice" => status.fields[1].name = "GU_RUNNING".to_owned(),
            _ => status.fields.clear(),
        }
        changes.push((text, own));
    }
    for (text, own) in changes {
        assert!(
            own.faults().iter().any(|fault| fault == text),
            "{text}: {:?}",
            own.faults()
        );
    }
}

#[test]
fn the_json_has_every_field_with_its_reset_value() {
    let map = register_map_of(&Config::default()).unwrap();
    let read: serde_json::Value = serde_json::from_str(&json(&map)).unwrap();
    let listed = read["registers"].as_array().unwrap();
    assert_eq!(listed.len(), map.registers.len());
    for (own, found) in map.registers.iter().zip(listed) {
        assert_eq!(found["offset"], own.offset);
        let mut reset = 0;
        for field in found["fields"].as_array().unwrap() {
            let [low, value] = ["low", "reset"].map(|key| field[key].as_u64().unwrap());
            reset |= value << low;
        }
        assert_eq!(found["reset"], reset, "{}", own.name);
        assert_eq!(found["fields"].as_array().unwrap().len(), own.fields.len());
    }
}

/// The page of the book shows the map of the default configuration.
#[test]
fn the_table_of_the_book_is_the_default_configuration_s() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/soc-top.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let marks = ["<!-- registers -->\n", "<!-- end of registers -->\n"];
    let (before, rest) = text.split_once(marks[0]).unwrap();
    let (found, after) = rest.split_once(marks[1]).unwrap();
    let expected = format!(
        "\n{}\n",
        tables(&register_map_of(&Config::default()).unwrap())
    );
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        let whole = [before, marks[0], &expected, marks[1], after].concat();
        return std::fs::write(&page, whole).unwrap();
    }
    assert!(
        found == expected,
        "{} has not today's registers; again: POTAMOI_REFRESH=1 cargo test -p potamoi-units the_table_of_the_book",
        page.display()
    );
}

/// A compiler reads the header as C99 and as C++, and finds the numbers of the table in it.
#[test]
fn the_c_header_compiles_without_a_warning_and_has_the_table_s_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let map = register_map_of(&Config::default()).unwrap();
    std::fs::write(
        folder.path().join("potamoi_npu.h"),
        c_header(&map, "", "test"),
    )
    .unwrap();
    let mut program =
        "#include \"potamoi_npu.h\"\n#include <stdio.h>\nint main(void) {\n".to_owned();
    let mut expected = String::new();
    for own in &map.registers {
        let name = &own.name;
        program += &format!(
            "printf(\"{name} %lx %lx\\n\", (unsigned long)POTAMOI_NPU_{name}_OFFSET, (unsigned long)POTAMOI_NPU_{name}_RESET);\n"
        );
        expected += &format!("{name} {:x} {:x}\n", own.offset, own.reset());
        for field in &own.fields {
            let whole = format!("{name}, {}", field.name);
            program += &format!(
                "printf(\"{whole} %lx\\n\", (unsigned long)POTAMOI_NPU_GET(POTAMOI_NPU_{name}_RESET | POTAMOI_NPU_SET(1, {whole}), {whole}));\n"
            );
            expected += &format!("{whole} {:x}\n", field.reset | 1);
        }
    }
    program += "static uint32_t memory[1024];\nmemory[POTAMOI_NPU_ID_OFFSET / 4] = 1;\n\
        printf(\"%d\\n\", potamoi_npu_is_known(memory));\n\
        potamoi_npu_start_gather(memory, 3, 5);\npotamoi_npu_start_vector(memory, 7);\n\
        potamoi_npu_clear(memory);\npotamoi_npu_snapshot(memory);\nreturn (int)potamoi_npu_take_events(memory);\n}\n";
    expected += "0\n";
    for (name, compiler) in [
        ("main.c", &["cc", "-std=c99"]),
        ("main.cpp", &["c++", "-std=c++11"]),
    ] {
        std::fs::write(folder.path().join(name), &program).unwrap();
        let compiled = Command::new(compiler[0])
            .current_dir(folder.path())
            .args([
                compiler[1],
                "-Wall",
                "-Wextra",
                "-Wpedantic",
                "-Werror",
                "-Wconversion",
                "-o",
                "program",
                name,
            ])
            .output()
            .unwrap_or_else(|e| panic!("{}: {e}; tools/setup installs it", compiler[0]));
        assert!(
            compiled.status.success(),
            "{}",
            String::from_utf8_lossy(&compiled.stderr)
        );
        let ran = Command::new(folder.path().join("program"))
            .output()
            .unwrap();
        assert_eq!(String::from_utf8(ran.stdout).unwrap(), expected, "{name}");
    }
}
