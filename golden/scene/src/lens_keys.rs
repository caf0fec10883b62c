//! Keys of any camera file that change what a camera sees. They are refused unless their value has
//! no effect.

use potamoi_base::file_keys::{Fate, Format, KeyError, told};
use potamoi_formats::document::Value;

pub(super) const PINHOLE: &str = "only pinholes are rendered: render with undistorted pictures' cameras \
                                  (ns-process-data, colmap image_undistorter); a value that changes \
                                  nothing is accepted, such as 0, false or PINHOLE";
pub(super) const CROPPED: &str = "pictures are rendered whole: give the size and principal point of the \
                                  cropped one; 0 is accepted";
pub(super) const OTHER_AXES: &str = "cameras stand in the axes of this kind of file: turn them, or leave \
                                     it out; the name of its own convention is accepted";
pub(super) const OTHER_NAMES: &str = "focal lengths and principal points are read by their own names: give \
                                      these, and leave it out";

/// Names of lenses that are pinholes if their distortion is 0.
pub(super) const PINHOLES: [&str; 7] = [
    "PINHOLE",
    "SIMPLE_PINHOLE",
    "PERSPECTIVE",
    "OPENCV",
    "FULL_OPENCV",
    "SIMPLE_RADIAL",
    "RADIAL",
];
/// Maximum depth of the search in a document.
const DEPTH: usize = 8;

/// Keys of a format, its own before these.
macro_rules! with_strange_lenses {
    ($($own:expr),* $(,)?) => {{
        use potamoi_base::file_keys::Fate::Refused;
        use $crate::lens_keys::{CROPPED, OTHER_AXES, OTHER_NAMES, PINHOLE};
        &[
            $($own,)*
            key("k1", Refused, PINHOLE),
            key("k2", Refused, PINHOLE),
            key("k3", Refused, PINHOLE),
            key("k4", Refused, PINHOLE),
            key("k5", Refused, PINHOLE),
            key("k6", Refused, PINHOLE),
            key("k7", Refused, PINHOLE),
            key("k8", Refused, PINHOLE),
            key("p1", Refused, PINHOLE),
            key("p2", Refused, PINHOLE),
            key("s1", Refused, PINHOLE),
            key("s2", Refused, PINHOLE),
            key("s3", Refused, PINHOLE),
            key("s4", Refused, PINHOLE),
            key("skew", Refused, PINHOLE),
            key("*distortion*", Refused, PINHOLE),
            key("*fisheye*", Refused, PINHOLE),
            key("ftheta_*", Refused, PINHOLE),
            key("*latlong*", Refused, PINHOLE),
            key("*equirect*", Refused, PINHOLE),
            key("*ortho*", Refused, PINHOLE),
            key("*panorama*", Refused, PINHOLE),
            key("*spherical*", Refused, PINHOLE),
            key("camera_type", Refused, PINHOLE),
            key("*projection*", Refused, PINHOLE),
            key("lens_type", Refused, PINHOLE),
            key("lens_model", Refused, PINHOLE),
            key("model", Refused, PINHOLE),
            key("shift_x", Refused, CROPPED),
            key("shift_y", Refused, CROPPED),
            key("crop*", Refused, CROPPED),
            key("pixel_aspect*", Refused, "give focal lengths along x and along y; 1 is accepted"),
            key("*convention*", Refused, OTHER_AXES),
            key("coordinate_*", Refused, OTHER_AXES),
            key("K", Refused, OTHER_NAMES),
            key("intrinsics", Refused, OTHER_NAMES),
            key("params", Refused, OTHER_NAMES),
        ]
    }};
}
pub(super) use with_strange_lenses;

/// Whether a key's value has no effect; `axes` are the names of the file's own convention.
pub(super) fn is_neutral(key: &str, value: &Value, axes: &[&str]) -> bool {
    let of_axes = key.contains("convention") || key.starts_with("coordinate_");
    let known: &[&str] = if of_axes { axes } else { &PINHOLES };
    match value {
        Value::Null | Value::Bool(false) => true,
        // A convention may be explained behind its name.
        Value::Text(text) => {
            let name = text
                .split(|c: char| !(c.is_alphanumeric() || c == '_'))
                .next();
            let name = if of_axes {
                name.unwrap_or_default()
            } else {
                text
            };
            known.iter().any(|own| own.eq_ignore_ascii_case(name))
        }
        Value::List(values) => values.iter().all(|value| is_neutral(key, value, axes)),
        other => {
            let number = other.number();
            number == Some(0.0) || (number == Some(1.0) && key.starts_with("pixel_aspect"))
        }
    }
}

/// The entries without refused keys whose value has no effect.
pub(super) fn telling<K: AsRef<str>>(
    format: &Format,
    entries: Vec<(K, Value)>,
    axes: &[&str],
) -> impl Iterator<Item = (K, Value)> {
    entries.into_iter().filter(|(key, value)| {
        let key = key.as_ref();
        let row = format.row(key);
        !(row.is_some_and(|row| row.fate == Fate::Refused) && is_neutral(key, value, axes))
    })
}

/// Searches for such keys within the values of others, which would be listed as wholes.
///
/// # Errors
/// The first key that is refused, with its path.
pub(super) fn within(
    format: &Format,
    path: &str,
    value: &Value,
    axes: &[&str],
) -> Result<(), KeyError> {
    if path.split('.').count() > DEPTH {
        return Ok(());
    }
    match value {
        Value::List(values) => values
            .iter()
            .try_for_each(|value| within(format, path, value, axes)),
        Value::Map(entries) => entries.iter().try_for_each(|(key, value)| {
            let own = format!("{path}.{key}");
            match format.row(key) {
                Some(row) if row.fate == Fate::Refused && !is_neutral(key, value, axes) => {
                    Err(KeyError::Refused {
                        key: told(&own),
                        value: Some(told(&value.shown())),
                        why: row.about,
                    })
                }
                // By this name it may be a lens of another kind.
                _ if key.eq_ignore_ascii_case("camera_model") && !is_neutral(key, value, axes) => {
                    Err(KeyError::Refused {
                        key: told(&own),
                        value: Some(told(&value.shown())),
                        why: PINHOLE,
                    })
                }
                _ => within(format, &own, value, axes),
            }
        }),
        _ => Ok(()),
    }
}
