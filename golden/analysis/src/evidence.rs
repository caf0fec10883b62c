//! Evidence for each effect from a scene's data and a camera path, in words with numbers.

use potamoi_formats::config::Config;
use potamoi_formats::record::RECORD_CHANNELS;

use super::{PathVisibility, Surroundings};
use potamoi_base::effects::Effect;
use potamoi_scene::Scene;
use potamoi_scene::model_facts::ModelFacts;

/// The data that findings are derived from.
pub(super) struct EvidenceInputs<'a> {
    pub(super) scene: &'a Scene,
    pub(super) facts: &'a ModelFacts,
    pub(super) seen: PathVisibility,
    pub(super) config: &'a Config,
    pub(super) around: Surroundings,
    pub(super) is_still: bool,
    /// Number of empty voxel cells, and of all cells.
    pub(super) void: Option<[u64; 2]>,
    /// Number of splat cells before and after merging.
    pub(super) merged: Option<[usize; 2]>,
}

impl EvidenceInputs<'_> {
    /// Whether an effect is needed, with the evidence.
    pub(super) fn finding(&self, effect: Effect) -> (bool, String) {
        match effect {
            Effect::Trilinear => self.trilinear(),
            Effect::Exponential => self.exponential(),
            Effect::SphericalHarmonics(degree) => self.harmonics(degree.into()),
            Effect::ViewMlp => self.view_mlp(),
            Effect::HashLevels => self.hash_levels(),
            Effect::Segments => self.segments(),
            Effect::Sorting => self.sorting(),
            Effect::EarlyTermination => self.early_termination(),
            Effect::Warping => self.warping(),
            Effect::Disocclusion => self.disocclusion(),
            Effect::VoidTest => self.void_test(),
            Effect::OctreeMerging => self.octree_merging(),
            Effect::RemoteLink => self.remote_link(),
            Effect::RandomDram => self.random_dram(),
        }
    }

    fn frames(&self) -> String {
        match self.seen.frames {
            1 => "1 frame".to_owned(),
            n => format!("{n} frames"),
        }
    }

    fn trilinear(&self) -> (bool, String) {
        let interpolated = self.facts.tables.iter().filter(|t| t.vertices > 1).count();
        let (name, parts) = self.facts.parts;
        if self.facts.tables.is_empty() {
            return (
                false,
                format!("{parts} {name} are records of one vertex each: nothing to interpolate"),
            );
        }
        if interpolated == 0 {
            return (
                false,
                format!("{} rows of one vertex each: nothing to interpolate", parts),
            );
        }
        // Colours of Gaussians are interpolated whether one is in view or not.
        let sees = self.scene.model().is_splats() || self.is_seen();
        let most = self.facts.tables.iter().map(|t| t.vertices).max();
        let evidence = format!(
            "{interpolated} of {} tables have {} vertices or fewer a sample; {}",
            self.facts.tables.len(),
            most.unwrap_or(0),
            self.view()
        );
        (sees, evidence)
    }

    /// Whether any visible part is computed; Gaussians count even if none is opaque.
    fn is_seen(&self) -> bool {
        let is_splats = self.scene.model().is_splats();
        (is_splats || self.facts.can_be_seen()) && self.seen.in_view > 0
    }

    /// Description of what the path sees.
    fn view(&self) -> String {
        let (name, parts) = self.facts.parts;
        let is_splats = self.scene.model().is_splats();
        if !is_splats && !self.facts.can_be_seen() {
            return format!("no opacity above 0 in {parts} {name}");
        }
        let met = if is_splats {
            "(tile, Gaussian) pairs"
        } else {
            "rays that cross the model's bounds"
        };
        format!("{} {met} in {}", self.seen.met, self.frames())
    }

    fn exponential(&self) -> (bool, String) {
        let evidence = match self.facts.most_opaque {
            Some(most) if self.is_seen() => {
                let what = match self.scene.model().is_splats() {
                    true => "opacity",
                    false => "density a voxel edge",
                };
                format!("largest {what} {most:.4}; {}", self.view())
            }
            _ => self.view(),
        };
        (self.is_seen(), evidence)
    }

    fn harmonics(&self, degree: usize) -> (bool, String) {
        let Some(bands) = &self.facts.harmonics else {
            return (false, "the model has no spherical harmonics".to_owned());
        };
        let (holders, what) = (bands.holders, self.facts.holders);
        if bands.stored < degree {
            return (
                false,
                format!(
                    "degrees up to {} are stored in {holders} {what}",
                    bands.stored
                ),
            );
        }
        let used = bands.from(degree);
        match used {
            0 => (
                false,
                format!(
                    "no coefficient above degree {} in {holders} {what}",
                    degree - 1
                ),
            ),
            _ => (
                true,
                format!("{used} of {holders} {what} have coefficients of degree {degree} or above"),
            ),
        }
    }

    fn view_mlp(&self) -> (bool, String) {
        match self.facts.perceptron {
            None => (false, "the model has no perceptron".to_owned()),
            Some(own) => {
                let [all, of_directions] = own.inputs;
                let [weights, used] = own.weights;
                (
                    used > 0,
                    format!(
                        "{used} of {weights} weights of the {of_directions} inputs of {all} that \
                         are the direction's are not 0"
                    ),
                )
            }
        }
    }

    fn hash_levels(&self) -> (bool, String) {
        let (hashed, all) = (self.facts.hashed_tables(), self.facts.tables.len());
        let rows = self.facts.tables.iter().filter(|table| table.is_hashed);
        let rows: usize = rows.map(|table| table.rows).sum();
        let evidence = match (hashed, all) {
            (0, 0) => "the model has no table of vertices".to_owned(),
            (0, 1) => "each vertex has a row of its own".to_owned(),
            (0, all) => format!("each vertex has a row of its own in all {all} tables"),
            _ => format!("vertices share {rows} rows in {hashed} of {all} tables"),
        };
        (hashed > 0, evidence)
    }

    fn channels(&self) -> usize {
        let tables = self.facts.tables.iter().map(|table| table.channels);
        let records = self.scene.model().is_splats().then_some(RECORD_CHANNELS);
        tables.chain(records).max().unwrap_or(0)
    }

    fn segments(&self) -> (bool, String) {
        let channels = self.channels();
        let segments = self.config.segments(channels);
        let pass = self.config.lanes_a_port();
        (
            segments > 1,
            format!(
                "{channels} channels at most, {pass} read in a pass: {segments} {}",
                if segments == 1 { "pass" } else { "passes" }
            ),
        )
    }

    fn sorting(&self) -> (bool, String) {
        let (name, parts) = self.facts.parts;
        if !self.scene.model().is_splats() {
            return (
                false,
                "samples along a ray are made in their order".to_owned(),
            );
        }
        (
            self.seen.unsorted > 0,
            format!(
                "{parts} {name} are stored in another order than that of their depths in {} of {}",
                self.seen.unsorted,
                self.frames()
            ),
        )
    }

    fn early_termination(&self) -> (bool, String) {
        let own = self.facts.thickness;
        // What cannot be rendered does not stop either.
        let lost = self.scene.lost_a_sample(self.config).unwrap_or(0.0);
        let evidence = if own.depth.is_infinite() {
            format!(
                "nothing bounds the optical depth of a ray, which stops below {:.0e}",
                own.stop
            )
        } else {
            format!(
                "the largest optical depth of a ray is {:.2}, a transmittance of {}; rays stop below {:.0e}",
                own.depth,
                transmittance(own.least_left()),
                own.stop
            )
        };
        (own.can_stop(lost), evidence)
    }

    fn warping(&self) -> (bool, String) {
        if self.seen.frames < 2 {
            return (
                false,
                "a single frame has no reference to be warped from".to_owned(),
            );
        }
        if self.is_still {
            return (
                false,
                format!("the camera does not move in {}", self.frames()),
            );
        }
        (
            true,
            format!(
                "the camera moves in {} of {} steps, by {:.4} scene units and {:.3} degrees at most from the \
                 first",
                self.seen.moves,
                self.seen.frames - 1,
                self.seen.distance,
                self.seen.turn
            ),
        )
    }

    fn disocclusion(&self) -> (bool, String) {
        let (is_warped, evidence) = self.warping();
        match is_warped {
            false => (false, format!("nothing is warped: {evidence}")),
            // Without parallax nothing is uncovered but what enters at the borders.
            true if self.seen.distance == 0.0 => (
                true,
                format!(
                    "the camera turns by {:.3} degrees in its place: the borders alone are new",
                    self.seen.turn
                ),
            ),
            true => (
                true,
                format!(
                    "the camera moves by {:.4} scene units at most: hidden surfaces can become visible",
                    self.seen.distance
                ),
            ),
        }
    }

    fn void_test(&self) -> (bool, String) {
        match self.void {
            Some([void, all]) => (void > 0, format!("{void} of {all} cells are void")),
            None if self.scene.model().is_splats() => (false, "splats have no cells".to_owned()),
            None => (false, "no grid marks empty space".to_owned()),
        }
    }

    fn octree_merging(&self) -> (bool, String) {
        match self.merged {
            Some([cells, merged]) => (
                merged < cells,
                format!("{cells} cells fit {merged} MVoxels"),
            ),
            None if self.scene.model().is_splats() => (false, "merging is turned off".to_owned()),
            None => (false, "no splats".to_owned()),
        }
    }

    fn remote_link(&self) -> (bool, String) {
        match self.around.is_remote {
            true => (
                true,
                format!("full frames of {} are rendered elsewhere", self.frames()),
            ),
            false => (
                false,
                "all frames are rendered by the device itself".to_owned(),
            ),
        }
    }

    fn random_dram(&self) -> (bool, String) {
        let hashed = self.facts.hashed_tables();
        let fetched = self.seen.fetched_bytes;
        let mut evidence = vec![];
        if hashed > 0 {
            evidence.push(format!(
                "{hashed} tables do not stream: their rows lie anywhere"
            ));
        }
        if self.scene.model().is_splats() {
            evidence.push(format!(
                "{fetched} bytes of records are fetched one by one in {}",
                self.frames()
            ));
        }
        if evidence.is_empty() {
            let tables = self.facts.tables.len();
            evidence.push(match tables {
                1 => "the table streams".to_owned(),
                _ => format!("all {tables} tables stream"),
            });
        }
        (hashed > 0 || fetched > 0, evidence.join("; "))
    }
}

/// A transmittance; one that floating point rounds to nothing is none.
fn transmittance(own: f64) -> String {
    match own == 0.0 {
        true => "0".to_owned(),
        false => format!("{own:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_scene::model_facts::{Perceptron, TableFacts};

    /// A count of one makes an effect needed, a count of zero does not.
    #[test]
    fn one_is_enough() {
        let scene = Scene::open("lantern").unwrap();
        let config = Config::paper();
        let calls = |effect: Effect, number: usize| {
            let mut facts = scene.facts().clone();
            let table = facts.tables[0];
            facts.tables = vec![table, table];
            facts.tables.extend((0..number).map(|_| TableFacts {
                is_hashed: true,
                ..table
            }));
            facts.perceptron = Some(Perceptron {
                inputs: [39, 27],
                weights: [27 * 64, number as u64],
            });
            let known = EvidenceInputs {
                scene: &scene,
                facts: &facts,
                seen: PathVisibility::default(),
                config: &config,
                around: Surroundings::default(),
                is_still: false,
                void: Some([number as u64, 8]),
                merged: Some([8, 8 - number]),
            };
            known.finding(effect).0
        };
        for effect in [
            Effect::HashLevels,
            Effect::ViewMlp,
            Effect::VoidTest,
            Effect::OctreeMerging,
            Effect::RandomDram,
        ] {
            assert!(calls(effect, 1) && !calls(effect, 0), "{effect}");
        }
    }
}
