//! Observers of the units' calls: counters, recorders and digests, any number at once.
//!
//! An [`Observer`] is told of each call with its results. It forwards nothing, so it can neither
//! drop nor change a request. [`Observed`] is the one place that forwards.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::units::{OpCode, VectorOp};
//! use potamoi_reference::observer::Observed;
//! use potamoi_reference::trace_recorder::{Limits, Recorder};
//! use potamoi_reference::{ReferenceUnits, Units};
//!
//! let config = Config::paper();
//! let mut twins = ReferenceUnits::new(&config);
//! let mut recorder = Recorder::new(Limits::NONE);
//! let mut units = Observed::new(&mut twins, &config).by(&mut recorder);
//! let mut out = [0; 2];
//! let op = VectorOp::new(OpCode::Add);
//! units.vector(op, &[3, 8], &[5, 5], &mut out).unwrap();
//! assert_eq!(out, [8, 13]);
//! assert_eq!(recorder.computed[0].out, out);
//! ```

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::units::VectorOp;

use super::gathering_unit::Reducer;
use super::splat_unit::{Composited, SplatJob};
use super::{GatherTask, Product, UnitError, Units};

/// A gather call, with `channels` results for every entry of every task, in order.
#[derive(Debug, Clone, Copy)]
pub struct GatherCall<'c> {
    /// The tasks.
    pub tasks: &'c [GatherTask],
    /// Feature codes, unless unrounded sums were requested ([`Units::sums`]).
    pub codes: Option<&'c [i16]>,
    /// Unrounded sums in units of 2^-W, if the unit has `gu.sums = "exact"`, whichever result was
    /// requested.
    pub sums: Option<&'c [i32]>,
}

impl GatherCall<'_> {
    /// Calls `each` with every task and its results as the unit itself returns them: sums if there
    /// are any, else codes.
    pub fn each_task(&self, mut each: impl FnMut(&GatherTask, Vec<i32>)) {
        let mut at = 0;
        for task in self.tasks {
            let own = at..at + task.entries.len() * task.channels;
            at = own.end;
            let values = match (self.sums, self.codes) {
                (Some(sums), _) => sums[own].to_vec(),
                (None, Some(codes)) => codes[own].iter().map(|code| (*code).into()).collect(),
                (None, None) => vec![],
            };
            each(task, values);
        }
    }
}

/// A vector operation with its results. All slices have the same length.
#[derive(Debug, Clone, Copy)]
pub struct VectorCall<'c> {
    /// The operation.
    pub op: VectorOp,
    /// First operands.
    pub a: &'c [i32],
    /// Second operands.
    pub b: &'c [i32],
    /// Results.
    pub out: &'c [i32],
}

/// A job of the splat unit with its results.
#[derive(Debug, Clone, Copy)]
pub struct SplatCall<'c> {
    /// The job.
    pub job: &'c SplatJob<'c>,
    /// Pixels and counts.
    pub done: &'c Composited,
}

/// Receives every call of the units. No method has a default body: an observer states explicitly
/// what it ignores.
pub trait Observer {
    /// Called after tasks were gathered.
    ///
    /// # Errors
    /// The call cannot be counted; the renderer stops with that error.
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError>;

    /// Called after a vector operation was computed.
    ///
    /// # Errors
    /// As [`Observer::gathered`].
    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError>;

    /// Called after the splat unit did a job.
    ///
    /// # Errors
    /// As [`Observer::gathered`].
    fn composited(&mut self, call: &SplatCall<'_>) -> Result<(), UnitError>;

    /// Called for each product of the MAC array.
    fn multiplied(&mut self, product: &Product);
}

/// Forwards calls to units, and reports each successful one to the observers.
pub struct Observed<'u> {
    units: &'u mut dyn Units,
    observers: Vec<&'u mut dyn Observer>,
    sums: Sums,
    reducer: Reducer,
}

impl<'u> Observed<'u> {
    /// `units`, which must be those of `config`, without observers.
    pub fn new(units: &'u mut dyn Units, config: &Config) -> Self {
        Self {
            units,
            observers: vec![],
            sums: config.gu.sums,
            reducer: Reducer::new(config),
        }
    }

    /// Adds an observer, which is called after those added before.
    #[must_use]
    pub fn by(mut self, observer: &'u mut dyn Observer) -> Self {
        self.observers.push(observer);
        self
    }

    fn tell(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        let mut observers = self.observers.iter_mut();
        observers.try_for_each(|observer| observer.gathered(call))
    }
}

impl Units for Observed<'_> {
    /// A unit of exact sums returns no rounded ones, so they are rounded here.
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let begin = features.len();
        let mut sums = vec![];
        match self.sums {
            Sums::Rounded => self.units.gather(tasks, features)?,
            Sums::Exact => {
                self.units.sums(tasks, &mut sums)?;
                features.extend(sums.iter().map(|sum| self.reducer.round((*sum).into())));
            }
        }
        self.tell(&GatherCall {
            tasks,
            codes: Some(&features[begin..]),
            sums: (self.sums == Sums::Exact).then_some(&sums),
        })
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        let begin = sums.len();
        self.units.sums(tasks, sums)?;
        self.tell(&GatherCall {
            tasks,
            codes: None,
            sums: Some(&sums[begin..]),
        })
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.units.vector(op, a, b, out)?;
        let call = VectorCall { op, a, b, out };
        let mut observers = self.observers.iter_mut();
        observers.try_for_each(|observer| observer.computed(&call))
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        let done = self.units.splats(job)?;
        let call = SplatCall { job, done: &done };
        let mut observers = self.observers.iter_mut();
        observers.try_for_each(|observer| observer.composited(&call))?;
        Ok(done)
    }

    fn multiplied(&mut self, product: Product) {
        self.units.multiplied(product);
        for observer in &mut self.observers {
            observer.multiplied(&product);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::rit::{RitEntry, Vertices};
    use potamoi_formats::units::OpCode;

    use super::*;
    use crate::ReferenceUnits;
    use crate::trace_recorder::{Limits, Recorder};

    fn task(code: i16) -> GatherTask {
        GatherTask {
            vertices: Vertices::Eight,
            channels: 1,
            rows: vec![code, 0],
            entries: vec![RitEntry {
                slot: 0,
                rows: [0, 1, 1, 1, 1, 1, 1, 1],
                weights: [1 << 14, 1 << 14, 0, 0, 0, 0, 0, 0],
            }],
        }
    }

    /// Observed units return the same results as on their own, and every observer sees them.
    fn seen(config: &Config) -> [Recorder; 2] {
        let [mut alone, mut twins] = [(); 2].map(|()| ReferenceUnits::new(config));
        let mut recorders = [(); 2].map(|()| Recorder::new(Limits::NONE));
        let [first, second] = &mut recorders;
        let mut units = Observed::new(&mut twins, config).by(first).by(second);
        let tasks = [task(82), task(-6)];
        let (mut codes, mut expected) = (vec![7], vec![7]);
        units.gather(&tasks, &mut codes).unwrap();
        alone.gather(&tasks, &mut expected).unwrap();
        assert_eq!(codes, expected);
        if config.gu.sums == Sums::Exact {
            let (mut sums, mut expected) = (vec![], vec![]);
            units.sums(&tasks, &mut sums).unwrap();
            alone.sums(&tasks, &mut expected).unwrap();
            assert_eq!(sums, expected);
        }
        let mut out = [0; 2];
        let op = VectorOp::new(OpCode::Add);
        units.vector(op, &[1, 2], &[2, 1], &mut out).unwrap();
        assert_eq!(out, [3, 3]);
        assert_eq!(twins.counts().gathers, alone.counts().gathers);
        recorders
    }

    #[test]
    fn units_give_the_same_with_observers_who_all_see_it() {
        let paper = Config::paper();
        for recorder in seen(&paper) {
            let values = recorder.gathered.iter().map(|g| &g.features[..]);
            assert_eq!(values.collect::<Vec<_>>(), [[41], [-3]]);
            assert_eq!(recorder.computed.len(), 1);
        }
        let exact = Config::from_toml("[gu]\nsums = \"exact\"\n", "test").unwrap();
        for recorder in seen(&exact) {
            // Codes that were asked for, and then the sums: of both the unit gives sums.
            let values = recorder.gathered.iter().map(|g| g.features[0]);
            let sums = [82 << 14, -6 * (1 << 14)];
            assert_eq!(values.collect::<Vec<_>>(), [sums, sums].concat());
        }
    }

    /// An observer that ignores results and refuses every call.
    struct Refuses;

    impl Observer for Refuses {
        fn gathered(&mut self, _: &GatherCall<'_>) -> Result<(), UnitError> {
            Err("seen enough".into())
        }

        fn computed(&mut self, _: &VectorCall<'_>) -> Result<(), UnitError> {
            Err("seen enough".into())
        }

        fn composited(&mut self, _: &SplatCall<'_>) -> Result<(), UnitError> {
            Err("seen enough".into())
        }

        fn multiplied(&mut self, _: &Product) {}
    }

    #[test]
    fn an_observer_that_fails_ends_the_call() {
        let config = Config::paper();
        let mut twins = ReferenceUnits::new(&config);
        let mut refuses = Refuses;
        let mut units = Observed::new(&mut twins, &config).by(&mut refuses);
        let error = units.gather(&[task(1)], &mut vec![]).unwrap_err();
        assert_eq!(error.to_string(), "seen enough");
        let op = VectorOp::new(OpCode::Add);
        assert!(units.vector(op, &[1], &[2], &mut [0]).is_err());
    }
}
