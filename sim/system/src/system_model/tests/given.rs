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
