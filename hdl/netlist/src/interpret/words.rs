//! Multi-word arithmetic, low word first, zero above the width.

/// Number of words for `width` bits.
pub(super) const fn count(width: u32) -> usize {
    width.div_ceil(64) as usize
}

/// Ones in the low `width` bits, 64 at most.
pub(super) const fn mask(width: u32) -> u64 {
    if width >= 64 {
        u64::MAX
    } else {
        (1 << width) - 1
    }
}

/// Clears the bits above `width`.
pub(super) fn trim(out: &mut [u64], width: u32) {
    if let Some(last) = out.last_mut() {
        *last &= mask(width - 64 * (count(width) as u32 - 1));
    }
}

pub(super) fn bit(a: &[u64], at: u32) -> bool {
    a[(at / 64) as usize] >> (at % 64) & 1 == 1
}

pub(super) fn set(a: &mut [u64], at: u32) {
    a[(at / 64) as usize] |= 1 << (at % 64);
}

pub(super) fn clear(a: &mut [u64], at: u32) {
    a[(at / 64) as usize] &= !(1 << (at % 64));
}

/// Whether the top bit is set and counts as a sign.
pub(super) fn negative(a: &[u64], width: u32, signed: bool) -> bool {
    signed && bit(a, width - 1)
}

/// The 64 bits from bit `at` on; bits past the width are `fill`.
fn bits_at(a: &[u64], width: u32, fill: u64, at: u32) -> u64 {
    let word = |i: u32| {
        let low = i * 64;
        if low >= width {
            fill
        } else if width - low < 64 {
            a[i as usize] | fill << (width - low)
        } else {
            a[i as usize]
        }
    };
    let (i, shift) = (at / 64, at % 64);
    if shift == 0 {
        word(i)
    } else {
        word(i) >> shift | word(i + 1) << (64 - shift)
    }
}

/// `out = a >> low`, of `out_width` bits, with the sign or zeros above `a`.
pub(super) fn extract(
    out: &mut [u64],
    out_width: u32,
    a: &[u64],
    width: u32,
    signed: bool,
    low: u32,
) {
    let fill = if negative(a, width, signed) {
        u64::MAX
    } else {
        0
    };
    for (i, o) in out.iter_mut().enumerate() {
        *o = bits_at(a, width, fill, low + 64 * i as u32);
    }
    trim(out, out_width);
}

/// Ors `a` into `out` at bit `at`; bits past the end are lost.
pub(super) fn deposit(out: &mut [u64], a: &[u64], at: u32) {
    let (first, shift) = ((at / 64) as usize, at % 64);
    for (i, word) in a.iter().enumerate() {
        if let Some(o) = out.get_mut(first + i) {
            *o |= word << shift;
        }
        if shift > 0
            && let Some(o) = out.get_mut(first + i + 1)
        {
            *o |= word >> (64 - shift);
        }
    }
}

/// Each word with a mask of its bits from `low` up to the width.
fn from(a: &[u64], width: u32, low: u32) -> impl Iterator<Item = (u64, u64)> {
    (low / 64..width.div_ceil(64)).map(move |i| {
        let skip = if i == low / 64 { low % 64 } else { 0 };
        (a[i as usize], mask(width - 64 * i) >> skip << skip)
    })
}

/// Whether any bit at `low` or above is set, within the width.
pub(super) fn any_from(a: &[u64], width: u32, low: u32) -> bool {
    from(a, width, low).any(|(word, mask)| word & mask != 0)
}

/// Whether all bits at `low` and above are set, within the width.
pub(super) fn all_from(a: &[u64], width: u32, low: u32) -> bool {
    from(a, width, low).all(|(word, mask)| word & mask == mask)
}

/// `out = a + b`, not trimmed.
pub(super) fn add(out: &mut [u64], a: &[u64], b: &[u64]) {
    let mut carry = false;
    for (o, (x, y)) in out.iter_mut().zip(a.iter().zip(b)) {
        let (sum, over) = x.overflowing_add(*y);
        let (sum, more) = sum.overflowing_add(u64::from(carry));
        *o = sum;
        carry = over || more;
    }
}

/// `out = a - b`, not trimmed.
pub(super) fn sub(out: &mut [u64], a: &[u64], b: &[u64]) {
    let mut borrow = false;
    for (o, (x, y)) in out.iter_mut().zip(a.iter().zip(b)) {
        let (rest, under) = x.overflowing_sub(*y);
        let (rest, more) = rest.overflowing_sub(u64::from(borrow));
        *o = rest;
        borrow = under || more;
    }
}

/// `out += 1`, not trimmed.
pub(super) fn increment(out: &mut [u64]) {
    for o in out {
        let (sum, carry) = o.overflowing_add(1);
        *o = sum;
        if !carry {
            return;
        }
    }
}

/// `out -= b << at`, not trimmed.
fn sub_at(out: &mut [u64], b: &[u64], at: u32) {
    let mut shifted = vec![0; out.len()];
    deposit(&mut shifted, b, at);
    let minuend = out.to_vec();
    sub(out, &minuend, &shifted);
}

/// The full product of the operands' widths.
pub(super) fn mul(out: &mut [u64], (a, wa): (&[u64], u32), (b, wb): (&[u64], u32), signed: bool) {
    out.fill(0);
    for (i, x) in a.iter().enumerate() {
        let mut carry = 0u128;
        for (j, y) in b.iter().enumerate() {
            let Some(o) = out.get_mut(i + j) else { break };
            carry += u128::from(*x) * u128::from(*y) + u128::from(*o);
            *o = carry as u64;
            carry >>= 64;
        }
        if let Some(o) = out.get_mut(i + b.len()) {
            *o = carry as u64;
        }
    }
    // A set sign bit was counted as +2^(w-1) instead of -2^(w-1).
    if negative(a, wa, signed) {
        sub_at(out, b, wa);
    }
    if negative(b, wb, signed) {
        sub_at(out, a, wb);
    }
    trim(out, wa + wb);
}

/// Compares two values of one type.
pub(super) fn compare(a: &[u64], b: &[u64], width: u32, signed: bool) -> std::cmp::Ordering {
    let signs = negative(b, width, signed).cmp(&negative(a, width, signed));
    signs.then_with(|| a.iter().rev().cmp(b.iter().rev()))
}

/// A shift amount, at most `limit`.
pub(super) fn amount(a: &[u64], limit: u32) -> u32 {
    if a[1..].iter().any(|w| *w != 0) {
        limit
    } else {
        a[0].min(u64::from(limit)) as u32
    }
}
