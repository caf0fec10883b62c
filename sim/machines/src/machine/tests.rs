#![allow(clippy::unwrap_used)]
use proptest::prelude::*;

use super::*;

fn machine(text: &str) -> Result<Machine, MachineError> {
    let document = document::toml(text.as_bytes()).unwrap();
    Machine::of_document("m.toml", document, Path::new(""))
}

#[test]
fn a_configuration_is_a_machine() {
    for (name, text) in PRESETS {
        let own = machine(text).unwrap();
        let hardware = own.hardware.clone();
        // A preset whose every key is the default's names no hardware.
        if let Some(hardware) = hardware {
            assert_eq!(hardware.preset, Some(name), "{name}");
        }
        assert_eq!(own.system, System::default());
        assert!(own.sections().is_empty());
        let named = Machine::named(name).unwrap();
        assert_eq!(named.hardware.unwrap().preset, Some(name));
    }
}

#[test]
fn a_file_changes_what_it_names() {
    let own = machine(
        "preset = \"lean-splats\"\n[su]\nunits = 4\n[system]\nmemory_channels = 2\n\
         gpu.device = \"orin-nx\"\n[render]\nalpha_min = 0.01\nwithout = [\"sh_colour\"]\n[path]\nwindow = 8\n",
    );
    let own = own.unwrap();
    let config = own.hardware.as_ref().unwrap();
    assert_eq!(
        (config.config.su.as_ref().unwrap().units, config.preset),
        (4, None)
    );
    assert_eq!(own.system.memory_channels, 2);
    assert_eq!(own.system.gpu.device.name, "orin-nx");
    assert_eq!(own.path.variant().name, "potamoi");
    assert_eq!(own.sections(), Section::ALL);
    let again = Machine::of_document(
        "again",
        document::toml(own.to_toml().unwrap().as_bytes()).unwrap(),
        Path::new(""),
    );
    assert_eq!(again.unwrap().identity(), own.identity());
}

#[test]
fn a_point_changes_one_field() {
    let own = machine("preset = \"paper\"\nclock_ghz = 1.0").unwrap();
    let point = own
        .with(
            "p",
            &[
                ("vu.lanes", Value::Int(48)),
                ("system.memory_channels", Value::Int(1)),
                ("clock_ghz", Value::Text("reached".into())),
            ],
        )
        .unwrap();
    let config = &point.hardware.as_ref().unwrap().config;
    assert_eq!((config.vu.lanes, config.clock_mhz), (48, None));
    assert_eq!(point.system.memory_channels, 1);
    assert_ne!(point.identity(), own.identity());
    assert_eq!(point.value("vu.lanes").as_deref(), Some("48"));
    assert_eq!(own.value("vu.lanes").as_deref(), Some("24"));
    assert_eq!(own.value("vu.exp.form").as_deref(), Some("restoring"));
    assert_eq!(own.value("system.memory_channels").as_deref(), Some("4"));
    assert_eq!(
        own.value("system.gpu.device").as_deref(),
        Some("xavier-maxn")
    );
    assert_eq!(own.value("gu.vertices").as_deref(), Some("[8, 4, 2]"));
    assert_eq!(own.value("render.step"), None);
}

#[test]
fn mistakes_are_named() {
    for (text, said) in [
        ("preset = \"papr\"", "did you mean `paper`?"),
        ("preset = 3", "found 3, expected one of paper"),
        (
            "[sytem]\nmemory_channels = 2",
            "expected one of preset, system, render, path",
        ),
        ("[system]\nmemory_chanels = 2", "memory_chanels"),
        ("[system]\nmemory_channels = 3", "1, 2, 4, 8 or 16"),
        ("[path]\nvariant = \"potmoi\"", "did you mean `potamoi`?"),
        ("[path]\nwindow = 0", "1 frame or more"),
        ("[path]\nvariant = \"fs\"\nwindow = 3", "leave it out"),
        ("[path]\nphi = -1", "0 to 180 degrees"),
        ("[path]\nspeed = 3", "path.speed"),
        ("[render]\nwithout = 3", "render.without"),
        ("[vu]\nlanes = 0", "vu.lanes"),
        ("system = 3", "system"),
    ] {
        let error = machine(text).unwrap_err().to_string();
        assert!(
            error.contains(said) && error.contains("m.toml"),
            "{text}: {error}"
        );
    }
}

#[test]
fn render_settings_are_for_the_scene() {
    let own = machine("[render]\norder = \"approximate\"").unwrap();
    assert_eq!(own.hardware, None);
    own.prepare(&mut Scene::open("garden").unwrap()).unwrap();
    let error = own.prepare(&mut Scene::open("lantern").unwrap());
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("m.toml") && error.contains("render.order"),
        "{error}"
    );
    let wrong = machine("[render]\nwithout = [\"rain\"]").unwrap();
    let error = wrong.prepare(&mut Scene::open("garden").unwrap());
    assert!(error.unwrap_err().to_string().contains("rain"));
}

proptest! {
    /// What is written is read again, whatever was changed.
    #[test]
    fn a_written_machine_is_the_same(
        lanes in 1i64..64, channels in prop::sample::select(vec![1i64, 2, 4, 8]),
        window in prop::option::of(1i64..32), clock in prop::option::of(1i64..4000),
        preset in prop::sample::select(vec!["paper", "pipelined", "piecewise"]),
    ) {
        let base = Machine::named(preset).unwrap();
        let mut changes = vec![
            ("vu.lanes", Value::Int(lanes)),
            ("system.memory_channels", Value::Int(channels)),
        ];
        changes.extend(window.map(|own| ("path.window", Value::Int(own))));
        changes.extend(clock.map(|mhz| ("clock_ghz", Value::Float(mhz as f64 / 1e3))));
        let Ok(own) = base.with("p", &changes) else { return Ok(()) };
        let text = own.to_toml().unwrap();
        let again = Machine::of_document("again", document::toml(text.as_bytes()).unwrap(), Path::new(""));
        prop_assert_eq!(again.unwrap().identity(), own.identity());
    }
}

/// Devices are what their files say, wherever those lie.
#[test]
fn a_device_counts_by_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let devices = [
        "../gpu/devices/xavier-nx.toml",
        "../system/memories/lpddr3-1600.toml",
    ];
    let devices = devices.map(|own| std::fs::read_to_string(own).unwrap());
    let at = |place: &str, changed: (&str, &str)| {
        let place = folder.path().join(place);
        std::fs::create_dir_all(&place).unwrap();
        let own = "[system]\nmemory = \"memory.toml\"\ngpu.device = \"gpu.toml\"\n";
        std::fs::write(place.join("own.toml"), own).unwrap();
        for (name, text) in ["gpu.toml", "memory.toml"].iter().zip(&devices) {
            let (from, to) = changed;
            std::fs::write(place.join(name), text.replacen(from, to, 1)).unwrap();
        }
        Machine::read(&place.join("own.toml")).unwrap().identity()
    };
    let own = at("a", ("", ""));
    assert_eq!(own, at("b", ("", "")));
    let watts = ("watts = { value = 15", "watts = { value = 14");
    assert_ne!(own, at("c", watts));
    let clock = ("clock_ns = { value = 1.25", "clock_ns = { value = 1.5");
    assert_ne!(own, at("d", clock));
}
