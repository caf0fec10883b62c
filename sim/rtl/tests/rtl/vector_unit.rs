//! The Verilated vector unit: element-wise operations against exact integers,
//! every one of the 65,536 exponentials against the mathematical function.
//!
//! Double precision stands in for the function here: its error, below 2^-50,
//! is far under the third decimal of a unit of 2^-16 that is asserted.
use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::{Config, VuConfig};
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::exact_exponential::ExactExponential;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_reference::widths::{budget, target};
use potamoi_rtl::{Check, EngineKind, RtlError, VectorBatch, VectorTotals, VectorUnit};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The command that runs these tests again.
const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl vector_unit";

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Results for every code of a 16-bit operand, and the cycles they took.
fn sweep(config: &Config, code: OpCode, codes: &[i32]) -> (Vec<i32>, u64) {
    let unit = VectorUnit::build(config).unwrap();
    let zeros = vec![0; codes.len()];
    let batch = VectorBatch {
        op: VectorOp::new(code),
        a: codes,
        b: &zeros,
    };
    let run = unit.run(&[batch], &Stalls::NONE, 0).unwrap();
    assert_eq!(run.totals.errors, 0);
    let first = run.vectors.first().unwrap().0;
    let last = run.vectors.last().unwrap().0;
    (run.results, last - first)
}

/// Every input through the Verilated unit: equal to the twin in every bit, and
/// as far from the exponential, to 120 bits, as its number of iterations says.
#[test]
fn every_exponential_of_the_stated_widths() {
    every_exponential(&[
        (16, false, 1, true, 16, 1),
        (16, false, 4, false, 16, 5),
        (9, true, 1, true, 16, 1),
        (8, false, 1, false, 8, 12),
        (16, false, 1, false, 16, 20),
        (16, true, 1, false, 16, 21),
    ]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_exponential_of_all_widths() {
    let mut rows = vec![
        (16, false, 1, true, 16, 1),
        (16, false, 4, false, 16, 5),
        (16, false, 20, false, 16, 1),
        (16, false, 3, true, 16, 1),
        (9, true, 1, true, 16, 1),
        (14, true, 2, false, 16, 10),
        (8, false, 1, false, 8, 12),
        (12, false, 1, false, 12, 16),
    ];
    for n in [8, 12, 16, 20, 27] {
        rows.extend([
            (n, false, 1, false, 16, 4 + n),
            (n, true, 1, false, 16, 5 + n),
        ]);
    }
    every_exponential(&rows);
}

/// Of n, tail, r, pipelined, F and interval.
fn every_exponential(rows: &[(u32, bool, u32, bool, u32, u32)]) {
    let codes: Vec<i32> = (0..65_536).collect();
    for &(n, tail, r, pipelined, f, interval) in rows {
        let text = format!(
            "[vu]\nlanes = 4\nops = [\"exp\"]\n[vu.exp]\niterations = {n}\ntail = {tail}\niterations_per_clock = {r}\n\
             pipelined = {pipelined}\noutput_bits = {f}"
        );
        let config = config(&text);
        let (results, cycles) = sweep(&config, OpCode::Exp, &codes);
        let twin = ReferenceExponential::new(&config.vu.exp);
        for (u, y) in codes.iter().zip(&results) {
            let expected = twin.exp(*u);
            assert_eq!(
                *y, expected,
                "vector_unit: exp of code {u} is {y}, expected {expected}\n{text}\nagain: {AGAIN}"
            );
        }
        let reference = ExactExponential::of(config.vu.exp.input).unwrap();
        let error = reference.measure(f, |u| results[u as usize]);
        println!(
            "n {n}, tail {tail}, r {r}, pipelined {pipelined}, F {f}: at most {:.4} ulp, mean {:.4}, interval {interval}",
            error.max_ulp, error.mean
        );
        let target = target(n, tail, f);
        assert!(
            target.is_met(error.max_ulp),
            "{text}: {error:?}, {target:?}"
        );
        assert!(error.monotone, "{text}");
        assert_eq!(
            cycles,
            (65_536 / 4 - 1) * u64::from(interval),
            "{text}: no load or unload bubble"
        );
    }
}

/// Built as printed, the recurrence never subtracts for x < 0: everything
/// below 0 comes out as 1.
#[test]
fn the_literal_recurrence_is_wrong_below_zero() {
    let text = "[vu]\nlanes = 4\nops = [\"exp\"]\n[vu.exp]\nform = \"literal\"\ninput = \"S0.15\"\noutput_bits = 14";
    let codes: Vec<i32> = (-32_768..32_768).collect();
    let (results, _) = sweep(&config(text), OpCode::Exp, &codes);
    let mut worst = [0.0f64; 2];
    for (x, y) in codes.iter().zip(&results) {
        let error = (f64::from(*y) - (f64::from(*x) / 32_768.0).exp() * 16_384.0).abs();
        let side = usize::from(*x >= 0);
        worst[side] = worst[side].max(error);
    }
    assert!(worst[0] > 10_000.0, "below 0: {} units of 2^-14", worst[0]);
    assert!(worst[1] < 4.0, "from 0: {} units of 2^-14", worst[1]);
}

#[test]
fn one_minus_exp_keeps_empty_space_empty() {
    let text = "[vu]\nlanes = 8\n";
    let mut codes: Vec<i32> = (0..=24).map(|e| 1 << e).collect();
    codes.extend([
        0,
        -1,
        i32::MIN,
        i32::MAX,
        (8 << 20) - 1,
        8 << 20,
        (8 << 20) + 1,
        (16 << 20) - 1,
        16 << 20,
    ]);
    codes.extend((0..40_000).map(|i| i * 419));
    let config = config(text);
    // Every input of the twin is held to the same: its 24 bits are too many here.
    let most = budget(&config.vu.exp) + 2f64.powi(16 - 20);
    let (results, _) = sweep(&config, OpCode::OneMinusExp, &codes);
    for (s, y) in codes.iter().zip(&results) {
        let depth = f64::from((*s).clamp(0, (16 << 20) - 1)) / 2f64.powi(20);
        let exact = (-(-depth).exp_m1() * 65_536.0).min(65_535.0);
        assert!(
            (f64::from(*y) - exact).abs() <= most,
            "s = {depth}: {y}, exactly {exact}"
        );
        if *s <= 0 {
            assert_eq!(*y, 0);
        }
        if s.count_ones() == 1 && *s > 0 {
            let error = (f64::from(*y) - exact).abs();
            println!("s = 2^{}: {y}, {error:.4} ulp off", s.ilog2() as i32 - 20);
        }
    }
    // What the saturated exponential would do to a ray through 1,000 empty samples.
    let naive = (1.0 - 1.0f64 / 65_536.0).powi(1000);
    assert!(naive < 0.986, "{naive}");
}

#[test]
fn the_general_form_gives_exponent_and_mantissa() {
    let text = "[vu]\nlanes = 8\nops = [\"exp\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"\niterations = 18\n\
                accumulator_bits = 24\nconstant_bits = 24";
    let codes: Vec<i32> = (-32_768..32_768).collect();
    let (results, _) = sweep(&config(text), OpCode::Exp, &codes);
    for (x, y) in codes.iter().zip(&results) {
        let (exponent, mantissa) = (y >> 17, y & 0x1_ffff);
        assert!(
            (65_536..131_072).contains(&mantissa),
            "x = {x}: mantissa {mantissa}"
        );
        let found = f64::from(mantissa) * 2f64.powi(exponent - 16);
        let exact = (f64::from(*x) / 4096.0).exp();
        assert!(
            ((found - exact) / exact).abs() < 2f64.powi(-16),
            "x = {x}: {found} for {exact}"
        );
    }
}

#[test]
fn element_wise_operations_are_exact_in_every_rounding() {
    for pipelined in [false, true] {
        let config = config(&format!(
            "[vu]\nlanes = 5\n[vu.exp]\npipelined = {pipelined}"
        ));
        let unit = VectorUnit::build(&config).unwrap();
        for seed in 0..8u64 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let mut work = vec![];
            for _ in 0..60 {
                let code = OpCode::ALL[random.random_range(0..6)];
                let rounding = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven]
                    [random.random_range(0..3)];
                let op = VectorOp {
                    code,
                    shift: random.random_range(0..64),
                    rounding,
                };
                let count = random.random_range(1..20);
                let mut operand = || -> Vec<i32> {
                    (0..count)
                        .map(|_| match random.random_range(0..8) {
                            0 => i32::MIN,
                            1 => i32::MAX,
                            2 => 0,
                            3 => 1 << random.random_range(0..31),
                            _ => random.random::<i32>() >> random.random_range(0..31),
                        })
                        .collect()
                };
                let (a, b) = (operand(), operand());
                work.push((op, a, b));
            }
            let batches: Vec<_> = work
                .iter()
                .map(|(op, a, b)| VectorBatch { op: *op, a, b })
                .collect();
            let often = StreamStalls {
                per_mille: 400,
                burst: 1,
            };
            let stalls = Stalls {
                rit: often,
                sink: often,
                ..Stalls::NONE
            };
            let run = unit.run(&batches, &stalls, seed).unwrap();
            let mut results = run.results.iter();
            for (op, a, b) in &work {
                for (x, y) in a.iter().zip(b) {
                    let found = *results.next().unwrap();
                    let (x, y) = (i128::from(*x), i128::from(*y));
                    let exact = match op.code {
                        OpCode::Pass => x,
                        OpCode::Relu => x.max(0),
                        OpCode::Add => x + y,
                        OpCode::Multiply => x * y,
                        OpCode::SquareSum => x * x + y * y,
                        _ => {
                            let u = x.clamp(0, 65_535) as f64 / 8192.0;
                            assert!(
                                (f64::from(found) - ((-u).exp() * 65_536.0).min(65_535.0)).abs()
                                    < 1.0
                            );
                            continue;
                        }
                    };
                    let wanted = round_shift(exact, u32::from(op.shift), op.rounding)
                        .clamp(i32::MIN.into(), i32::MAX.into());
                    assert_eq!(i128::from(found), wanted, "seed {seed} {op:?} {x} {y}");
                }
            }
        }
    }
}

/// Every cycle against the cycle model, every bit against the twin, under
/// random stalls, for iterative and pipelined engines of all sorts.
#[test]
fn every_cycle_is_as_predicted_under_random_stalls() {
    as_predicted(
        &[
            "[vu]\nlanes = 1\nfifo_depth = 3\n[vu.exp]\niterations_per_clock = 3\ntail = true",
            "[vu]\nlanes = 2\nfifo_depth = 3\n[vu.exp]\npipelined = true",
        ],
        3,
    );
}

#[test]
fn every_cycle_of_other_forms_is_as_predicted() {
    as_predicted(
        &[
            "[vu]\nlanes = 3",
            "[vu]\nlanes = 3\nops = [\"pass\", \"multiply\", \"exp\", \"one-minus-exp\", \"sigmoid\", \"softplus\"]",
            "[vu]\nlanes = 3\n[vu.exp]\nform = \"piecewise\"\npipelined = true",
            "[vu]\nlanes = 3\nfifo_depth = 3\n[vu.exp]\nform = \"radix-4\"\niterations = 4\ntail = true",
            "[vu]\nlanes = 3\n[vu.exp]\nearly_out = true",
        ],
        3,
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_cycle_of_other_units_is_as_predicted_under_random_stalls() {
    as_predicted(
        &[
            "[vu]\nlanes = 33\n[vu.exp]\niterations_per_clock = 20",
            "[vu]\nlanes = 2\n[vu.exp]\npipelined = true\niterations_per_clock = 4\ntail = true",
            "[vu]\nlanes = 4\nops = [\"exp\"]",
            "[vu]\nlanes = 2\nfifo_depth = 3\nops = [\"add\", \"exp\", \"sigmoid\", \"softplus\"]\n\
         [vu.exp]\niterations = 9\niterations_per_clock = 4\ntail = true",
            "[vu]\nlanes = 5\nops = [\"relu\", \"sigmoid\", \"softplus\"]\n[vu.exp]\niterations_per_clock = 20",
            "[vu]\nlanes = 2\nfifo_depth = 3\n[vu.exp]\nform = \"piecewise\"\npipelined = true\npieces = 128\nbase = \"two\"",
            "[vu]\nlanes = 2\n[vu.exp]\nform = \"radix-4\"\niterations = 4\ntail = true\npipelined = true",
            "[vu]\nlanes = 1\nfifo_depth = 3\nops = [\"exp\"]\n[vu.exp]\nearly_out = true\niterations_per_clock = 3",
        ],
        4,
    );
}

/// Of so many rounds each.
fn as_predicted(units: &[&str], rounds: u64) {
    for (i, text) in units.iter().enumerate() {
        let config = config(text);
        let unit = VectorUnit::build(&config).unwrap();
        for round in 0..rounds {
            agrees(&config, &unit, 100 * i as u64 + round);
        }
    }
}

/// Vector units of any sort that the rules allow, on the interpreter.
#[test]
fn units_of_any_sort_agree_under_random_stalls() {
    units_of_any_sort(0..6);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn many_units_of_any_sort_agree_under_random_stalls() {
    units_of_any_sort(6..300);
}

fn units_of_any_sort(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut random = Pcg64Mcg::seed_from_u64(7000 + seed);
        let mut pick = |from: &[&'static str]| from[random.random_range(0..from.len())];
        let general = pick(&["alpha", "alpha", "general"]) == "general";
        let form = pick(&[
            "restoring",
            "restoring",
            "piecewise",
            "radix-4",
            "early-out",
        ]);
        let engine = if general {
            format!(
                "output = \"general\"\ninput = \"{}\"",
                pick(&["S3.12", "S5.8"])
            )
        } else {
            let input = pick(&["U3.13", "U2.10", "U3.8"]);
            format!(
                "input = \"{input}\"\none_minus_frac_bits = {}",
                pick(&["12", "20", "24"])
            )
        };
        let other = !general && form != "restoring";
        let ops = if general {
            pick(&[r#"["exp"]"#, r#"["add", "exp"]"#])
        } else if other {
            pick(&[
                r#"["exp", "one-minus-exp"]"#,
                r#"["exp", "relu", "multiply"]"#,
                r#"["exp", "square-sum", "add", "multiply"]"#,
                r#"["exp"]"#,
                r#"["add", "one-minus-exp"]"#,
            ])
        } else {
            pick(&[
                r#"["exp", "one-minus-exp"]"#,
                r#"["exp", "relu", "multiply"]"#,
                r#"["square-sum", "exp", "pass"]"#,
                r#"["exp", "one-minus-exp", "sigmoid", "softplus"]"#,
                r#"["add", "softplus"]"#,
                r#"["sigmoid", "one-minus-exp", "pass"]"#,
                r#"["sigmoid"]"#,
            ])
        };
        // Sigmoid and softplus are of the iterative form alone.
        let forms: &[_] = if ops.contains("sig") || ops.contains("soft") {
            &["false"]
        } else {
            &["true", "false"]
        };
        let knobs = match if other { form } else { "" } {
            "piecewise" => format!(
                "form = \"piecewise\"\npipelined = true\npieces = {}\nbase = \"{}\"",
                pick(&["256", "1024"]),
                pick(&["e", "two"])
            ),
            "radix-4" => format!(
                "form = \"radix-4\"\niterations = {}\ntail = {}\npipelined = {}\niterations_per_clock = {}",
                pick(&["3", "4", "9", "15"]),
                pick(&["true", "false"]),
                pick(&["true", "false"]),
                pick(&["1", "2", "5"]),
            ),
            "early-out" => format!(
                "early_out = true\niterations = {}\niterations_per_clock = {}",
                pick(&["9", "16", "20", "27"]),
                pick(&["1", "2", "3"]),
            ),
            _ => format!(
                "iterations = {}\ntail = {}\npipelined = {}\niterations_per_clock = {}",
                pick(&["4", "9", "16", "20", "27"]),
                pick(&["true", "false"]),
                pick(forms),
                pick(&["1", "2", "3", "7"]),
            ),
        };
        let vu = format!(
            "lanes = {}\nfifo_depth = {}",
            pick(&["1", "2", "5"]),
            pick(&["3", "4", "7"])
        );
        let output = pick(&["6", "12", "16", "20"]);
        let registered = match knobs.contains("early_out") {
            true => "false",
            false => pick(&["true", "false"]),
        };
        let mut operands = String::new();
        if ops.contains("multiply") && pick(&["true", "false"]) == "true" {
            let (a, b) = (pick(&["2", "9", "22", "32"]), pick(&["3", "18", "31"]));
            operands += &format!("multiply = [{a}, {b}]\n");
        }
        if ops.contains("square-sum") {
            operands += &format!("square_sum = {}\n", pick(&["2", "19", "25", "32"]));
        }
        let config = config(&format!(
            "[vu]\n{vu}\nregistered = {registered}\nops = {ops}\n[vu.operands]\n{operands}\
             [vu.exp]\n{engine}\n{knobs}\noutput_bits = {output}",
        ));
        let unit = VectorUnit::on(EngineKind::Interpreter, &config).unwrap();
        agrees(&config, &unit, seed);
    }
}

/// One run of random work under random stalls.
fn agrees(config: &Config, unit: &VectorUnit, seed: u64) {
    let found = compared(config, &config.vu, unit, seed);
    let totals =
        found.unwrap_or_else(|e| panic!("{:?}, seed {seed}: {e}\nagain: {AGAIN}", config.vu));
    assert!(totals.vectors >= 40);
}

/// The same against the results and flags of a reference unit of `vu`.
pub(crate) fn compared(
    config: &Config,
    vu: &VuConfig,
    unit: &VectorUnit,
    seed: u64,
) -> Result<VectorTotals, RtlError> {
    let twin = ReferenceVectorUnit::new(vu);
    let mut flags = 0;
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let (mut work, mut results) = (vec![], vec![]);
    for _ in 0..40 {
        let op = VectorOp {
            code: config.vu.ops[random.random_range(0..config.vu.ops.len())],
            shift: random.random_range(0..40),
            rounding: [Rounding::HalfEven, Rounding::HalfUp, Rounding::Floor]
                [random.random_range(0..3)],
        };
        let count = random.random_range(1..100);
        let mut operand = || -> Vec<i32> {
            (0..count)
                .map(|_| random.random::<i32>() >> random.random_range(0..31))
                .collect()
        };
        let (a, b) = (operand(), operand());
        let mut out = vec![0; count];
        twin.slice(op, &a, &b, &mut out).unwrap();
        flags |= u64::from(twin.within(op.code, &a, &b).is_err()) << 3;
        results.extend(out);
        work.push((op, a, b));
    }
    let batches: Vec<_> = work
        .iter()
        .map(|(op, a, b)| VectorBatch { op: *op, a, b })
        .collect();
    let mut stream = || StreamStalls {
        per_mille: random.random_range(0..900),
        burst: [1, 1, 3, 30][random.random_range(0..4)],
    };
    let stalls = Stalls {
        rit: stream(),
        sink: stream(),
        ..Stalls::NONE
    };
    let check = Check {
        stalls,
        seed,
        flags,
        progress: &mut |_| {},
    };
    unit.check(config, &batches, &results, check)
}
