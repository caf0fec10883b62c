//! Terms of the figures of each module.

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};

use crate::grid::Family;
use crate::path_ends::OUTPUTS;

/// Numbers that terms depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Numbers {
    /// Banks B.
    banks: f64,
    /// Ports M.
    ports: f64,
    /// Feature width in bits.
    feature: f64,
    /// Weight width in bits.
    weight: f64,
    /// Words of the gathering unit's FIFO.
    depth: f64,
    /// Banks with a channel of the sample in the mean segment.
    active: f64,
    /// Lanes of the vector unit.
    lanes: f64,
    /// Width of an exponential's result in bits.
    output: f64,
    /// Width of its accumulator in bits.
    accumulator: f64,
    /// Width of its constants in bits.
    constant: f64,
    /// Iterations n.
    iterations: f64,
    /// 1 where a lane has all operations, 0 where it has exponentials only.
    operations: f64,
}

impl Numbers {
    /// Numbers of a configuration that gathers so many channels.
    pub(super) fn new(config: &Config, channels: u64) -> Self {
        let exp = &config.vu.exp;
        let engine = exp.engine();
        Self {
            banks: config.gu.banks.into(),
            ports: config.gu.ports.into(),
            feature: config.gu.feature_bits.into(),
            weight: config.gu.weight_bits.into(),
            depth: config.feature_fifo_depth().into(),
            active: active_banks(config, channels),
            lanes: config.vu.lanes.into(),
            output: exp.output_bits.into(),
            accumulator: engine.accumulator_bits.into(),
            constant: engine.constant_bits.into(),
            iterations: exp.iterations.into(),
            operations: if config.vu.ops.len() > 1 { 1.0 } else { 0.0 },
        }
    }

    fn product(&self) -> f64 {
        self.feature * self.weight
    }

    pub(super) fn all(&self) -> f64 {
        self.ports * self.banks
    }

    /// Reducers of banks with a channel.
    fn active(&self) -> f64 {
        self.ports * self.active
    }

    fn idle(&self) -> f64 {
        self.all() - self.active()
    }
}

/// Banks with a channel in the mean segment of a sample.
pub(super) fn active_banks(config: &Config, channels: u64) -> f64 {
    let segments = channels.div_ceil(config.gu.banks.into()).max(1);
    channels as f64 / segments as f64
}

/// A term of a sum.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// Printed name.
    pub(super) name: &'static str,
    pub(super) of: fn(&Numbers) -> f64,
}

/// Terms of a module's figures.
#[derive(Debug, Clone, Copy)]
pub(super) struct ModuleTerms {
    pub(super) module: &'static str,
    /// Number of instances.
    pub(super) count: fn(&Numbers) -> f64,
    /// Terms of the area of one, flip-flops included.
    pub(super) area: &'static [Term],
    /// Terms of the energy of all instances in a busy cycle above the clock's.
    pub(super) energy: &'static [Term],
}

/// Terms of a family.
#[derive(Debug, Clone, Copy)]
pub(super) struct FamilyTerms {
    pub(super) modules: &'static [ModuleTerms],
    /// Terms of the longest path into each module, or to the outputs.
    pub(super) ends: &'static [(&'static str, &'static [Term])],
}

const fn term(name: &'static str, of: fn(&Numbers) -> f64) -> Term {
    Term { name, of }
}

const fn module(
    module: &'static str,
    count: fn(&Numbers) -> f64,
    area: &'static [Term],
    energy: &'static [Term],
) -> ModuleTerms {
    ModuleTerms {
        module,
        count,
        area,
        energy,
    }
}

const fn one(_: &Numbers) -> f64 {
    1.0
}

const ONE: Term = term("1", |_| 1.0);
const B: Term = term("B", |n| n.banks);
const M: Term = term("M", |n| n.ports);
const D: Term = term("d", |n| n.depth);
const F: Term = term("f", |n| n.feature);
const W: Term = term("w", |n| n.weight);
const F_W: Term = term("f w", Numbers::product);
const M_B: Term = term("M B", Numbers::all);
const M_B_D: Term = term("M B d", |n| n.all() * n.depth);
const M_B_F: Term = term("M B f", |n| n.all() * n.feature);
const M_W: Term = term("M w", |n| n.ports * n.weight);
const M_A_F: Term = term("M a f", |n| n.active() * n.feature);
// A multiplier's rows are digits of the weight: what ripples through them grows with its square.
const M_A_F_W: Term = term("M a f w", |n| n.active() * n.product());
const M_A_W_W: Term = term("M a w w", |n| n.active() * n.weight * n.weight);
const M_I_F_W: Term = term("M (B - a) f w", |n| n.idle() * n.product());
const M_I_W_W: Term = term("M (B - a) w w", |n| n.idle() * n.weight * n.weight);
const LOG_B: Term = term("log2 B", |n| n.banks.log2());
const LOG_F_W: Term = term("log2 (f + w)", |n| (n.feature + n.weight).log2());
const L: Term = term("L", |n| n.lanes);
const L_N: Term = term("L n", |n| n.lanes * n.iterations);
const L_R: Term = term("L r", |n| n.lanes * n.accumulator);
const L_ALL: Term = term("L all", |n| n.lanes * n.operations);
const L_N_ALL: Term = term("L n all", |n| n.lanes * n.iterations * n.operations);
// Lanes take turns along a ray: the more there are, the less alike are operands that follow one another.
const L_N_LOG_L: Term = term("L n log2 (2 L)", |n| {
    n.lanes * n.iterations * (2.0 * n.lanes).log2()
});
const N: Term = term("n", |n| n.iterations);
const N_K: Term = term("n k", |n| n.iterations * n.constant);
const N_R: Term = term("n r", |n| n.iterations * n.accumulator);
const K: Term = term("k", |n| n.constant);
const R: Term = term("r", |n| n.accumulator);
const ALL: Term = term("all", |n| n.operations);
const ALL_N: Term = term("all n", |n| n.operations * n.iterations);
const ALL_O: Term = term("all o", |n| n.operations * n.output);
const ALL_R: Term = term("all r", |n| n.operations * n.accumulator);
const LOG_K: Term = term("log2 k", |n| n.constant.log2());
const LOG_L: Term = term("log2 L", |n| n.lanes.log2());

const GATHERING: FamilyTerms = FamilyTerms {
    modules: &[
        module(
            GATHERING_UNIT,
            one,
            &[ONE, B, M, M_W, M_B_F],
            &[ONE, M, M_W, M_A_F],
        ),
        module(
            "feature_fifo",
            one,
            &[ONE, D, M_B, M_B_D],
            &[ONE, M_B, M_A_F],
        ),
        module("mft", one, &[ONE, M, M_B], &[ONE, M_B]),
        module(
            "reducer",
            Numbers::all,
            &[ONE, F, W, F_W],
            &[M_A_F_W, M_A_W_W, M_I_F_W, M_I_W_W],
        ),
        module("rit_buffer", one, &[ONE, M], &[ONE, M]),
    ],
    ends: &[
        ("reducer", &[ONE, LOG_F_W, LOG_B]),
        ("feature_fifo", &[ONE, F]),
        ("rit_buffer", &[ONE, M]),
        ("mft", &[ONE, M]),
        (GATHERING_UNIT, &[ONE, LOG_B, M]),
        (OUTPUTS, &[ONE, D]),
    ],
};

const VECTOR: FamilyTerms = FamilyTerms {
    modules: &[
        module(VECTOR_UNIT, one, &[ONE, L, ALL], &[ONE, L]),
        module("exp_constants", one, &[ONE, N, N_K], &[ONE, K]),
        module("result_fifo", one, &[ONE, L], &[L, L_N]),
        module(
            "vector_lane",
            |n| n.lanes,
            &[ONE, R, ALL],
            &[L, L_R, L_ALL, L_N_ALL],
        ),
    ],
    ends: &[
        ("vector_lane", &[ONE, ALL, LOG_K]),
        ("result_fifo", &[ALL, ALL_R, LOG_K]),
        ("exp_constants", &[ONE, LOG_L]),
        (VECTOR_UNIT, &[ONE]),
        (OUTPUTS, &[ONE, LOG_L]),
    ],
};

const VECTOR_PIPELINED: FamilyTerms = FamilyTerms {
    modules: &[
        module(VECTOR_UNIT, one, &[ONE, L, L_N, ALL], &[ONE, L]),
        module("result_fifo", one, &[ONE, L, L_N], &[L, L_N]),
        module(
            "vector_lane",
            |n| n.lanes,
            &[N, N_R, ALL, ALL_N],
            &[L_ALL, L_N_ALL, L_N_LOG_L],
        ),
    ],
    ends: &[
        ("vector_lane", &[ONE, ALL, LOG_K]),
        ("result_fifo", &[ONE, ALL_O, LOG_L]),
        (VECTOR_UNIT, &[ONE]),
        (OUTPUTS, &[ONE, LOG_L]),
    ],
};

impl FamilyTerms {
    pub(super) const fn of(family: Family) -> Self {
        match family {
            Family::Gathering | Family::GatheringPipelined => GATHERING,
            Family::Vector => VECTOR,
            Family::VectorPipelined => VECTOR_PIPELINED,
        }
    }
}
