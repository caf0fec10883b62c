//! PLY files and checkpoints of PyTorch, as plain data.

pub mod ply;
pub mod torch;
