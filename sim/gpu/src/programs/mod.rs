//! Programs as published: counts of a frame in, launched operations out.
//!
//! Each program is a structure of counts, and gives its operations on a device. What an operation
//! asks for follows from the program's own source, which its reason names: bytes of its tensors
//! and instructions of its inner loop. Nothing here is fitted to a frame rate.

mod direct_voxgo;
mod eager_hash;
mod hash_grid;
mod instant_ngp;
mod ngp_pl;
mod rounds;
mod splatting;
mod tensorf;
mod torch_ngp;

use std::collections::BTreeMap;

pub use direct_voxgo::DirectVoxGo;
pub use eager_hash::EagerHash;
pub use instant_ngp::InstantNgp;
pub use ngp_pl::NgpPl;
pub use rounds::march;
pub use splatting::{Host, Splatting};
pub use tensorf::TorchTensorf;
pub use torch_ngp::TorchNgp;

use crate::device::nearest;
use crate::{Device, Frame};

/// How a count changes where half or twice of it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Fixed by the picture, the program or the model, such as its width.
    Fixed,
    /// Depends on scene and view.
    Count,
    /// Depends on scene and view, and is a share: at most 1.
    Share,
}

/// A count that a program takes.
#[derive(Debug, Clone, Copy)]
pub struct Count<P> {
    /// Name in files of rows.
    pub name: &'static str,
    /// Description of the count, per frame.
    pub meaning: &'static str,
    /// How it changes.
    pub kind: Kind,
    /// Place of the value.
    pub place: fn(&mut P) -> &mut f64,
}

/// Describes counts: name, kind, meaning.
macro_rules! counts {
    ($($name:ident $kind:ident $meaning:literal),+ $(,)?) => {
        &[$($crate::programs::Count {
            name: stringify!($name),
            meaning: $meaning,
            kind: $crate::programs::Kind::$kind,
            place: |own| &mut own.$name,
        }),+]
    };
}
pub(crate) use counts;

/// A program that renders frames.
pub trait Program: Sized + 'static {
    /// Its counts, in the order of tables.
    const COUNTS: &'static [Count<Self>];

    /// The operations of a frame. Whether a tensor passes the memory depends on the device's L2.
    fn frame(&self, device: &Device) -> Frame;
}

/// A count of a registered program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named {
    /// Name in files of rows.
    pub name: &'static str,
    /// Description of the count, per frame.
    pub meaning: &'static str,
    /// How it changes.
    pub kind: Kind,
}

/// Counts of a frame by name.
pub type Counts = BTreeMap<String, f64>;

/// Why counts are refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CountError {
    /// No program has that name.
    #[error("no program is called `{0}`{1}; the programs are {2}")]
    Program(String, String, String),
    /// The program lacks a count.
    #[error("`{program}` lacks the count `{name}`: {meaning}; add it")]
    Missing {
        /// The program.
        program: &'static str,
        /// The count.
        name: &'static str,
        /// What it counts.
        meaning: &'static str,
    },
    /// The program has no such count.
    #[error("`{program}` has no count `{name}`; its counts are {known}")]
    Unknown {
        /// The program.
        program: &'static str,
        /// The count.
        name: String,
        /// The counts that it has.
        known: String,
    },
    /// The value is out of range.
    #[error("`{program}`: `{name}` is {value}, but has to be from 0 to {most}; correct it")]
    Range {
        /// The program.
        program: &'static str,
        /// The count.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The largest that makes sense.
        most: f64,
    },
}

/// A program that can be asked for by name.
#[derive(Debug, Clone, Copy)]
pub struct Registered {
    /// Name in files of rows.
    pub name: &'static str,
    /// Description in one line.
    pub title: &'static str,
    counts: fn() -> Vec<Named>,
    frame: fn(&Registered, &Counts, &Device) -> Result<Frame, CountError>,
}

macro_rules! registered {
    ($name:literal, $title:literal, $blank:expr) => {
        Registered {
            name: $name,
            title: $title,
            counts: || named(&$blank),
            frame: |own, counts, device| Ok(filled(own.name, $blank, counts)?.frame(device)),
        }
    };
}

/// All programs.
pub const PROGRAMS: [Registered; 9] = [
    registered!(
        "3dgs-viewer",
        "3D Gaussians, the paper's viewer: rasterizer from C++, parameters activated beforehand",
        Splatting::blank(Host::Viewer)
    ),
    registered!(
        "3dgs-rasterizer",
        "3D Gaussians, the rasterizer called from Python, parameters activated beforehand",
        Splatting::blank(Host::Rasterizer)
    ),
    registered!(
        "3dgs-render",
        "3D Gaussians, `render()` of the paper's repository: activates all parameters each frame",
        Splatting::blank(Host::Render)
    ),
    registered!("direct-voxgo", "DirectVoxGO, eager", DirectVoxGo::default()),
    registered!(
        "torch-ngp",
        "torch-ngp, hash grid, half precision",
        TorchNgp::default()
    ),
    registered!(
        "torch-tensorf",
        "torch-ngp, TensoRF",
        TorchTensorf::default()
    ),
    registered!(
        "ngp-pl",
        "ngp_pl, hash grid, fused layers",
        NgpPl::default()
    ),
    registered!(
        "instant-ngp",
        "instant-ngp, hash grid, fused, without a framework",
        InstantNgp::default()
    ),
    registered!(
        "eager-hash",
        "hash grid in element-wise tensors (HashNeRF-pytorch)",
        EagerHash::default()
    ),
];

/// The program of that name.
///
/// # Errors
///
/// [`CountError::Program`], with the nearest name where one is near.
pub fn program(name: &str) -> Result<&'static Registered, CountError> {
    let names = PROGRAMS.map(|p| p.name);
    PROGRAMS.iter().find(|p| p.name == name).ok_or_else(|| {
        let near = nearest(name, names);
        let near = near.map_or_else(String::new, |n| format!(": did you mean `{n}`?"));
        CountError::Program(name.to_owned(), near, names.join(", "))
    })
}

impl Registered {
    /// Its counts.
    #[must_use]
    pub fn counts(&self) -> Vec<Named> {
        (self.counts)()
    }

    /// The operations of a frame with these counts.
    ///
    /// # Errors
    ///
    /// [`CountError`], where a count is missing, unknown or out of range.
    pub fn frame(&self, counts: &Counts, device: &Device) -> Result<Frame, CountError> {
        (self.frame)(self, counts, device)
    }
}

fn named<P: Program>(_: &P) -> Vec<Named> {
    let one = |c: &Count<P>| Named {
        name: c.name,
        meaning: c.meaning,
        kind: c.kind,
    };
    P::COUNTS.iter().map(one).collect()
}

/// The program with all its counts set.
fn filled<P: Program>(program: &'static str, mut own: P, counts: &Counts) -> Result<P, CountError> {
    if let Some(name) = counts
        .keys()
        .find(|k| P::COUNTS.iter().all(|c| c.name != *k))
    {
        let known: Vec<_> = P::COUNTS.iter().map(|c| c.name).collect();
        return Err(CountError::Unknown {
            program,
            name: name.clone(),
            known: known.join(", "),
        });
    }
    for count in P::COUNTS {
        let value = *counts.get(count.name).ok_or(CountError::Missing {
            program,
            name: count.name,
            meaning: count.meaning,
        })?;
        let most = if count.kind == Kind::Share { 1.0 } else { 1e15 };
        if !(0.0..=most).contains(&value) {
            return Err(CountError::Range {
                program,
                name: count.name,
                value,
                most,
            });
        }
        *(count.place)(&mut own) = value;
    }
    Ok(own)
}

#[cfg(test)]
mod tests;
