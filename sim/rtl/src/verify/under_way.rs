//! Runs that are under way while the renderer goes on.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use rayon::ThreadPool;

use super::{Conditions, Verifier};
use crate::RtlError;

/// Pieces of work that are under way at most. A constant, so that on any machine as many pieces have
/// been seen when the first difference is told.
const MOST: usize = 4;
/// Time between two looks at the progress.
const LOOK: Duration = Duration::from_millis(50);

/// A piece of work of a unit.
pub(super) trait Piece {
    /// Cycles compared so far.
    fn cycles(&self) -> u64;

    /// Waits for both runs, and compares them.
    fn compare(self: Box<Self>, verifier: &mut Verifier<'_>) -> Result<(), RtlError>;
}

/// Both runs of a piece of work: without stalls, and under random stalls.
pub(super) struct Runs<T> {
    conditions: [Conditions; 2],
    results: [Receiver<Result<T, RtlError>>; 2],
    cycles: Arc<AtomicU64>,
}

impl<T> Runs<T> {
    /// Cycles compared so far.
    pub(super) fn cycles(&self) -> u64 {
        self.cycles.load(Ordering::Relaxed)
    }

    /// Waits for both runs and calls `look` now and then.
    pub(super) fn wait(self, mut look: impl FnMut(u64)) -> [(Conditions, Result<T, RtlError>); 2] {
        let mut of = |which: usize| loop {
            match self.results[which].recv_timeout(LOOK) {
                Ok(result) => return (self.conditions[which], result),
                Err(RecvTimeoutError::Timeout) => look(self.cycles()),
                Err(RecvTimeoutError::Disconnected) => {
                    let text = "a run of a unit ended without a result: its thread panicked";
                    return (
                        self.conditions[which],
                        Err(RtlError::Usage(text.to_owned())),
                    );
                }
            }
        };
        [of(0), of(1)]
    }
}

/// The threads that run units, as many as the renderer has, and apart from its own: a renderer's
/// thread may wait for them. `None` where no thread can be started: runs are then made at once.
fn threads() -> Option<&'static ThreadPool> {
    static THREADS: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let build = || {
        let threads = rayon::ThreadPoolBuilder::new();
        let named = threads.thread_name(|number| format!("verify {number}"));
        let threads = named.num_threads(rayon::current_num_threads());
        // A panic is told by its run, which ends without a result.
        threads.panic_handler(|_| ()).build().ok()
    };
    THREADS.get_or_init(build).as_ref()
}

/// The pieces under way, the oldest first.
#[derive(Default)]
pub(super) struct UnderWay(VecDeque<Box<dyn Piece>>);

impl UnderWay {
    /// Begins both runs. Each has an instance of its unit of its own, so that no order is needed.
    pub(super) fn begin<T: Send + 'static>(
        conditions: [Conditions; 2],
        run: impl Fn(&Conditions, &mut dyn FnMut(u64)) -> Result<T, RtlError> + Send + Sync + 'static,
    ) -> Runs<T> {
        let (run, cycles) = (Arc::new(run), Arc::new(AtomicU64::new(0)));
        let results = conditions.map(|own| {
            let (send, receive) = channel();
            let (run, cycles) = (run.clone(), cycles.clone());
            let job = move || {
                let result = run(&own, &mut |more| {
                    cycles.fetch_add(more, Ordering::Relaxed);
                });
                // Nobody waits for it after a difference.
                let _ = send.send(result);
            };
            match threads() {
                Some(threads) => threads.spawn(job),
                None => job(),
            }
            receive
        });
        Runs {
            conditions,
            results,
            cycles,
        }
    }

    pub(super) fn push(&mut self, piece: Box<dyn Piece>) {
        self.0.push_back(piece);
    }

    /// The oldest piece, if more are under way than may be.
    pub(super) fn overdue(&mut self) -> Option<Box<dyn Piece>> {
        (self.0.len() > MOST).then(|| self.0.pop_front())?
    }

    /// The oldest piece.
    pub(super) fn oldest(&mut self) -> Option<Box<dyn Piece>> {
        self.0.pop_front()
    }

    /// Forgets all pieces.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Cycles compared so far in pieces under way.
    pub(super) fn cycles(&self) -> u64 {
        self.0.iter().map(|piece| piece.cycles()).sum()
    }
}
