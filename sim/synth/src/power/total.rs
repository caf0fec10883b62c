//! Total power of a unit from measurements of its netlists.

use std::collections::BTreeMap;

use super::compose::{Slice, compose};
use super::count::Energies;
use super::measure::{Measured, Work};
use super::order::Order;
use super::static_data::StaticData;
use super::unavailable::Unavailable;
use crate::UnitKind;
use crate::power_report::{Activity, Figures, ModulePower, PowerReport};

/// A simulated netlist.
pub(super) struct Ran {
    /// Banks or lanes.
    pub(super) size: u64,
    pub(super) still: StaticData,
    /// Weight of each work in the energy.
    pub(super) shares: Vec<f64>,
    /// Measurements of each work, without and with delays.
    pub(super) runs: [Vec<Measured>; 2],
}

impl Order<'_> {
    /// Report from slices, the smaller first, or from the whole unit.
    pub(super) fn report(&self, work: &Work, ran: &[Ran]) -> Result<PowerReport, Unavailable> {
        let nothing = || Unavailable::Absent("nothing was simulated".to_owned());
        let Ran {
            still: largest,
            shares,
            runs,
            ..
        } = ran.last().ok_or_else(nothing)?;
        let last = runs[0].first().ok_or_else(nothing)?;
        let mut ways = vec![];
        for way in 0..2 {
            let of = |pick: fn(&Measured) -> &[Energies]| -> Result<_, Unavailable> {
                let slices = ran.iter().map(|own| {
                    let slice = |m| Slice::new(own.size, &own.still, pick(m));
                    let all: Vec<Slice> = own.runs[way].iter().map(slice).collect();
                    Slice::mean(&all, &own.shares).ok_or_else(nothing)
                });
                self.whole(&slices.collect::<Result<Vec<_>, _>>()?)
            };
            let toggles = runs[way].iter().zip(shares).map(|(m, s)| s * m.toggles);
            let at_work = of(|m| &m.energies)?;
            let at_rest = of(|m| &m.at_rest)?;
            ways.push((at_work, at_rest, toggles.sum()));
        }
        let [zero, glitches] = [&ways[0], &ways[1]];
        let leakage_nw = zero.0.values().map(|(_, leakage)| leakage).sum();
        let reached = self.made.report.clock_ghz;
        let clock_ghz = (self.config.clock_ghz()).map_or(reached, |ghz| ghz.min(reached));
        let figures = |way: &(Whole, Whole, f64)| {
            let sum = |whole: &Whole| {
                let all = whole.values().map(|(energies, _)| *energies);
                all.fold(Energies::default(), Energies::plus).times(1e-3)
            };
            let (at_work, at_rest) = (sum(&way.0), sum(&way.1));
            Figures {
                toggles_a_net: way.2,
                switching_pj_a_cycle: at_work.switching,
                internal_pj_a_cycle: at_work.internal,
                clock_pj_a_cycle: at_work.clock,
                pj_a_cycle: at_work.total(),
                rest_pj_a_cycle: at_rest.total(),
                pj_an_item: at_work.total() * last.cycles as f64 / work.items() as f64,
                mw: at_work.total() * clock_ghz + leakage_nw * 1e-6,
            }
        };
        let report = &self.made.report;
        let modules = report.modules.iter().map(|module| {
            let of = |whole: &Whole| whole.get(&module.module).copied().unwrap_or_default();
            let (energies, leakage_nw) = of(&zero.0);
            ModulePower {
                module: module.module.clone(),
                count: module.count,
                zero_delay_pj_a_cycle: energies.total() * 1e-3,
                with_glitches_pj_a_cycle: of(&glitches.0).0.total() * 1e-3,
                leakage_nw,
            }
        });
        Ok(PowerReport {
            clock_ghz,
            volts: largest.units.volts,
            activity: Activity {
                scene: self.scene.to_owned(),
                work: describe(work),
                simulated: ran.iter().map(|own| self.named(own.size)).collect(),
                cycles: last.cycles,
                busy: last.busy,
                item: self.item().to_owned(),
                items: work.items(),
                channels: channels(work),
            },
            leakage_nw,
            zero_delay: figures(zero),
            with_glitches: figures(glitches),
            modules: modules.collect(),
        })
    }

    /// The whole unit, composed of slices or measured itself.
    fn whole(&self, slices: &[Slice]) -> Result<Whole, Unavailable> {
        let report = &self.made.report;
        match slices {
            [small, large] => {
                let pair = [small.clone(), large.clone()];
                compose(&pair, self.size().into(), &report.modules).map_err(|module| {
                    Unavailable::Absent(format!("its module {module} is in no slice of it"))
                })
            }
            _ => {
                let pieces = slices.iter().flat_map(|slice| &slice.pieces);
                Ok(pieces
                    .map(|(name, piece)| (name.clone(), (piece.energies, piece.leakage)))
                    .collect())
            }
        }
    }

    fn named(&self, size: u64) -> String {
        let name = match self.unit {
            UnitKind::Gathering => "bank",
            UnitKind::Vector => "lane",
            UnitKind::ArrayMac | UnitKind::Splat => "unit",
        };
        let s = if size == 1 { "" } else { "s" };
        format!("{size} {name}{s}")
    }

    const fn item(&self) -> &'static str {
        match self.unit {
            UnitKind::Gathering => "sample",
            UnitKind::Vector => "exponential",
            UnitKind::ArrayMac => "product",
            UnitKind::Splat => "pair",
        }
    }
}

/// Energies in femtojoules a cycle and leakage in nanowatts, by kind of module.
type Whole = BTreeMap<String, (Energies, f64)>;

fn channels(work: &Work) -> u64 {
    match work {
        Work::Gather(window) => window.tasks.first().map_or(0, |t| t.channels as u64),
        Work::Vector(_) | Work::Multiply(_) | Work::Splat(_) => 0,
    }
}

fn describe(work: &Work) -> String {
    match work {
        Work::Gather(window) => {
            let vertices = window.tasks.first().map_or(0, |t| t.vertices.count());
            let channels = channels(work);
            format!(
                "{} entries of {} MVoxels, the largest of the frame, {vertices} vertices each, \
                 {channels} channels",
                window.entries(),
                window.tasks.len()
            )
        }
        Work::Vector(window) => format!(
            "{} operations `{}` in {} runs of the frame",
            window.elements(),
            window.op.map_or("", |op| op.code.name()),
            window.runs.len()
        ),
        Work::Multiply(window) => format!(
            "{} products of the features gathered, in {} channels, by weights drawn from a bell of \
             a quarter of their range",
            window.products(),
            window.runs.len()
        ),
        Work::Splat(window) => format!(
            "{} records in {} tiles, the begin of the longest ray group, and the pixels of these tiles",
            window.entries.len(),
            window.tiles
        ),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::netlist::ModuleArea;
    use crate::power::activity::VectorWindow;
    use crate::power::estimate::Part;
    use crate::power::order::{Extent, Windows};
    use crate::{Library, SynthReport, SynthesisedUnit, Tools, UnitKind, UnitReport};
    use potamoi_formats::config::Config;
    use std::path::Path;

    /// A flip-flop whose `q` drives one inverter in each lane.
    fn netlist(lanes: u64) -> String {
        let mut text = "module lane(a, y);\n input a;\n output y;\n INV i (.A(a), .Y(y));\n\
                        endmodule\nmodule vector_unit(clk, y);\n input clk;\n output y;\n\
                        wire q;\n DFF d (.CK(clk), .D(y), .Q(q));\n"
            .to_owned();
        for lane in 0..lanes {
            let own = if lane == 0 { "y" } else { &*format!("y{lane}") };
            text += &format!(" wire {own};\n lane l{lane} (.a(q), .y({own}));\n");
        }
        text.replace(" wire y;\n", "") + "endmodule\n"
    }

    /// The paper's vector unit with these modules instead of its own, at half a gigahertz.
    fn unit() -> UnitReport {
        let [paper, _] = SynthReport::checked_in().unwrap();
        let mut unit = paper.unit(UnitKind::Vector).unwrap().clone();
        let module = |name: &str, count, flops| ModuleArea {
            module: name.to_owned(),
            count,
            cells: 1,
            flops,
            area_um2: 1.0,
            flop_area_um2: 0.0,
        };
        unit.modules = vec![module("vector_unit", 1, 1), module("lane", 24, 0)];
        unit.clock_ghz = 0.5;
        unit
    }

    /// So many runs of one element for each of `lanes`.
    fn work(runs: usize, lanes: usize) -> Work {
        let run = || [vec![0; lanes], vec![0; lanes], vec![0; lanes]];
        Work::Vector(VectorWindow {
            op: None,
            runs: (0..runs).map(|_| run()).collect(),
        })
    }

    /// For k runs: k fJ a lane without delays and twice that with them, as much for the unit around
    /// the lanes, and internally one femtojoule for each unit of load on `q`.
    fn measured(still: &StaticData, work: &Work, is_delayed: bool) -> Measured {
        let Work::Vector(window) = work else {
            unreachable!("lanes alone")
        };
        let lanes = still.flat.cells.len() - 1;
        let times = if is_delayed { 2 } else { 1 };
        let each = (times * window.runs.len() * lanes) as f64;
        let q = still.flat.named["q"];
        let energies = still.flat.modules.iter().map(|module| Energies {
            switching: each,
            internal: match &*module.name {
                "lane" => 0.0,
                _ => still.far_load(q),
            },
            clock: 0.0,
        });
        Measured {
            energies: energies.collect(),
            at_rest: vec![Energies::default(); still.flat.modules.len()],
            cycles: 10,
            busy: 7,
            toggles: window.runs.len() as f64,
            longest_ps: 0.0,
        }
    }

    /// Lanes scale with their number, single modules along the line through both slices, work by
    /// its weight; loads are the whole unit's; milliwatts are at the reached clock.
    #[test]
    fn a_unit_is_added_up_from_slices_as_by_hand() {
        let cells = Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/handful.lib");
        let library = Library::read(&cells).unwrap();
        let tools = Tools {
            is_pyosys: false,
            yosys: String::new(),
            opensta: String::new(),
        };
        let config = Config::paper();
        assert_eq!((config.vu.lanes, config.clock_mhz), (24, None));
        let made = SynthesisedUnit {
            report: unit(),
            netlist: netlist(24),
            key: String::new(),
            verilog: String::new(),
            instances: BTreeMap::new(),
            is_cached: false,
        };
        let order = Order {
            config: &config,
            unit: UnitKind::Vector,
            library: &library,
            tools: &tools,
            made: &made,
            scene: "garden",
            windows: Windows::default(),
            extent: Extent::Slices,
            step: &|| (),
        };
        let part = |lanes: u64, works: &[(f64, usize)]| Part {
            size: lanes,
            config: config.clone(),
            netlist: netlist(lanes),
            module: order.unit.module(&config).unwrap(),
            works: works.iter().map(|(s, k)| (*s, work(*k, 1))).collect(),
        };
        // Both 2.5 runs on average.
        let parts = [
            part(1, &[(0.25, 1), (0.75, 3)]),
            part(2, &[(0.75, 2), (0.25, 4)]),
        ];
        let run = |still: &StaticData, _: &Config, work: &Work, is_delayed: bool| {
            Ok(measured(still, work, is_delayed))
        };
        let found = order.compute(&work(2, 24), &parts, &run).unwrap();
        // 2.5 x 24 of the lanes and as much of the unit, and 24 inverters of 1 fF each.
        let lanes = 60.0;
        let [zero, glitches] = [&found.zero_delay, &found.with_glitches];
        for (figures, times) in [(zero, 1.0), (glitches, 2.0)] {
            let sum = 1e-3 * (times * 2.0 * lanes + 24.0);
            let near = |found: f64, expected: f64, what: &str| {
                assert!((found / expected - 1.0).abs() < 1e-12, "{what}: {found}");
            };
            near(figures.pj_a_cycle, sum, "sum");
            near(
                figures.internal_pj_a_cycle,
                0.024,
                "by the whole unit's load",
            );
            near(figures.mw, sum * 0.5 + (0.8 + 24.0 * 0.1) * 1e-6, "mW");
            near(figures.pj_an_item, sum * 10.0 / 48.0, "an exponential");
            near(
                figures.toggles_a_net,
                0.75 * 2.0 + 0.25 * 4.0,
                "of the larger",
            );
        }
        assert!((found.clock_ghz - 0.5).abs() < 1e-12);
        let modules = found.modules.iter().map(|m| m.zero_delay_pj_a_cycle * 1e3);
        let modules: Vec<i64> = modules.map(|fj| fj.round() as i64).collect();
        assert_eq!(modules, [84, 60]);
        assert_eq!(found.activity.simulated, ["1 lane", "2 lanes"]);
        assert_eq!((found.activity.busy, found.activity.items), (7, 48));

        // A clock below what is reached is the clock.
        let slow = Config {
            clock_mhz: Some(200),
            ..config.clone()
        };
        let order = Order {
            config: &slow,
            ..order
        };
        let found = order.compute(&work(2, 24), &parts, &run).unwrap();
        let mw = 0.144 * 0.2 + 3.2e-6;
        assert!((found.zero_delay.mw / mw - 1.0).abs() < 1e-12);
    }
}
