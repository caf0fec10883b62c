//! Figures of a memory device: keys, units, ranges, and what they have to be together.

use potamoi_formats::device_file::{DeviceError, Figure};

use super::MemoryDevice;

const fn figure(key: &'static str, unit: &'static str, [least, most]: [f64; 2]) -> Figure {
    Figure {
        key,
        unit,
        least,
        most,
    }
}

const NS: [f64; 2] = [0.0, 1000.0];
const CLOCKS: [f64; 2] = [0.0, 255.0];
const MA: [f64; 2] = [0.0, 5000.0];

/// All figures of a file, in the order of the book.
pub const FIGURES: [Figure; 50] = [
    figure("channel_bits", "bits", [8.0, 128.0]),
    figure("channels", "channels a package", [1.0, 16.0]),
    figure("die_channels", "channels a die", [1.0, 16.0]),
    figure("ranks", "ranks a channel", [1.0, 4.0]),
    figure("bank_groups", "groups a rank", [1.0, 8.0]),
    figure("banks", "banks a rank", [2.0, 64.0]),
    figure("row_bytes", "bytes", [256.0, 65_536.0]),
    figure("burst_length", "transfers", [2.0, 64.0]),
    figure("transfers_a_clock", "transfers a clock", [1.0, 16.0]),
    figure("clock_ns", "ns", [0.1, 20.0]),
    figure("read_latency_clocks", "clocks", CLOCKS),
    figure("write_latency_clocks", "clocks", CLOCKS),
    figure("activate_to_column_ns", "ns", NS),
    figure("precharge_ns", "ns", NS),
    figure("activate_to_precharge_ns", "ns", NS),
    figure("activate_to_activate_ns", "ns", NS),
    figure("four_activates_ns", "ns", NS),
    figure("column_to_column_clocks", "clocks", CLOCKS),
    figure("column_to_column_group_clocks", "clocks", CLOCKS),
    figure("write_to_read_ns", "ns", NS),
    figure("write_to_read_group_ns", "ns", NS),
    figure("write_recovery_ns", "ns", NS),
    figure("read_to_precharge_ns", "ns", NS),
    figure("precharge_to_precharge_clocks", "clocks", CLOCKS),
    figure("turnaround_clocks", "clocks", CLOCKS),
    figure("rank_switch_clocks", "clocks", CLOCKS),
    figure("refresh_ns", "ns", [0.0, 2000.0]),
    figure("refresh_interval_ns", "ns", [500.0, 64_000.0]),
    figure("vdd1_volts", "V", [0.0, 5.0]),
    figure("vdd2_volts", "V", [0.1, 5.0]),
    figure("idd0_vdd1_ma", "mA", MA),
    figure("idd0_vdd2_ma", "mA", MA),
    figure("idd2n_vdd1_ma", "mA", MA),
    figure("idd2n_vdd2_ma", "mA", MA),
    figure("idd3n_vdd1_ma", "mA", MA),
    figure("idd3n_vdd2_ma", "mA", MA),
    figure("idd4r_vdd1_ma", "mA", MA),
    figure("idd4r_vdd2_ma", "mA", MA),
    figure("idd4w_vdd1_ma", "mA", MA),
    figure("idd4w_vdd2_ma", "mA", MA),
    figure("idd5_vdd1_ma", "mA", MA),
    figure("idd5_vdd2_ma", "mA", MA),
    figure("io_volts", "V", [0.1, 5.0]),
    figure("io_swing_volts", "V", [0.05, 5.0]),
    figure("io_pf", "pF", [0.0, 100.0]),
    figure("io_changes", "of the bits", [0.0, 1.0]),
    figure("io_ohms", "ohms, 0 without termination", [0.0, 1e4]),
    figure("capacity_gbit", "Gbit a package", [0.1, 4096.0]),
    figure("die_gbit", "Gbit a die", [0.1, 512.0]),
    figure("dies", "dies a package", [1.0, 64.0]),
];

/// Figures that address bits come from.
const POWERS: [&str; 8] = [
    "channel_bits",
    "channels",
    "die_channels",
    "ranks",
    "bank_groups",
    "banks",
    "row_bytes",
    "burst_length",
];

/// Refuses figures that are each in range and describe no memory together.
pub(super) fn check(own: &MemoryDevice, file: &str) -> Result<(), DeviceError> {
    let refuse = |key: &str, expected: String, action: &str| {
        Err(DeviceError::Field {
            file: file.to_owned(),
            field: key.to_owned(),
            found: own.value(key).to_string(),
            expected,
            action: action.to_owned(),
        })
    };
    for key in POWERS {
        let value = own.value(key);
        if value.fract() != 0.0 || !(value as u64).is_power_of_two() {
            let expected = "it is a power of two".to_owned();
            return refuse(key, expected, "addresses are split by bits");
        }
    }
    let clocks = FIGURES.iter().map(|figure| figure.key);
    for key in clocks.filter(|key| key.ends_with("_clocks")) {
        if own.value(key).fract() != 0.0 {
            return refuse(key, "it is a whole number".to_owned(), "write whole clocks");
        }
    }
    let (burst, a_clock) = (own.value("burst_length"), own.value("transfers_a_clock"));
    if burst % a_clock != 0.0 {
        let expected = format!("a divisor of a burst of {burst} transfers");
        return refuse("transfers_a_clock", expected, "a burst takes whole clocks");
    }
    if own.value("bank_groups") > own.value("banks") {
        let expected = format!("a rank has {} banks", own.value("banks"));
        return refuse("bank_groups", expected, "write 1 without groups");
    }
    let burst_bytes = burst * own.value("channel_bits") / 8.0;
    if own.value("row_bytes") < burst_bytes {
        let expected = format!("a burst has {burst_bytes} bytes");
        return refuse(
            "row_bytes",
            expected,
            "write the bytes of a row of a channel",
        );
    }
    for [group, other] in [
        ["column_to_column_group_clocks", "column_to_column_clocks"],
        ["write_to_read_group_ns", "write_to_read_ns"],
    ] {
        let (value, least) = (own.value(group), own.value(other));
        if value < least || (own.value("bank_groups") == 1.0 && value != least) {
            let expected = format!("`{other}` is {least}");
            let action = "write the same without bank groups, and no less with them";
            return refuse(group, expected, action);
        }
    }
    if own.value("refresh_ns") >= own.value("refresh_interval_ns") / own.value("ranks") {
        let expected = "ranks are refreshed in turn within the interval".to_owned();
        return refuse("refresh_ns", expected, "look up tRFCab and tREFI");
    }
    if own.value("io_swing_volts") > own.value("io_volts") {
        let expected = format!("the supply has {} V", own.value("io_volts"));
        return refuse("io_swing_volts", expected, "write the swing of a data line");
    }
    let bits = own.value("dies") * own.value("die_gbit");
    if (bits / own.value("capacity_gbit") - 1.0).abs() > 1e-9 {
        let expected = format!("its dies hold {bits} Gbit");
        return refuse("capacity_gbit", expected, "count the dies");
    }
    let dies = own.value("channels") * own.value("ranks") / own.value("die_channels");
    if dies != own.value("dies") {
        let expected = format!("its channels and ranks are {dies} dies");
        return refuse("dies", expected, "count channels, ranks and channels a die");
    }
    Ok(())
}
