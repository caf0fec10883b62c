//! Ranges of a system's numbers. Within them are machines that could be built.

/// Range of a field, ends included.
pub(super) struct Range {
    /// Path of the field.
    pub(super) field: &'static str,
    low: f64,
    high: f64,
    /// The range and its unit, as in messages and the book.
    pub(super) expected: &'static str,
}

impl Range {
    /// Whether `value` is in range; NaN never is.
    pub(super) fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

const fn range(field: &'static str, [low, high]: [f64; 2], expected: &'static str) -> Range {
    Range {
        field,
        low,
        high,
        expected,
    }
}

const KILO: f64 = 1024.0;
const GIGA: f64 = KILO * KILO * KILO;

const WATTS: [f64; 2] = [0.0, 1e5];

/// One row for each number.
pub(super) const RANGES: [Range; 19] = [
    range("array_rows", [1.0, 1024.0], "1 to 1024"),
    range("array_columns", [1.0, 1024.0], "1 to 1024"),
    range(
        "feature_buffer_bytes",
        [2.0 * KILO, 64.0 * GIGA],
        "two blocks or more, 64 GiB at most",
    ),
    range("feature_block_bytes", [KILO, GIGA], "1024 bytes to 1 GiB"),
    range("feature_banks", [1.0, 1024.0], "1 to 1024"),
    range(
        "feature_block_banks",
        [1.0, 1024.0],
        "1 to 1024, a divisor of feature_banks",
    ),
    range("weight_buffer_bytes", [0.0, 64.0 * GIGA], "0 to 64 GiB"),
    range("memory_channels", [1.0, 16.0], "1, 2, 4, 8 or 16"),
    range("dma_descriptor_bytes", [0.0, 4096.0], "0 to 4096 bytes"),
    range(
        "interconnect_over_memory",
        [0.001, 1000.0],
        "0.001 to 1000, a ratio",
    ),
    range(
        "interconnect_pj_per_byte",
        [0.0, 1e6],
        "0 to 1e6 picojoules",
    ),
    range("groups_in_flight", [1.0, 1_048_576.0], "1 to 1048576"),
    range("wire_margin", [0.0, 10.0], "0 to 10, a share of the period"),
    range(
        "link_bytes_per_second",
        [1.0, 1e15],
        "1 to 1e15 bytes a second",
    ),
    range("link_nj_per_byte", [0.0, 1e9], "0 to 1e9 nanojoules"),
    range("link_colour_bytes", [0.0, 1024.0], "0 to 1024 bytes"),
    range("link_depth_bytes", [0.0, 1024.0], "0 to 1024 bytes"),
    range(
        "gpu.idle_watts",
        WATTS,
        "0 to 1e5 watts, those of the device at most",
    ),
    range(
        "remote.idle_watts",
        WATTS,
        "0 to 1e5 watts, those of the device at most",
    ),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::path::Path;

    use super::*;

    #[test]
    fn the_table_of_the_book_is_current() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/files.md");
        let text = std::fs::read_to_string(&page).unwrap();
        let marks = ["<!-- ranges -->\n", "<!-- end of ranges -->\n"];
        let (before, rest) = text.split_once(marks[0]).unwrap();
        let (found, after) = rest.split_once(marks[1]).unwrap();
        let rows = RANGES
            .iter()
            .map(|r| format!("| `{}` | {} |\n", r.field, r.expected));
        let expected = format!(
            "\n| field | range |\n|---|---|\n{}\n",
            rows.collect::<String>()
        );
        if std::env::var_os("POTAMOI_REFRESH").is_some() {
            let whole = [before, marks[0], &expected, marks[1], after].concat();
            return std::fs::write(&page, whole).unwrap();
        }
        assert!(
            found == expected,
            "docs/reference/files.md is not what the ranges are; make refresh writes it, then git diff"
        );
    }
}
