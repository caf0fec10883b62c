//! Results of a cache that stay in memory.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use potamoi_result_cache::Key;

/// A result of any kind; none while it was not found.
type Slot = Arc<Mutex<Option<Arc<dyn Any + Send + Sync>>>>;

/// Results by key. A slot is locked while its result is counted, so that no other thread counts it.
#[derive(Debug, Clone, Default)]
pub(super) struct Held(Arc<Mutex<HashMap<String, Slot>>>);

impl Held {
    /// The result of a key, and whether it was there before.
    ///
    /// # Errors
    /// Those of `find`, which is called where the result is not held.
    pub(super) fn get<T: Send + Sync + 'static, E>(
        &self,
        key: &Key,
        find: impl FnOnce() -> Result<(T, bool), E>,
    ) -> Result<(Arc<T>, bool), E> {
        let slot = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(all.entry(key.hex()).or_default())
        };
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        // The key has the kind of result: another type is not found under it.
        if let Some(Ok(found)) = slot.as_ref().map(|own| Arc::clone(own).downcast::<T>()) {
            return Ok((found, true));
        }
        let (found, was_there) = find()?;
        let found = Arc::new(found);
        *slot = Some(Arc::clone(&found) as Arc<dyn Any + Send + Sync>);
        Ok((found, was_there))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    /// Eight threads ask at the same time; one of them counts.
    #[test]
    fn threads_count_a_result_once() {
        let (held, counted) = (Held::default(), AtomicU32::new(0));
        std::thread::scope(|threads| {
            for _ in 0..8 {
                threads.spawn(|| {
                    let found = held.get(&Key::new("number", "1"), || {
                        Ok::<_, ()>((counted.fetch_add(1, Ordering::SeqCst) + 41, false))
                    });
                    assert_eq!(*found.unwrap().0, 41);
                });
            }
        });
        assert_eq!(counted.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn a_failure_is_not_held() {
        let held = Held::default();
        let key = Key::new("number", "1");
        assert_eq!(held.get::<u32, _>(&key, || Err(3)).unwrap_err(), 3);
        let (found, was_there) = held.get::<u32, ()>(&key, || Ok((7, true))).unwrap();
        assert_eq!((*found, was_there), (7, true));
    }
}
