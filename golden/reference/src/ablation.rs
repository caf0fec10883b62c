//! Units with single effects left out or forced, for ablation.

use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};

use crate::gathering_unit::Reducer;
use crate::splat_unit::{Composited, SplatJob};
use crate::{GatherTask, Product, UnitError, Units};
use potamoi_base::effects::{Choices, Effect};

/// Wraps units so that chosen effects of their arithmetic are left out, or forced where no task
/// needs them.
///
/// | effect | left out | forced |
/// |---|---|---|
/// | trilinear | only the vertex of the largest weight counts | single ids are weighted with 1 and rounded too; a changed code is an error |
/// | exponential | only the first term of the series: `exp(-u)` is 1, `1 - exp(-s)` is s, at most 1 | |
/// | segments | only the channels of the first pass are gathered, the others are 0 | |
pub struct AblatedUnits<'u> {
    units: &'u mut dyn Units,
    choices: Choices,
    reducer: Reducer,
    /// Channels of one pass.
    pass: usize,
    /// Fraction bits of the arguments of powers, of the arguments of `1 - exp`, and of results.
    bits: [u32; 3],
}

impl<'u> AblatedUnits<'u> {
    /// Wraps `units`, which must be those of `config`.
    pub fn new(units: &'u mut dyn Units, config: &Config, choices: Choices) -> Self {
        let exp = &config.vu.exp;
        Self {
            units,
            choices,
            reducer: Reducer::new(config),
            pass: config.lanes_a_port() as usize,
            bits: [
                exp.input.frac_bits(),
                exp.one_minus_frac_bits,
                exp.output_bits,
            ],
        }
    }

    /// Whether `choices` leave out or force an effect that this wrapper implements.
    pub fn is_asked_for(choices: Choices) -> bool {
        let effects = [Effect::Trilinear, Effect::Exponential, Effect::Segments];
        choices.forces(Effect::Trilinear) || effects.iter().any(|e| choices.leaves_out(*e))
    }

    /// The same tasks with the whole weight of each entry on its nearest vertex.
    #[must_use]
    fn nearest(&self, tasks: &[GatherTask]) -> Vec<GatherTask> {
        let mut tasks = tasks.to_vec();
        for task in &mut tasks {
            let count = task.vertices.count();
            if !task.vertices.is_structured() {
                continue;
            }
            for entry in &mut task.entries {
                let own = &mut entry.weights[..count];
                // Of equal ones the first.
                let largest = own.iter().copied().max().unwrap_or_default();
                let nearest = own.iter().position(|w| *w == largest).unwrap_or_default();
                own.fill(0);
                own[nearest] = 1 << self.reducer.weight_bits();
            }
        }
        tasks
    }

    /// Weights single ids with 1 and fails where a code changes.
    fn weigh(&self, tasks: &[GatherTask], features: &[i16]) -> Result<(), UnitError> {
        let one = 1u16 << self.reducer.weight_bits();
        let mut rest = features;
        for (number, task) in tasks.iter().enumerate() {
            let (own, after) = rest.split_at(task.entries.len() * task.channels);
            rest = after;
            let differs = |code: &i16| {
                let sum = self.reducer.sum([(one, *code)].into_iter());
                self.reducer.round(sum) != *code
            };
            if !task.vertices.is_structured()
                && let Some(at) = own.iter().position(differs)
            {
                return Err(format!(
                    "task {number}: code {} of single id {} is another one behind a reducer",
                    own[at],
                    at / task.channels.max(1)
                )
                .into());
            }
        }
        Ok(())
    }

    /// Clears the channels of all segments but the first, if segments are left out.
    fn first_pass<T: Copy + Default>(&self, tasks: &[GatherTask], results: &mut [T]) {
        if !self.choices.leaves_out(Effect::Segments) {
            return;
        }
        let mut rest = results;
        for task in tasks {
            let (own, after) = rest.split_at_mut(task.entries.len() * task.channels);
            rest = after;
            for codes in own.chunks_exact_mut(task.channels.max(1)) {
                codes[self.pass.min(task.channels)..].fill(T::default());
            }
        }
    }

    /// The first term of the series of a power.
    fn first_term(&self, code: OpCode, a: i32) -> i32 {
        let [input, one_minus, output] = self.bits;
        let of = |bits: u32| f64::from(a) * 2f64.powi(-(bits as i32));
        let full = 2f64.powi(output as i32);
        let (value, most) = match code {
            OpCode::Exp => (1.0, full - 1.0),
            OpCode::OneMinusExp => (of(one_minus).clamp(0.0, 1.0), full - 1.0),
            OpCode::Sigmoid => ((0.5 + of(input) / 4.0).clamp(0.0, 1.0), full - 1.0),
            _ => (of(input).max(0.0), f64::from(i32::MAX)),
        };
        (value * full).round().min(most) as i32
    }
}

impl Units for AblatedUnits<'_> {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let begin = features.len();
        if self.choices.leaves_out(Effect::Trilinear) {
            self.units.gather(&self.nearest(tasks), features)?;
        } else {
            self.units.gather(tasks, features)?;
        }
        if self.choices.forces(Effect::Trilinear) {
            self.weigh(tasks, &features[begin..])?;
        }
        self.first_pass(tasks, &mut features[begin..]);
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        let weighted = tasks.iter().any(|task| task.vertices.is_structured());
        if weighted && self.choices.leaves_out(Effect::Trilinear) {
            return Err(
                "interpolation cannot be left out of sums of parts of a cell, whose nearest \
                 vertex may lie in another MVoxel: use render.halo = \"shared\""
                    .into(),
            );
        }
        let begin = sums.len();
        self.units.sums(tasks, sums)?;
        if self.choices.forces(Effect::Trilinear) {
            let rounded = sums[begin..]
                .iter()
                .map(|s| self.reducer.round((*s).into()));
            self.weigh(tasks, &rounded.collect::<Vec<_>>())?;
        }
        self.first_pass(tasks, &mut sums[begin..]);
        Ok(())
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        if !(op.code.is_exponential() && self.choices.leaves_out(Effect::Exponential)) {
            return self.units.vector(op, a, b, out);
        }
        for (out, a) in out.iter_mut().zip(a) {
            *out = self.first_term(op.code, *a);
        }
        Ok(())
    }

    /// The splat unit's exponential is one operation with the cut, which takes the limits from it.
    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        if self.choices.leaves_out(Effect::Exponential) {
            return Err(
                "the splat unit's exponential cannot be left out: its cut is derived from it; \
                        use a configuration without the table [su]"
                    .into(),
            );
        }
        self.units.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.units.multiplied(product);
    }
}

#[cfg(test)]
mod tests {
    use potamoi_formats::config::Config;
    use potamoi_formats::rit::{RitEntry, Vertices};

    use super::*;
    use crate::ReferenceUnits;

    /// Only the vertex of the largest weight remains, the first among equal ones; single ids do
    /// not change.
    #[test]
    fn the_nearest_vertex_is_the_heaviest() {
        let config = Config::paper();
        let mut twins = ReferenceUnits::new(&config);
        let altered = AblatedUnits::new(&mut twins, &config, Choices::default());
        let task = |vertices, weights: [u16; 8]| GatherTask {
            vertices,
            channels: 1,
            rows: (0..8).collect(),
            entries: vec![RitEntry {
                slot: 0,
                rows: [0, 1, 2, 3, 4, 5, 6, 7],
                weights,
            }],
        };
        let one = 1u16 << altered.reducer.weight_bits();
        let alone = |at: usize| {
            let mut all = [0; 8];
            all[at] = one;
            all
        };
        let (half, quarter) = (one / 2, one / 4);
        for (weights, at) in [
            ([quarter, 0, 0, half, quarter, 0, 0, 0], 3),
            ([0, quarter, quarter, 0, 0, quarter, quarter, 0], 1),
        ] {
            let found = altered.nearest(&[task(Vertices::Eight, weights)]);
            assert_eq!(found[0].entries[0].weights, alone(at));
        }
        let single = task(Vertices::One, [one, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(altered.nearest(std::slice::from_ref(&single)), [single]);
    }
}
