//! DRAMsim3 with a memory of the project's model, as the reference for its clock counts.
//!
//! The file that comes with DRAMsim3 for 8 Gb x32 at 1600 MT/s has a bus of 64 bits, and `REFI` for
//! `tREFI`, so that it refreshes every 7800 clocks instead of every 3120.

use std::fmt::Write as _;

use dramsim3::MemorySystem;
use potamoi_system::system_model::dram::{Access, Geometry, Timing};

/// Rows of a bank: addresses of the tests are below 1 GB.
const ROWS: u64 = 1 << 15;

/// Its configuration: the sizes and delays of the model, the policies that the model says of
/// itself.
///
/// DRAMsim3 derives the clocks of a burst from its transfers, two a clock, and its bytes from them
/// and the width of the bus. A memory of eight transfers a clock (LPDDR5, which DRAMsim3 does not
/// have) has a bus as wide as its burst needs, and a protocol with bank groups. Of the names of
/// protocols LPDDR4 alone has an effect, the delay between precharges.
#[must_use]
pub fn configuration(geometry: &Geometry, timing: &Timing) -> String {
    let mut text = String::new();
    let mut section = |name: &str, fields: &[(&str, String)]| {
        let _ = writeln!(text, "[{name}]");
        for (field, value) in fields {
            let _ = writeln!(text, "{field} = {value}");
        }
    };
    let of = |value: u64| value.to_string();
    let protocol = match timing.precharge_to_precharge {
        0 => "LPDDR3",
        _ => "LPDDR4",
    };
    let transfers = 2 * timing.burst;
    let width = 8 * u64::from(geometry.burst_bytes) / transfers;
    let row_bytes = u64::from(geometry.row_bursts * geometry.burst_bytes);
    let rank_megabytes = (row_bytes * ROWS * u64::from(geometry.banks)) >> 20;
    section(
        "dram_structure",
        &[
            ("protocol", protocol.to_owned()),
            ("bankgroups", geometry.bank_groups.to_string()),
            ("banks_per_group", geometry.banks_of_group().to_string()),
            ("rows", of(ROWS)),
            ("columns", of(transfers * u64::from(geometry.row_bursts))),
            ("device_width", of(width)),
            ("BL", of(transfers)),
        ],
    );
    section(
        "timing",
        &[
            ("tCK", timing.clock_ns.to_string()),
            ("AL", of(0)),
            ("CL", of(timing.read_latency)),
            ("CWL", of(timing.write_latency)),
            ("tRCD", of(timing.activate_to_column)),
            ("tRP", of(timing.precharge)),
            ("tRAS", of(timing.activate_to_precharge)),
            ("tRFC", of(timing.refresh)),
            ("tREFI", of(timing.refresh_interval)),
            ("tRRD_S", of(timing.activate_to_activate)),
            ("tRRD_L", of(timing.activate_to_activate)),
            ("tWTR_S", of(timing.write_to_read)),
            ("tWTR_L", of(timing.write_to_read_group)),
            ("tFAW", of(timing.four_activates)),
            ("tWR", of(timing.write_recovery)),
            ("tRTP", of(timing.read_to_precharge)),
            ("tCCD_S", of(timing.column_to_column)),
            ("tCCD_L", of(timing.column_to_column_group)),
            ("tPPD", of(timing.precharge_to_precharge)),
            ("tRTRS", of(timing.turnaround)),
        ],
    );
    section(
        "system",
        &[
            (
                "channel_size",
                of(u64::from(geometry.ranks) * rank_megabytes),
            ),
            ("channels", geometry.channels.to_string()),
            ("bus_width", of(width)),
            ("address_mapping", "rorabacobgch".to_owned()),
            ("queue_structure", "PER_BANK".to_owned()),
            ("refresh_policy", "RANK_LEVEL_STAGGERED".to_owned()),
            ("row_buf_policy", "OPEN_PAGE".to_owned()),
            ("cmd_queue_size", of(8)),
            ("trans_queue_size", of(32)),
        ],
    );
    section(
        "other",
        &[("epoch_period", of(1_000_000_000)), ("output_level", of(0))],
    );
    text
}

/// Clocks until the last access is done, each offered as soon as there is room for it. Writes
/// count as done when they are taken.
///
/// # Errors
/// Its configuration cannot be written.
pub fn clocks(
    geometry: &Geometry,
    timing: &Timing,
    accesses: &[Access],
) -> Result<u64, std::io::Error> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("memory.ini");
    std::fs::write(&file, configuration(geometry, timing))?;
    let mut memory = MemorySystem::new(&file, folder.path())
        .map_err(|e| std::io::Error::other(format!("{e:?}")))?;
    let reads = accesses.iter().filter(|a| !a.is_write).count();
    let mut waiting = accesses.iter().peekable();
    let (mut clocks, mut done) = (0, 0);
    while done < reads || waiting.peek().is_some() {
        while let Some(next) = waiting.next_if(|a| memory.can_add(a.address, a.is_write)) {
            memory.add(next.address, next.is_write);
        }
        memory.tick(|_, is_write| done += usize::from(!is_write));
        clocks += 1;
    }
    Ok(clocks)
}
