//! Random modules: acyclic nodes of every kind on odd widths, registers and
//! memories that close loops, and instances of smaller random modules.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_netlist::{Feed, MemId, Module, ModuleBuilder, Signal, Ty};

use super::every_kind::WIDTHS;
use super::kinds::KINDS;
use crate::choices::Random;

/// Rows of the deepest memory.
pub(crate) const ROWS: u32 = 32;
/// Bits of the deepest memory's address.
const ROW_BITS: u32 = ROWS.ilog2();
struct Memory {
    id: MemId,
    depth: u32,
    width: u32,
}

/// Ports by which a bench fills every memory while the registers are in reset.
#[derive(Clone, Copy)]
struct Load {
    on: Signal,
    row: Signal,
    data: Signal,
}

/// As [`Feed`], with its own loops.
enum Fed {
    Shared(Signal),
    Each(Signal),
    Along(Vec<usize>, Signal),
    Strided(Signal, u32, u32),
}

impl Fed {
    fn feed(&self) -> Feed<'_> {
        match self {
            Self::Shared(s) => Feed::Shared(*s),
            Self::Each(s) => Feed::Each(*s),
            Self::Along(over, s) => Feed::Along(over, *s),
            Self::Strided(vector, stride, base) => Feed::Strided {
                vector: *vector,
                stride: *stride,
                base: *base,
            },
        }
    }
}

pub(crate) struct Grower {
    pub(crate) m: ModuleBuilder,
    pub(crate) r: Random,
    /// Values so far, and whether something reads them.
    pool: Vec<(Signal, bool)>,
    memories: Vec<Memory>,
    children: Vec<Arc<Module>>,
    load: Option<Load>,
    /// Numbers for names.
    named: u32,
}

/// The random module of a seed.
pub(crate) fn module(name: &str, seed: u64) -> Arc<Module> {
    let mut r = Random::new(seed);
    let children = (0..r.below(3))
        .map(|i| small(&format!("{name}_part{i}"), r.next(), vec![]))
        .collect();
    small(name, seed, children)
}

fn small(name: &str, seed: u64, children: Vec<Arc<Module>>) -> Arc<Module> {
    let mut g = Grower {
        m: ModuleBuilder::new(name),
        r: Random::new(!seed),
        pool: vec![],
        memories: vec![],
        children,
        load: None,
        named: 0,
    };
    g.m.doc(&format!("the random netlist of seed {seed}"));
    g.sources();
    let regs: Vec<_> = (0..g.r.below(4)).map(|_| g.register()).collect();
    let steps = 12 + g.r.below(28);
    for step in 0..steps {
        if step % 16 == 9 {
            g.m.section(&format!("Part {}", step / 16 + 1));
        }
        let kind = g.r.pick(&KINDS);
        if let Some(s) = g.step(kind) {
            g.add(s);
        }
    }
    for reg in regs {
        let value = g.any_as(reg.ty());
        if g.r.chance(50) {
            let enable = g.any_as(Ty::bit());
            g.m.set_next_if(reg, enable, value);
        } else {
            g.m.set_next(reg, value);
        }
    }
    g.writes();
    g.finish()
}

impl Grower {
    fn add(&mut self, s: Signal) {
        if self.r.chance(12) {
            self.m.note(s, "what the author said of it");
        }
        self.pool.push((s, false));
    }

    pub(crate) fn width(&mut self) -> u32 {
        let most = if self.r.chance(75) { 9 } else { WIDTHS.len() };
        WIDTHS[self.r.below(most)]
    }

    pub(crate) fn ty(&mut self) -> Ty {
        Ty {
            width: self.width(),
            signed: self.r.chance(50),
        }
    }

    pub(crate) fn fresh(&mut self, what: &str) -> String {
        self.named += 1;
        format!("{what}_{}", self.named)
    }

    fn sources(&mut self) {
        let loads = self
            .children
            .iter()
            .any(|c| c.ports().iter().any(|p| p.name == "load"));
        let memories = self.r.below(3);
        if loads || memories > 0 {
            self.load = Some(Load {
                on: self.m.input("load", Ty::bit(), "fills the memories"),
                row: self.m.input("load_row", Ty::u(ROW_BITS), ""),
                data: self.m.input("load_data", Ty::u(64), ""),
            });
        }
        for i in 0..2 + self.r.below(4) {
            let ty = self.ty();
            let s = self.m.input(&format!("in{i}"), ty, "any value");
            // Chance may leave it unread.
            self.m.unused(s, "");
            self.pool.push((s, false));
        }
        if self.r.chance(30) {
            let ty = self.ty();
            let spare = self.m.input("spare", ty, "");
            self.m.unused(spare, "kept for a later use");
        }
        for _ in 0..memories {
            let name = self.fresh("rows");
            let depth = self.r.pick(&[2, 3, 4, 5, 16, 17, 31, ROWS]);
            let width = WIDTHS[self.r.below(12)];
            let id = self.m.memory(&name, depth, width, "a memory");
            self.memories.push(Memory { id, depth, width });
        }
    }

    fn register(&mut self) -> Signal {
        let name = self.fresh("state");
        let ty = self.ty();
        let reset = match self.r.below(3) {
            0 => BigInt::ZERO,
            1 => ty.min(),
            _ => ty.max(),
        };
        let reg = self.m.reg(&name, ty, reset);
        self.pool.push((reg, false));
        reg
    }

    /// A value, the later ones more often.
    pub(crate) fn any(&mut self) -> Signal {
        let from = if self.r.chance(50) {
            self.pool.len().saturating_sub(6)
        } else {
            0
        };
        let at = from + self.r.below(self.pool.len() - from);
        self.pool[at].1 = true;
        self.pool[at].0
    }

    pub(crate) fn fit(&mut self, s: Signal, ty: Ty) -> Signal {
        let sized = if s.width() < ty.width {
            self.m.extend(s, ty.width)
        } else {
            self.m.truncate(s, ty.width)
        };
        if ty.signed {
            self.m.as_signed(sized)
        } else {
            self.m.as_unsigned(sized)
        }
    }

    pub(crate) fn any_as(&mut self, ty: Ty) -> Signal {
        let s = self.any();
        self.fit(s, ty)
    }

    /// Two values of one type.
    pub(crate) fn pair(&mut self) -> (Signal, Signal) {
        let a = self.any();
        let b = self.any_as(a.ty());
        (a, b)
    }

    pub(crate) fn up_to(&mut self, most: u32) -> u32 {
        self.r.below(most as usize + 1) as u32
    }

    pub(crate) fn constant(&mut self) -> (BigInt, Ty) {
        let ty = self.ty();
        let code = BigInt::from(num_bigint::BigUint::new(self.r.edge_value(ty.width)));
        (
            if code > ty.max() {
                code - (BigInt::from(1) << ty.width)
            } else {
                code
            },
            ty,
        )
    }

    /// An address below the depth, which is all that memories promise to hold,
    /// and the loader's row while it is at work.
    fn address(&mut self, depth: u32) -> Signal {
        let ty = Ty::u((depth - 1).ilog2() + 1);
        let free = self.any_as(ty);
        let row = self.load.map(|l| (l.on, self.fit(l.row, ty)));
        let wanted = match row {
            Some((on, row)) => self.m.mux(on, row, free),
            None => free,
        };
        if depth.is_power_of_two() {
            return wanted;
        }
        let last = self.m.lit(depth - 1, ty);
        let inside = self.m.le(wanted, last);
        self.m.mux(inside, wanted, last)
    }

    pub(crate) fn read(&mut self, clocked: bool) -> Option<Signal> {
        if self.memories.is_empty() {
            return None;
        }
        let at = self.r.below(self.memories.len());
        let (id, depth) = (self.memories[at].id, self.memories[at].depth);
        let address = self.address(depth);
        if !clocked {
            return Some(self.m.mem_read_async(id, address));
        }
        let enable = self.any_as(Ty::bit());
        let enable = match self.load {
            Some(l) => self.m.or(enable, l.on),
            None => enable,
        };
        let name = self.fresh("read");
        Some(self.m.mem_read(id, enable, address, &name))
    }

    /// One or two writers a memory; only the first one writes while it is filled.
    fn writes(&mut self) {
        let Some(load) = self.load else { return };
        for at in 0..self.memories.len() {
            let (id, depth, width) = (
                self.memories[at].id,
                self.memories[at].depth,
                self.memories[at].width,
            );
            for port in 0..1 + self.r.below(2) {
                let (enable, data) = (self.any_as(Ty::bit()), self.any_as(Ty::u(width)));
                let (enable, data) = if port == 0 {
                    let copies = self.m.repeat(load.data, width.div_ceil(64));
                    let fill = self.fit(copies, Ty::u(width));
                    (self.m.or(enable, load.on), self.m.mux(load.on, fill, data))
                } else {
                    let quiet = self.m.not(load.on);
                    (self.m.and(enable, quiet), data)
                };
                let address = self.address(depth);
                self.m.mem_write(id, enable, address, data);
            }
        }
    }

    pub(crate) fn instance(&mut self) -> Option<Signal> {
        if self.children.is_empty() {
            return None;
        }
        let at = self.r.below(self.children.len());
        let child = self.children[at].clone();
        let name = self.fresh("part");
        let (mut inputs, mut outputs) = (vec![], vec![]);
        for port in child.ports() {
            if port.output {
                outputs.push(port.name);
                continue;
            }
            let given = match (self.load, port.name.as_str()) {
                (Some(l), "load") => l.on,
                (Some(l), "load_row") => l.row,
                (Some(l), "load_data") => l.data,
                _ => self.moving(port.ty),
            };
            inputs.push((port.name, given));
        }
        let inputs: Vec<_> = inputs.iter().map(|(n, s)| (n.as_str(), *s)).collect();
        let instance = self.m.instance(&name, &child, &inputs);
        for port in outputs {
            // Some outputs stay open.
            if !self.r.chance(15) {
                let s = self.m.out(instance, &port);
                self.add(s);
            }
        }
        None
    }

    /// An array over one to three loops, each input shared, along some loops, or at a distance.
    pub(crate) fn array(&mut self) -> Option<Signal> {
        if self.children.is_empty() {
            return None;
        }
        let at = self.r.below(self.children.len());
        let child = self.children[at].clone();
        let name = self.fresh("row");
        let counts: Vec<u32> = (0..=self.up_to(2)).map(|_| 1 + self.up_to(2)).collect();
        let variables: Vec<String> = (0..counts.len()).map(|_| self.fresh("i")).collect();
        let loops: Vec<(&str, u32)> = variables.iter().map(|v| &**v).zip(counts.clone()).collect();
        let all: u32 = counts.iter().product();
        let ports = child.ports();
        let mut inputs: Vec<(&str, Fed)> = vec![];
        for port in ports.iter().filter(|port| !port.output) {
            let given = match (self.load, port.name.as_str()) {
                (Some(l), "load") => Fed::Shared(l.on),
                (Some(l), "load_row") => Fed::Shared(l.row),
                (Some(l), "load_data") => Fed::Shared(l.data),
                _ => self.fed(port.ty, &counts, all),
            };
            inputs.push((&port.name, given));
        }
        let feeds: Vec<(&str, Feed<'_>)> = inputs.iter().map(|(n, fed)| (*n, fed.feed())).collect();
        let array = self.m.array(&name, &child, &loops, &feeds);
        for port in ports.iter().filter(|port| port.output) {
            if !self.r.chance(15) {
                let s = self.m.all_out(array, &port.name);
                self.add(s);
            }
        }
        None
    }

    /// A value that is no constant: Verilator 5.006 misfolds signed comparisons in a module that has
    /// an input tied to one.
    fn moving(&mut self, ty: Ty) -> Signal {
        let given = self.any_as(ty);
        let first = self.pool[0].0;
        let moving = self.fit(first, ty);
        // Of a wide vector, every part moves.
        let copies = ty.width.div_ceil(first.width());
        let moving = match copies {
            0 | 1 => moving,
            _ => {
                let all = self.m.repeat(first, copies);
                self.fit(all, ty)
            }
        };
        self.m.xor(given, moving)
    }

    /// What feeds a port of all instances.
    fn fed(&mut self, ty: Ty, counts: &[u32], all: u32) -> Fed {
        match self.r.below(4) {
            0 => Fed::Shared(self.moving(ty)),
            1 => Fed::Each(self.moving(Ty::u(ty.width * all))),
            2 => {
                let over: Vec<usize> = (0..counts.len()).filter(|_| self.r.chance(50)).collect();
                if over.is_empty() {
                    return Fed::Shared(self.moving(ty));
                }
                let values: u32 = over.iter().map(|l| counts[*l]).product();
                Fed::Along(over, self.moving(Ty::u(ty.width * values)))
            }
            _ => {
                let (base, more) = (self.up_to(5), self.up_to(3));
                let stride = ty.width + more;
                let width = stride * (all - 1) + base + ty.width + self.up_to(2);
                Fed::Strided(self.moving(Ty::u(width)), stride, base)
            }
        }
    }

    /// Shows every value that nothing reads, and a few that something does.
    fn finish(mut self) -> Arc<Module> {
        if let Some(load) = self.load {
            let bits = [load.on, self.m.any(load.row), self.m.any(load.data)];
            let read = self.m.any_of(&bits);
            self.m.output("loading", read, "");
        }
        for i in 0..self.pool.len() {
            let (s, read) = self.pool[i];
            if !read || self.r.chance(10) {
                self.m.output(&format!("out{i}"), s, "");
            }
        }
        self.m
            .finish()
            .unwrap_or_else(|e| panic!("a random netlist is refused:\n{e}"))
    }
}
