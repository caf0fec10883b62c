//! Memories and instances.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::generate::Making;

impl Making<'_> {
    /// A memory whose rows are all written while `init` is set, read within
    /// its depth, of this data.
    pub(super) fn memory(&mut self, sync: bool, data: Signal) -> Signal {
        let depth = 2 + self.random.below(7) as u32;
        let bits = (depth - 1).ilog2() + 1;
        let name = self.fresh("rows");
        let mem = self.b.memory(&name, depth, data.width(), "");
        let (init, row) = (
            self.input("init", Ty::bit()),
            self.input("init_row", Ty::u(3)),
        );
        let data = self.b.as_unsigned(data);
        let fixed = self.input(
            &format!("in_{}_0", Ty::u(data.width())),
            Ty::u(data.width()),
        );
        let mut data = self.b.mux(init, fixed, data);
        for _ in 0..=self.random.below(2) {
            let addr = self.address(init, row, depth, bits);
            let en = self.bit();
            let en = self.b.or(init, en);
            self.b.mem_write(mem, en, addr, data);
            // Two writes to one row are told apart.
            data = self.b.not(data);
        }
        let addr = self.address(init, row, depth, bits);
        if sync {
            let en = self.bit();
            let en = self.b.or(init, en);
            let name = self.fresh("read");
            self.b.mem_read(mem, en, addr, &name)
        } else {
            self.b.mem_read_async(mem, addr)
        }
    }

    fn address(&mut self, init: Signal, row: Signal, depth: u32, bits: u32) -> Signal {
        let any = self.input("amount_3", Ty::u(3));
        let turn = self.bit();
        let turn = self.b.extend(turn, 3);
        let any = self.b.add(any, turn);
        let addr = self.b.mux(init, row, any);
        let last = self.b.lit(depth - 1, Ty::u(3));
        let past = self.b.gt(addr, last);
        let none = self.b.lit(0, Ty::u(3));
        let addr = self.b.mux(past, none, addr);
        self.b.truncate(addr, bits)
    }

    /// An instance of a small module of its own, with a way through it and a
    /// register.
    pub(super) fn instance(&mut self, a: Signal) -> Signal {
        let name = self.fresh("below");
        let mut inner = ModuleBuilder::new(&format!("inner_{}_{:x}", a.ty(), self.random.next()));
        let (x, y) = (inner.input("x", a.ty(), ""), inner.input("y", a.ty(), ""));
        let kept = inner.reg("kept", a.ty(), 0);
        let sum = inner.add(x, kept);
        inner.set_next(kept, y);
        inner.output("sum", sum, "");
        inner.output("old", kept, "");
        let inner = inner.finish().unwrap();
        let late = self.random.flip();
        let inst = if late {
            self.b.instance(&name, &inner, &[("x", a)])
        } else {
            let y = self.value(a.ty());
            self.b.instance(&name, &inner, &[("y", y), ("x", a)])
        };
        let (sum, old) = (self.b.out(inst, "sum"), self.b.out(inst, "old"));
        self.values.push(old);
        if late {
            // What follows from an output comes back in.
            let back = self.b.xor(sum, a);
            self.b.connect(inst, "y", back);
        }
        sum
    }
}
