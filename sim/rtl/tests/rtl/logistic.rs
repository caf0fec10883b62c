//! Sigmoid and softplus on the Verilated vector unit: every operand from -16 to
//! 16 and past it, equal to the twin in every bit, as far from the functions as
//! stated, in the cycles that are stated.
use potamoi_cycles::{Stalls, vector_cycles};
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::logistic::{Logistic, LogisticReference, logistic_budget};
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_rtl::{VectorBatch, VectorUnit};
use potamoi_units::vector_unit::error_bound;

/// Knobs; clocks of softplus and sigmoid; largest errors of sigmoid and softplus.
type Case = (&'static str, [u64; 2], [f64; 2]);

const TWO_STEPS_A_CLOCK: Case = (
    "iterations = 18\niterations_per_clock = 2\naccumulator_bits = 20\nconstant_bits = 20",
    [22, 33],
    [0.731, 0.740],
);
const TAIL: Case = ("iterations = 9\ntail = true", [27, 41], [0.966, 1.013]);
const A_STEP_A_CLOCK: Case = ("", [40, 60], [1.127, 0.832]);
const ALL_IN_A_CLOCK: Case = ("iterations_per_clock = 20", [2, 3], [1.127, 0.832]);

#[test]
fn every_sigmoid_and_softplus_of_the_unit() {
    every_operand(&[TWO_STEPS_A_CLOCK, ALL_IN_A_CLOCK]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_sigmoid_and_softplus_of_other_engines() {
    every_operand(&[A_STEP_A_CLOCK, TAIL]);
}

fn every_operand(cases: &[Case]) {
    let ops = "[vu]\nlanes = 8\nops = [\"exp\", \"sigmoid\", \"softplus\"]\n[vu.exp]\n";
    let reference = LogisticReference::new(13).unwrap();
    let end = reference.last();
    let mut codes: Vec<i32> = (-end..=end).collect();
    codes.extend((17..31).flat_map(|e| [1 << e, -1 << e, (1 << e) + 4095]));
    codes.extend([i32::MIN, i32::MAX, end + 1, -end - 1]);
    for &(knobs, clocks, limits) in cases {
        let config = Config::from_toml(&format!("{ops}{knobs}"), "test").unwrap();
        let unit = VectorUnit::build(&config).unwrap();
        let twin = ReferenceVectorUnit::new(&config.vu);
        let zeros = vec![0; codes.len()];
        for (i, (of, code)) in [
            (Logistic::Softplus, OpCode::Softplus),
            (Logistic::Sigmoid, OpCode::Sigmoid),
        ]
        .into_iter()
        .enumerate()
        {
            let op = VectorOp::new(code);
            let batch = VectorBatch {
                op,
                a: &codes,
                b: &zeros,
            };
            let run = unit.run(&[batch], &Stalls::NONE, 0).unwrap();
            assert_eq!(run.totals.errors, 0);
            for (a, found) in codes.iter().zip(&run.results) {
                let golden = twin.element(op, *a, 0).unwrap();
                assert_eq!(*found, golden, "{knobs}: {code:?} of {a}");
            }
            let error = reference.measure(of, 16, |x| run.results[(x + end) as usize]);
            println!("{knobs:?}: {of:?} at most {:.4} ulp", error.max_ulp);
            assert!(error.max_ulp <= limits[1 - i], "{knobs}: {of:?} {error:?}");
            assert!(error.monotone, "{knobs}: {of:?}");
            let formula = logistic_budget(of, &config.vu.exp);
            assert!(error.max_ulp <= formula, "{knobs}: {of:?} {formula}");
            // Of what fits a clock whole the analysis of the netlist takes minutes.
            if config.vu.exp.iterations_per_clock < config.vu.exp.iterations {
                let bound = error_bound(&config, code).unwrap().unwrap().ulp;
                println!("{of:?}: netlist {bound:.3}, formula {formula:.3}");
                assert!(
                    error.max_ulp <= bound && bound <= formula,
                    "{knobs}: {of:?} {bound} {formula}"
                );
            }

            let vectors = codes.len().div_ceil(8) as u64;
            let (first, last) = (run.vectors[0].0, run.vectors[run.vectors.len() - 1].0);
            assert_eq!(
                last - first,
                (vectors - 1) * clocks[i],
                "{knobs}: no bubble"
            );
            let closed = vector_cycles(&config, &[(code, codes.as_slice())]).unwrap();
            assert_eq!(closed.busy, vectors * clocks[i], "{knobs}");
        }
    }
}
