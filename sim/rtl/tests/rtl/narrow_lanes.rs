//! Vector units whose multiplications take narrow operands, and those with register stages between their
//! operations, against the reference unit and the cycle model.

use potamoi_cycles::Stalls;
use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::Units;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_rtl::verify::{Settings, Verifier};
use potamoi_rtl::{Check, EngineKind, RtlError, RtlUnits, VectorBatch, VectorUnit};
use potamoi_scene::Scene;

use super::scenes_common::{garden_through, verified};
use super::vector_unit::compared;

/// What splats send.
const SPLATS: &str = "[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 19\n";

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Of so many rounds of random work under random stalls, operands beyond their widths among it.
fn as_predicted(engine: EngineKind, units: &[String], rounds: u64) {
    for (i, text) in units.iter().enumerate() {
        let config = config(text);
        let unit = VectorUnit::on(engine, &config).unwrap();
        for round in 0..rounds {
            let seed = 40_000 + 100 * i as u64 + round;
            compared(&config, &config.vu, &unit, seed)
                .unwrap_or_else(|e| panic!("{text}, seed {seed}: {e}"));
        }
    }
}

#[test]
fn every_cycle_and_bit_is_as_predicted() {
    as_predicted(
        EngineKind::Verilator,
        &[
            format!("[vu]\nlanes = 3\nregistered = true\n{SPLATS}"),
            format!(
                "[vu]\nlanes = 2\nregistered = true\n{SPLATS}[vu.exp]\nform = \"piecewise\"\npipelined = true"
            ),
        ],
        4,
    );
}

#[test]
fn other_units_are_as_predicted_on_the_interpreter() {
    let registered = |rest: &str| format!("[vu]\nlanes = 2\nregistered = true\n{rest}");
    as_predicted(
        EngineKind::Interpreter,
        &[
            format!("[vu]\nlanes = 3\n{SPLATS}"),
            registered(""),
            registered("ops = [\"square-sum\", \"pass\"]\n[vu.operands]\nsquare_sum = 2\n"),
            registered("ops = [\"multiply\", \"relu\"]\n[vu.operands]\nmultiply = [2, 32]\n"),
            registered(&format!("{SPLATS}[vu.exp]\npipelined = true")),
            registered(&format!("{SPLATS}[vu.exp]\niterations_per_clock = 20")),
            registered(&format!(
                "{SPLATS}[vu.exp]\niterations_per_clock = 3\ntail = true"
            )),
            registered(&format!(
                "{SPLATS}[vu.exp]\nform = \"radix-4\"\niterations = 4\ntail = true"
            )),
            registered(
                "ops = [\"add\", \"exp\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            ),
            registered(
                "ops = [\"exp\"]\n[vu.exp]\nform = \"literal\"\ninput = \"S0.15\"\noutput_bits = 14",
            ),
            registered(
                "[vu.exp]\nform = \"piecewise\"\npipelined = true\npieces = 256\nbase = \"two\"",
            ),
        ],
        1,
    );
}

/// A frame of splats through narrow lanes: no flag, every bit and cycle. Forms that are not held, as by
/// a renderer of 32 bits, are refused by name, and the unit raises its flag.
#[test]
fn a_frame_of_splats_raises_no_flag() {
    let config = config(&format!("[vu]\nlanes = 4\nregistered = true\n{SPLATS}"));
    let mut none = |_| {};
    let settings = Settings {
        engine: EngineKind::Interpreter,
        seed: 5,
        gather_every: 400,
        vector_every: 200,
        splat_every: 1,
        inject: None,
        rtl: None,
        excerpt: None,
    };
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(10), Some(10)).unwrap();
    let mut verifier = Verifier::new(&config, settings, &mut none);
    let render = |units: &mut dyn Units| {
        let done = scene.render_fixed(&config, units);
        done.map(|_| ()).map_err(|error| error.to_string())
    };
    verified(&mut verifier, render).unwrap();
    assert_eq!(verifier.failure(), None);
    let report = verifier.vector_report().clone();
    assert!(report.elements > 100, "{report:?}");

    let error = verified(&mut verifier, |units| garden_through(units, 16))
        .unwrap_err()
        .to_string();
    assert!(error.contains("vu.operands.square_sum"), "{error}");
    let mut units = RtlUnits::on(EngineKind::Interpreter, &config);
    let squares = VectorOp::new(OpCode::SquareSum);
    let mut out = [0];
    assert!(
        units
            .vector(squares, &[(1 << 18) - 1], &[-1 << 18], &mut out)
            .is_ok()
    );
    let error = units
        .vector(squares, &[1 << 18], &[0], &mut out)
        .unwrap_err();
    assert!(
        error.to_string().contains("an operand beyond its width"),
        "{error}"
    );
}

/// A lane whose width is not that of the reference unit gives another bit or another flag.
#[test]
fn a_width_that_is_off_by_one_is_found() {
    let own = config(&format!("[vu]\nlanes = 2\nregistered = true\n{SPLATS}"));
    let unit = VectorUnit::on(EngineKind::Interpreter, &own).unwrap();
    assert!(compared(&own, &own.vu, &unit, 1).is_ok());
    for (field, by) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
        let mut other = own.vu.clone();
        let operands = other.operands.as_mut().unwrap();
        let width = match field {
            2 => &mut operands.square_sum,
            at => &mut operands.multiply[at],
        };
        *width = width.checked_add_signed(by).unwrap();
        let found = compared(&own, &other, &unit, 1);
        assert!(
            matches!(found, Err(RtlError::Mismatch(_))),
            "{other:?}: {found:?}"
        );
    }
}

/// The ends of every width, one operand at a time: the flag rises with the first value beyond, and
/// not before.
#[test]
fn the_flag_rises_with_the_first_operand_beyond_its_width() {
    let text = "[vu]\nlanes = 1\nops = [\"multiply\", \"square-sum\"]\nregistered = true\n\
                [vu.operands]\nmultiply = [5, 9]\nsquare_sum = 7";
    let config = config(text);
    let twin = ReferenceVectorUnit::new(&config.vu);
    let unit = VectorUnit::on(EngineKind::Interpreter, &config).unwrap();
    let (mut raised, mut kept) = (0, 0);
    for code in [OpCode::Multiply, OpCode::SquareSum] {
        for (at, bits) in config.vu.operand_widths(code).into_iter().enumerate() {
            let end = 1 << (bits - 1);
            for value in [-end - 1, -end, end - 1, end, 2 * end, 3 * end - 1, i32::MIN] {
                let (a, b) = if at == 0 {
                    ([value], [3])
                } else {
                    ([-3], [value])
                };
                let op = VectorOp {
                    code,
                    shift: 1,
                    rounding: Rounding::HalfEven,
                };
                let beyond = !(-end..end).contains(&value);
                let results = [twin.element(op, a[0], b[0]).unwrap()];
                let check = Check {
                    stalls: Stalls::NONE,
                    seed: 0,
                    flags: u64::from(beyond) << 3,
                    progress: &mut |_| {},
                };
                let batch = VectorBatch { op, a: &a, b: &b };
                unit.check(&config, &[batch], &results, check)
                    .unwrap_or_else(|e| panic!("{code:?} {a:?} {b:?}: {e}"));
                raised += u32::from(beyond);
                kept += u32::from(!beyond);
            }
        }
    }
    assert_eq!((raised, kept), (20, 8));
}
