//! Parallel work on many items.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::Progress;

/// Processes every item, `jobs` at once; after a failure no further ones begin. An item has a
/// number of steps, and calls its argument after each; steps that it skips count when it ends.
///
/// # Errors
/// The first failure in the items' order.
pub fn in_parallel<I: Sync, T: Send, E: Send>(
    items: &[I],
    jobs: usize,
    steps: u64,
    progress: &dyn Progress,
    make: impl Fn(&I, &dyn Fn()) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    progress.expect(items.len() as u64 * steps);
    let next = AtomicUsize::new(0);
    let done = Mutex::new((0..items.len()).map(|_| None).collect::<Vec<_>>());
    let work = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(at) else { return };
            let left = Cell::new(steps);
            let result = make(item, &|| {
                let one = left.get().min(1);
                left.set(left.get() - one);
                progress.advance(one);
            });
            if result.is_err() {
                next.store(items.len(), Ordering::Relaxed);
            }
            progress.advance(left.get());
            done.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(items.len()) {
            scope.spawn(work);
        }
    });
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counter of reported steps.
    #[derive(Default)]
    struct Steps(AtomicUsize);

    impl Progress for Steps {
        fn expect(&self, _: u64) {}

        fn advance(&self, steps: u64) {
            self.0.fetch_add(steps as usize, Ordering::Relaxed);
        }

        fn now(&self, _: &str) {}
    }

    /// Results are in the items' order for any number of jobs, and all steps are reported: skipped
    /// ones when an item ends, and never more than there are.
    #[test]
    fn items_stay_in_order_and_all_steps_are_told() {
        let items: Vec<usize> = (0..20).collect();
        for jobs in [1, 3, 64] {
            let steps = Steps::default();
            let made = in_parallel(&items, jobs, 4, &steps, |item, step| {
                (0..item % 7).for_each(|_| step());
                Ok::<_, ()>(item * item)
            });
            let squares: Vec<usize> = items.iter().map(|i| i * i).collect();
            assert_eq!(made, Ok(squares));
            assert_eq!(steps.0.into_inner(), 80);
        }
    }

    /// The first failure in the items' order is returned, and no item begins after it.
    #[test]
    fn a_failure_ends_the_work() {
        let items: Vec<usize> = (0..1000).collect();
        let begun = AtomicUsize::new(0);
        let made = in_parallel(&items, 2, 1, &(), |item, _| {
            begun.fetch_add(1, Ordering::Relaxed);
            if *item >= 10 { Err(*item) } else { Ok(()) }
        });
        assert_eq!(made, Err(10));
        assert!(begun.into_inner() < 20);
    }
}
