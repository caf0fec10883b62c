//! A scene whose path was rendered and counted, for studies that change the system around it.

use potamoi_system::system_model::work::PathWork;

use crate::Setup;

/// A scene with a counted path.
pub struct CountedScene {
    /// Name of the scene, as requested.
    pub name: String,
    /// Its setup.
    pub setup: Setup,
    /// Work of its path.
    pub path: PathWork,
}
