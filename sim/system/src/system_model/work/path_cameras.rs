//! The cameras of a path and of its references.

use potamoi_base::camera::Camera;
use potamoi_scene::Scene;
use potamoi_warp::{Plan, PlanOptions, ReferenceFrom, WarpError};

use super::path::{PathOptions, PathParts};

/// The scene as a camera sees it.
pub(super) fn seen_by(scene: &Scene, camera: &Camera) -> Scene {
    let mut scene = scene.clone();
    scene.set_camera(*camera);
    scene
}

/// The references of a path.
pub(super) fn plan(path: &[Camera], options: &PathOptions) -> Result<Plan, WarpError> {
    let plan = PlanOptions {
        window: options.window,
        reference: ReferenceFrom::Predicted,
        lead: None,
    };
    Plan::new(path, &plan)
}

/// Cameras of the references, in full and then, where they are counted, at half the resolution.
pub(super) fn whole_and_half(plan: &Plan, parts: PathParts) -> Vec<Camera> {
    let whole = plan.references.iter().map(|task| task.camera);
    let small = |of: Camera| of.resized(of.width.div_ceil(2), of.height.div_ceil(2));
    match parts {
        PathParts::All => whole.clone().chain(whole.map(small)).collect(),
        PathParts::FullFrames => whole.collect(),
    }
}
