//! Cameras, pictures, masks and files: the base of every renderer.
//!
//! ```
//! use glam::DVec3;
//! use potamoi_base::camera::Camera;
//! use potamoi_base::picture::Picture;
//!
//! // A camera of 64 x 48 pixels at (0, 0, -2) that looks at the origin.
//! let eye = DVec3::new(0.0, 0.0, -2.0);
//! let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.7, 64, 48);
//! assert!((camera.position() - eye).length() < 1e-12);
//!
//! let black = Picture::filled(camera.width, camera.height, [0.0; 3]);
//! let grey = Picture::filled(camera.width, camera.height, [0.1; 3]);
//! // A difference of 0.1 everywhere is 20 dB.
//! assert!((grey.psnr(&black, |_| true).unwrap() - 20.0).abs() < 1e-4);
//! ```

#[cfg(not(target_os = "linux"))]
compile_error!(
    "Potamoi runs on Linux: on another system use the container of docs/how-to/install.md"
);

pub mod camera;
pub mod content_hash;
pub mod effects;
pub mod file_keys;
pub mod file_set;
pub mod files;
pub mod mask;
pub mod memory;
pub mod memory_limit;
pub mod outputs;
pub mod picture;
pub mod precision;
pub mod sh;
pub mod sh_degrees;
pub mod ssim;
pub mod vectors;
