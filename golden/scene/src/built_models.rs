//! Models of built-in scenes that this process has built: sampling one takes a second or two.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{Model, SceneError};

/// Most models that are kept; the one that was asked for longest ago goes first.
const KEPT: usize = 4;

/// Models with their names, from the one that was asked for longest ago to the last.
pub(super) struct Built(Mutex<Vec<(String, Arc<Model>)>>);

/// The models of this process.
pub(super) static BUILT: Built = Built::new();

impl Built {
    const fn new() -> Self {
        Self(Mutex::new(vec![]))
    }

    /// The model of a name, which stands for one model: as it was built before, or by `build`. Two
    /// threads that ask at once may both build it.
    pub(super) fn get(
        &self,
        name: &str,
        build: impl FnOnce() -> Result<Model, SceneError>,
    ) -> Result<Arc<Model>, SceneError> {
        if let Some(model) = self.find(name) {
            return Ok(model);
        }
        let model = Arc::new(build()?);
        let mut all = self.all();
        all.retain(|(own, _)| own != name);
        if all.len() == KEPT {
            all.remove(0);
        }
        all.push((name.to_owned(), Arc::clone(&model)));
        Ok(model)
    }

    fn all(&self) -> MutexGuard<'_, Vec<(String, Arc<Model>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn find(&self, name: &str) -> Option<Arc<Model>> {
        let mut all = self.all();
        let at = all.iter().position(|(own, _)| own == name)?;
        let own = all.remove(at);
        let model = Arc::clone(&own.1);
        all.push(own);
        Some(model)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::Scene;

    /// What one scene changes in its model, another does not see.
    #[test]
    fn a_scene_s_change_is_its_own() {
        let mut changed = Scene::open("garden").unwrap();
        let was = changed.is_antialiased();
        changed.set_antialiased(!was);
        assert_eq!(Scene::open("garden").unwrap().is_antialiased(), was);
        assert_eq!(changed.is_antialiased(), !was);
    }

    /// A model is built again once others have taken its place, and not before; an error is not
    /// kept.
    #[test]
    fn few_models_are_kept() {
        let models = Built::new();
        let mut built = 0;
        let mut ask = |name: &str| {
            let own = models.get(name, || {
                built += 1;
                Ok(Model::Splats(crate::garden::cloud()))
            });
            (own.unwrap(), built)
        };
        let (first, _) = ask("0");
        let (again, count) = ask("0");
        assert!(Arc::ptr_eq(&first, &again) && count == 1);
        for other in 1..=KEPT {
            ask(&other.to_string());
        }
        let (anew, count) = ask("0");
        assert!(!Arc::ptr_eq(&first, &anew));
        assert_eq!(count, 2 + KEPT);

        let failed = models.get("none", || Err(Scene::unknown("none")));
        assert!(failed.is_err());
        let (_, count) = ask("none");
        assert_eq!(count, 3 + KEPT);
    }
}
