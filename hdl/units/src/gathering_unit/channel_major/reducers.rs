//! The reducers, one for each channel and port, and their features.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal};

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
        let mut results = vec![];
        for port in 0..gu.ports {
            let features = self.features(m, inputs, issue, s1, port);
            let groups = self.config.vertices_a_row();
            let weights: Vec<_> = (0..groups)
                .map(|g| m.slice(s1.weight, 16 * (port * groups + g), gu.weight_bits + 1))
                .collect();
            let enables = enables(m, s1, done, port);
            for lane in 0..self.config.lanes_a_port() {
                let features = self.of_lane(m, features, lane);
                let mut inputs = enables.clone();
                inputs.extend(self.operands(&features, &weights, done.first));
                results.push(self.reducer(m, port, lane, &inputs));
            }
        }
        results.reverse();
        m.cat(&results)
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

    /// Feature of a channel, from each group of banks.
    fn of_lane(&self, m: &mut ModuleBuilder, features: Signal, lane: u32) -> Vec<Signal> {
        let (bits, lanes) = (self.config.gu.feature_bits, self.config.lanes_a_port());
        (0..self.config.vertices_a_row())
            .map(|g| {
                let feature = m.slice(features, (g * lanes + lane) * bits, bits);
                m.as_signed(feature)
            })
            .collect()
    }

    fn operands(
        &self,
        features: &[Signal],
        weights: &[Signal],
        first: Signal,
    ) -> Vec<(&'static str, Signal)> {
        if self.config.is_parity() {
            let pairs = features.iter().zip(weights).enumerate();
            return pairs
                .flat_map(|(g, (feature, weight))| [(FEATURES[g], *feature), (WEIGHTS[g], *weight)])
                .collect();
        }
        let mut all = vec![("feature", features[0])];
        if self.config.gu.modes != Modes::Unstructured {
            all.extend([("first", first), ("weight", weights[0])]);
        }
        all
    }

    fn reducer(
        &self,
        m: &mut ModuleBuilder,
        port: u32,
        lane: u32,
        inputs: &[(&str, Signal)],
    ) -> Signal {
        let name = match self.config.gu.modes {
            Modes::Unstructured => format!("register{port}_{lane}"),
            _ => format!("reducer{port}_{lane}"),
        };
        let inst = m.instance(&name, &self.module, inputs);
        let result = m.out(inst, "result");
        let result = m.as_signed(result);
        let lane = m.extend(result, self.config.feature_lane_bits());
        m.as_unsigned(lane)
    }
}

/// Enables of a port's reducers; each port has its own where ports take turns.
fn enables(
    m: &mut ModuleBuilder,
    s1: &StageOne,
    done: &Summed,
    port: u32,
) -> Vec<(&'static str, Signal)> {
    let own = |m: &mut ModuleBuilder, arrives: Signal| match s1.turns {
        None => arrives,
        Some(_) => m.bit(arrives, port),
    };
    let mut all = vec![("valid", own(m, s1.turns.unwrap_or(s1.valid)))];
    for &(name, arrives) in &done.enables {
        all.push((name, own(m, arrives)));
    }
    all
}
