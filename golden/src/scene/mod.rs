//! Scenes: built-in ones, model files and scene descriptions.
