//! Scenes of fields and the configuration that renders them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use potamoi_formats::config::Config;
use potamoi_scene::Scene;

/// A built-in scene or a file among the fixtures, `side` pixels wide. Each is opened once and
/// shared by copies: building a model takes up to seconds.
pub(crate) fn scene(name: &str, side: u32) -> Scene {
    type Kept = BTreeMap<String, Arc<OnceLock<Scene>>>;
    static KEPT: Mutex<Kept> = Mutex::new(Kept::new());
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let own = Arc::clone(all.entry(name.to_owned()).or_default());
    drop(all);
    let open = || {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures");
        let file = file.join(name);
        let file = file.to_str().filter(|_| file.exists());
        Scene::open(file.unwrap_or(name)).unwrap()
    };
    let mut scene = own.get_or_init(open).clone();
    scene.set_size(Some(side), None).unwrap();
    scene
}

/// The preset `fields`, and what more is said.
pub(crate) fn config(more: &str) -> Config {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml");
    let text = std::fs::read_to_string(path).unwrap();
    Config::from_toml(&format!("{text}\n{more}"), "fields").unwrap()
}
