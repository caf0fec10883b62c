//! Energy, leakage and area of splat units.

use potamoi_cycles::batch::Batch;
use potamoi_formats::config::{Config, SuConfig};
use potamoi_synth::UnitKind;

use super::logic::{Logic, UnitEnergy};
use super::on_chip_memories::{self, Port};
use super::unit_source::{Known, UnitSource};

/// Memories of a splat unit: colours, transmittances and limits, by module.
const COLOURS: &str = "splat_colour";
const TRANSMITTANCES: &str = "splat_transmittance";
const LIMITS: &str = "splat_limit_base";

/// Energy of a splat unit; leakage and area of all of them.
#[derive(Debug, Clone)]
pub(super) struct SplatUnitCosts {
    logic: UnitEnergy,
    colours: Port,
    transmittances: Port,
    limits: Port,
    /// Of logic and memories, in milliwatts.
    pub(super) leakage_mw: f64,
    /// Of logic, in square millimetres.
    pub(super) area_mm2: f64,
}

impl SplatUnitCosts {
    /// No splat unit.
    pub(super) const NONE: Self = {
        let none = Port {
            read_pj: 0.0,
            write_pj: 0.0,
        };
        Self {
            logic: UnitEnergy {
                rest_pj: 0.0,
                work_pj: 0.0,
            },
            colours: none,
            transmittances: none,
            limits: none,
            leakage_mw: 0.0,
            area_mm2: 0.0,
        }
    };

    /// Costs from the unit's own synthesis.
    ///
    /// # Errors
    /// Why they are not known: the unit was not synthesised, or without power or memories.
    pub(super) fn new(config: &Config, su: &SuConfig, known: &Known<'_>) -> Result<Self, String> {
        let unit = UnitKind::Splat;
        let UnitSource::Synthesised(own) = known.source(config, unit) else {
            return Err(
                "no formulas are of it, and it was not synthesised: potamoi --config FILE synth \
                 --activity garden --node 7 --liberty LIBRARY --json F, then --synth F"
                    .to_owned(),
            );
        };
        let logic = Logic::measured(&own.report, unit)
            .ok_or("its parameters lack its power: synth all units, with --activity garden")?;
        let units = f64::from(su.units);
        let memories = on_chip_memories::of_unit(config, known, unit)?;
        let of = |name| -> Result<Port, String> {
            let missing = || format!("no memory {name} in its parameters: synth with CACTI");
            let own = memories.iter().find(|own| own.memory == name);
            own.map(Port::of).ok_or_else(missing)
        };
        let (colours, transmittances) = (of(COLOURS)?, of(TRANSMITTANCES)?);
        let limits = of(LIMITS)?;
        Ok(Self {
            logic: logic.energy,
            colours,
            transmittances,
            limits,
            leakage_mw: units * (logic.leakage_nw * 1e-6 + on_chip_memories::leakage_mw(&memories)),
            area_mm2: units * logic.area_um2 * 1e-6,
        })
    }

    /// Picojoules of the units for a frame's work. A pair that counts reads and writes the transmittance
    /// and the colour of its pixel, a pixel that is returned reads and clears both, and a record reads
    /// its limit. All cycles of jobs are busy.
    pub(super) fn pj(&self, done: &Batch) -> f64 {
        let pixel = [self.colours, self.transmittances];
        let pixel: f64 = pixel.iter().map(|own| own.read_pj + own.write_pj).sum();
        let turns = (done.splat_counted + done.splat_pixels) as f64;
        self.logic.of(done.splat_cycles, done.splat_cycles)
            + turns * pixel
            + done.splat_records as f64 * self.limits.read_pj
    }
}
