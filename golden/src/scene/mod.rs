//! Scenes: built-in ones, model files and scene descriptions.

pub mod camera_file;
