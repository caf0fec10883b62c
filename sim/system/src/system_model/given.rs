//! What descriptions say of a system's devices: fields that are gone, and device files beside them.

use std::path::Path;

use potamoi_formats::device_file::is_file;
use potamoi_formats::document::Value;

/// Fields of the calibrated model of the GPU that this one does not have, and what to write.
const GONE: [(&str, &str); 11] = [
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
];
const NO_SHARE: &str =
    "leave it out: no share of a peak is calibrated any more, kernels are counted";

/// A field of the calibrated model in a description, and what to write instead.
pub(super) fn gone(given: &Value) -> Option<(String, String)> {
    for gpu in ["gpu", "remote"] {
        let part = given.get(gpu);
        let mut keys = GONE.iter();
        let has = |key| part.is_some_and(|part| part.get(key).is_some());
        if let Some((key, instead)) = keys.find(|(key, _)| has(key)) {
            let instead = match *instead {
                NO_SHARE => NO_SHARE.to_owned(),
                field => format!("write {field} ({gpu}.device = \"FILE.toml\")"),
            };
            return Some((format!("{gpu}.{key}"), instead));
        }
    }
    if given.get("interconnect_bytes_a_clock").is_some() {
        let instead = "write interconnect_over_memory, a ratio to the memory's peak".to_owned();
        return Some(("interconnect_bytes_a_clock".to_owned(), instead));
    }
    let counted = "leave it out: instructions are counted from each kernel, on each pipe";
    let gone = given.get("instructions");
    gone.map(|_| ("instructions".to_owned(), counted.to_owned()))
}

/// Device files of a description lie beside it.
pub(super) fn beside(given: Value, folder: &Path) -> Value {
    let Value::Map(entries) = given else {
        return given;
    };
    let entries = entries.into_iter().map(|(key, value)| {
        let own = match (&*key, value) {
            ("gpu" | "remote", Value::Map(parts)) => {
                let parts = parts.into_iter().map(|(key, value)| match &*key {
                    "device" => (key, file_beside(value, folder)),
                    _ => (key, value),
                });
                Value::Map(parts.collect())
            }
            ("memory", value) => file_beside(value, folder),
            (_, value) => value,
        };
        (key, own)
    });
    Value::Map(entries.collect())
}

fn file_beside(value: Value, folder: &Path) -> Value {
    match value {
        Value::Text(text) if is_file(&text) => {
            let path = folder.join(&*text).display().to_string();
            Value::Text(path.into())
        }
        value => value,
    }
}
