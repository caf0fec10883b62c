//! Picture sizes, focal lengths and principal points, of all frames or of one.

use glam::{DAffine3, DVec2};
use potamoi_formats::document::Value;

use crate::lens_keys::PINHOLES;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::{FileKeys, Notes};

/// Default side: that of NeRF's synthetic scenes.
const SIDE: u32 = 800;
/// The longest side, in pixels.
const MAX_SIDE: u32 = 32768;
/// Maximum relative difference of two focal lengths of one axis.
const AGREEMENT: f64 = 0.01;

/// Width or height in pixels, and the lens along that axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Axis {
    side: Option<u32>,
    /// Field of view in degrees, focal length, field of view in radians: the first that is present
    /// counts.
    focal: [Option<f64>; 3],
    /// Whether a frame says `focal`, and not the document for all.
    of_frame: bool,
    centre: Option<f64>,
}

/// Names of an axis's values.
struct Names {
    side: &'static str,
    focal: [&'static str; 3],
    centre: &'static str,
}

const X: Names = Names {
    side: "w",
    focal: ["x_fov", "fl_x", "camera_angle_x"],
    centre: "cx",
};
const Y: Names = Names {
    side: "h",
    focal: ["y_fov", "fl_y", "camera_angle_y"],
    centre: "cy",
};

/// The values of the lens.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Lens {
    x: Axis,
    y: Axis,
}

fn number(
    record: &mut FileKeys<Value>,
    name: &str,
    low: f64,
    high: f64,
) -> Result<Option<f64>, String> {
    let Some(value) = record.take(name).filter(|value| *value != Value::Null) else {
        return Ok(None);
    };
    // Not a number is in no range.
    match value.number().filter(|v| (low..=high).contains(v)) {
        Some(number) => Ok(Some(number)),
        None => {
            let found = value.shown();
            Err(format!("`{name}` is {found}: expected {low} to {high}"))
        }
    }
}

impl Axis {
    fn take(record: &mut FileKeys<Value>, names: &Names) -> Result<Self, String> {
        let name = names.side;
        let side = match record.take(name).filter(|value| *value != Value::Null) {
            None => None,
            Some(value) => {
                let whole = value.whole().and_then(|whole| u32::try_from(whole).ok());
                let side = whole.filter(|side| (1..=MAX_SIDE).contains(side));
                let found = value.shown();
                let expected = format!("a whole number from 1 to {MAX_SIDE}");
                Some(side.ok_or_else(|| format!("`{name}` is {found}: expected {expected}"))?)
            }
        };
        let [fov, length, angle] = names.focal;
        let most = std::f64::consts::PI - 1e-3;
        Ok(Self {
            side,
            focal: [
                number(record, fov, 0.1, 179.9)?,
                number(record, length, 1e-3, 1e9)?,
                number(record, angle, 1e-3, most)?,
            ],
            of_frame: false,
            centre: number(record, names.centre, -1e6, 1e6)?,
        })
    }

    fn over(self, common: &Self) -> Self {
        let says = self.focal.iter().any(Option::is_some);
        Self {
            side: self.side.or(common.side),
            focal: if says { self.focal } else { common.focal },
            of_frame: says,
            centre: self.centre.or(common.centre),
        }
    }

    /// The side that follows from a principal point in the middle.
    fn twice(&self, names: &Names) -> Result<Option<u32>, String> {
        let Some(centre) = self.centre else {
            return Ok(None);
        };
        let side = 2.0 * centre;
        if side.fract() == 0.0 && (1.0..=f64::from(MAX_SIDE)).contains(&side) {
            return Ok(Some(side as u32));
        }
        let Names { side, centre, .. } = names;
        Err(format!(
            "`{side}` is missing, and twice `{centre}` is no side of a picture: give `{side}` as a \
             whole number from 1 to {MAX_SIDE}"
        ))
    }

    /// Focal length in pixels; the names of contradicting values are listed.
    fn length(&self, side: u32, names: &Names, notes: &mut Notes) -> Option<f64> {
        let half = f64::from(side) / 2.0;
        let [fov, length, angle] = self.focal;
        let of_angle = |angle: f64| half / (angle / 2.0).tan();
        let all = [
            fov.map(|degrees| of_angle(degrees.to_radians())),
            length,
            angle.map(of_angle),
        ];
        let chosen = all.iter().flatten().next().copied()?;
        for (name, other) in names.focal.iter().zip(all) {
            let off = other.map_or(0.0, |other| (other / chosen - 1.0).abs());
            if off > AGREEMENT {
                let within = if self.of_frame { "frames[]." } else { "" };
                notes.list(format!(
                    "{within}{name} (it contradicts the focal length that is used)"
                ));
            }
        }
        Some(chosen)
    }
}

impl Lens {
    /// Takes the values of a document or a frame.
    pub(super) fn take(record: &mut FileKeys<Value>) -> Result<Self, String> {
        if let Some(model) = record.take("camera_model").filter(|v| *v != Value::Null) {
            let known = |name: &str| PINHOLES.iter().any(|p| p.eq_ignore_ascii_case(name));
            if !model.text().is_some_and(known) {
                let found = model.shown();
                let all = PINHOLES.join(", ");
                return Err(format!(
                    "`camera_model` is {found}: only pinholes are rendered; expected one of \
                     {all}, without distortion (undistort the pictures and give their cameras)"
                ));
            }
        }
        Ok(Self {
            x: Axis::take(record, &X)?,
            y: Axis::take(record, &Y)?,
        })
    }

    /// These values, completed by those of `common`.
    pub(super) fn over(self, common: &Self) -> Self {
        Self {
            x: self.x.over(&common.x),
            y: self.y.over(&common.y),
        }
    }

    /// A camera with this lens and no pose; assumptions are added to `notes`.
    pub(super) fn camera(&self, notes: &mut Notes) -> Result<Camera, String> {
        let Self { x, y } = self;
        let twice = |axis: &Axis, names| match axis.side {
            None => axis.twice(names),
            side => Ok(side),
        };
        let (wide, high) = (twice(x, &X)?, twice(y, &Y)?);
        let width = wide.or(high).unwrap_or(SIDE);
        let height = high.unwrap_or(width);
        if x.side.is_none() || y.side.is_none() {
            let from = match (x.centre, y.centre) {
                (None, None) => "the file does not state it",
                _ => match (x.side, y.side) {
                    (None, None) => "from twice cx and cy, as the file has no w and h",
                    (None, _) => "from twice cx and cy, as the file has no w",
                    _ => "from twice cx and cy, as the file has no h",
                },
            };
            notes.assume(format!("size of pictures, {width} x {height}: {from}"));
        }
        let fx = x.length(width, &X, notes);
        let fy = y.length(height, &Y, notes);
        // Square pixels unless the file says otherwise.
        let focal = match (fx, fy) {
            (Some(fx), fy) => DVec2::new(fx, fy.unwrap_or(fx)),
            (None, Some(fy)) => DVec2::splat(fy),
            (None, None) => {
                return Err("neither `camera_angle_x` nor `fl_x` nor `x_fov` is given".to_owned());
            }
        };
        Ok(Camera {
            width,
            height,
            focal,
            centre: DVec2::new(
                x.centre.unwrap_or(f64::from(width) / 2.0),
                y.centre.unwrap_or(f64::from(height) / 2.0),
            ),
            world_to_camera: DAffine3::IDENTITY,
        })
    }
}
