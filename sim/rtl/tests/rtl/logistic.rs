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

/// An engine, and what is expected of it.
struct Case {
    registered: bool,
    knobs: &'static str,
    /// Clocks of softplus and sigmoid.
    clocks: [u64; 2],
    /// Largest errors of sigmoid and softplus, in ulp.
    limits: [f64; 2],
}

const TWO_STEPS_A_CLOCK: Case = Case {
    registered: false,
    knobs: "iterations = 18\niterations_per_clock = 2\naccumulator_bits = 20\nconstant_bits = 20",
    clocks: [22, 33],
    limits: [0.731, 0.740],
};
/// The same bits. Two clocks pass between passes, and one after a softplus.
const REGISTERED: Case = Case {
    registered: true,
    clocks: [25, 37],
    ..TWO_STEPS_A_CLOCK
};
const TAIL: Case = Case {
    registered: false,
    knobs: "iterations = 9\ntail = true",
    clocks: [27, 41],
    limits: [0.966, 1.013],
};
const REGISTERED_TAIL: Case = Case {
    registered: true,
    clocks: [30, 45],
    ..TAIL
};
const A_STEP_A_CLOCK: Case = Case {
    registered: false,
    knobs: "",
    clocks: [40, 60],
    limits: [1.127, 0.832],
};
const ALL_IN_A_CLOCK: Case = Case {
    registered: false,
    knobs: "iterations_per_clock = 20",
    clocks: [2, 3],
    limits: [1.127, 0.832],
};
const REGISTERED_IN_A_CLOCK: Case = Case {
    registered: true,
    clocks: [5, 7],
    ..ALL_IN_A_CLOCK
};

#[test]
fn every_sigmoid_and_softplus_of_the_unit() {
    every_operand(&[REGISTERED]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_sigmoid_and_softplus_of_other_engines() {
    every_operand(&[
        TWO_STEPS_A_CLOCK,
        ALL_IN_A_CLOCK,
        A_STEP_A_CLOCK,
        TAIL,
        REGISTERED_TAIL,
        REGISTERED_IN_A_CLOCK,
    ]);
}

fn every_operand(cases: &[Case]) {
    let ops = "lanes = 8\nops = [\"exp\", \"sigmoid\", \"softplus\"]";
    let reference = LogisticReference::new(13).unwrap();
    let end = reference.last();
    let mut codes: Vec<i32> = (-end..=end).collect();
    codes.extend((17..31).flat_map(|e| [1 << e, -1 << e, (1 << e) + 4095]));
    codes.extend([i32::MIN, i32::MAX, end + 1, -end - 1]);
    for case in cases {
        let &Case {
            registered,
            knobs,
            clocks,
            limits,
        } = case;
        let text = format!("[vu]\n{ops}\nregistered = {registered}\n[vu.exp]\n{knobs}");
        let config = Config::from_toml(&text, "test").unwrap();
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
            // Of what fits a clock whole the analysis of the netlist takes minutes, and register
            // stages change no bit.
            if !registered && config.vu.exp.iterations_per_clock < config.vu.exp.iterations {
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
