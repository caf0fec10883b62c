//! Buffer trees.

use serde_json::{Map, Value};

use super::design::{Bit, Instance, Module};
use super::net::{FAN_OUT, LOAD, Net, Sink};
use crate::Library;

/// A buffer of the library.
pub(super) struct Buffer<'a> {
    name: &'a str,
    input: &'a str,
    output: &'a str,
    load: f64,
    strength: f64,
}

/// Buffers, smallest first.
pub(super) fn buffers(library: &Library) -> Vec<Buffer<'_>> {
    let mut found: Vec<(f64, Buffer<'_>)> = library
        .cells
        .iter()
        .filter(|(_, cell)| cell.is_buffer())
        .filter_map(|(name, cell)| {
            let (input, load) = cell.inputs.iter().next()?;
            let output = cell.outputs.keys().next()?;
            let (load, strength) = (*load, LOAD * cell.drive);
            let buffer = Buffer {
                name,
                input,
                output,
                load,
                strength,
            };
            Some((cell.area, buffer))
        })
        .collect();
    found.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.name.cmp(y.name)));
    found.into_iter().map(|(_, buffer)| buffer).collect()
}

pub(super) struct Builder<'a> {
    pub(super) module: &'a mut Module,
    pub(super) buffers: Vec<Buffer<'a>>,
    /// First unused net.
    pub(super) next_net: u64,
    pub(super) added: u64,
}

impl Builder<'_> {
    /// Buffers a net, level by level from its pins. Returns the remaining load of its driver.
    pub(super) fn tree(&mut self, id: u64, net: Net) -> f64 {
        let Net {
            mut sinks,
            strength,
            crosses,
            ..
        } = net;
        let strongest = self.buffers.iter().map(|b| b.strength).fold(0.0, f64::max);
        // Who drives an input port is buffered for it, where it is driven.
        let limit = match strength {
            Some(limit) if crosses && limit > 0.0 => limit,
            _ => f64::INFINITY,
        };
        let total = |sinks: &[Sink]| sinks.iter().map(|s| s.load).sum::<f64>();
        while sinks.len() > FAN_OUT || total(&sinks) > limit {
            let groups = groups(&sinks, strongest);
            let buffers = groups.iter().filter_map(|g| self.choose(total(g)));
            let next: f64 = buffers.map(|at| self.buffers[at].load).sum();
            // As many buffers as pins, and no lighter: nothing is gained.
            if groups.len() == sinks.len() && next >= total(&sinks) {
                break;
            }
            sinks = groups.iter().filter_map(|g| self.insert(id, g)).collect();
        }
        total(&sinks)
    }

    /// The smallest buffer that can drive a load, otherwise the strongest.
    fn choose(&self, load: f64) -> Option<usize> {
        let enough = self.buffers.iter().position(|b| b.strength >= load);
        let by_strength = |a: &usize, b: &usize| {
            self.buffers[*a]
                .strength
                .total_cmp(&self.buffers[*b].strength)
        };
        enough.or_else(|| (0..self.buffers.len()).max_by(by_strength))
    }

    /// Inserts a buffer from `id` to the pins.
    fn insert(&mut self, id: u64, pins: &[Sink]) -> Option<Sink> {
        let at = self.choose(pins.iter().map(|s| s.load).sum())?;
        let buffer = &self.buffers[at];
        let net = self.next_net;
        self.next_net += 1;
        for sink in pins {
            let Some(cell) = &sink.cell else {
                self.module.connect_port(&sink.pin, sink.at, net)?;
                continue;
            };
            let cell = self.module.cells.get_mut(cell)?;
            *cell.connections.get_mut(&sink.pin)?.get_mut(sink.at)? = Bit::Net(net);
        }
        let number = (self.added..).find(|n| !self.module.cells.contains_key(&name(*n)))?;
        let connections = [(buffer.input, id), (buffer.output, net)];
        let connections = connections.map(|(pin, net)| (pin.to_owned(), vec![Bit::Net(net)]));
        let nothing = || Value::Object(Map::new());
        let others = [
            ("hide_name", Value::from(0)),
            ("parameters", nothing()),
            ("attributes", nothing()),
        ];
        let instance = Instance {
            kind: buffer.name.to_owned(),
            connections: connections.into(),
            others: others.map(|(k, v)| (k.to_owned(), v)).into_iter().collect(),
        };
        let sink = Sink {
            cell: Some(name(number)),
            pin: buffer.input.to_owned(),
            at: 0,
            load: buffer.load,
        };
        self.module.cells.insert(name(number), instance);
        self.added += 1;
        Some(sink)
    }
}

fn name(number: u64) -> String {
    format!("fan_out_{number}")
}

/// Groups neighbouring pins, each group within the fan-out and load limits of the strongest buffer,
/// with balanced loads.
fn groups(sinks: &[Sink], strongest: f64) -> Vec<Vec<Sink>> {
    let total: f64 = sinks.iter().map(|s| s.load).sum();
    let by_load = match strongest > 0.0 {
        true => (total / strongest).ceil() as usize,
        false => 1,
    };
    let count = by_load.max(sinks.len().div_ceil(FAN_OUT)).max(1);
    let size = sinks.len().div_ceil(count).max(1);
    sinks.chunks(size).map(<[Sink]>::to_vec).collect()
}
