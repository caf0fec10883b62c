//! What a search seeks: an objective, and limits that the machine keeps.

use potamoi_system::system_model::ClockOrigin;
use schemars::JsonSchema;
use serde::Serialize;

use crate::cells::{COLUMNS, Cell};

/// The figure that a search makes best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Most frames a second.
    Rate,
    /// Least energy a frame.
    Energy,
    /// Least product of energy and time of a frame.
    EnergyDelay,
    /// Least area of the accelerator.
    Area,
}

impl Objective {
    /// The column, and whether more of it is better.
    #[must_use]
    pub const fn column(self) -> (&'static str, bool) {
        match self {
            Self::Rate => ("fps", true),
            Self::Energy => ("mj", false),
            Self::EnergyDelay => ("mj_ms", false),
            Self::Area => ("mm2", false),
        }
    }
}

/// Objective and limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Goal {
    /// The figure to make best; with several scenes its geometric mean.
    pub objective: Objective,
    /// Most area of the accelerator, in square millimetres.
    pub max_area: Option<f64>,
    /// Least PSNR on every scene, in dB.
    pub min_psnr: Option<f64>,
    /// Least frames a second on every scene.
    pub min_fps: Option<f64>,
    /// Most energy a frame on every scene, in millijoules.
    pub max_mj: Option<f64>,
    /// Whether a clock above the one that the slowest block reaches misses a limit: where the clock varies.
    /// A clock that the base assumes is the user's own.
    pub needs_reached_clock: bool,
    /// Whether a clock that is a guess misses a limit: where the base's clock is none.
    pub needs_known_clock: bool,
}

/// Where a machine stands: a smaller place is better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Objective, as a logarithm of which less is better.
    loss: f64,
    /// Sum of the logarithms by which limits are missed; 0 where all are kept.
    missed: f64,
    /// Area, which decides between machines that are otherwise alike; infinite where it is not known.
    area: f64,
}

/// Loss of a limit that cannot be checked: a factor of a million.
const UNKNOWN: f64 = 13.8;

impl Standing {
    /// Whether the machine keeps all limits.
    #[must_use]
    pub fn keeps_limits(&self) -> bool {
        self.missed == 0.0
    }

    /// Whether this is better than another: limits first, then the objective, then the area.
    #[must_use]
    pub fn is_better(&self, other: &Self) -> bool {
        (self.missed, self.loss, self.area) < (other.missed, other.loss, other.area)
    }

    /// One number for an optimiser. Any machine that keeps the limits is below any that does not.
    #[must_use]
    pub fn value(&self) -> f64 {
        match self.keeps_limits() {
            true => self.loss.clamp(-100.0, 100.0),
            false => 1000.0 + self.missed,
        }
    }
}

impl Goal {
    /// The standing of a machine by its cells on each scene; `None` stands for a scene without figures.
    #[must_use]
    pub fn standing(&self, scenes: &[Option<&[Cell]>]) -> Standing {
        let (column, is_more) = self.objective.column();
        let (mut loss, mut missed) = (0.0, 0.0);
        for cells in scenes {
            let Some(cells) = cells else {
                missed += 2.0 * UNKNOWN;
                continue;
            };
            match figure(cells, column).filter(|own| *own > 0.0) {
                Some(own) if is_more => loss -= own.ln(),
                Some(own) => loss += own.ln(),
                None => {}
            }
            missed += self.misses(cells).iter().map(|own| own.loss).sum::<f64>();
        }
        let areas = scenes.iter().flatten();
        let areas = areas.map(|cells| figure(cells, "mm2").unwrap_or(f64::INFINITY));
        Standing {
            loss: loss / scenes.len().max(1) as f64,
            missed,
            area: areas.fold(0.0, f64::max),
        }
    }
}

impl Goal {
    /// What a machine misses on a scene; nothing where it keeps all limits.
    fn misses(&self, cells: &[Cell]) -> Vec<Miss> {
        let mut all = vec![];
        let (column, _) = self.objective.column();
        if figure(cells, column).is_none_or(|own| own <= 0.0) {
            all.push(Miss::unknown(column));
        }
        let limits = [
            ("mm2", self.max_area, Side::Most),
            ("mj", self.max_mj, Side::Most),
            ("psnr_db", self.min_psnr, Side::Least),
            ("fps", self.min_fps, Side::Least),
        ];
        for (name, limit, side) in limits {
            // Equal pictures have no PSNR: they keep every limit.
            let is_equal = name == "psnr_db" && has_quality(cells);
            let own = figure(cells, name).or(is_equal.then_some(f64::INFINITY));
            all.extend(limit.and_then(|limit| Miss::of(name, own, limit, side)));
        }
        if self.needs_reached_clock {
            match excess(cells) {
                None => all.push(Miss::unknown("reached_ghz")),
                Some(own) if own > 1.0 => all.push(Miss {
                    words: "its clock is above the one that its slowest block reaches".to_owned(),
                    loss: own.ln(),
                }),
                Some(_) => {}
            }
        }
        if self.needs_known_clock && is_clock_guessed(cells) {
            all.push(Miss {
                words: "its clock is a guess, since the period of a block is not known".to_owned(),
                loss: UNKNOWN,
            });
        }
        all
    }

    /// The limits that a machine misses, in words, each once; with the scene where there are several.
    #[must_use]
    pub fn missed(&self, scenes: &[Option<&[Cell]>]) -> Vec<String> {
        let mut all: Vec<String> = vec![];
        for cells in scenes.iter().flatten() {
            let scene = text(cells, "scene").filter(|_| scenes.len() > 1);
            for own in self.misses(cells) {
                let words = match scene {
                    Some(scene) => format!("{} ({scene})", own.words),
                    None => own.words,
                };
                if !all.contains(&words) {
                    all.push(words);
                }
            }
        }
        all
    }
}

/// A limit that is missed.
struct Miss {
    /// The figure beside the limit.
    words: String,
    /// Logarithm of the figure over the limit, or of the limit over the figure.
    loss: f64,
}

/// Which side of a limit is kept.
#[derive(Clone, Copy)]
enum Side {
    Most,
    Least,
}

impl Miss {
    fn unknown(name: &str) -> Self {
        Self {
            words: format!("{name} is not known"),
            loss: UNKNOWN,
        }
    }

    /// `None` where the limit is kept.
    fn of(name: &str, own: Option<f64>, limit: f64, side: Side) -> Option<Self> {
        let Some(own) = own else {
            return Some(Self::unknown(name));
        };
        let (ratio, least) = match side {
            Side::Most => (own / limit, "at most"),
            Side::Least => (limit / own, "at least"),
        };
        (ratio > 1.0).then(|| Self {
            words: format!("{name} is {own:.4}, expected {least} {limit}"),
            loss: ratio.ln().min(UNKNOWN),
        })
    }
}

/// The clock over the one that the slowest block reaches; 1 where it is no higher, `None` where the reached
/// one is not known.
fn excess(cells: &[Cell]) -> Option<f64> {
    let own = figure(cells, "clock_ghz")? / figure(cells, "reached_ghz")?;
    Some(own.max(1.0))
}

/// Whether a row's clock is above the one that its slowest block reaches, or that one is not known.
#[must_use]
pub fn is_clock_above_reached(cells: &[Cell]) -> bool {
    excess(cells).is_none_or(|own| own > 1.0)
}

/// Whether a row's clock rests on a block of unknown period.
#[must_use]
pub fn is_clock_guessed(cells: &[Cell]) -> bool {
    text(cells, "clock_origin") == Some(ClockOrigin::Guessed.word())
}

/// A figure by the name of its column.
pub(super) fn figure(cells: &[Cell], name: &str) -> Option<f64> {
    let at = COLUMNS.iter().position(|own| own.name == name)?;
    cells.get(at)?.number()
}

/// A text by the name of its column.
pub(super) fn text<'a>(cells: &'a [Cell], name: &str) -> Option<&'a str> {
    let at = COLUMNS.iter().position(|own| own.name == name)?;
    match cells.get(at)? {
        Cell::Text(own) => Some(own),
        _ => None,
    }
}

fn has_quality(cells: &[Cell]) -> bool {
    let at = COLUMNS.iter().position(|own| own.name == "psnr_beside");
    at.and_then(|at| cells.get(at))
        .is_some_and(|own| *own != Cell::Unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(own: &[(&str, f64)]) -> Vec<Cell> {
        let of = |name: &str| own.iter().find(|(known, _)| *known == name);
        let each = COLUMNS
            .iter()
            .map(|column| of(column.name).map(|(_, v)| *v).into());
        each.collect()
    }

    #[test]
    fn limits_come_before_the_objective() {
        let goal = Goal {
            objective: Objective::Rate,
            max_area: Some(1.0),
            min_psnr: Some(40.0),
            min_fps: None,
            max_mj: None,
            needs_reached_clock: false,
            needs_known_clock: false,
        };
        let of = |fps, mm2, db| {
            let own = cells(&[("fps", fps), ("mm2", mm2), ("psnr_db", db)]);
            goal.standing(&[Some(&own)])
        };
        let (slow, fast, large, poor) = (
            of(10.0, 0.9, 50.0),
            of(20.0, 1.0, 40.0),
            of(99.0, 1.1, 50.0),
            of(99.0, 0.9, 39.0),
        );
        assert!(fast.is_better(&slow) && slow.is_better(&large) && slow.is_better(&poor));
        assert!(fast.keeps_limits() && !large.keeps_limits() && !poor.keeps_limits());
        assert!(fast.value() < slow.value() && slow.value() < large.value());
        // An area that is not known keeps no limit of it.
        let unknown = goal.standing(&[Some(&cells(&[("fps", 99.0), ("psnr_db", 50.0)]))]);
        assert!(!unknown.keeps_limits() && large.is_better(&unknown));
        assert!(!goal.standing(&[None]).keeps_limits());
    }

    /// A machine that cannot run at its clock is none to build, however fast it would be.
    #[test]
    fn a_clock_above_the_reached_one_misses_a_limit_where_clocks_vary() {
        let goal = |needs_reached_clock| Goal {
            objective: Objective::Rate,
            max_area: None,
            min_psnr: None,
            min_fps: None,
            max_mj: None,
            needs_reached_clock,
            needs_known_clock: false,
        };
        let of = |fps, clock| {
            let own = cells(&[("fps", fps), ("clock_ghz", clock), ("reached_ghz", 0.6)]);
            [true, false].map(|reached| goal(reached).standing(&[Some(&own)]))
        };
        let (at, above) = (of(10.0, 0.6), of(20.0, 1.0));
        assert!(at[0].is_better(&above[0]) && !above[0].keeps_limits());
        assert!(above[1].is_better(&at[1]) && above[1].keeps_limits());
    }

    #[test]
    fn several_scenes_count_by_their_geometric_mean() {
        let goal = Goal {
            objective: Objective::Energy,
            max_area: None,
            min_psnr: None,
            min_fps: None,
            max_mj: None,
            needs_reached_clock: false,
            needs_known_clock: false,
        };
        let [two, eight, four] = [2.0, 8.0, 4.0].map(|mj| cells(&[("mj", mj)]));
        let both = goal.standing(&[Some(&two), Some(&eight)]);
        let same = goal.standing(&[Some(&four), Some(&four)]);
        assert!((both.value() - same.value()).abs() < 1e-12);
    }
}
