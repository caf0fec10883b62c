//! Bank organisations: cycles, conflicts and bandwidth of a frame's gathers in each.

use potamoi_cycles::layouts::{Layout, Layouts};
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_scene::Scene;
use potamoi_system::system_model::Clock;
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;
use crate::setup::accelerator_clock;

/// A frame's gathers in every organisation.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Organisations {
    /// Entries gathered.
    pub samples: u64,
    /// Clock of the cycles.
    pub clock: Clock,
    /// One organisation each.
    pub layouts: Vec<OrganisationRow>,
    /// The paper's conflict rates.
    pub paper: PaperConflicts,
}

/// A frame's gathers in one organisation.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct OrganisationRow {
    /// The organisation, with its counts.
    #[serde(flatten)]
    pub layout: Layout,
    /// Conflict rate: conflicts over reads.
    pub conflict_rate: f64,
    /// Conflict rate if lanes could not share a read of the same row.
    pub conflict_rate_unshared: f64,
    /// Share of cycles lost to bank stalls.
    pub lost: f64,
    /// Entries gathered in a cycle.
    pub samples_per_cycle: f64,
    /// Cycles to transfer the bytes at 25.6 GB/s.
    pub bandwidth_cycles: u64,
}

/// Conflict rates in the paper (Sec. "Motivation").
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PaperConflicts {
    /// Mean over algorithms, 16 rays on 16 banks.
    pub rays_16_banks_16_average: f64,
    /// The highest of them.
    pub rays_16_banks_16_most: f64,
    /// Instant-NGP, 64 rays on 16 banks.
    pub rays_64_banks_16_instant_ngp: f64,
}

impl PaperConflicts {
    /// The paper's figures.
    pub const PAPER: Self = Self {
        rays_16_banks_16_average: 0.51,
        rays_16_banks_16_most: 0.83,
        rays_64_banks_16_instant_ngp: 0.80,
    };
}

impl Organisations {
    /// Renders a frame and counts its gathers in the organisations of [`Layout::all`].
    ///
    /// # Errors
    /// The scene cannot be rendered.
    pub fn of(scene: &Scene, config: &Config) -> Result<Self, ExploreError> {
        let clock = accelerator_clock(scene, config)?;
        let ghz = clock.ghz;
        let mut layouts = Layouts::new(Layout::all(config));
        let mut twins = ReferenceUnits::new(config);
        let mut units = Observed::new(&mut twins, config).by(&mut layouts);
        scene.render_fixed(config, &mut units)?;
        let samples = layouts.samples;
        let rows = layouts.layouts.into_iter().map(|layout| OrganisationRow {
            conflict_rate: layout.conflict_rate(),
            conflict_rate_unshared: layout.unshared_rate(),
            lost: layout.lost(),
            samples_per_cycle: samples as f64 / layout.cycles.max(1) as f64,
            bandwidth_cycles: layout.bandwidth_cycles(ghz),
            layout,
        });
        Ok(Self {
            samples,
            clock,
            layouts: rows.collect(),
            paper: PaperConflicts::PAPER,
        })
    }
}
