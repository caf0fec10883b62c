//! Sources of the figures, and what is assumed.

use potamoi_explore::system::Modelled;
use potamoi_system::system_model::{Gpu, Scenario, System};

use super::{areas, clock};
use crate::stdout::{prose, say};

/// Source of the energies, and what is assumed.
pub(super) fn print(found: &Modelled, system: &System) {
    say!(
        "\n{}",
        crate::tables::fitted(&clock::table(&found.clock), &[])
    );
    say!(
        "\n{}",
        crate::tables::fitted(&areas::table(&found.area), &[])
    );
    areas::say_memories(&found.area);
    if found.reorder_bytes > 0 {
        prose!(
            2,
            "the reorder buffer of {} bytes lies in global_feature_buffer",
            found.reorder_bytes
        );
    }
    say!("");
    prose!(0, "energy: {}", found.energy_origin);
    for unknown in &found.energy_unknown {
        prose!(
            0,
            "energy of the {} is not known: {}",
            unknown.block,
            unknown.why
        );
    }
    of_system(system, found.outcomes.iter().map(|o| o.scenario));
    prose!(
        0,
        "each figure that depends on a GPU is from where all demands of a kernel overlap to where \
         none do; mid is the geometric mean; a ratio that includes 1 is no conclusion"
    );
}

/// The GPUs and the memory, with what is assumed of them.
pub(super) fn of_system(system: &System, mut scenarios: impl Iterator<Item = Scenario>) {
    prose!(
        0,
        "GPU: {}; assumed: walked and blending shares and the longest tile of splats, lines and \
         sectors of a request of fields (sim/gpu/rows)",
        described(&system.gpu, system)
    );
    prose!(0, "memory: {}", memory_described(system));
    if scenarios.any(|scenario| scenario == Scenario::Remote) {
        prose!(0, "remote GPU: {}", described(&system.remote, system));
    }
}

/// Device, channels, packages and rate of the memory, and the energy of its data lines.
fn memory_described(system: &System) -> String {
    let (device, channels) = (&system.memory, system.memory_channels);
    let (of_package, channels_of) = (device.package_channels(), f64::from(channels));
    let packages = match channels.div_ceil(of_package) {
        1 if channels < of_package => format!("of the {of_package} of a package"),
        1 => "in a package".to_owned(),
        packages => format!("in {packages} packages"),
    };
    format!(
        "{}, {channels} channels {packages}, {:.1} GB/s; data lines take {:.2} pJ a bit, derived \
         from their capacitance and swing (docs/reference/memory-devices.md)",
        device.title,
        channels_of * device.peak_gb_s(),
        device.interface().pj_a_bit()
    )
}

/// Device, power mode, memory and watts of a GPU.
fn described(gpu: &Gpu, system: &System) -> String {
    let device = &gpu.device;
    let peak = f64::from(system.memory_channels) * system.memory.peak_gb_s();
    let memory = match gpu.shares_memory {
        true => format!(
            "the system's memory of {peak:.1} GB/s (by itself it has {:.0} GB/s)",
            device.dram_gb_s
        ),
        false => format!("a memory of its own of {:.0} GB/s", device.dram_gb_s),
    };
    format!(
        "{} ({}), {memory}, {} W active, {} W idle (assumed)",
        device.title, device.mode, device.watts, gpu.idle_watts
    )
}
