//! Axis conventions of splat files.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;
use thiserror::Error;

use potamoi_base::sh;

/// Names of the first, second and third axis of a [`Cloud`](super::Cloud), and of their opposites.
const WORDS: [[&str; 2]; 3] = [["right", "left"], ["down", "up"], ["front", "back"]];

/// The direction of one file axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, schemars::JsonSchema)]
struct AxisDirection {
    /// Right, down or front: 0, 1 or 2.
    along: u8,
    /// Whether it is left, up or back instead.
    against: bool,
}

/// The directions of a file's x, y and z axes. Those of a cloud point right, down and front, as in
/// 3D Gaussian splatting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, schemars::JsonSchema)]
pub struct Axes([AxisDirection; 3]);

/// A text that does not name [`Axes`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "axes `{0}`: expected where x, y and z point, such as right-down-front or right-up-back: one of \
     right and left, one of up and down, one of front and back, in any order"
)]
pub struct UnknownAxes(String);

impl Axes {
    /// The convention of 3D Gaussian splatting.
    pub const RIGHT_DOWN_FRONT: Self = Self::new([(0, false), (1, false), (2, false)]);
    /// The default convention of SPZ.
    pub const RIGHT_UP_BACK: Self = Self::new([(0, false), (1, true), (2, true)]);
    /// The convention of glTF.
    pub const LEFT_UP_FRONT: Self = Self::new([(0, true), (1, true), (2, false)]);

    const fn new(ways: [(u8, bool); 3]) -> Self {
        let [x, y, z] = ways;
        const fn way((along, against): (u8, bool)) -> AxisDirection {
            AxisDirection { along, against }
        }
        Self([way(x), way(y), way(z)])
    }

    /// All 48 conventions.
    pub fn all() -> impl Iterator<Item = Self> {
        const ORDERS: [[u8; 3]; 6] = [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [2, 1, 0],
            [1, 0, 2],
        ];
        ORDERS.into_iter().flat_map(|[x, y, z]| {
            (0..8u8).map(move |signs| {
                Self::new([
                    (x, signs & 1 != 0),
                    (y, signs & 2 != 0),
                    (z, signs & 4 != 0),
                ])
            })
        })
    }

    /// The convention with this code in SPZ files, 1 to 8: left or right, down or up, back or
    /// front.
    pub(super) fn of_spz(code: u32) -> Option<Self> {
        let bits = code.checked_sub(1).filter(|bits| *bits < 8)?;
        Some(Self::new([
            (0, bits & 1 == 0),
            (1, bits & 2 != 0),
            (2, bits & 4 == 0),
        ]))
    }

    /// Converts a point or vector from file axes to cloud axes.
    pub(super) fn point<T: Copy + Default + std::ops::Neg<Output = T>>(
        self,
        file: [T; 3],
    ) -> [T; 3] {
        let mut own = [T::default(); 3];
        for (value, way) in file.into_iter().zip(self.0) {
            own[usize::from(way.along)] = if way.against { -value } else { value };
        }
        own
    }

    /// Converts lengths from the order of the file axes to that of the cloud axes.
    pub(super) fn lengths(self, file: [f32; 3]) -> [f32; 3] {
        let mut own = file;
        for (value, way) in file.into_iter().zip(self.0) {
            own[usize::from(way.along)] = value;
        }
        own
    }

    /// Converts a quaternion `w, x, y, z` from file axes to cloud axes. Together with
    /// [`Axes::lengths`] the ellipsoid is unchanged: `P R P^T` and `P S P^T` with the axes' matrix
    /// `P`, a reflection or not.
    pub(super) fn quaternion(self, [w, x, y, z]: [f32; 4]) -> [f32; 4] {
        let [x, y, z] = self.point([x, y, z]);
        if self.is_mirrored() {
            return [w, -x, -y, -z];
        }
        [w, x, y, z]
    }

    /// Whether the axes are left-handed.
    fn is_mirrored(self) -> bool {
        let [x, y, z] = self.0;
        let is_odd = (y.along + 3 - x.along) % 3 == 2;
        is_odd != (x.against != (y.against != z.against))
    }

    /// The matrix that converts spherical-harmonics coefficients from file axes to cloud axes, one
    /// row a coefficient, up to degree 3; bands do not mix.
    pub(super) fn harmonics(self) -> [[f64; 16]; 16] {
        harmonics(|own| self.of_file(own))
    }

    /// Converts a centre from cloud axes to file axes.
    pub fn point_of_file(self, own: [f32; 3]) -> [f32; 3] {
        self.0.map(|way| {
            let value = own[usize::from(way.along)];
            if way.against { -value } else { value }
        })
    }

    /// Converts a vector from cloud axes to file axes.
    pub fn of_file(self, own: DVec3) -> DVec3 {
        DVec3::from(self.0.map(|way| {
            let value = own[usize::from(way.along)];
            if way.against { -value } else { value }
        }))
    }
}

/// The matrix that converts spherical-harmonics coefficients where directions are turned, one row a
/// coefficient, up to degree 3; bands do not mix. `before` is what a direction was before.
///
/// Its elements are integrals over the sphere of products of two basis functions, of degree 6
/// at most, by 4 Gauss-Legendre nodes times 8 azimuths, which are exact to degree 7.
pub(super) fn harmonics(before: impl Fn(DVec3) -> DVec3) -> [[f64; 16]; 16] {
    const NODES: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let mut mixed = [[0.0; 16]; 16];
    for (z, weight) in NODES {
        let across = (1.0 - z * z).sqrt();
        for step in 0..8 {
            let azimuth = (f64::from(step) + 0.5) * std::f64::consts::FRAC_PI_4;
            let own = DVec3::new(across * azimuth.cos(), across * azimuth.sin(), z);
            let to = sh::basis(own);
            let from = sh::basis(before(own));
            for (row, to) in mixed.iter_mut().zip(to) {
                for (factor, from) in row.iter_mut().zip(from) {
                    *factor += weight * std::f64::consts::FRAC_PI_4 * to * from;
                }
            }
        }
    }
    // Rounding aside they are 0 and 1 where axes only change their sign.
    for factor in mixed.as_flattened_mut() {
        if (*factor - factor.round()).abs() < 1e-12 {
            *factor = factor.round();
        }
    }
    mixed
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = self
            .0
            .map(|w| WORDS[usize::from(w.along)][usize::from(w.against)]);
        f.write_str(&words.join("-"))
    }
}

/// Parses three words, or their initials as other programs write them (`RUB`).
impl FromStr for Axes {
    type Err = UnknownAxes;

    fn from_str(text: &str) -> Result<Self, UnknownAxes> {
        let unknown = || UnknownAxes(text.chars().take(60).collect());
        let lower = text.to_lowercase();
        let mut words: Vec<&str> = (lower.split(|c: char| !c.is_alphanumeric()))
            .filter(|word| !word.is_empty())
            .collect();
        if let [letters] = words[..] {
            words = letters
                .split("")
                .filter(|letter| !letter.is_empty())
                .collect();
        }
        let way = |word: &str| {
            WORDS.iter().zip(0u8..).find_map(|(pair, along)| {
                let named = |own: &str| own == word || own.get(..1) == Some(word);
                let against = pair.iter().position(|own| named(own))?;
                Some((along, against == 1))
            })
        };
        let ways: Option<Vec<(u8, bool)>> = words.iter().map(|word| way(word)).collect();
        let ways: [(u8, bool); 3] = ways
            .and_then(|ways| ways.try_into().ok())
            .ok_or_else(unknown)?;
        let mut seen = ways.map(|way| way.0);
        seen.sort_unstable();
        if seen != [0, 1, 2] {
            return Err(unknown());
        }
        Ok(Self::new(ways))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_read_back_and_letters_stand_for_words() {
        let mut seen = std::collections::HashSet::new();
        for axes in Axes::all() {
            assert_eq!(axes.to_string().parse(), Ok(axes));
            assert!(seen.insert(axes));
        }
        assert_eq!(seen.len(), 48);
        assert_eq!("RUB".parse(), Ok(Axes::RIGHT_UP_BACK));
        assert_eq!("right, Down, front".parse(), Ok(Axes::RIGHT_DOWN_FRONT));
        for wrong in [
            "",
            "RU",
            "RUBB",
            "right-left-up",
            "x-y-z",
            "right-up",
            "ärz",
        ] {
            assert!(wrong.parse::<Axes>().is_err(), "{wrong}");
        }
    }

    /// The order of codes in nianticlabs/spz: LDB, RDB, LUB, RUB, LDF, RDF, LUF, RUF.
    #[test]
    fn codes_of_spz() {
        let names = ["LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF"];
        for (code, name) in (1..).zip(names) {
            assert_eq!(Axes::of_spz(code), name.parse().ok(), "{name}");
        }
        assert_eq!([0, 9, u32::MAX].map(Axes::of_spz), [None; 3]);
    }

    /// Pure sign changes are exact, so that files in such axes keep their bits.
    #[test]
    fn harmonics_of_sign_changes_are_ones() {
        let signs = [1, -1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1];
        let mixed = Axes::RIGHT_UP_BACK.harmonics();
        for (k, row) in mixed.iter().enumerate() {
            for (j, factor) in row.iter().enumerate() {
                let expected = if j == k { f64::from(signs[k]) } else { 0.0 };
                assert_eq!(*factor, expected, "{k} {j}");
            }
        }
    }

    /// The expansion of converted coefficients in a converted direction equals the original
    /// expansion in the original direction, for all axes and bands; unconverted coefficients do
    /// not.
    #[test]
    fn harmonics_turn_with_the_axes() {
        let direction = DVec3::new(0.36, 0.48, -0.8);
        for axes in Axes::all() {
            let own = DVec3::from(axes.point(direction.to_array()));
            let [before, after] = [direction, own].map(sh::basis);
            let mixed = axes.harmonics();
            let mut off = 0f64;
            for k in 0..16 {
                let turned: f64 = (0..16).map(|j| mixed[j][k] * after[j]).sum();
                assert!((turned - before[k]).abs() < 1e-12, "{axes} {k}");
                off = off.max((after[k] - before[k]).abs());
            }
            assert!(
                axes == Axes::RIGHT_DOWN_FRONT || off > 0.05,
                "{axes}: {off}"
            );
        }
    }
}
