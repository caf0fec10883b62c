//! Comparison of Instant-NGP with `NeuRex` and `NGPC`, modelled by their published structure
//! (paper, Sec. "Compared with Prior Works").

use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::{Config, Modes, Organisation};
use potamoi_system::system_model::work::PathWork;
use potamoi_system::system_model::{AtBounds, Clock, Gathering, Outcome, Scenario, Variant};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{ExploreError, Setup};

/// Rows and columns of `NeuRex`'s array (paper, ibid.).
pub const NEUREX_SIDE: u64 = 32;

/// Speed-ups over the baseline on the same scene, at both bounds of the GPU's kernels: all have the
/// same GPU.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Accelerators {
    /// Name of the scene, as requested.
    pub scene: String,
    /// `NeuRex`: tables in MVoxels as here, feature-major banks, a larger array; each frame in
    /// full.
    pub neurex: AtBounds<f64>,
    /// `NGPC`: all tables on chip, one bank a level that delivers a vertex a cycle; each frame in
    /// full.
    pub ngpc: AtBounds<f64>,
    /// Potamoi, each frame in full.
    pub potamoi_without_sparw: AtBounds<f64>,
    /// Potamoi with warped frames.
    pub potamoi: AtBounds<f64>,
    /// The clock of all three.
    pub clock: Clock,
}

impl Accelerators {
    /// Compares on a scene of Instant-NGP with a counted path, in the setup's system.
    ///
    /// # Errors
    /// As [`Setup::frame`].
    pub fn of(name: &str, setup: &Setup, path: &PathWork) -> Result<Self, ExploreError> {
        let model = setup.model();
        // Banks that hold whole vectors, lanes that want them, and a larger array.
        let array = MacArray {
            rows: NEUREX_SIDE,
            columns: NEUREX_SIDE,
            ..setup.system.array()
        };
        let neurex = setup.frame_of(&feature_major(&setup.config), array)?;
        let run = |name: &str| -> Result<Outcome, ExploreError> {
            let variant = Variant::named(name).unwrap_or(Variant::ALL[0]);
            Ok(model.run(path, variant, Scenario::Local)?.0)
        };
        let baseline = run("baseline")?;
        let span = |own: &Outcome| own.run.span_ns();
        let per_frame = baseline.run.map(|run| run.span_ns / run.frames as f64);
        // One frame, which is the same for all that render each in full.
        let ngpc = model.frame(&path.full(0).with_resident_tables(), Gathering::Unit)?;
        let neurex = model.frame(&neurex, Gathering::Unit)?;
        let ours = run("fs+gu")?;
        let warped = run("potamoi")?;
        Ok(Self {
            scene: name.to_owned(),
            neurex: per_frame.over(&neurex.span_ns()),
            ngpc: per_frame.over(&ngpc.span_ns()),
            potamoi_without_sparw: span(&baseline).over(&span(&ours)),
            potamoi: span(&baseline).over(&span(&warped)),
            clock: model.costs.clock.clone(),
        })
    }

    /// Speed-ups of Potamoi over `NeuRex` and `NGPC`: without warping, then with it.
    #[must_use]
    pub fn ratios(&self) -> [AtBounds<f64>; 4] {
        [
            self.potamoi_without_sparw.over(&self.neurex),
            self.potamoi_without_sparw.over(&self.ngpc),
            self.potamoi.over(&self.neurex),
            self.potamoi.over(&self.ngpc),
        ]
    }
}

/// The configuration with feature-major banks, which hold whole vectors.
fn feature_major(config: &Config) -> Config {
    let mut config = config.clone();
    config.gu.organisation = Organisation::FeatureMajor;
    config.gu.modes = Modes::Both;
    (config.gu.banks, config.gu.lanes, config.gu.ports) = (16, 16, 1);
    config
}
