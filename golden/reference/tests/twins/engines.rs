//! Engines whose twins are compared with the reference unit, and the comparison.

use std::path::PathBuf;

use potamoi_formats::config::{Config, ExpConfig};
use potamoi_reference::exponential::ReferenceExponential;

/// Bodies of `[vu.exp]`: every form with each of its knobs, and the extremes of its widths.
pub(crate) const ENGINES: [&str; 27] = [
    "",
    "iterations = 9\ntail = true",
    "iterations = 2\ntail = true",
    "early_out = true",
    "early_out = true\niterations_per_clock = 3\niterations = 13",
    "pipelined = true\niterations = 7\noutput_bits = 10\noffset = -3",
    "input = \"U1.4\"\nconstant_bits = 4\noutput_bits = 4\naccumulator_bits = 4",
    "input = \"U2.15\"\naccumulator_bits = 40\nconstant_bits = 40\niterations = 31\noffset = 16",
    "accumulator_bits = 40\nconstant_bits = 40\niterations = 2\ntail = true\noutput_bits = 24",
    "output_bits = 24\niterations = 18\ntail = true",
    "output = \"general\"\ninput = \"S3.12\"",
    "output = \"general\"\ninput = \"S0.16\"\niterations = 12\ntail = true\noutput_bits = 23",
    "output = \"general\"\ninput = \"S6.10\"\niterations = 27\naccumulator_bits = 40\noutput_bits = 8",
    "form = \"literal\"\ninput = \"S0.15\"",
    "form = \"literal\"\ninput = \"S0.4\"\niterations = 31\noutput_bits = 24",
    "form = \"literal\"\ninput = \"S0.14\"\noutput = \"general\"\niterations = 5\nconstant_bits = 40\n\
     accumulator_bits = 40",
    "form = \"radix-4\"\niterations = 4\ntail = true",
    "form = \"radix-4\"\niterations = 8",
    "form = \"radix-4\"\niterations = 15\naccumulator_bits = 40\nconstant_bits = 40\noffset = -16",
    "form = \"radix-4\"\niterations = 1\ntail = true\naccumulator_bits = 40\nconstant_bits = 40\n\
     input = \"U3.10\"\noutput_bits = 20\niterations_per_clock = 2",
    "form = \"piecewise\"\npipelined = true",
    "form = \"piecewise\"\npipelined = true\npieces = 128\nbase = \"two\"",
    "form = \"piecewise\"\npipelined = true\npieces = 1024\noutput_bits = 24",
    "form = \"piecewise\"\npipelined = true\npieces = 1024\naccumulator_bits = 40\nconstant_bits = 40",
    "form = \"piecewise\"\npipelined = true\npieces = 16\noutput_bits = 4\naccumulator_bits = 4\n\
     input = \"U1.4\"\nconstant_bits = 8",
    "form = \"piecewise\"\npipelined = true\npieces = 16\naccumulator_bits = 40\nconstant_bits = 8\n\
     input = \"U3.8\"\noutput_bits = 12\nbase = \"two\"",
    "form = \"piecewise\"\npipelined = true\npieces = 256\ninput = \"U3.13\"\noutput_bits = 20",
];

/// Bodies of `[vu.exp]` over the whole range of widths, of operands of at most 14 bits.
pub(crate) fn grid() -> Vec<String> {
    let mut all = vec![];
    let widths = [
        None,
        Some((0, 0)),
        Some((1, 3)),
        Some((40, 0)),
        Some((0, 40)),
        Some((40, 40)),
    ];
    for ((f, bits), n) in [4, 8, 16, 23]
        .into_iter()
        .flat_map(|f| widths.map(|bits| (f, bits)))
        .flat_map(|own| [1, 2, 5, 15, 31].map(|n| (own, n)))
    {
        let steps = format!("iterations = {n}\noutput_bits = {f}\n");
        let own = bits.map_or(String::new(), |(accumulator, constant)| {
            let [accumulator, constant] = [f + accumulator, 10 + constant].map(|bits| bits.min(40));
            format!("accumulator_bits = {accumulator}\nconstant_bits = {constant}\n")
        });
        for (form, input) in [
            ("form = \"literal\"", "S0.10"),
            ("form = \"restoring\"", "U3.10"),
            ("form = \"restoring\"\ntail = true", "U2.10"),
            ("form = \"restoring\"\nearly_out = true", "U3.9"),
            ("form = \"restoring\"\noutput = \"general\"", "S4.8"),
            (
                "form = \"restoring\"\noutput = \"general\"\ntail = true",
                "S1.10",
            ),
            ("form = \"radix-4\"", "U3.10"),
            ("form = \"radix-4\"\ntail = true", "U1.10"),
        ] {
            all.push(format!("{form}\ninput = \"{input}\"\n{steps}{own}"));
        }
        let pieces = 16 << n.min(6);
        for base in ["e", "two"] {
            all.push(format!(
                "form = \"piecewise\"\npipelined = true\nbase = \"{base}\"\npieces = {pieces}\n\
                 input = \"U3.10\"\noutput_bits = {f}\n{own}"
            ));
        }
    }
    all.retain(|body| read(body).is_ok());
    all
}

/// The configuration of an engine, or what is wrong with it.
pub(crate) fn read(body: &str) -> Result<ExpConfig, String> {
    let text = format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{body}\n");
    let config = Config::from_toml(&text, "test").map_err(|error| error.to_string())?;
    Ok(config.vu.exp)
}

/// All codes of the operand's format, some beyond its ends, and the ends of 32 bits.
pub(crate) fn operands(config: &ExpConfig) -> Vec<i32> {
    let (least, most) = (config.input.min() as i32, config.input.max() as i32);
    let ends = [i32::MIN, i32::MIN + 1, i32::MAX - 1, i32::MAX];
    (least - 3..=most + 3).chain(ends).collect()
}

/// Panics where a twin's results, 4 bytes each, are not those of the reference unit.
pub(crate) fn assert_equal(config: &ExpConfig, found: &[u8], twin: &str) {
    let (operands, reference) = (operands(config), ReferenceExponential::new(config));
    let found: Vec<_> = found
        .chunks(4)
        .map(|bytes| i32::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    assert_eq!(found.len(), operands.len(), "{twin}: {config:?}");
    for (&a, &own) in operands.iter().zip(&found) {
        assert_eq!(own, reference.exp(a), "{twin}: exp({a}) of {config:?}");
    }
}

/// A folder of the test's own.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn engines_are_of_all_forms_and_keep_the_rules() {
    let all: Vec<_> = ENGINES.iter().map(|body| read(body).unwrap()).collect();
    for form in ["restoring", "literal", "radix-4", "piecewise"] {
        let own = all.iter().filter(|own| own.form.name() == form);
        assert!(own.count() >= 3, "{form}");
    }
    let grid = grid();
    assert!(grid.len() > 500, "{}", grid.len());
}
