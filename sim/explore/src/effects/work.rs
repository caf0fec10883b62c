//! Work of an effect, by unit.

use potamoi_base::effects::Effect;
use potamoi_cycles::effect_meter::EffectCycles;
use potamoi_scene::{FrameCounts, Scene};
use schemars::JsonSchema;
use serde::Serialize;

/// Work of an effect: the unit and the amount.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Work {
    /// The unit that does it.
    pub unit: &'static str,
    /// Modelled cycles, where counted.
    pub cycles: Option<u64>,
    /// Amount of work that is not counted in cycles.
    pub amount: Option<u64>,
    /// Unit of measure of `amount`.
    pub amount_of: Option<&'static str>,
}

impl Work {
    const fn cycles(unit: &'static str, cycles: u64) -> Self {
        Self {
            unit,
            cycles: Some(cycles),
            amount: None,
            amount_of: None,
        }
    }

    const fn amount(unit: &'static str, amount: u64, of: &'static str) -> Self {
        Self {
            unit,
            cycles: None,
            amount: Some(amount),
            amount_of: Some(of),
        }
    }

    /// The work as report text.
    #[must_use]
    pub fn words(&self) -> String {
        match (self.cycles, self.amount, self.amount_of) {
            (Some(cycles), _, _) => format!("{}: {cycles} cycles (cycle model)", self.unit),
            (_, Some(amount), Some(of)) => format!("{}: {amount} {of}", self.unit),
            _ => self.unit.to_owned(),
        }
    }
}

/// Work of simulating an effect.
pub(super) fn work_of(
    effect: Effect,
    cycles: &EffectCycles,
    counts: &FrameCounts,
    left: u64,
    scene: &Scene,
) -> Work {
    let splats = counts.splats.unwrap_or_default();
    let terms = |degree: u8| 2 * u64::from(degree) + 1;
    match effect {
        // Of the runs that interpolate, which without it would read one vertex in as many cycles.
        Effect::Trilinear => Work::cycles("gathering unit", cycles.interpolating),
        // Of one operation with the rest of a pair.
        Effect::Exponential if cycles.splats > 0 => Work::cycles("splat unit", cycles.splats),
        Effect::Exponential => Work::cycles("vector unit", cycles.exponentials),
        Effect::SphericalHarmonics(degree) => {
            let is_splats = scene.model().is_splats();
            match (scene.facts().perceptron.is_some(), is_splats) {
                (true, true) => {
                    let codes = splats.visible * terms(degree);
                    Work::amount("GPU", codes, "codes of visible Gaussians' directions")
                }
                (true, false) => {
                    let codes = counts.rays * terms(degree);
                    Work::amount("GPU", codes, "codes of rays' directions")
                }
                (false, true) => {
                    let products = 3 * splats.visible * terms(degree);
                    Work::amount("GPU", products, "multiplications of visible Gaussians")
                }
                // Colours stored as linear in the direction.
                (false, false) => Work::cycles("MAC array", cycles.array),
            }
        }
        Effect::ViewMlp => Work::cycles("MAC array", cycles.array),
        Effect::HashLevels => Work::amount("DRAM", counts.scattered_bytes, "bytes row by row"),
        Effect::Segments => Work::cycles("gathering unit", cycles.further_passes),
        Effect::Sorting => Work::amount("GPU", splats.visible, "visible Gaussians"),
        Effect::EarlyTermination => Work::amount("compositing", counts.rays, "rays"),
        Effect::Warping => Work::amount("GPU", counts.rays, "pixels a frame"),
        Effect::Disocclusion => {
            Work::amount("all units", left, "pixels of the path's warped frames")
        }
        Effect::VoidTest => Work::amount("GPU", counts.samples, "samples"),
        Effect::OctreeMerging => Work::amount("GPU", splats.gaussians, "Gaussians"),
        Effect::RemoteLink => Work::amount("link", counts.rays, "pixels a full frame"),
        Effect::RandomDram => Work::amount("DRAM", counts.scattered_bytes, "bytes"),
    }
}
