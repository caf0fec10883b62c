//! Frames of radiance fields in floating point, beside the arithmetic of the same samples in JAX.
//!
//! A *gathered* sample is one where the field is not known to be empty, up to where its ray stops; a
//! *coloured* one is one whose colour is computed. Empty samples on the way take time and do not count.

mod jax;

use potamoi_fields::{Field, FieldFrame, FloatOptions, render_masked};
use potamoi_scene::{Kind as ModelKind, Scene};

use crate::error::SpeedError;
use crate::frame_name;
use crate::machine::Tool;
use crate::row::{Beside, Figure, Kind, Row, Section};
use crate::sizes::Sizes;
use crate::time::Meter;
use jax::Jax;

/// Built-in scenes.
const SCENES: [&str; 4] = ["cairn:dvgo", "cairn:ngp", "cairn:tensorf", "cairn"];

/// A frame of a field.
struct Measured {
    name: String,
    scene: Scene,
    ms: f64,
    frame: FieldFrame,
}

/// The scene's field; `None` of Gaussians.
pub(crate) fn field(scene: &Scene) -> Option<&dyn Field> {
    match scene.model().kind() {
        ModelKind::Field(field) => Some(field),
        ModelKind::Splats(_) => None,
    }
}

/// Number of steps of [`rows`].
pub(crate) fn steps(own: Option<&Scene>) -> u64 {
    SCENES.len() as u64 + 1 + u64::from(own.and_then(field).is_some())
}

/// Each scene, and what is known of JAX.
///
/// # Errors
/// A scene that cannot be rendered.
pub(crate) fn rows(
    sizes: &Sizes,
    runs: u32,
    own: Option<&Scene>,
    meter: &mut Meter,
    begin: &mut dyn FnMut(&str),
) -> Result<(Vec<Row>, Tool), SpeedError> {
    let mut scenes = vec![];
    for name in SCENES {
        let mut scene = Scene::open(name)?;
        scene.set_size(Some(sizes.fields), None)?;
        scenes.push(scene);
    }
    scenes.extend(own.filter(|own| field(own).is_some()).cloned());
    let mut all = vec![];
    for scene in scenes {
        begin(scene.name());
        let Some(field) = field(&scene) else {
            continue;
        };
        let options = FloatOptions::default();
        let frame = || render_masked(field, scene.camera(), &options, None);
        let (ms, frame) = meter.fastest(runs, rayon::current_num_threads(), frame)?;
        let name = frame_name::of_scene(&scene);
        all.push(Measured {
            name,
            scene,
            ms,
            frame,
        });
    }
    begin("JAX");
    let jax = Jax::measure(runs, all.iter().filter_map(asked));
    let found = all.iter().map(|own| row(own, &jax)).collect();
    Ok((found, Tool::new("JAX", &jax.version)))
}

/// What a peer is asked for a frame; `None` of a field that it does not compute.
fn asked(own: &Measured) -> Option<jax::Model<'_>> {
    let counts = [own.frame.gathered, own.frame.coloured];
    jax::Model::of(&own.name, field(&own.scene)?, counts)
}

fn row(own: &Measured, jax: &Jax) -> Row {
    let (scene, frame) = (&own.scene, &own.frame);
    let peer: Figure = match asked(own) {
        Some(_) => jax.figure(&own.name),
        None => Err(format!(
            "the script in JAX computes DirectVoxGO and Instant-NGP, not {}",
            scene.model().algorithm()
        )),
    };
    let origin = "a frame, from rays to the picture; beside: no ray marcher, but the gathering, \
                  interpolation and perceptrons alone of as many samples, of which as many are \
                  coloured, in a model of the same sizes with random weights";
    let beside = Beside::new(Kind::Peer, jax.name(), &peer);
    Row::new(Section::Fields, &own.name, &Ok(own.ms), beside, origin).with_counts([
        ("samples", frame.samples),
        ("samples gathered", frame.gathered),
        ("samples coloured", frame.coloured),
    ])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn measured(name: &str) -> Measured {
        let mut scene = Scene::open(name).unwrap();
        scene.set_size(Some(8), None).unwrap();
        let frame = render_masked(
            field(&scene).unwrap(),
            scene.camera(),
            &FloatOptions::default(),
            None,
        );
        Measured {
            name: frame_name::of_scene(&scene),
            ms: 3.0,
            frame: frame.unwrap(),
            scene,
        }
    }

    #[test]
    fn a_row_has_the_peer_s_figure_or_its_reason() {
        let own = measured("cairn:dvgo");
        let models = format!(r#"[{{"name": "{}", "ms": 1.5}}]"#, own.name);
        let jax = Jax::read(&format!(r#"{{"version": "9.9", "models": {models}}}"#));
        let dvgo = row(&own, &jax);
        assert_eq!((dvgo.measured, dvgo.ratio), (Some(3.0), Some(2.0)));
        assert!(dvgo.beside.name.contains("9.9"), "{:?}", dvgo.beside);
        assert!(dvgo.origin.contains("no ray marcher"));
        let missing = Jax::read(r#"{"missing": "No module named 'jax'"}"#);
        let dvgo = row(&own, &missing);
        assert_eq!((dvgo.beside.value, dvgo.ratio), (None, None));
        let why = dvgo.beside.why.unwrap();
        assert!(
            why.contains("No module named 'jax'") && why.contains("pip install jax"),
            "{why}"
        );
        let voxels = row(&measured("cairn"), &jax).beside.why.unwrap();
        assert!(
            voxels.contains("DirectVoxGO and Instant-NGP, not"),
            "{voxels}"
        );
    }
}
