//! Cameras, pictures, masks and files: what every renderer needs.

pub mod bands;
pub mod camera;
pub mod content;
pub mod effects;
pub mod files;
pub mod mask;
pub mod memory;
pub mod picture;
pub mod precision;
pub mod record;
pub mod sh;
pub mod ssim;
