//! Tables of `docs/reference/memory-devices.md`, compared with the page, or written into it.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;

use super::super::{Memory, Rate};
use super::*;

/// Names of the standards for keys, where they have one.
const SYMBOLS: [(&str, &str); 30] = [
    ("burst_length", "BL"),
    ("clock_ns", "tCK"),
    ("read_latency_clocks", "RL"),
    ("write_latency_clocks", "WL"),
    ("activate_to_column_ns", "tRCD"),
    ("precharge_ns", "tRPpb"),
    ("activate_to_precharge_ns", "tRAS"),
    ("activate_to_activate_ns", "tRRD"),
    ("four_activates_ns", "tFAW"),
    ("column_to_column_clocks", "tCCD, tCCD_S"),
    ("column_to_column_group_clocks", "tCCD_L"),
    ("write_to_read_ns", "tWTR, tWTR_S"),
    ("write_to_read_group_ns", "tWTR_L"),
    ("write_recovery_ns", "tWR"),
    ("read_to_precharge_ns", "tRTP"),
    ("precharge_to_precharge_clocks", "tPPD"),
    ("refresh_ns", "tRFCab"),
    ("refresh_interval_ns", "tREFI"),
    ("idd0_vdd1_ma", "IDD01"),
    ("idd0_vdd2_ma", "IDD02"),
    ("idd2n_vdd1_ma", "IDD2N1"),
    ("idd2n_vdd2_ma", "IDD2N2"),
    ("idd3n_vdd1_ma", "IDD3N1"),
    ("idd3n_vdd2_ma", "IDD3N2"),
    ("idd4r_vdd1_ma", "IDD4R1"),
    ("idd4r_vdd2_ma", "IDD4R2"),
    ("idd4w_vdd1_ma", "IDD4W1"),
    ("idd4w_vdd2_ma", "IDD4W2"),
    ("idd5_vdd1_ma", "IDD51"),
    ("idd5_vdd2_ma", "IDD52"),
];

fn all() -> Vec<MemoryDevice> {
    let names = MemoryDevice::names().into_iter();
    names
        .map(|name| MemoryDevice::builtin(name).unwrap())
        .collect()
}

/// A channel of each device, and its rates on the model.
fn devices() -> String {
    let mut text = "| device | channels x ranks of a package | a channel, GB/s | streamed | single bursts | refreshes | streamed, \
                    pJ a bit | single bursts | of both, data lines |\n|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for own in all() {
        let (memory, timing) = (Memory::new(&own, 1), own.timing());
        let [stream, single] = [memory.streamed(), memory.random(32.0)];
        let gb_s = |rate: &Rate| format!("{:.2}", 1.0 / rate.ns);
        let a_bit = |rate: &Rate| format!("{:.2}", rate.pj / 8.0);
        writeln!(
            text,
            "| `{}`: {} | {} x {} | {:.2} | {} | {} | {:.1} % | {} | {} | {:.2} |",
            own.name,
            own.title,
            own.package_channels(),
            own.value("ranks"),
            own.peak_gb_s(),
            gb_s(&stream),
            gb_s(&single),
            100.0 * timing.refresh as f64 / timing.refresh_interval as f64,
            a_bit(&stream),
            a_bit(&single),
            own.interface().pj_a_bit(),
        )
        .unwrap();
    }
    text
}

/// Every figure of every device.
fn figures() -> String {
    let names = MemoryDevice::names().join("` | `");
    let mut text =
        format!("| key | standard's name | unit | range | `{names}` |\n|---|---|---|---|");
    text += &"---|".repeat(all().len());
    text.push('\n');
    for figure in &FIGURES {
        let symbol = SYMBOLS.iter().find(|(key, _)| *key == figure.key);
        let values = all().into_iter().map(|own| {
            let mark = match own.origins[figure.key] {
                Origin::Source(_) => "",
                Origin::Assumed(_) => "*",
            };
            format!("{}{mark}", own.value(figure.key))
        });
        writeln!(
            text,
            "| `{}` | {} | {} | {} to {} | {} |",
            figure.key,
            symbol.map_or("", |(_, symbol)| symbol),
            figure.unit,
            figure.least,
            figure.most,
            values.collect::<Vec<_>>().join(" | "),
        )
        .unwrap();
    }
    text
}

#[test]
fn the_table_of_the_book_has_every_memory_device() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/memory-devices.md");
    let mut text = std::fs::read_to_string(&page).unwrap();
    let is_refreshed = std::env::var_os("POTAMOI_REFRESH").is_some();
    for (marks, expected) in [
        (
            ["<!-- devices -->\n", "<!-- end of devices -->\n"],
            devices(),
        ),
        (
            ["<!-- figures of devices -->\n", "<!-- end of figures -->\n"],
            figures(),
        ),
    ] {
        let (before, rest) = text.split_once(marks[0]).unwrap();
        let (found, after) = rest.split_once(marks[1]).unwrap();
        let expected = format!("\n{expected}\n");
        assert!(
            is_refreshed || found == expected,
            "{} is not what the devices are; again: POTAMOI_REFRESH=1 cargo test -p potamoi-system the_table_of_the_book",
            page.display()
        );
        text = [before, marks[0], &expected, marks[1], after].concat();
    }
    if is_refreshed {
        std::fs::write(&page, text).unwrap();
    }
}
