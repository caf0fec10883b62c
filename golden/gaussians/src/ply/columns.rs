//! Columns of a PLY vertex, by meaning.

use ply_rs_bw::ply::{ElementDef, Header as PlyHeader, PropertyType, ScalarType};

use super::PlyError;
use potamoi_base::file_keys::{FileKeys, KeyError};
use potamoi_base::sh;
use potamoi_containers::ply::header::type_name;

/// Properties of the sizes along the axes.
const SCALES: [&str; 3] = ["scale_0", "scale_1", "scale_2"];

/// Columns of a vertex's values.
pub(super) struct Columns {
    pub(super) degree: usize,
    pub(super) mean: [usize; 3],
    /// Whether centres are wider than 32-bit floats.
    pub(super) wide: bool,
    /// Sizes; discs lack the third.
    pub(super) scale: [Option<usize>; 3],
    pub(super) rotation: [usize; 4],
    pub(super) opacity: usize,
    pub(super) constant: [usize; 3],
    /// Coefficients above the constant, channel-major: all of red, then green, then blue.
    pub(super) rest: Vec<usize>,
    /// Width of the 3D filter of Mip-Splatting.
    pub(super) filter: Option<usize>,
}

/// Finds properties and removes them from the record.
struct Finder<'a> {
    vertex: &'a ElementDef,
    record: &'a mut FileKeys<String>,
    origin: &'a str,
}

impl Columns {
    /// Finds every property that a Gaussian needs or may have.
    pub(super) fn take(
        header: &PlyHeader,
        record: &mut FileKeys<String>,
        origin: &str,
    ) -> Result<Self, PlyError> {
        let empty = || PlyError::Empty {
            origin: origin.to_owned(),
        };
        let vertex = header.elements.get("vertex").ok_or_else(empty)?;
        if vertex.count == 0 {
            return Err(empty());
        }
        let numbered = |name: &&String| {
            let number = name.strip_prefix("f_rest_");
            number.is_some_and(|own| own.bytes().all(|c| c.is_ascii_digit()))
        };
        let found = vertex.properties.keys().filter(numbered).count();
        let degree = (0..=sh::MAX_DEGREE)
            .find(|d| 3 * (sh::coefficients(*d) - 1) == found)
            .ok_or_else(|| PlyError::Degree {
                origin: origin.to_owned(),
                found,
            })?;
        let mut finder = Finder {
            vertex,
            record,
            origin,
        };
        let mean = finder.all(["x", "y", "z"])?;
        let constant = finder.all(["f_dc_0", "f_dc_1", "f_dc_2"])?;
        let rest = (0..found)
            .map(|i| finder.need(&format!("f_rest_{i}")))
            .collect::<Result<_, _>>()?;
        let opacity = finder.need("opacity")?;
        let scale = finder.scales()?;
        let rotation = finder.all(["rot_0", "rot_1", "rot_2", "rot_3"])?;
        if scale[2].is_none() && vertex.properties.contains_key("filter_3D") {
            let why = "it widens discs into volumes: 2DGS has no such filter; leave it out";
            let (key, value) = ("filter_3D".to_owned(), None);
            return Err(PlyError::Key {
                origin: origin.to_owned(),
                source: Box::new(KeyError::Refused { key, value, why }),
            });
        }
        let filter = match vertex.properties.contains_key("filter_3D") {
            true => Some(finder.need("filter_3D")?),
            false => None,
        };
        let double = |column: usize| {
            let own = vertex.properties.get_index(column);
            own.is_some_and(|(_, p)| p.data_type == PropertyType::Scalar(ScalarType::Double))
        };
        Ok(Self {
            degree,
            mean,
            wide: mean.into_iter().any(double),
            scale,
            rotation,
            opacity,
            constant,
            rest,
            filter,
        })
    }
}

impl Finder<'_> {
    fn all<const N: usize>(&mut self, names: [&str; N]) -> Result<[usize; N], PlyError> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.need(name)?;
        }
        Ok(columns)
    }

    /// Three sizes, or two for a disc.
    fn scales(&mut self) -> Result<[Option<usize>; 3], PlyError> {
        let is_disc = !self.vertex.properties.contains_key(SCALES[2])
            && self.vertex.properties.contains_key(SCALES[1]);
        let mut columns = [None; 3];
        for (column, name) in columns
            .iter_mut()
            .zip(SCALES)
            .take(if is_disc { 2 } else { 3 })
        {
            *column = Some(self.need(name)?);
        }
        Ok(columns)
    }

    /// The column of a required property. Integer types are refused, since the scale of their
    /// codes is unknown.
    fn need(&mut self, name: &str) -> Result<usize, PlyError> {
        let origin = || self.origin.to_owned();
        let property = name.to_owned();
        let Some((column, _, definition)) = self.vertex.properties.get_full(name) else {
            return Err(PlyError::Missing {
                origin: origin(),
                property,
            });
        };
        let found = match &definition.data_type {
            PropertyType::Scalar(ScalarType::Float | ScalarType::Double) => {
                self.record.take(name);
                return Ok(column);
            }
            PropertyType::Scalar(other) => type_name(other),
            PropertyType::List(..) => "a list",
        };
        Err(PlyError::Type {
            origin: origin(),
            property,
            found,
        })
    }
}
