//! The reducers, one for each channel and port, and their features.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal};

use super::inputs::Inputs;
use super::issue::Issue;
use super::product_stages::Summed;
use super::shared_rows::one_record;
use super::stage_one::StageOne;
use crate::gathering_unit::parity::cell_reducer::cell_reducer;
use crate::gathering_unit::shared::reducer::reducer;

/// Inputs of a cell's reducer.
const FEATURES: [&str; 8] = [
    "feature0", "feature1", "feature2", "feature3", "feature4", "feature5", "feature6", "feature7",
];
const WEIGHTS: [&str; 8] = [
    "weight0", "weight1", "weight2", "weight3", "weight4", "weight5", "weight6", "weight7",
];

/// The reducers of all ports.
pub(super) struct Reducers<'a> {
    config: &'a Config,
    module: Arc<Module>,
}

impl<'a> Reducers<'a> {
    pub(super) fn of(config: &'a Config) -> Result<Self, IrErrors> {
        let module = if config.is_parity() {
            cell_reducer(config)?
        } else {
            reducer(config)?
        };
        Ok(Self { config, module })
    }

    /// Results of all ports and channels, first lowest.
    pub(super) fn build(
        &self,
        m: &mut ModuleBuilder,
        inputs: &Inputs,
        issue: &Issue,
        s1: &StageOne,
        done: &Summed,
    ) -> Signal {
        let gu = &self.config.gu;
        m.section(match gu.modes {
            Modes::Unstructured => "Features, one register a channel and port",
            _ => "Reducers: one a channel and port",
        });
        let of_ports: Vec<_> = (0..gu.ports)
            .map(|port| self.features(m, inputs, issue, s1, port))
            .collect();
        let mut inputs = enables(s1, done);
        inputs.extend(self.operands(m, &of_ports, s1, done.first));
        let loops = [("port", gu.ports), ("lane", self.config.lanes_a_port())];
        let name = match gu.modes {
            Modes::Unstructured => "held",
            _ => "reduced",
        };
        let all = m.array(name, &self.module, &loops, &inputs);
        let results = m.all_out(all, "result");
        self.in_lanes(m, results)
    }

    /// Results in the stream's lanes of 16 or 32 bits.
    fn in_lanes(&self, m: &mut ModuleBuilder, results: Signal) -> Signal {
        let lane_bits = self.config.feature_lane_bits();
        let count = self.config.gu.ports * self.config.lanes_a_port();
        let bits = results.width() / count;
        if bits == lane_bits {
            return results;
        }
        let lanes: Vec<_> = (0..count)
            .rev()
            .map(|lane| {
                let result = m.slice(results, bits * lane, bits);
                let result = m.as_signed(result);
                let lane = m.extend(result, lane_bits);
                m.as_unsigned(lane)
            })
            .collect();
        m.cat(&lanes)
    }

    /// Features of a port in stage 1; 0 where the row is not loaded.
    fn features(
        &self,
        m: &mut ModuleBuilder,
        inputs: &Inputs,
        issue: &Issue,
        s1: &StageOne,
        port: u32,
    ) -> Signal {
        let groups = self.config.vertices_a_row();
        let bits = self.config.gu.feature_bits * self.config.lanes_a_port();
        let table_out = m.out(issue.table, &format!("feature{port}"));
        let masks: Vec<_> = (0..groups)
            .rev()
            .map(|g| {
                let ok = m.bit(s1.in_range, port * groups + g);
                m.repeat(ok, bits)
            })
            .collect();
        let mask = m.cat(&masks);
        let mut features = m.and(table_out, mask);
        if let (Some(two), Some(upper)) = (inputs.two_records, s1.upper) {
            let upper = m.bit(upper, port);
            features = one_record(m, features, two, upper);
        }
        m.name(features, &format!("s1_features{port}"))
    }

    /// Features and weights, of each group of banks where a cell is read at once.
    fn operands(
        &self,
        m: &mut ModuleBuilder,
        of_ports: &[Signal],
        s1: &StageOne,
        first: Signal,
    ) -> Vec<(&'static str, Feed<'static>)> {
        let gu = &self.config.gu;
        let groups = self.config.vertices_a_row();
        let bits = gu.feature_bits * self.config.lanes_a_port();
        let mut all = vec![];
        for g in 0..groups {
            let (feature, weight) = match groups {
                1 => ("feature", "weight"),
                _ => (FEATURES[g as usize], WEIGHTS[g as usize]),
            };
            let features: Vec<_> = of_ports
                .iter()
                .rev()
                .map(|of_port| m.slice(*of_port, g * bits, bits))
                .collect();
            let features = m.cat(&features);
            all.push((feature, Feed::Each(features)));
            if gu.modes != Modes::Unstructured {
                let weights: Vec<_> = (0..gu.ports)
                    .rev()
                    .map(|port| m.slice(s1.weight, 16 * (port * groups + g), gu.weight_bits + 1))
                    .collect();
                let weights = m.cat(&weights);
                all.push((weight, Feed::Along(&[0], weights)));
            }
        }
        if gu.modes != Modes::Unstructured && !self.config.is_parity() {
            all.push(("first", Feed::Shared(first)));
        }
        all
    }
}

/// Enables of the reducers; each port has its own where ports take turns.
fn enables(s1: &StageOne, done: &Summed) -> Vec<(&'static str, Feed<'static>)> {
    let of_ports = |arrives: Signal| match s1.turns {
        None => Feed::Shared(arrives),
        Some(_) => Feed::Along(&[0], arrives),
    };
    let mut all = vec![("valid", of_ports(s1.turns.unwrap_or(s1.valid)))];
    for &(name, arrives) in &done.enables {
        all.push((name, of_ports(arrives)));
    }
    all
}
