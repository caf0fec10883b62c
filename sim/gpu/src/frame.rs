//! A frame as the launched operations of a program, and its time.

use std::collections::BTreeMap;

use crate::{Device, Kernel, Term};

/// Who launches the kernels, which decides the host's time for each operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Launch {
    /// A framework in eager mode, operation by operation.
    Framework,
    /// A program in C++.
    Native,
}

/// Whether a kernel's demands overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlap {
    /// Wholly: a kernel takes its largest demand.
    Whole,
    /// Not at all: a kernel takes the sum of its demands.
    None,
}

/// The operations of a frame, in the order in which the host launches them.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Who launches.
    pub launch: Launch,
    /// The launched operations.
    pub kernels: Vec<Kernel>,
}

/// Seconds of a frame, and what they are spent on.
#[derive(Debug, Clone, PartialEq)]
pub struct Time {
    /// All seconds.
    pub seconds: f64,
    /// Seconds by term. They add up to all seconds.
    pub by_term: BTreeMap<Term, f64>,
}

/// Seconds of a frame at both bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// With the demands of each kernel overlapped wholly: the fewest seconds.
    pub max: Time,
    /// With the demands of each kernel one after the other: the most seconds.
    pub sum: Time,
}

impl Bounds {
    /// The geometric mean of both bounds, in seconds: the prediction.
    #[must_use]
    pub fn mid(&self) -> f64 {
        (self.max.seconds * self.sum.seconds).sqrt()
    }
}

impl Time {
    /// Terms by seconds, the largest first.
    #[must_use]
    pub fn largest(&self) -> Vec<(Term, f64)> {
        let mut terms: Vec<_> = self.by_term.iter().map(|(t, s)| (*t, *s)).collect();
        terms.sort_by(|a, b| b.1.total_cmp(&a.1));
        terms
    }
}

impl Frame {
    /// Time at both bounds.
    #[must_use]
    pub fn bounds(&self, device: &Device) -> Bounds {
        self.bounds_without(device, None)
    }

    /// Time at both bounds as if one term cost nothing.
    #[must_use]
    pub fn bounds_without(&self, device: &Device, without: Option<Term>) -> Bounds {
        Bounds {
            max: self.time(device, Overlap::Whole, without),
            sum: self.time(device, Overlap::None, without),
        }
    }

    /// Time with the demands of a kernel overlapped or not, as if one term cost nothing.
    ///
    /// Host and device overlap between waits: such a stretch takes the longer of both. A wait adds
    /// its own time, since neither has work then.
    #[must_use]
    pub fn time(&self, device: &Device, overlap: Overlap, without: Option<Term>) -> Time {
        let mut clock = Clock::new(self.launch, device, without);
        for kernel in &self.kernels {
            clock.launch(kernel, overlap);
            if kernel.waits {
                clock.wait();
            }
        }
        clock.end()
    }

    /// Operations that the host launches.
    #[must_use]
    pub fn operations(&self) -> f64 {
        self.kernels.iter().map(|k| k.operations).sum()
    }

    /// Waits of the host.
    #[must_use]
    pub fn waits(&self) -> usize {
        self.kernels.iter().filter(|k| k.waits).count()
    }
}

/// Time so far, and the stretch since the last wait.
struct Clock<'a> {
    device: &'a Device,
    without: Option<Term>,
    operation_s: f64,
    done: BTreeMap<Term, f64>,
    stretch: BTreeMap<Term, f64>,
    host_s: f64,
}

impl<'a> Clock<'a> {
    fn new(launch: Launch, device: &'a Device, without: Option<Term>) -> Self {
        let operation_us = match launch {
            Launch::Framework => device.operation_us,
            Launch::Native => device.launch_us,
        };
        Self {
            device,
            without,
            operation_s: operation_us * 1e-6,
            done: BTreeMap::new(),
            stretch: BTreeMap::new(),
            host_s: 0.0,
        }
    }

    fn counts(&self, term: Term) -> bool {
        self.without != Some(term)
    }

    fn launch(&mut self, kernel: &Kernel, overlap: Overlap) {
        let terms = kernel.terms(self.device);
        let terms = terms.into_iter().filter(|(term, _)| self.counts(*term));
        let spent: Vec<_> = match overlap {
            Overlap::Whole => terms
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .into_iter()
                .collect(),
            Overlap::None => terms.collect(),
        };
        for (term, seconds) in spent {
            *self.stretch.entry(term).or_default() += seconds;
        }
        if self.counts(Term::Ramp) {
            let ramp = kernel.operations * self.device.ramp_us * 1e-6;
            *self.stretch.entry(Term::Ramp).or_default() += ramp;
        }
        if self.counts(Term::Host) {
            self.host_s += kernel.operations * self.operation_s;
        }
    }

    /// Ends the stretch: it took as long as the longer of host and device.
    fn close(&mut self) {
        let stretch = std::mem::take(&mut self.stretch);
        let device_s: f64 = stretch.values().sum();
        if self.host_s > device_s {
            *self.done.entry(Term::Host).or_default() += self.host_s;
        } else {
            for (term, seconds) in stretch {
                *self.done.entry(term).or_default() += seconds;
            }
        }
        self.host_s = 0.0;
    }

    fn wait(&mut self) {
        self.close();
        if self.counts(Term::Wait) {
            *self.done.entry(Term::Wait).or_default() += self.device.wait_us * 1e-6;
        }
    }

    fn end(mut self) -> Time {
        self.close();
        Time {
            seconds: self.done.values().sum(),
            by_term: self.done,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn device() -> Device {
        Device::builtin("2080ti").unwrap()
    }

    fn of(kernels: Vec<Kernel>) -> Frame {
        Frame {
            launch: Launch::Framework,
            kernels,
        }
    }

    fn streaming(bytes: f64, waits: bool) -> Kernel {
        Kernel {
            dram_bytes: bytes,
            waits,
            ..Kernel::new("stream")
        }
    }

    #[test]
    fn small_kernels_take_the_hosts_time() {
        let frame = of(vec![streaming(1.0, false); 100]);
        let time = frame.time(&device(), Overlap::Whole, None);
        let expected = 100.0 * device().operation_us * 1e-6;
        assert!((time.seconds / expected - 1.0).abs() < 1e-9);
        assert_eq!(time.largest()[0].0, Term::Host);
    }

    #[test]
    fn host_and_device_overlap_between_waits_alone() {
        let long = device().dram_gb_s * 1e9 * 1e-3;
        let apart = of(vec![streaming(long, true), streaming(1.0, false)]);
        let together = of(vec![streaming(long, false), streaming(1.0, false)]);
        let seconds = |f: &Frame| f.time(&device(), Overlap::Whole, None).seconds;
        let wait = device().wait_us * 1e-6;
        assert!(seconds(&apart) >= seconds(&together) + wait);
    }

    #[test]
    fn terms_add_up_and_an_ablation_takes_no_longer() {
        let mut kernel = Kernel::new("busy");
        for demand in kernel.demands() {
            *demand = 1e7;
        }
        let frame = of(vec![
            kernel.clone(),
            Kernel {
                waits: true,
                ..kernel
            },
        ]);
        let all = frame.bounds(&device());
        for time in [&all.max, &all.sum] {
            let sum: f64 = time.by_term.values().sum();
            assert!((sum / time.seconds - 1.0).abs() < 1e-12);
        }
        assert!(all.max.seconds <= all.mid() && all.mid() <= all.sum.seconds);
        for term in Term::ALL {
            let less = frame.bounds_without(&device(), Some(term));
            assert!(less.max.seconds <= all.max.seconds, "{term:?}");
            assert!(less.sum.seconds <= all.sum.seconds, "{term:?}");
            assert!(!less.sum.by_term.contains_key(&term), "{term:?}");
        }
    }

    #[test]
    fn empty_kernels_give_host_and_launch_time_only() {
        let frame = of(vec![Kernel::new("empty"); 3]);
        let bounds = frame.bounds(&device());
        assert_eq!(bounds.max.seconds, bounds.sum.seconds);
        let spent: Vec<_> = bounds.sum.largest();
        assert!(
            spent
                .iter()
                .all(|(t, s)| *s == 0.0 || matches!(t, Term::Host | Term::Ramp))
        );
        assert_eq!(of(vec![]).bounds(&device()).sum.seconds, 0.0);
    }

    #[test]
    fn an_infinite_device_takes_no_time() {
        let frame = of(vec![streaming(1e12, true); 5]);
        assert_eq!(frame.bounds(&Device::infinite()).sum.seconds, 0.0);
    }
}
