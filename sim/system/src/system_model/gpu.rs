//! The GPU of a system: a device of `potamoi-gpu`, and what a device file does not state.

use potamoi_formats::device_file::is_file;
use potamoi_gpu::Device;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A GPU in a system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Written", into = "Written")]
pub struct Gpu {
    /// Its rates, and its watts at work in the same power mode.
    pub device: Device,
    /// Power while it waits, in watts.
    pub idle_watts: f64,
    /// Whether its memory is the system's. Bytes then go through that, and the energy of each is
    /// the memory's. Otherwise its own memory's rate holds, and the energy is part of its watts.
    pub shares_memory: bool,
    /// Kernels that other hardware does in no time, for questions of the kind "what if"; their bytes still
    /// move. No description has any.
    pub moved: &'static [&'static str],
    /// Name or file, as given.
    given: String,
}

/// A GPU in a description: the device is a name, or the path of a device file.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Gpu")]
struct Written {
    device: String,
    idle_watts: f64,
    shares_memory: bool,
}

impl TryFrom<Written> for Gpu {
    type Error = String;

    fn try_from(own: Written) -> Result<Self, String> {
        Ok(Self {
            device: device(&own.device).map_err(|e| e.to_string())?,
            idle_watts: own.idle_watts,
            shares_memory: own.shares_memory,
            moved: &[],
            given: own.device,
        })
    }
}

impl From<Gpu> for Written {
    fn from(own: Gpu) -> Self {
        Self {
            device: own.given,
            idle_watts: own.idle_watts,
            shares_memory: own.shares_memory,
        }
    }
}

/// A device by its name, or by the path of a file that ends in `.toml`.
fn device(given: &str) -> Result<Device, potamoi_gpu::DeviceError> {
    match is_file(given) {
        true => Device::from_file(given),
        false => Device::builtin(given),
    }
}

impl Gpu {
    /// The mobile Volta GPU of the paper's Xavier, in its unlimited mode, the one in which the
    /// paper's 1.377 GHz exist. It shares the system's memory. Idle power is an assumption.
    pub(crate) fn xavier() -> Self {
        Self::builtin("xavier-maxn", 1.0, true)
    }

    /// The 2080 Ti of the paper's remote machine. Idle power is an assumption.
    pub(crate) fn rtx_2080_ti() -> Self {
        Self::builtin("2080ti", 15.0, false)
    }

    fn builtin(name: &str, idle_watts: f64, shares_memory: bool) -> Self {
        // Never infinite: tests read all built-in devices.
        let device = device(name).unwrap_or_else(|_| Device::infinite());
        Self {
            device,
            idle_watts,
            shares_memory,
            moved: &[],
            given: name.to_owned(),
        }
    }

    /// This GPU as another device: a name, or the path of a file.
    ///
    /// # Errors
    /// [`potamoi_gpu::DeviceError`], with all names and the nearest.
    pub fn of_device(self, given: &str) -> Result<Self, potamoi_gpu::DeviceError> {
        Ok(Self {
            device: device(given)?,
            given: given.to_owned(),
            ..self
        })
    }

    /// Bytes of its second-level cache. Misses are counted for it.
    #[must_use]
    pub const fn cache_bytes(&self) -> u32 {
        self.device.l2_bytes as u32
    }

    /// Power at work, in watts.
    #[must_use]
    pub const fn watts(&self) -> f64 {
        self.device.watts
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn built_in_gpus_are_devices_and_short_names_hold() {
        assert_eq!(
            Gpu::xavier().device,
            Device::builtin("xavier-maxn").unwrap()
        );
        assert_eq!(Gpu::rtx_2080_ti().device.name, "2080ti");
        let short = Gpu::xavier().of_device("xavier").unwrap();
        assert_eq!(short.device, Gpu::xavier().device);
        let wrong = Gpu::xavier().of_device("orin-mx").unwrap_err().to_string();
        assert!(wrong.contains("did you mean `orin-nx`?"), "{wrong}");
    }
}
