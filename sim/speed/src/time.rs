//! Processor time of all threads of this process.

use std::time::{Duration, Instant};

/// What all threads have taken so far.
#[derive(Debug, Clone, Copy)]
struct Taken {
    /// Time on a processor.
    processor: Duration,
    /// Time in which a thread that could run had none.
    waited: Duration,
}

/// The system brings the account of a thread up to date where it leaves its processor, and else at each
/// tick of some milliseconds. Within such a sleep all threads without work leave it.
const SETTLE: Duration = Duration::from_micros(200);

impl Taken {
    /// As the system reports it; `None` where it does not.
    fn now() -> Option<Self> {
        std::thread::sleep(SETTLE);
        let (mut processor, mut waited) = (0, 0);
        for thread in std::fs::read_dir("/proc/self/task").ok()? {
            // A thread may end meanwhile.
            let path = thread.ok()?.path().join("schedstat");
            let Ok(stat) = std::fs::read_to_string(path) else {
                continue;
            };
            let mut words = stat.split_whitespace();
            let mut next = || words.next()?.parse::<u64>().ok();
            processor += next()?;
            waited += next()?;
        }
        // A system that keeps no account reports 0.
        (processor > 0).then(|| Self {
            processor: Duration::from_nanos(processor),
            waited: Duration::from_nanos(waited),
        })
    }
}

/// Times work, and keeps account of how busy the machine was meanwhile.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    processor: Duration,
    waited: Duration,
    /// Whether some work was timed by elapsed time, since the system did not report the other.
    is_elapsed: bool,
}

impl Meter {
    /// Processor time of `work`, and its result. `threads` is the number of threads that it keeps busy:
    /// where the system does not report processor time, it is elapsed time times threads.
    pub(crate) fn time<T>(&mut self, threads: usize, work: impl FnOnce() -> T) -> (Duration, T) {
        let before = Taken::now();
        let start = Instant::now();
        let done = work();
        let elapsed = start.elapsed();
        let spent = before.zip(Taken::now()).and_then(|(before, after)| {
            let processor = after.processor.checked_sub(before.processor)?;
            Some((processor, after.waited.saturating_sub(before.waited)))
        });
        let processor = match spent {
            Some((processor, waited)) => {
                self.waited += waited;
                processor
            }
            None => {
                self.is_elapsed = true;
                elapsed * u32::try_from(threads).unwrap_or(u32::MAX)
            }
        };
        self.processor += processor;
        (processor, done)
    }

    /// The fastest of so many runs, at least one, in milliseconds, and the result of the last.
    ///
    /// # Errors
    /// The first error of the work.
    pub(crate) fn fastest<T, E>(
        &mut self,
        runs: u32,
        threads: usize,
        mut work: impl FnMut() -> Result<T, E>,
    ) -> Result<(f64, T), E> {
        let (mut best, result) = self.time(threads, &mut work);
        let mut last = result?;
        for _ in 1..runs {
            let (spent, result) = self.time(threads, &mut work);
            last = result?;
            best = best.min(spent);
        }
        Ok((1e3 * best.as_secs_f64(), last))
    }

    /// Whether any time was elapsed time times threads.
    pub(crate) const fn is_elapsed(&self) -> bool {
        self.is_elapsed
    }

    /// Share of the time of all threads in which they could run and had no processor; `None` where the
    /// system does not report it.
    pub(crate) fn waiting(&self) -> Option<f64> {
        let whole = (self.processor + self.waited).as_secs_f64();
        (!self.is_elapsed && whole > 0.0).then(|| self.waited.as_secs_f64() / whole)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::hint::black_box;

    use super::*;

    fn work() -> Result<u64, ()> {
        Ok((0..200_000).fold(0, |sum, own| black_box(sum + own)))
    }

    #[test]
    fn work_takes_time_and_gives_its_result() {
        let mut meter = Meter::default();
        let (ms, sum) = meter.fastest(3, 1, work).unwrap();
        assert_eq!(sum, 199_999 * 100_000);
        assert!(ms > 0.0);
        let share = meter.waiting();
        assert!(share.is_none_or(|share| (0.0..=1.0).contains(&share)));
        assert_eq!(share.is_none(), meter.is_elapsed());
    }

    #[test]
    fn work_runs_so_many_times_and_its_error_ends_it() {
        let mut count = 0;
        let mut meter = Meter::default();
        let mut run = |runs, fails_at: u32| {
            count = 0;
            let done = meter.fastest(runs, 1, || {
                count += 1;
                if count == fails_at { Err(()) } else { Ok(()) }
            });
            (count, done.is_ok())
        };
        assert_eq!(run(4, 9), (4, true));
        assert_eq!(run(0, 9), (1, true));
        assert_eq!(run(4, 2), (2, false));
    }

    #[test]
    fn nothing_timed_says_nothing_of_the_machine() {
        assert_eq!(Meter::default().waiting(), None);
    }
}
