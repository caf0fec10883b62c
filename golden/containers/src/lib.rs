//! PLY files, ZIP archives and PyTorch checkpoints as plain data.
//!
//! The crate does not interpret the numbers. A damaged or hostile file yields an error that names
//! it; no code of a pickle is run.
//!
//! ```
//! use potamoi_containers::ply::header;
//!
//! let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n";
//! let header = header::read(&mut text.as_bytes(), "example.ply").unwrap();
//! assert_eq!(header.ply.elements["vertex"].count, 2);
//! assert!(header::read(&mut "no ply".as_bytes(), "example.ply").is_err());
//! ```

pub mod archive;
pub mod ply;
pub mod torch;
