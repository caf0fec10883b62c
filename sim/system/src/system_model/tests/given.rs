//! Systems as files and as names of devices.

use std::path::Path;

use super::*;

#[test]
fn what_is_gone_is_refused_by_name_with_what_to_write() {
    for (text, field, instead) in [
        ("gpu.cores = 512", "gpu.cores", "multiprocessors"),
        ("remote.watts = 250", "remote.watts", "remote.device"),
        (
            "gpu.fields_efficiency = 0.1",
            "gpu.fields_efficiency",
            "no share",
        ),
        ("[instructions]\nsample = 40", "instructions", "counted"),
    ] {
        let error = System::from_toml(text, "s.toml").unwrap_err().to_string();
        assert!(error.contains("s.toml") && error.contains(field), "{error}");
        assert!(error.contains(instead), "{error}");
    }
}

#[test]
fn a_system_is_a_device_or_a_file_with_files_beside_it() {
    let orin = System::named(Path::new("orin-nx")).unwrap();
    assert_eq!(orin.gpu.device.name, "orin-nx");
    let wrong = System::named(Path::new("xaver")).unwrap_err().to_string();
    assert!(wrong.contains("did you mean `xavier`?"), "{wrong}");
    let folder = tempfile::tempdir().unwrap();
    let device = include_str!("../../../../gpu/devices/orin-nano.toml");
    std::fs::write(folder.path().join("mine.toml"), device).unwrap();
    let bare = System::named(&folder.path().join("mine.toml")).unwrap();
    assert_eq!(bare.gpu.device.name, "mine");
    let path = folder.path().join("s.toml");
    std::fs::write(&path, "gpu.device = \"mine.toml\"\n").unwrap();
    let found = System::named(&path).unwrap();
    assert_eq!(found.gpu.device.name, "mine");
    assert_eq!(
        found.gpu.device.watts,
        System::named(Path::new("orin-nano"))
            .unwrap()
            .gpu
            .device
            .watts
    );
}

/// A memory is a device by name, or a file beside the description; what is wrong with either names
/// the description.
#[test]
fn a_memory_is_a_device_or_a_file_beside_it() {
    let read = |text: &str| System::from_toml(text, "s.toml");
    assert_eq!(System::default().memory.name, "lpddr3-1600");
    let own = read("memory = \"lpddr4x-4266\"\nmemory_channels = 16").unwrap();
    assert_eq!(own.memory.name, "lpddr4x-4266");
    assert_eq!(Memory::of(&own).channels(), 16);
    let text = toml::to_string(&own).unwrap();
    assert_eq!(read(&text).unwrap(), own);
    for (text, said) in [
        ("memory = \"lpddr4-4266\"", "did you mean `lpddr4x-4266`?"),
        ("memory = \"none.toml\"", "none.toml"),
        ("memory = 3", "memory"),
        ("memory_channels = 3", "1, 2, 4, 8 or 16"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains("s.toml") && error.contains(said), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let device = include_str!("../../../memories/lpddr5-6400.toml");
    std::fs::write(folder.path().join("mine.toml"), device).unwrap();
    let system = folder.path().join("system.toml");
    std::fs::write(&system, "memory = \"mine.toml\"").unwrap();
    let own = System::read(&system).unwrap().memory;
    assert_eq!((&*own.name, own.peak_gb_s()), ("mine", 12.8));
}
