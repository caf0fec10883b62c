//! The fields of `[camera] kind = "trajectory"`.

use std::path::PathBuf;

use serde::Deserialize;

/// A recorded motion and its place in the scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrajectoryDescription {
    /// The file, relative to the description's folder.
    pub(crate) path: PathBuf,
    /// Its dialect; by default it is recognised.
    pub(crate) format: Option<String>,
    /// Frames a second; by default those of the run.
    pub(crate) rate_hz: Option<f64>,
    /// Begin of the motion in seconds after the first pose; by default 0.
    pub(crate) start_s: Option<f64>,
    /// Length of the motion in seconds; by default up to the last pose.
    pub(crate) duration_s: Option<f64>,
    /// Scene units a unit of the file; by default from the scene's size.
    pub(crate) scale: Option<f64>,
    /// Where it begins: first-view, or a camera file; by default the first view.
    pub(crate) at: Option<PathBuf>,
    /// Index of the camera in that file, from 0.
    pub(crate) index: Option<usize>,
    /// Times of a KITTI trajectory, relative to the description's folder.
    pub(crate) times: Option<PathBuf>,
    /// Poses a second of a file without times.
    pub(crate) file_hz: Option<f64>,
    /// Pose of the camera in the body, 16 numbers by rows.
    pub(crate) t_bs: Option<[f64; 16]>,
    /// Width in pixels; by default that of the view at which it begins.
    pub(crate) width: Option<u32>,
    /// Height in pixels; by default that of the view at which it begins.
    pub(crate) height: Option<u32>,
}
