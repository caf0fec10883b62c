//! The Gaussians of a primitive.

use super::super::bytes::{f32, u16};
use super::super::error::{FileError, Origin};
use super::super::values;
use super::buffers::{Buffers, Elements};
use super::document::{Document, Primitive, SPLATTING};
use crate::Cloud;
use potamoi_base::sh;

/// Types of components.
const BYTE: usize = 5120;
const UNSIGNED_BYTE: usize = 5121;
const SHORT: usize = 5122;
const UNSIGNED_SHORT: usize = 5123;
const FLOAT: usize = 5126;

/// What an attribute may hold.
struct Wanted {
    components: usize,
    kind: &'static str,
    /// Types of components, and whether they are normalised; `None` for either.
    types: &'static [(usize, Option<bool>)],
    expected: &'static str,
}

const POSITION: Wanted = Wanted {
    components: 3,
    kind: "VEC3",
    types: &[
        (FLOAT, Some(false)),
        (BYTE, None),
        (UNSIGNED_BYTE, None),
        (SHORT, None),
        (UNSIGNED_SHORT, None),
    ],
    expected: "VEC3 of floats, bytes or shorts",
};
const ROTATION: Wanted = Wanted {
    components: 4,
    kind: "VEC4",
    types: &[
        (FLOAT, Some(false)),
        (BYTE, Some(true)),
        (SHORT, Some(true)),
    ],
    expected: "VEC4 of floats, or of normalised signed bytes or shorts",
};
const SCALE: Wanted = Wanted {
    components: 3,
    kind: "VEC3",
    types: &[
        (FLOAT, Some(false)),
        (UNSIGNED_BYTE, None),
        (UNSIGNED_SHORT, None),
    ],
    expected: "VEC3 of floats, or of unsigned bytes or shorts (signed ones are of a draft, whose sizes are \
               logarithms: write the file again)",
};
const OPACITY: Wanted = Wanted {
    components: 1,
    kind: "SCALAR",
    types: &[
        (FLOAT, Some(false)),
        (UNSIGNED_BYTE, Some(true)),
        (UNSIGNED_SHORT, Some(true)),
    ],
    expected: "SCALAR of floats, or of normalised unsigned bytes or shorts",
};
const COEFFICIENT: Wanted = Wanted {
    components: 3,
    kind: "VEC3",
    types: &[(FLOAT, Some(false))],
    expected: "VEC3 of floats",
};

/// Values of an attribute.
struct Attribute {
    elements: Elements,
    component: usize,
    is_normalised: bool,
    count: usize,
}

/// The Gaussians of a primitive, and how many of their values were held at a limit.
pub(super) struct Read {
    pub(super) cloud: Cloud,
    /// Sizes of 0, which became the smallest normal float.
    pub(super) raised: u64,
    /// Attributes that were not used.
    pub(super) rest: Vec<String>,
}

/// Reads the Gaussians of a primitive from its attributes.
pub(super) fn of_attributes(
    document: &Document,
    buffers: &mut Buffers<'_>,
    primitive: &Primitive,
    name: Origin<'_>,
) -> Result<Read, FileError> {
    let mut left = primitive.attributes.clone();
    let mut take = |semantic: &str, wanted: &Wanted| {
        let at = left.iter().position(|(key, _)| key == semantic);
        let field = format!("{}.{semantic}", primitive.place);
        match at.map(|at| left.swap_remove(at).1) {
            Some(index) => attribute(document, buffers, wanted, index, &field, name).map(Some),
            None => Ok(None),
        }
    };
    let own = |name: &str| format!("{SPLATTING}:{name}");
    let missing = |semantic: &str| {
        let field = format!("{}.{semantic}", primitive.place);
        name.field(field, "missing", "an accessor")
    };
    let mut needed =
        |semantic: &str, wanted: &Wanted| take(semantic, wanted)?.ok_or_else(|| missing(semantic));
    let position = needed("POSITION", &POSITION)?;
    let rotation = needed(&own("ROTATION"), &ROTATION)?;
    let scale = needed(&own("SCALE"), &SCALE)?;
    let opacity = needed(&own("OPACITY"), &OPACITY)?;
    let mut coefficients = vec![needed(&own("SH_DEGREE_0_COEF_0"), &COEFFICIENT)?];
    let mut degree = 0;
    'degrees: for band in 1..=sh::MAX_DEGREE {
        for order in 0..2 * band + 1 {
            match take(
                &own(&format!("SH_DEGREE_{band}_COEF_{order}")),
                &COEFFICIENT,
            )? {
                Some(found) => coefficients.push(found),
                None if order == 0 => break 'degrees,
                None => return Err(missing(&own(&format!("SH_DEGREE_{band}_COEF_{order}")))),
            }
        }
        degree = band;
    }
    let count = position.count;
    let rest: Vec<_> = left
        .iter()
        .map(|(key, _)| format!("attributes.{key}"))
        .collect();
    let all = [&rotation, &scale, &opacity]
        .into_iter()
        .chain(&coefficients);
    if let Some(other) = all.map(|own| own.count).find(|own| *own != count) {
        let field = format!("{}: elements of an attribute", primitive.place);
        return Err(name.field(field, other, format!("{count}, as of POSITION")));
    }
    let read = Values { buffers };
    let mut raised = 0;
    for index in 0..count {
        let value = read.component(&opacity, index, 0);
        if !(0.0..=1.0).contains(&value) {
            let field = format!("Gaussian {index}: opacity");
            return Err(name.field(field, value, "0 to 1"));
        }
        for axis in 0..3 {
            let value = read.component(&scale, index, axis);
            if !(0.0..=f64::from(f32::MAX)).contains(&value) {
                let field = format!("Gaussian {index}: scale[{axis}]");
                let expected = "a finite number of at least 0 (drafts of the extension wrote logarithms: write \
                                the file again)";
                return Err(name.field(field, value, expected));
            }
            raised += u64::from(value < f64::from(f32::MIN_POSITIVE));
        }
    }
    let cloud = Cloud::new(
        degree,
        values::each(count, |i| read.three(&position, i)),
        values::each(count, |i| {
            let sizes = [0, 1, 2].map(|axis| read.component(&scale, i, axis));
            sizes.map(|size| size.max(f64::from(f32::MIN_POSITIVE)).ln() as f32)
        }),
        values::each(count, |i| {
            [3, 0, 1, 2].map(|k| read.component(&rotation, i, k) as f32)
        }),
        values::each(count, |i| {
            let value = read.component(&opacity, i, 0);
            (value / (1.0 - value)).ln() as f32
        }),
        values::coefficients(count, degree, |i, out| {
            for (own, from) in out.iter_mut().zip(&coefficients) {
                *own = read.three(from, i);
            }
        }),
    );
    Ok(Read {
        cloud: cloud.map_err(|e| name.cloud(e))?,
        raised,
        rest,
    })
}

fn attribute(
    document: &Document,
    buffers: &mut Buffers<'_>,
    wanted: &Wanted,
    index: usize,
    field: &str,
    name: Origin<'_>,
) -> Result<Attribute, FileError> {
    let Some(own) = document.accessors.get(index) else {
        let all = document.accessors.len();
        return Err(name.field(
            field,
            index,
            format!("below {all}, the number of accessors"),
        ));
    };
    let is_type = |(component, is_normalised): &(usize, Option<bool>)| {
        *component == own.component && is_normalised.is_none_or(|is| is == own.is_normalised)
    };
    if own.kind != wanted.kind || !wanted.types.iter().any(is_type) {
        let normalised = if own.is_normalised {
            ", normalised"
        } else {
            ""
        };
        let kind = potamoi_base::file_keys::told(&own.kind);
        let value = format!("{kind} of components {}{normalised}", own.component);
        return Err(name.field(field, value, wanted.expected));
    }
    let width = match own.component {
        BYTE | UNSIGNED_BYTE => 1,
        SHORT | UNSIGNED_SHORT => 2,
        _ => 4,
    };
    Ok(Attribute {
        elements: buffers.elements(own, index, wanted.components * width)?,
        component: own.component,
        is_normalised: own.is_normalised,
        count: own.count,
    })
}

/// Reads components.
struct Values<'a, 'b> {
    buffers: &'a Buffers<'b>,
}

impl Values<'_, '_> {
    fn component(&self, own: &Attribute, index: usize, at: usize) -> f64 {
        let bytes = self.buffers.element(&own.elements, index);
        let (code, most) = match own.component {
            BYTE => (f64::from(bytes[at] as i8), 127.0),
            UNSIGNED_BYTE => (f64::from(bytes[at]), 255.0),
            SHORT => (f64::from(u16(bytes, 2 * at) as i16), 32767.0),
            UNSIGNED_SHORT => (f64::from(u16(bytes, 2 * at)), 65535.0),
            _ => return f64::from(f32(bytes, 4 * at)),
        };
        match own.is_normalised {
            true => (code / most).max(-1.0),
            false => code,
        }
    }

    fn three(&self, own: &Attribute, index: usize) -> [f32; 3] {
        [0, 1, 2].map(|at| self.component(own, index, at) as f32)
    }
}
