//! What a page is to be about.

use potamoi_machines::Machine;
use potamoi_scene::Scene;

/// What is asked for.
pub(super) struct Asked<'a> {
    pub(super) machines: &'a [Machine],
    pub(super) scenes: &'a [Scene],
    pub(super) frames: u32,
    pub(super) knobs: &'a [String],
}
