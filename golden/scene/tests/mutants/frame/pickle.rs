//! Pickles by their operations.

use super::Rng;
use super::zips;
use super::{Files, flat};

/// An operation: its code, and what follows it.
type Operation = (u8, Vec<u8>);

/// The length of an operation's argument.
enum Follows {
    Bytes(usize),
    /// A length of this many bytes, followed by that many bytes.
    Counted(usize),
    /// This many lines.
    Lines(usize),
}

/// Of protocols 0 to 4, what PyTorch and NumPy write.
const fn follows(code: u8) -> Follows {
    match code {
        b'K' | b'q' | b'h' | 0x80 => Follows::Bytes(1),
        b'M' => Follows::Bytes(2),
        b'J' | b'r' | b'j' => Follows::Bytes(4),
        b'G' | 0x95 => Follows::Bytes(8),
        b'U' | b'C' | 0x8a | 0x8c => Follows::Counted(1),
        b'X' | b'B' | b'T' | 0x8b => Follows::Counted(4),
        0x8d | 0x8e => Follows::Counted(8),
        b'c' => Follows::Lines(2),
        b'I' | b'L' | b'F' | b'S' | b'V' | b'g' | b'p' => Follows::Lines(1),
        _ => Follows::Bytes(0),
    }
}

/// The operations up to the stop, and what lies behind it.
fn operations(bytes: &[u8]) -> (Vec<Operation>, &[u8]) {
    let mut found = vec![];
    let mut left = bytes;
    while let Some((code, rest)) = left.split_first() {
        let length = match follows(*code) {
            Follows::Bytes(bytes) => bytes,
            Follows::Counted(width) => {
                let mut all = [0; 8];
                let own = rest.get(..width).unwrap_or_default();
                all[..own.len()].copy_from_slice(own);
                width.saturating_add(u64::from_le_bytes(all) as usize)
            }
            Follows::Lines(lines) => {
                let ends = rest.iter().enumerate().filter(|(_, b)| **b == b'\n');
                ends.map(|(at, _)| at + 1)
                    .nth(lines - 1)
                    .unwrap_or(rest.len())
            }
        };
        let (own, after) = rest.split_at(length.min(rest.len()));
        found.push((*code, own.to_vec()));
        left = after;
        if *code == b'.' {
            break;
        }
    }
    (found, left)
}

/// A mutant of a pickle: mostly of a number, a text or a name of it.
pub(crate) fn mutate(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let (mut all, rest) = operations(bytes);
    for _ in 0..rng.few() {
        let telling: Vec<usize> = (0..all.len())
            .filter(|i| {
                matches!(
                    all[*i].0,
                    b'K' | b'M' | b'J' | b'G' | b'X' | 0x8a | 0x8c | b'c'
                )
            })
            .collect();
        if telling.is_empty() {
            break;
        }
        if rng.one_in(6) {
            let (at, other) = (rng.below(all.len()), rng.below(all.len()));
            match rng.below(5) {
                0 => drop(all.remove(at)),
                1 => all.insert(at, all[other].clone()),
                2 => all.swap(at, other),
                3 => all.truncate(at),
                _ => {
                    let deep = *rng.pick(&[10, 2000, 100_000]);
                    all.splice(at..at, std::iter::repeat_n((b']', vec![]), deep))
                        .for_each(drop);
                }
            }
            continue;
        }
        let at = *rng.pick(&telling);
        let telling: Vec<usize> = telling
            .into_iter()
            .filter(|i| all[*i].0 == all[at].0)
            .collect();
        let other = all[*rng.pick(&telling)].clone();
        all[at] = match rng.below(6) {
            // One key or number in place of another.
            0 => other,
            1 => (b'N', vec![]),
            _ => changed(&all[at], rng),
        };
    }
    let mut out = vec![];
    for (code, follows) in all {
        out.push(code);
        out.extend(follows);
    }
    out.extend(rest);
    out
}

/// The same with another number or text.
fn changed((code, own): &Operation, rng: &mut Rng) -> Operation {
    let number = |bytes: &[u8]| {
        let mut all = [0; 8];
        all[..bytes.len().min(8)].copy_from_slice(&bytes[..bytes.len().min(8)]);
        i64::from_le_bytes(all)
    };
    match code {
        b'K' | b'M' | b'J' | 0x8a => {
            let near = number(if *code == 0x8a { &own[1..] } else { own });
            if rng.one_in(6) {
                let value = rng.float(near as f64);
                return (b'G', value.to_be_bytes().to_vec());
            }
            let value = rng.integer(near.into());
            let mut follows = vec![9];
            follows.extend(&value.to_le_bytes()[..9]);
            (0x8a, follows)
        }
        b'G' => {
            let near = f64::from_bits(number(own).swap_bytes() as u64);
            (b'G', rng.float(near).to_be_bytes().to_vec())
        }
        b'X' | 0x8c => {
            let head = if *code == b'X' { 4 } else { 1 };
            let text = String::from_utf8_lossy(own.get(head..).unwrap_or_default()).into_owned();
            let text = rng.text(&text);
            let mut follows = (text.len() as u32).to_le_bytes().to_vec();
            follows.extend(text.bytes());
            (b'X', follows)
        }
        _ => {
            const NAMES: [&str; 5] = [
                "torch\nDoubleStorage\n",
                "torch\nHalfStorage\n",
                "torch\nLongStorage\n",
                "os\nsystem\n",
                "collections\nOrderedDict\n",
            ];
            (*code, rng.pick(&NAMES).bytes().collect())
        }
    }
}

/// A mutant of what `torch.save` writes: of the pickle, of a storage, or of the members.
pub(crate) fn torch(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut members = zips::members(bytes);
    match rng.below(10) {
        0 => zips::mutate(&mut members, rng),
        1..=4 => storage(&mut members, rng),
        _ => {
            let found = members
                .iter_mut()
                .find(|(name, _)| name.ends_with("data.pkl"));
            let (_, pickle) = found.expect("a pickle");
            *pickle = mutate(pickle, rng);
        }
    }
    zips::packed(&members, zip::CompressionMethod::Stored)
}

fn storage(members: &mut Files, rng: &mut Rng) {
    let storages: Vec<usize> = (0..members.len())
        .filter(|i| members[*i].0.contains("/data/"))
        .collect();
    let bytes = &mut members[*rng.pick(&storages)].1;
    if rng.one_in(4) {
        flat::change(bytes, rng, &[4, 8, 1]);
    } else {
        flat::number(bytes, flat::Kind::Float, rng);
    }
}
