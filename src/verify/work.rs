//! What is verified.

use std::path::{Path, PathBuf};

use potamoi_formats::config::{Config, Sums};
use potamoi_reference::{Twins, Units};
use potamoi_rtl::verify::Verifier;
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;

use super::VerifyArgs;
use crate::failure::Failure;

/// What is verified: a frame, or a trace of one.
pub(super) enum Work {
    Scene(Box<Scene>),
    Trace(PathBuf, Box<Trace>),
}

impl Work {
    pub(super) fn open(args: &VerifyArgs, config: &Config) -> Result<Self, Failure> {
        Ok(match &args.trace {
            Some(path) => Self::Trace(path.clone(), Box::new(Trace::read(path, config)?)),
            None => Self::Scene(Box::new(args.scene.open()?)),
        })
    }

    pub(super) fn scene(&self) -> &str {
        match self {
            Self::Scene(scene) => scene.name(),
            Self::Trace(_, trace) => &trace.scene,
        }
    }

    /// What agreement says nothing of.
    pub(super) fn not_checked(&self) -> Vec<String> {
        match self {
            Self::Scene(scene) => scene.not_checked(),
            Self::Trace(..) => {
                vec!["all that lies outside the units: a trace holds their work alone".to_owned()]
            }
        }
    }

    pub(super) fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Scene(scene) => Some([scene.camera().width, scene.camera().height]),
            Self::Trace(..) => None,
        }
    }

    /// Feature vectors and elements.
    pub(super) fn counts(&self, config: &Config) -> Result<[u64; 2], Failure> {
        match self {
            Self::Scene(scene) => {
                let frame = scene.render_fixed(config, &mut Twins::new(config))?.counts;
                Ok([frame.feature_vectors, frame.elements.values().sum()])
            }
            Self::Trace(_, trace) => {
                let entries = trace.gathered.iter().map(|g| g.task.entries.len() as u64);
                let elements = trace.computed.iter().map(|c| c.a.len() as u64);
                Ok([entries.sum(), elements.sum()])
            }
        }
    }

    pub(super) fn run(&self, config: &Config, verifier: &mut Verifier<'_>) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => {
                scene.render_fixed(config, verifier)?;
                Ok(())
            }
            Self::Trace(path, trace) => replay(path, trace, verifier),
        }
    }
}

/// Sends a trace through units that also compute the golden values: those must
/// be the trace's.
fn replay(path: &Path, trace: &Trace, units: &mut dyn Units) -> Result<(), Failure> {
    let differs = |what: &str| {
        Failure::Check(format!(
            "trace {}: its {what} differ from the golden model's: it was written by another \
             version of potamoi; write it again",
            path.display()
        ))
    };
    let tasks: Vec<_> = trace.gathered.iter().map(|g| g.task.clone()).collect();
    let mut features: Vec<i32> = vec![];
    match trace.sums {
        Sums::Exact => units.sums(&tasks, &mut features),
        Sums::Rounded => {
            let mut codes = vec![];
            let gathered = units.gather(&tasks, &mut codes);
            features.extend(codes.into_iter().map(i32::from));
            gathered
        }
    }
    .map_err(Failure::Unit)?;
    let expected = trace.gathered.iter().flat_map(|g| &g.features);
    if !features.iter().eq(expected) {
        return Err(differs("features"));
    }
    for computed in &trace.computed {
        let mut out = vec![0; computed.a.len()];
        units
            .vector(computed.op, &computed.a, &computed.b, &mut out)
            .map_err(Failure::Unit)?;
        if out != computed.out {
            return Err(differs("results"));
        }
    }
    Ok(())
}
