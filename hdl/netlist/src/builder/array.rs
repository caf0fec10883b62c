//! Arrays of instances.

use std::sync::Arc;

use super::ModuleBuilder;
use crate::Module;
use crate::node::{Instance, Op, Signal, Ty};
use crate::repetition::{Array, Fed, Rearranged, Stride};

/// An array of instances of one module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InstanceArray(usize);

/// What an input port of the instances of an array is connected to.
#[derive(Debug, Clone, Copy)]
pub enum Feed<'a> {
    /// The same signal for all of them.
    Shared(Signal),
    /// A vector with a value for each instance, the first lowest; the innermost loop is fastest.
    Each(Signal),
    /// A vector with a value for each turn of some of the loops, by their indices in order; the
    /// outermost loop is 0.
    Along(&'a [usize], Signal),
    /// As `Each`, with values at a distance of so many bits, the first at a lowest bit.
    Strided {
        /// The vector.
        vector: Signal,
        /// Distance of the values in bits.
        stride: u32,
        /// Lowest bit of the first value.
        base: u32,
    },
}

impl ModuleBuilder {
    /// Instances of a module over loops, outermost first, which print as `generate for`.
    /// A loop is its variable and its count.
    pub fn array(
        &mut self,
        name: &str,
        module: &Arc<Module>,
        loops: &[(&str, u32)],
        inputs: &[(&str, Feed<'_>)],
    ) -> InstanceArray {
        if loops.is_empty() || loops.iter().any(|(_, count)| *count == 0) {
            self.fail(
                name,
                "an array needs a loop, and a count of 1 at least".to_owned(),
            );
        }
        let array = Array {
            name: name.to_owned(),
            loops: loops.iter().map(|(v, n)| ((*v).to_owned(), *n)).collect(),
            first: self.module.instances.len(),
            inputs: vec![],
            outputs: vec![],
        };
        let count = array.count();
        for i in 0..count {
            self.instance(&format!("{name}_{i}"), module, &[]);
        }
        let at = self.module.arrays.len();
        self.module.arrays.push(array);
        for (port, info) in module.ports.iter().enumerate() {
            if info.output {
                let vector = self.joined_output(at, port, count, module);
                self.module.arrays[at].outputs.push((port, vector));
            }
        }
        for (port, feed) in inputs {
            self.feed(InstanceArray(at), port, *feed);
        }
        InstanceArray(at)
    }

    /// The vector of all values of an output port, the first lowest.
    fn joined_output(&mut self, at: usize, port: usize, count: usize, module: &Module) -> usize {
        let first = self.module.arrays[at].first;
        let ty = module.nodes[module.ports[port].node].ty;
        let parts: Vec<usize> = (0..count)
            .rev()
            .map(|i| self.node(Op::InstanceOut(first + i, port), ty).id)
            .collect();
        let width = ty.width.saturating_mul(count as u32);
        let vector = self.node(Op::Cat(parts), Ty::u(width));
        let name = format!(
            "{}_{}",
            self.module.arrays[at].name, module.ports[port].name
        );
        self.module.nodes[vector.id].name = Some(name);
        vector.id
    }

    /// Connects an input port of all instances of an array.
    pub fn feed(&mut self, array: InstanceArray, port: &str, feed: Feed<'_>) {
        let own = &self.module.arrays[array.0];
        let (name, first, count) = (own.name.clone(), own.first, own.count());
        let loops: Vec<u32> = own.loops.iter().map(|(_, n)| *n).collect();
        let module = self.module.instances[first].module.clone();
        let found = module
            .ports
            .iter()
            .position(|p| p.name == port && !p.output);
        let Some(index) = found else {
            let of = module.name.clone();
            return self.fail(&name, format!("module {of} has no input `{port}`"));
        };
        let ty = module.nodes[module.ports[index].node].ty;
        let all: Vec<usize> = (0..loops.len()).collect();
        let width = ty.width;
        let (signal, over, stride, base) = match feed {
            Feed::Shared(signal) => (signal, vec![], width, 0),
            Feed::Each(signal) => (signal, all, width, 0),
            Feed::Along(some, signal) => match some.iter().find(|l| **l >= loops.len()) {
                None => (signal, some.to_vec(), width, 0),
                Some(none) => return self.fail(&name, format!("it has no loop {none}")),
            },
            Feed::Strided {
                vector,
                stride,
                base,
            } => (vector, all, stride, base),
        };
        let values: u32 = over.iter().map(|l| loops[*l]).product();
        let reach = stride
            .saturating_mul(values - 1)
            .saturating_add(base + width);
        let right = match (over.is_empty(), feed) {
            (true, _) => signal.ty == ty,
            (_, Feed::Strided { .. }) => !signal.ty.signed && signal.width() >= reach,
            _ => signal.ty == Ty::u(reach),
        };
        if !right {
            let got = self.describe(signal);
            let what = format!("port `{port}` is {ty}, {values} of it are connected to {got}");
            return self.fail(&name, what);
        }
        for i in 0..count {
            let mut own = signal;
            if !over.is_empty() {
                let low = turn(&loops, &over, i as u32) * stride + base;
                let bits = self.slice(signal, low, width);
                own = self.cast(bits, ty.signed);
            }
            self.connect(Instance(first + i), port, own);
        }
        let only = (values == 1 && !over.is_empty()).then(|| {
            let bits = self.slice(signal, base, width);
            self.cast(bits, ty.signed)
        });
        let fed = Fed {
            node: only.unwrap_or(signal).id,
            over: over.into_iter().filter(|l| loops[*l] > 1).collect(),
            stride,
            base,
        };
        self.module.arrays[array.0].inputs.push((index, fed));
    }

    /// A matrix of bits, row by row, with rows and columns exchanged. Rows and columns are given as
    /// loop variable and count; no array may have these variables.
    pub fn transpose(
        &mut self,
        name: &str,
        matrix: Signal,
        rows: (&str, u32),
        columns: (&str, u32),
    ) -> Signal {
        if matrix.ty != Ty::u(rows.1.saturating_mul(columns.1)) {
            let of = self.describe(matrix);
            self.fail(
                name,
                format!("{of} is no matrix of {} x {} bits", rows.1, columns.1),
            );
            return matrix;
        }
        if rows.1 == 1 || columns.1 == 1 {
            return self.name(matrix, name);
        }
        let turn = |(variable, count): (&str, u32), to, from| Stride {
            variable: variable.to_owned(),
            count,
            to,
            from,
        };
        let loops = vec![turn(rows, 1, columns.1), turn(columns, rows.1, 1)];
        let places = (0..columns.1).flat_map(|c| (0..rows.1).map(move |r| columns.1 * r + c));
        self.rearranged(name, matrix, places, loops)
    }

    /// Bits of a vector at a distance, bit 0 the first. They are given as loop variable and count; no
    /// array may have this variable.
    pub fn every(
        &mut self,
        name: &str,
        vector: Signal,
        distance: u32,
        (variable, count): (&str, u32),
    ) -> Signal {
        if count == 0 || distance == 0 || distance.saturating_mul(count - 1) >= vector.width() {
            let of = self.describe(vector);
            self.fail(name, format!("{of} has no {count} bits, {distance} apart"));
            return vector;
        }
        if count == 1 {
            let only = self.bit(vector, 0);
            return self.name(only, name);
        }
        let one = Stride {
            variable: variable.to_owned(),
            count,
            to: 1,
            from: distance,
        };
        let places = (0..count).map(|i| distance * i);
        self.rearranged(name, vector, places, vec![one])
    }

    /// Each bit of a vector several times, as the byte enables of words. The bits are given a loop
    /// variable, which no array may have.
    pub fn spread(&mut self, name: &str, vector: Signal, times: u32, variable: &str) -> Signal {
        let count = vector.width();
        let bits = (0..count).rev().map(|at| {
            let bit = self.bit(vector, at);
            self.repeat(bit, times)
        });
        let bits: Vec<Signal> = bits.collect();
        let node = self.cat(&bits);
        let node = self.name(node, name);
        if count > 1 && times > 1 && !self.fixed[vector.id] {
            let one = Stride {
                variable: variable.to_owned(),
                count,
                to: times,
                from: 1,
            };
            self.module.rearranged.push(Rearranged {
                node: node.id,
                from: vector.id,
                loops: vec![one],
                times,
            });
        }
        node
    }

    /// Bits of a vector, the lowest first, which the text has as loops.
    fn rearranged(
        &mut self,
        name: &str,
        from: Signal,
        places: impl Iterator<Item = u32>,
        loops: Vec<Stride>,
    ) -> Signal {
        let mut bits: Vec<Signal> = places.map(|at| self.bit(from, at)).collect();
        bits.reverse();
        let node = self.cat(&bits);
        self.module.nodes[node.id].name = Some(name.to_owned());
        // Nothing would ever wake a process of constants.
        if !self.fixed[from.id] {
            self.module.rearranged.push(Rearranged {
                node: node.id,
                from: from.id,
                loops,
                times: 1,
            });
        }
        node
    }

    /// All values of an output port as one vector, the first lowest.
    pub fn all_out(&mut self, array: InstanceArray, port: &str) -> Signal {
        let own = &self.module.arrays[array.0];
        let module = &self.module.instances[own.first].module;
        let found = own
            .outputs
            .iter()
            .find(|(p, _)| module.ports[*p].name == port);
        if let Some((_, id)) = found {
            return Signal {
                id: *id,
                ty: self.module.nodes[*id].ty,
            };
        }
        let (name, of) = (own.name.clone(), module.name.clone());
        self.fail(&name, format!("module {of} has no output `{port}`"));
        self.zero(Ty::bit())
    }
}

/// Position of instance `i` in a vector over some of the loops.
fn turn(loops: &[u32], over: &[usize], i: u32) -> u32 {
    let mut rest = i;
    let mut digits = vec![0; loops.len()];
    for (digit, count) in digits.iter_mut().zip(loops).rev() {
        *digit = rest % count;
        rest /= count;
    }
    over.iter().fold(0, |at, l| at * loops[*l] + digits[*l])
}
