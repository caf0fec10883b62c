//! Sums of addends beside those of integers.

#![allow(clippy::unwrap_used)]

use super::*;
use potamoi_netlist::Interpreter;

/// The sum of the two addends for all values of two inputs.
fn every(
    widths: [u32; 2],
    signed: bool,
    out: u32,
    build: impl Fn(&mut ModuleBuilder, &mut Rows<'_>, Signal, Signal),
    expected: impl Fn(i64, i64) -> i64,
) {
    let mut m = ModuleBuilder::new("adder");
    let ty = |width| Ty { width, signed };
    let (x, y) = (
        m.input("x", ty(widths[0]), ""),
        m.input("y", ty(widths[1]), ""),
    );
    let mut rows = Rows::always("rows", out, &mut m);
    build(&mut m, &mut rows, x, y);
    let [a, b] = rows.two(&mut m);
    let sum = m.add(a, b);
    m.output("sum", sum, "");
    let module = m.finish().unwrap();
    let mut run = Interpreter::new(&module, 1);
    let [x, y, sum] = ["x", "y", "sum"].map(|name| run.port(name).unwrap());
    let mask = (1u64 << out) - 1;
    let value = |code: u64, width: u32| match signed {
        true => (code as i64) << (64 - width) >> (64 - width),
        false => code as i64,
    };
    for i in 0..1 << widths[0] {
        for j in 0..1 << widths[1] {
            run.set_u64(x, i).unwrap();
            run.set_u64(y, j).unwrap();
            run.eval().unwrap();
            let wanted = expected(value(i, widths[0]), value(j, widths[1])) as u64 & mask;
            assert_eq!(run.get_u64(sum).unwrap(), wanted, "{widths:?} {i} {j}");
        }
    }
}

#[test]
fn products_are_those_of_integers() {
    for widths in [[2, 2], [2, 5], [5, 2], [6, 4]] {
        let out = widths[0] + widths[1];
        // Also where high bits fall off.
        for out in [out - 2, out, out + 3] {
            every(
                widths,
                true,
                out,
                |m, r, x, y| r.signed_product(m, x, y),
                |x, y| x * y,
            );
        }
    }
    every(
        [5, 4],
        false,
        14,
        |m, r, x, y| {
            r.minus_product(m, x, y);
            r.shifted(m, x, 6);
        },
        |x, y| 64 * x - x * y,
    );
    every(
        [5, 1],
        false,
        12,
        |m, r, x, y| {
            r.multiple(m, x, &BigInt::from(45));
            r.value(m, y);
            r.constant(&BigInt::from(-3));
        },
        |x, y| 45 * x + y - 3,
    );
}

#[test]
fn squares_are_those_of_integers() {
    for n in 2..=8 {
        for out in [2 * n - 1, 2 * n, 2 * n + 1] {
            every(
                [n, 3],
                true,
                out,
                |m, r, x, y| {
                    r.square(m, x);
                    r.value(m, y);
                },
                |x, y| x * x + y,
            );
        }
    }
}

/// A product, a square, a value or nothing, by what is on.
#[test]
fn alternatives_share_their_rows() {
    let mut m = ModuleBuilder::new("adder");
    let ons = ["product", "square", "value"].map(|name| m.input(name, Ty::bit(), ""));
    let (x, y) = (m.input("x", Ty::s(5), ""), m.input("y", Ty::s(4), ""));
    let mut rows = Rows::new("rows", 12);
    rows.or_if(ons[0]);
    rows.signed_product(&mut m, x, y);
    rows.or_if(ons[1]);
    rows.square(&mut m, x);
    rows.square(&mut m, y);
    rows.or_if(ons[2]);
    let held = rows.only(&mut m, x);
    let held = m.as_signed(held);
    rows.value(&mut m, held);
    let [a, b] = rows.two(&mut m);
    let sum = m.add(a, b);
    m.output("sum", sum, "");
    let module = m.finish().unwrap();
    let mut run = Interpreter::new(&module, 1);
    let [x, y, sum] = ["x", "y", "sum"].map(|name| run.port(name).unwrap());
    let ons = ["product", "square", "value"].map(|name| run.port(name).unwrap());
    for chosen in 0..4 {
        for (at, on) in ons.into_iter().enumerate() {
            run.set_u64(on, u64::from(at == chosen)).unwrap();
        }
        for i in -16i64..16 {
            for j in -8i64..8 {
                run.set_u64(x, i as u64 & 31).unwrap();
                run.set_u64(y, j as u64 & 15).unwrap();
                run.eval().unwrap();
                let wanted = [i * j, i * i + j * j, i, 0][chosen] as u64 & 0xfff;
                assert_eq!(run.get_u64(sum).unwrap(), wanted, "{chosen} {i} {j}");
            }
        }
    }
}
