//! What descriptions and the command line say of a system's GPUs.

use std::path::Path;

use potamoi_formats::document::Value;

use super::gpu::is_file;
use super::system::{System, SystemError};

/// Fields of the calibrated model of the GPU that this one does not have, and what to write.
const GONE: [(&str, &str); 12] = [
    (
        "cores",
        "multiprocessors, fp32_lanes and int_lanes of a device file",
    ),
    ("clock_ghz", "clock_ghz of a device file"),
    ("cache_gb_s", "l2_bytes_clock of a device file"),
    ("cache_bytes", "l2_bytes of a device file"),
    (
        "memory_gb_s",
        "dram_gb_s of a device file, and shares_memory = false",
    ),
    ("launch_us", "launch_us and ramp_us of a device file"),
    (
        "watts",
        "watts of a device file, in the same power mode as its clock",
    ),
    ("gathering_factor", NO_SHARE),
    ("fields_efficiency", NO_SHARE),
    ("splats_efficiency", NO_SHARE),
    ("pictures_efficiency", NO_SHARE),
    ("reaching", NO_SHARE),
];
const NO_SHARE: &str = "nothing: no share of a peak is calibrated any more, kernels are counted";

/// Refuses fields of the calibrated model by name.
pub(super) fn refuse_gone(given: &Value, name: &str) -> Result<(), SystemError> {
    let refuse = |field: String, instead: &str| {
        Err(SystemError::Gone {
            name: name.to_owned(),
            field,
            instead: instead.to_owned(),
        })
    };
    for gpu in ["gpu", "remote"] {
        let Some(part) = given.get(gpu) else { continue };
        for (key, instead) in GONE {
            if part.get(key).is_some() {
                let device = format!("{instead} ({gpu}.device = \"FILE.toml\")");
                let instead = if instead == NO_SHARE {
                    instead
                } else {
                    &device
                };
                return refuse(format!("{gpu}.{key}"), instead);
            }
        }
    }
    match given.get("instructions") {
        Some(_) => {
            let instead = "nothing: instructions are counted from each kernel, on each pipe";
            refuse("instructions".to_owned(), instead)
        }
        None => Ok(()),
    }
}

/// Device files of a description lie beside it.
pub(super) fn beside(given: Value, folder: &Path) -> Value {
    let Value::Map(entries) = given else {
        return given;
    };
    let entries = entries.into_iter().map(|(key, value)| {
        let own = match (&*key, value) {
            ("gpu" | "remote", Value::Map(parts)) => {
                let parts = parts.into_iter().map(|(key, value)| match value {
                    Value::Text(text) if &*key == "device" && is_file(&text) => {
                        let path = folder.join(&*text).display().to_string();
                        (key, Value::Text(path.into()))
                    }
                    value => (key, value),
                });
                Value::Map(parts.collect())
            }
            (_, value) => value,
        };
        (key, own)
    });
    Value::Map(entries.collect())
}

impl System {
    /// The system that the command line names: a description's file, or the paper's system with
    /// another device, by name.
    ///
    /// # Errors
    /// As [`System::read`]; no device has that name.
    pub fn named(given: &Path) -> Result<Self, SystemError> {
        match given
            .to_str()
            .filter(|name| !is_file(name) && !given.exists())
        {
            None => Self::read(given),
            Some(name) => {
                let system = Self::default();
                let gpu = system.gpu.clone().of_device(name);
                let gpu = gpu.map_err(|error| SystemError::Device(error.to_string()))?;
                Ok(Self { gpu, ..system })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
        assert!(
            wrong.contains("the devices are") && wrong.contains("xavier-nx"),
            "{wrong}"
        );
        let folder = tempfile::tempdir().unwrap();
        let device = include_str!("../../../gpu/devices/orin-nano.toml");
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
}
