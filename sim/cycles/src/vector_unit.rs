//! Stepwise model of the vector unit, one clock cycle a call: occupancy, no data (rules of
//! `docs/reference/vector-unit.md`).

use std::collections::VecDeque;

use potamoi_formats::config::{Config, rules};
use potamoi_formats::units::OpCode;

use super::exponential::{self, MOST_EXPONENT};
use super::work::WorkError;

/// Inputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VectorInputs {
    /// The operation's code, bits 3..0 of `tuser`, if a vector is valid.
    pub op: Option<u8>,
    /// Smallest exponent of its kept lanes ([`super::Exponents::least`]); used with early
    /// termination only.
    pub exponent: u32,
    /// Whether the sink accepts a result.
    pub ready: bool,
}

/// Outputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VectorOutputs {
    /// `s_axis_vec_tready`.
    pub ready: bool,
    /// `m_axis_vec_tvalid`.
    pub valid: bool,
    /// `stat_vectors`: vectors accepted by the end of the cycle before.
    pub vectors: u32,
    /// `stat_busy`: cycles in which a vector was accepted or stepped.
    pub busy: u32,
    /// `stat_stall_out`: cycles in which a vector was refused only by back-pressure, for lack of
    /// room.
    pub stall_out: u32,
}

/// Cycles of vectors, from the configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VectorTiming {
    /// I: cycles of an exponential in the iterative engine, or stages of the pipelined one.
    pub interval: u64,
    /// Whether the engine accepts a vector of any operation every cycle.
    pub pipelined: bool,
    /// Cycles by which the stages of a registered unit delay every result.
    pub lag: u64,
    /// Largest number of vectors inside.
    pub room: u64,
    /// Cycles in the iterative form by operation code; 1 for an operation that is not built.
    clocks: [u64; 16],
    /// Cycles of an exponential by smallest exponent, where they depend on it.
    by_exponent: Option<Vec<u64>>,
}

impl VectorTiming {
    /// Timing of a configuration.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(config: &Config) -> Result<Self, WorkError> {
        let breaches = rules::check(config);
        if !breaches.is_empty() {
            return Err(WorkError::Config(breaches.to_string()));
        }
        let exp = &config.vu.exp;
        let interval = exponential::clocks(exp);
        let mut clocks = [1; 16];
        for op in &config.vu.ops {
            clocks[usize::from(op.code() & 15)] = match op {
                OpCode::Exp | OpCode::OneMinusExp => interval,
                _ => config.vu.passes(*op).cycles().into(),
            };
        }
        let stages = if exp.pipelined { interval + 1 } else { 0 };
        let lag = u64::from(config.vu.lag());
        Ok(Self {
            interval,
            pipelined: exp.pipelined,
            lag,
            room: u64::from(config.vu.fifo_depth) + stages + lag,
            clocks,
            by_exponent: exponential::clocks_by_exponent(exp),
        })
    }

    /// Minimum cycles from accepting a vector to accepting the next; `exponent` is the smallest of
    /// its lanes. An operation that is not built takes as long as an element-wise one.
    #[must_use]
    pub fn occupancy(&self, code: u8, exponent: u32) -> u64 {
        let clocks = self.clocks[usize::from(code & 15)];
        if self.pipelined {
            return 1;
        }
        match &self.by_exponent {
            // One clock: no exponential, since those that stop early take more.
            Some(powers) if clocks > 1 => powers[exponent.min(MOST_EXPONENT) as usize],
            _ => clocks,
        }
    }

    /// Cycles from accepting a vector to offering its result.
    #[must_use]
    pub fn latency(&self, code: u8, exponent: u32) -> u64 {
        let stages = if self.pipelined {
            self.interval
        } else {
            self.occupancy(code, exponent)
        };
        stages + 1 + self.lag
    }
}

/// The vector unit between two clock edges.
#[derive(Debug, Clone)]
pub struct VectorModel {
    timing: VectorTiming,
    cycle: u64,
    /// First cycle in which the engine accepts a vector.
    free: u64,
    /// First cycle in which no vector is stepped.
    rest: u64,
    /// First cycle of offer of every vector inside.
    inside: VecDeque<u64>,
    vectors: u32,
    busy: u32,
    stall_out: u32,
}

impl VectorModel {
    /// The unit after reset.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(config: &Config) -> Result<Self, WorkError> {
        Ok(Self {
            timing: VectorTiming::new(config)?,
            cycle: 0,
            free: 0,
            rest: 0,
            inside: VecDeque::new(),
            vectors: 0,
            busy: 0,
            stall_out: 0,
        })
    }

    fn has_room(&self) -> bool {
        (self.inside.len() as u64) < self.timing.room
    }

    /// `s_axis_vec_tready` in the next cycle.
    #[must_use]
    pub fn ready(&self) -> bool {
        self.cycle >= self.free && self.has_room()
    }

    /// `m_axis_vec_tvalid` in the next cycle.
    #[must_use]
    pub fn offers(&self) -> bool {
        self.inside.front().is_some_and(|&due| due <= self.cycle)
    }

    /// Whether no vector is inside.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.inside.is_empty()
    }

    /// A cycle with `cfg_clear` high and no vector offered.
    pub fn clear(&mut self) {
        self.step(&VectorInputs::default());
        (self.vectors, self.busy, self.stall_out) = (0, 0, 0);
    }

    /// One clock cycle.
    pub fn step(&mut self, inputs: &VectorInputs) -> VectorOutputs {
        let outputs = VectorOutputs {
            ready: self.ready(),
            valid: self.offers(),
            vectors: self.vectors,
            busy: self.busy,
            stall_out: self.stall_out,
        };
        let refused = self.cycle >= self.free && !self.has_room();
        if outputs.valid && inputs.ready {
            self.inside.pop_front();
        }
        if let Some(code) = inputs.op {
            if outputs.ready {
                let occupancy = self.timing.occupancy(code, inputs.exponent);
                self.free = self.cycle + occupancy;
                self.rest = self.cycle
                    + if self.timing.pipelined {
                        self.timing.interval
                    } else {
                        occupancy
                    };
                let latency = self.timing.latency(code, inputs.exponent);
                self.inside.push_back(self.cycle + latency);
                self.vectors = self.vectors.saturating_add(1);
            } else if refused {
                self.stall_out = self.stall_out.saturating_add(1);
            }
        }
        if self.cycle < self.rest {
            self.busy = self.busy.saturating_add(1);
        }
        self.cycle += 1;
        outputs
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn model(text: &str) -> VectorModel {
        VectorModel::new(&Config::from_toml(text, "test").unwrap()).unwrap()
    }

    /// Offers the operations without pause; returns the cycles of acceptance and result.
    fn play(mut unit: VectorModel, ops: &[OpCode]) -> (Vec<u64>, Vec<u64>) {
        let (mut taken, mut given) = (Vec::new(), Vec::new());
        for cycle in 0..10_000 {
            let op = ops.get(taken.len()).map(|op| op.code());
            let out = unit.step(&VectorInputs {
                op,
                ready: true,
                ..VectorInputs::default()
            });
            if op.is_some() && out.ready {
                taken.push(cycle);
            }
            if out.valid {
                given.push(cycle);
            }
        }
        (taken, given)
    }

    #[test]
    fn the_iterative_engine_takes_its_interval_and_element_wise_one_cycle() {
        use OpCode::{Add, Exp, OneMinusExp, Pass};
        let (taken, given) = play(model(""), &[Exp, Pass, Add, OneMinusExp, Exp]);
        assert_eq!(taken, [0, 20, 21, 22, 42]);
        assert_eq!(given, [21, 22, 23, 43, 63]);
        let (taken, given) = play(
            model("[vu.exp]\niterations_per_clock = 6\ntail = true"),
            &[Exp, Exp, Pass],
        );
        assert_eq!(taken, [0, 5, 10]);
        assert_eq!(given, [6, 11, 12]);
    }

    /// I = 20 for an exponential, S = 20 for a logarithm; with a tail, which the logarithm does not
    /// use, 5 and 4.
    #[test]
    fn softplus_takes_two_passes_and_sigmoid_three() {
        use OpCode::{Exp, Pass, Sigmoid, Softplus};
        let ops = "[vu]\nops = [\"pass\", \"exp\", \"sigmoid\", \"softplus\"]";
        let (taken, given) = play(model(ops), &[Softplus, Pass, Sigmoid, Exp, Pass]);
        assert_eq!(taken, [0, 40, 41, 101, 121]);
        assert_eq!(given, [41, 42, 102, 122, 123]);
        let tail = format!("{ops}\n[vu.exp]\niterations_per_clock = 6\ntail = true");
        let (taken, given) = play(model(&tail), &[Softplus, Sigmoid, Exp, Pass]);
        assert_eq!(taken, [0, 9, 23, 28]);
        assert_eq!(given, [10, 24, 29, 30]);
    }

    #[test]
    fn the_pipelined_engine_takes_a_vector_a_cycle() {
        use OpCode::{Exp, Pass};
        let (taken, given) = play(model("[vu.exp]\npipelined = true"), &[Exp, Pass, Exp]);
        assert_eq!(taken, [0, 1, 2]);
        assert_eq!(given, [21, 22, 23]);
        let ops = vec![Exp; 500];
        let (taken, given) = play(
            model("[vu]\nfifo_depth = 3\n[vu.exp]\npipelined = true"),
            &ops,
        );
        assert_eq!((taken[499], given[499]), (499, 520));
    }

    /// Two cycles later, and four with straight pieces; the spacing of vectors stays.
    #[test]
    fn a_registered_unit_gives_the_same_later() {
        use OpCode::{Add, Exp, OneMinusExp, Pass};
        let ops = [Exp, Pass, Add, OneMinusExp, Exp];
        for (text, lag) in [
            ("", 2),
            ("[vu.exp]\niterations_per_clock = 20", 2),
            ("[vu.exp]\npipelined = true", 2),
            ("[vu.exp]\nform = \"piecewise\"\npipelined = true", 4),
        ] {
            let (taken, given) = play(model(text), &ops);
            let text = format!("[vu]\nregistered = true\n{text}");
            let later = given.iter().map(|cycle| cycle + lag).collect::<Vec<_>>();
            assert_eq!(play(model(&text), &ops), (taken, later), "{text}");
            // With the fewest places no cycle is lost.
            let (taken, _) = play(model(&text), &[Pass; 300]);
            assert_eq!(taken[299], 299);
        }
    }

    /// The default depth is the fewest: a result is offered two cycles after its operands are taken,
    /// and its place counts until the cycle after.
    #[test]
    fn three_places_lose_no_cycle_and_two_do() {
        let last = |depth: u64| {
            // The rules refuse two.
            let mut unit = model("");
            unit.timing.room = depth;
            play(unit, &[OpCode::Pass; 300]).0[299]
        };
        assert_eq!((last(2), last(3), last(4)), (448, 299, 299));
        assert_eq!(Config::default().vu.fifo_depth, 3);
    }

    /// n(k) iterations after four digits, at least 6 clocks; 20 for k up to 2.
    #[test]
    fn an_early_out_takes_what_the_exponent_asks_for() {
        let timing =
            VectorTiming::new(&Config::from_toml("[vu.exp]\nearly_out = true", "test").unwrap())
                .unwrap();
        for (k, clocks) in [
            (0, 20),
            (2, 20),
            (3, 19),
            (12, 10),
            (16, 6),
            (17, 6),
            (24, 6),
            (99, 6),
        ] {
            for op in [OpCode::Exp, OpCode::OneMinusExp] {
                assert_eq!(timing.occupancy(op.code(), k), clocks, "{k}");
                assert_eq!(timing.latency(op.code(), k), clocks + 1, "{k}");
            }
            assert_eq!(timing.occupancy(OpCode::Add.code(), k), 1);
        }
        let three = Config::from_toml(
            "[vu.exp]\nearly_out = true\niterations_per_clock = 3",
            "test",
        );
        let timing = VectorTiming::new(&three.unwrap()).unwrap();
        let found = [0, 3, 4, 6, 7, 9, 10, 24].map(|k| timing.occupancy(5, k));
        assert_eq!(found, [7, 7, 6, 6, 5, 5, 4, 4]);
    }

    /// Two stages, or one without a multiplication by log2 e.
    #[test]
    fn straight_pieces_take_two_stages() {
        use OpCode::{Exp, Pass};
        for (base, latency) in [("e", 3), ("two", 2)] {
            let text =
                format!("[vu.exp]\nform = \"piecewise\"\npipelined = true\nbase = \"{base}\"");
            let (taken, given) = play(model(&text), &[Exp, Pass, Exp]);
            assert_eq!(taken, [0, 1, 2]);
            assert_eq!(given, [0, 1, 2].map(|t| t + latency));
        }
        let (taken, given) = play(
            model("[vu.exp]\nform = \"radix-4\"\niterations = 4\ntail = true"),
            &[Exp, Exp, Pass],
        );
        assert_eq!(taken, [0, 7, 14]);
        assert_eq!(given, [8, 15, 16]);
    }

    #[test]
    fn an_operation_left_out_takes_one_cycle() {
        let (taken, _) = play(
            model("[vu]\nops = [\"pass\"]"),
            &[OpCode::Exp, OpCode::Exp, OpCode::Pass],
        );
        assert_eq!(taken, [0, 1, 2]);
    }

    #[test]
    fn a_blocked_sink_stops_the_unit_after_its_room_and_is_counted() {
        for (text, room) in [("", 3), ("[vu.exp]\npipelined = true", 24)] {
            let mut unit = model(text);
            let blocked = VectorInputs {
                op: Some(0),
                exponent: 0,
                ready: false,
            };
            for _ in 0..100 {
                unit.step(&blocked);
            }
            let out = unit.step(&VectorInputs {
                op: Some(0),
                exponent: 0,
                ready: true,
            });
            assert_eq!((out.vectors, out.stall_out), (room, 100 - room), "{text}");
            assert!(!out.ready && out.valid);
            // The place that was just given back counts from the next cycle.
            assert!(unit.ready());
        }
    }

    #[test]
    fn busy_counts_steps() {
        let mut unit = model("");
        let mut last = None;
        for cycle in 0..60 {
            let op = [(0, 5), (20, 0), (30, 0)]
                .iter()
                .find(|(at, _)| *at == cycle)
                .map(|&(_, code)| code);
            last = Some(unit.step(&VectorInputs {
                op,
                ready: true,
                ..VectorInputs::default()
            }));
        }
        let last = last.unwrap();
        assert_eq!((last.busy, last.vectors, last.stall_out), (22, 3, 0));
        unit.clear();
        assert_eq!(unit.step(&VectorInputs::default()).vectors, 0);
    }

    proptest! {
        /// Under any stalls, nothing is lost or early, and results wait until accepted.
        #[test]
        fn results_come_once_and_in_time(
            pipelined in any::<bool>(), depth in 3u32..8, r in 1u32..20,
            early in any::<bool>(), registered in any::<bool>(),
            ops in prop::collection::vec((0u8..7, any::<bool>(), any::<bool>(), 0u32..30), 1..400),
        ) {
            let early = early && !pipelined && r < 7;
            let registered = registered && !early;
            let text = format!("[vu]\nfifo_depth = {depth}\nregistered = {registered}\n[vu.exp]\npipelined = {pipelined}\niterations_per_clock = {r}\nearly_out = {early}");
            let mut unit = model(&text);
            let timing = unit.timing.clone();
            let mut due = VecDeque::new();
            let mut waits = false;
            for (cycle, &(code, valid, ready, exponent)) in ops.iter().chain([&(0, false, true, 0); 100]).enumerate() {
                let out = unit.step(&VectorInputs { op: valid.then_some(code), exponent, ready });
                prop_assert!(out.valid || !waits);
                waits = out.valid && !ready;
                if out.valid && ready {
                    prop_assert!(due.pop_front().unwrap() <= cycle as u64);
                }
                if valid && out.ready {
                    due.push_back(cycle as u64 + timing.latency(code, exponent));
                }
                prop_assert!(due.len() as u64 <= timing.room);
            }
            prop_assert!(due.is_empty() && unit.is_idle());
        }
    }
}
