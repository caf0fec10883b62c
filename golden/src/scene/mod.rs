//! Scenes: built-in ones, model files and scene descriptions.

pub mod camera_file;
pub mod garden;
pub mod lantern;
