//! Every operator against integers of any size.

use num_bigint::{BigInt, BigUint, Sign};
use potamoi_formats::fixed::Rounding;
use proptest::prelude::*;

use super::super::Interpreter;
use crate::{ModuleBuilder, Signal, Ty};

pub(super) fn value(words: &[u32], ty: Ty) -> BigInt {
    let code = BigInt::from(BigUint::new(words.to_vec()));
    if ty.signed && code.bit(u64::from(ty.width - 1)) {
        code - (BigInt::from(1) << ty.width)
    } else {
        code
    }
}

fn words_of(value: &BigInt, width: u32) -> Vec<u32> {
    let modulus = BigInt::from(1) << width;
    let code: BigInt = ((value % &modulus) + &modulus) % &modulus;
    let mut words = code.magnitude().to_u32_digits();
    words.resize(width.div_ceil(32) as usize, 0);
    words
}

/// One unit of every operator over two operands of one type.
fn every_operator(ty: Ty, amount: Ty, narrow: u32) -> std::sync::Arc<crate::Module> {
    let mut b = ModuleBuilder::new("ops");
    let (x, y, n) = (
        b.input("x", ty, ""),
        b.input("y", ty, ""),
        b.input("n", amount, ""),
    );
    let out = |b: &mut ModuleBuilder, name: &str, s: Signal| b.output(name, s, "");
    type Two = fn(&mut ModuleBuilder, Signal, Signal) -> Signal;
    let two: [(&str, Two); 10] = [
        ("and_", ModuleBuilder::and),
        ("or_", ModuleBuilder::or),
        ("xor_", ModuleBuilder::xor),
        ("add", ModuleBuilder::add),
        ("sub", ModuleBuilder::sub),
        ("mul", ModuleBuilder::mul),
        ("eq", ModuleBuilder::eq),
        ("ne", ModuleBuilder::ne),
        ("lt", ModuleBuilder::lt),
        ("le", ModuleBuilder::le),
    ];
    for (name, op) in two {
        let s = op(&mut b, x, y);
        out(&mut b, name, s);
    }
    type One = fn(&mut ModuleBuilder, Signal) -> Signal;
    let one: [(&str, One); 5] = [
        ("not_", ModuleBuilder::not),
        ("neg", ModuleBuilder::neg),
        ("any", ModuleBuilder::any),
        ("all", ModuleBuilder::all),
        ("parity", ModuleBuilder::parity),
    ];
    for (name, op) in one {
        let s = op(&mut b, x);
        out(&mut b, name, s);
    }
    let s = b.shl(x, n);
    out(&mut b, "shl", s);
    let s = b.shr(x, n);
    out(&mut b, "shr", s);
    let s = b.extend(x, ty.width + 67);
    out(&mut b, "extend", s);
    let s = b.cat(&[x, n, y]);
    out(&mut b, "cat", s);
    let s = b.repeat(x, 3);
    out(&mut b, "repeated", s);
    if ty.width > narrow {
        let s = b.slice(x, ty.width - narrow, narrow);
        out(&mut b, "slice", s);
        for (name, rounding) in ROUNDINGS {
            let s = b.round(x, narrow, rounding);
            out(&mut b, name, s);
        }
    }
    for (name, to) in [("sat_u", Ty::u(narrow)), ("sat_s", Ty::s(narrow))] {
        let s = b.saturate(x, to);
        let s = if s == x { b.not(x) } else { s };
        out(&mut b, name, s);
    }
    b.finish().unwrap()
}

const ROUNDINGS: [(&str, Rounding); 3] = [
    ("floor", Rounding::Floor),
    ("half_up", Rounding::HalfUp),
    ("half_even", Rounding::HalfEven),
];

/// What each output should be, by integer arithmetic.
fn expected(
    name: &str,
    x: &BigInt,
    y: &BigInt,
    n: &BigInt,
    ty: Ty,
    amount: Ty,
    narrow: u32,
) -> Option<BigInt> {
    let unsigned = |v: &BigInt, w: u32| BigInt::from(BigUint::new(words_of(v, w)));
    let ux = unsigned(x, ty.width);
    let by = u32::try_from(n).unwrap_or(u32::MAX).min(ty.width);
    let flag = BigInt::from;
    let rounded = |rounding| {
        let (unit, floor) = (BigInt::from(1) << narrow, x >> narrow);
        let twice: BigInt = (x - (&floor << narrow)) * 2;
        let up = match rounding {
            Rounding::Floor => false,
            Rounding::HalfUp => twice >= unit,
            Rounding::HalfEven => twice > unit || (twice == unit && floor.bit(0)),
        };
        floor + u8::from(up)
    };
    let saturated = |to: Ty| {
        if to == ty {
            !x
        } else {
            x.clone().clamp(to.min(), to.max())
        }
    };
    Some(match name {
        "and_" => x & y,
        "or_" => x | y,
        "xor_" => x ^ y,
        "add" => x + y,
        "sub" => x - y,
        "mul" => x * y,
        "eq" => flag(u8::from(x == y)),
        "ne" => flag(u8::from(x != y)),
        "lt" => flag(u8::from(x < y)),
        "le" => flag(u8::from(x <= y)),
        "not_" => !x,
        "neg" => -x,
        "any" => flag(u8::from(ux != BigInt::ZERO)),
        "all" => flag(u8::from(ux == (BigInt::from(1) << ty.width) - 1)),
        "parity" => flag((ux.magnitude().count_ones() & 1) as u8),
        "shl" => x << by,
        "shr" => x >> by,
        "extend" => x.clone(),
        "cat" => (((ux << amount.width) + n) << ty.width) + unsigned(y, ty.width),
        "repeated" => (&ux << (2 * ty.width)) + (&ux << ty.width) + &ux,
        "slice" => ux >> (ty.width - narrow),
        "floor" => rounded(Rounding::Floor),
        "half_up" => rounded(Rounding::HalfUp),
        "half_even" => rounded(Rounding::HalfEven),
        "sat_u" => saturated(Ty::u(narrow)),
        "sat_s" => saturated(Ty::s(narrow)),
        _ => return None,
    })
}

fn width() -> impl Strategy<Value = u32> {
    prop_oneof![1..=8u32, 31..=34u32, 62..=66u32, 126..=130u32, Just(300)]
}

/// Values with long runs of equal bits, which is where carries and signs go wrong.
fn bits() -> impl Strategy<Value = Vec<u32>> {
    proptest::collection::vec(
        prop_oneof![
            Just(0u32),
            Just(u32::MAX),
            any::<u32>(),
            Just(0x8000_0000),
            Just(1)
        ],
        10,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]
    #[test]
    fn operators_agree_with_integers(
        width in width(), signed: bool, amount_width in prop_oneof![1..=9u32, Just(70)], narrow in width(),
        x in bits(), y in bits(), n in bits(),
    ) {
        let (ty, amount) = (Ty { width, signed }, Ty::u(amount_width));
        let module = every_operator(ty, amount, narrow);
        let mut run = Interpreter::new(&module, 1);
        let take = |raw: &[u32], ty: Ty| value(&words_of(&BigInt::from_biguint(Sign::Plus, BigUint::new(raw.to_vec())), ty.width), ty);
        let (x, y, n) = (take(&x, ty), take(&y, ty), take(&n, amount));
        for (name, v, ty) in [("x", &x, ty), ("y", &y, ty), ("n", &n, amount)] {
            let port = run.port(name).unwrap();
            run.set_words(port, &words_of(v, ty.width)).unwrap();
        }
        run.eval().unwrap();
        for port in module.ports().iter().filter(|p| p.output) {
            let handle = run.port(&port.name).unwrap();
            let want = expected(&port.name, &x, &y, &n, ty, amount, narrow).unwrap();
            prop_assert_eq!(
                run.words(handle).unwrap(), words_of(&want, port.ty.width),
                "{} of {} {} {} ({}, narrow {})", port.name, x, y, n, ty, narrow
            );
        }
    }
}
