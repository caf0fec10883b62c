//! Formulas of one family.

use potamoi_formats::config::Config;
use schemars::JsonSchema;
use serde::Serialize;

use super::estimate::{Estimate, EstimatedModule, Work};
use super::solve::{Addend, Sum, Value};
use super::terms::{FamilyTerms, ModuleTerms, Numbers};
use crate::SynthError;
use crate::grid::{Family, GridModule, GridPoint};

/// All formulas of a family.
#[derive(Debug)]
pub(super) struct Formulas {
    modules: Vec<ModuleFormulas>,
    ends: Vec<(&'static str, Sum)>,
    /// Energy of a flip-flop's clock pin, in picojoules a cycle.
    clock_pj: f64,
}

#[derive(Debug)]
struct ModuleFormulas {
    terms: ModuleTerms,
    area: Sum,
    flops: Sum,
    /// Energy of all instances in a busy cycle above the clock's, with zero delays and with
    /// glitches.
    energy: [Sum; 2],
    /// Leakage in nanowatts a square micrometre.
    leakage_nw: f64,
}

/// A formula for reports.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Formula {
    /// The module, or the end of paths.
    pub of: &'static str,
    /// The figure with its unit.
    pub figure: &'static str,
    /// Terms of the sum.
    pub sum: Vec<Addend>,
}

/// A point, its numbers, and its share of busy cycles.
struct Fitted<'a> {
    point: &'a GridPoint,
    numbers: Numbers,
    busy: f64,
}

impl<'a> Fitted<'a> {
    fn new(point: &'a GridPoint) -> Result<Self, SynthError> {
        let work = Work::of(&point.activity);
        Ok(Self {
            point,
            numbers: Numbers::new(&point.config()?, work.channels),
            busy: work.busy,
        })
    }

    fn module(&self, name: &str) -> Result<&'a GridModule, SynthError> {
        let found = self.point.modules.iter().find(|m| m.module == name);
        found.ok_or_else(|| SynthError::Grid {
            point: self.point.config.replace('\n', "; "),
            why: format!("no module `{name}`"),
        })
    }
}

impl Formulas {
    pub(super) const fn flop_pj(&self) -> f64 {
        self.clock_pj
    }

    pub(super) fn fit(family: Family, points: &[&GridPoint]) -> Result<Self, SynthError> {
        let points = points.iter().map(|point| Fitted::new(point));
        let points: Vec<_> = points.collect::<Result<_, _>>()?;
        let few = |of: &str| SynthError::Grid {
            point: format!("all of {family:?}"),
            why: format!("too few to fit {of} to, or one of them is 0"),
        };
        let clock_pj = mean(points.iter().map(|p| {
            let own = p.point;
            own.activity.clock_pj / own.flops() as f64
        }));
        let terms = FamilyTerms::of(family);
        let mut modules = vec![];
        for own in terms.modules {
            let name = own.module;
            let mut found = vec![];
            for fitted in &points {
                found.push((fitted, fitted.module(name)?));
            }
            let fit = |what, terms, figure: &dyn Fn(&Fitted<'_>, &GridModule) -> [f64; 2]| {
                let values = found.iter().map(|(point, module)| {
                    let [value, of] = figure(point, module);
                    let numbers = point.numbers;
                    Value { numbers, value, of }
                });
                Sum::fit(terms, &values.collect::<Vec<_>>())
                    .ok_or_else(|| few(&format!("{name}'s {what}")))
            };
            let energy = |with_glitches: bool| {
                fit("energy", own.energy, &|point, module| {
                    let energy = module.energy;
                    let all = match with_glitches {
                        true => energy.with_glitches_pj,
                        false => energy.zero_delay_pj,
                    };
                    let clock = clock_pj * (module.count * module.flops) as f64;
                    [(all - clock) / point.busy, all / point.busy]
                })
            };
            let flops = |_: &Fitted<'_>, m: &GridModule| {
                let flops = m.flops as f64;
                [flops, flops.max(1.0)]
            };
            modules.push(ModuleFormulas {
                terms: *own,
                area: fit("area", own.area, &|_, m| [m.area_um2; 2])?,
                flops: fit("flip-flops", own.area, &flops)?,
                energy: [energy(false)?, energy(true)?],
                leakage_nw: mean(found.iter().map(|(_, m)| {
                    let area = m.count as f64 * m.area_um2;
                    m.energy.leakage_nw / area
                })),
            });
        }
        let mut ends = vec![];
        for (end, terms) in terms.ends {
            let found = points.iter().filter_map(|p| {
                let own = p.point.ends.iter().find(|e| e.end == *end)?;
                Some(Value {
                    numbers: p.numbers,
                    value: own.period_ps,
                    of: own.period_ps,
                })
            });
            let sum = Sum::fit(terms, &found.collect::<Vec<_>>());
            ends.push((*end, sum.ok_or_else(|| few(&format!("paths to {end}")))?));
        }
        Ok(Self {
            modules,
            ends,
            clock_pj,
        })
    }

    /// All formulas for reports.
    pub(super) fn written(&self) -> Vec<Formula> {
        let mut found = vec![];
        for own in &self.modules {
            for (figure, sum) in [
                ("um^2 of one", &own.area),
                ("flip-flops of one", &own.flops),
                (
                    "pJ of all, a cycle of work without delays, beyond the clock",
                    &own.energy[0],
                ),
                (
                    "pJ of all, a cycle of work with glitches, beyond the clock",
                    &own.energy[1],
                ),
            ] {
                found.push(Formula {
                    of: own.terms.module,
                    figure,
                    sum: sum.addends(),
                });
            }
        }
        found.extend(self.ends.iter().map(|(end, sum)| Formula {
            of: end,
            figure: "ps of the longest path into it; the period is the largest",
            sum: sum.addends(),
        }));
        let constant = |of, figure, coefficient| Formula {
            of,
            figure,
            sum: vec![Addend {
                term: "1",
                coefficient,
            }],
        };
        found.extend(self.modules.iter().map(|own| {
            let module = own.terms.module;
            constant(module, "nW of leakage of a um^2", own.leakage_nw)
        }));
        found.push(constant(
            "flip-flop",
            "pJ a cycle of its clock pin",
            self.clock_pj,
        ));
        found
    }

    /// Energy of each module in a busy cycle above the clock's, in picojoules, with zero delays and
    /// with glitches, before clamping.
    fn work_pj(&self, numbers: &Numbers) -> Vec<[f64; 2]> {
        let modules = self.modules.iter();
        let of = |own: &ModuleFormulas| [0, 1].map(|i| own.energy[i].at(numbers));
        modules.map(of).collect()
    }

    pub(super) fn at(&self, config: &Config, work: Work) -> Estimate {
        let numbers = Numbers::new(config, work.channels);
        let energies = self.work_pj(&numbers);
        let modules = self.modules.iter().zip(energies).map(|(own, energies)| {
            let count = (own.terms.count)(&numbers);
            let clock = self.clock_pj * own.flops.at(&numbers) * count;
            let area_um2 = own.area.at(&numbers);
            // What is next to nothing may come out below it.
            let work_pj = energies.map(|pj| work.busy * pj.max(0.0));
            let zero_delay_pj = clock + work_pj[0];
            let with_glitches_pj = zero_delay_pj.max(clock + work_pj[1]);
            EstimatedModule {
                module: own.terms.module.to_owned(),
                count: count as u64,
                area_um2,
                leakage_nw: own.leakage_nw * area_um2 * count,
                clock_pj: clock,
                zero_delay_pj,
                with_glitches_pj,
            }
        });
        let ends = self.ends.iter().map(|(end, sum)| (*end, sum.at(&numbers)));
        let (end, period_ps) = ends
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or(("", f64::NAN));
        Estimate::sum(modules.collect(), (end.to_owned(), period_ps), work)
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fit::Fit;

    /// Largest share of its unit's energy by which a module may be negative, or lower with glitches
    /// than without, at a point of the grid: the lane of the smallest pipelined vector unit has 0.0059.
    const NOTHING: f64 = 0.006;

    /// Before clamping at 0.
    #[test]
    fn energies_of_the_grid_are_in_order_as_the_sums_come_out() {
        let fit = Fit::checked_in().unwrap();
        let mut worst: f64 = 0.0;
        for family in Family::ALL {
            for point in fit.grid().of(family) {
                let fitted = Fitted::new(point).unwrap();
                let formulas = &fit.families[&family];
                let found = formulas.work_pj(&fitted.numbers);
                let unit = [0, 1].map(|i| found.iter().map(|pj| pj[i]).sum::<f64>());
                assert!(unit[0] > 0.0 && unit[1] > unit[0], "{}", point.name());
                for (own, [zero, glitches]) in formulas.modules.iter().zip(found) {
                    let below = (-zero).max(zero - glitches) / unit[1];
                    worst = worst.max(below);
                    let module = own.terms.module;
                    assert!(below < NOTHING, "{}: {module}: {below}", point.name());
                }
            }
        }
        eprintln!("at most {worst} of the unit's energy out of order");
    }
}
