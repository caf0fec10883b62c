//! Clouds of 3D Gaussians, and the files that hold them.
//!
//! A [`Cloud`] has the values of all Gaussians as files store them: logarithms of sizes, quaternions of
//! any length, opacities before the sigmoid. Readers of all formats are in [`files`], and
//! [`differences`] tells how far two clouds are apart.
//!
//! ```
//! use potamoi_gaussians::{Cloud, rotation, sigmoid};
//!
//! // One Gaussian of half a unit at the origin.
//! let cloud = Cloud::new(
//!     0,
//!     vec![[0.0; 3]],
//!     vec![[0.5f32.ln(); 3]],
//!     vec![[2.0, 0.0, 0.0, 0.0]],
//!     vec![0.0],
//!     vec![[1.0; 3]],
//! )?;
//! assert_eq!(sigmoid(f64::from(cloud.opacity_logits()[0])), 0.5);
//! assert_eq!(rotation(cloud.rotations()[0]), glam::DMat3::IDENTITY);
//! # Ok::<(), potamoi_gaussians::CloudError>(())
//! ```

mod axes;
mod cloud;
mod difference;
mod file_content;
pub mod files;
mod nearest;
pub mod ply;
mod stored_values;

pub use axes::{Axes, UnknownAxes};
pub use cloud::{Cloud, CloudError, Field};
pub use difference::{Difference, Differences, Pairing, differences};
pub use file_content::{AxesFrom, Facts, Loaded, Raw};
pub use stored_values::{rotation, sigmoid};
