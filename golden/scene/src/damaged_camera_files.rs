//! Damaged camera files for tests: changed bytes and words.

use std::path::Path;

use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::transforms::PathFrame;

/// Words to put in place of a number, a name or a bracket.
const WORDS: [&str; 24] = [
    "0",
    "-0",
    "-1",
    "1",
    "1e-9",
    "1e9",
    "1e300",
    "-1e300",
    "1e999",
    "nan",
    "inf",
    "16385",
    "4294967296",
    "18446744073709551616",
    "null",
    "true",
    "\"a\"",
    "[]",
    "{}",
    "[[",
    "}",
    ",",
    "",
    "\u{e9}\u{1f600}",
];

/// A change to a text.
#[derive(Debug, Clone)]
pub(super) enum Damage {
    Byte(u8),
    Cut,
    /// Replaces a word.
    Word(&'static str),
    /// Replaces a word by one from elsewhere in the text.
    Moved(Index),
    /// Repeats the rest of the text.
    Again,
}

/// One to three damages with their positions.
pub(super) fn damages() -> impl Strategy<Value = Vec<(Index, Damage)>> {
    let damage = prop_oneof![
        2 => any::<u8>().prop_map(Damage::Byte),
        1 => Just(Damage::Cut),
        6 => select(&WORDS[..]).prop_map(Damage::Word),
        2 => any::<Index>().prop_map(Damage::Moved),
        1 => Just(Damage::Again),
    ];
    prop::collection::vec((any::<Index>(), damage), 1..4)
}

/// Ranges of words: runs of characters of numbers and names.
fn words(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let within = |b: u8| b.is_ascii_alphanumeric() || b"+-._/#\"".contains(&b);
    let mut found = vec![];
    let mut from = None;
    for (at, byte) in text.iter().chain(b" ").enumerate() {
        match (from, within(*byte)) {
            (None, true) => from = Some(at),
            (Some(start), false) => {
                found.push(start..at);
                from = None;
            }
            _ => {}
        }
    }
    found
}

/// The text after the damages.
pub(super) fn damaged(text: &[u8], damages: &[(Index, Damage)]) -> Vec<u8> {
    let mut text = text.to_vec();
    for (at, damage) in damages {
        if text.is_empty() {
            break;
        }
        let byte = at.index(text.len());
        let words = words(&text);
        let word = (!words.is_empty()).then(|| words[at.index(words.len())].clone());
        match (damage, word) {
            (Damage::Byte(value), _) => text[byte] = *value,
            (Damage::Cut, _) => text.truncate(byte),
            (Damage::Again, _) => text.extend_from_within(byte..),
            (Damage::Word(other), Some(word)) => drop(text.splice(word, other.bytes())),
            (Damage::Moved(from), Some(word)) => {
                let other = text[words[from.index(words.len())].clone()].to_vec();
                drop(text.splice(word, other));
            }
            (_, None) => {}
        }
    }
    text
}

/// Checks for cameras that can be rendered from, or a one-line error that names the file.
pub(super) fn sound<E: std::fmt::Display>(
    read: Result<Vec<PathFrame>, E>,
    file: &Path,
) -> Result<(), TestCaseError> {
    match read {
        Ok(frames) => {
            prop_assert!(!frames.is_empty());
            for PathFrame { camera, .. } in frames {
                let sides = 1..=32768;
                prop_assert!(sides.contains(&camera.width) && sides.contains(&camera.height));
                let (origin, direction) = camera.ray(camera.width - 1, 0);
                prop_assert!(origin.is_finite(), "{:?}", camera);
                prop_assert!((direction.length() - 1.0).abs() < 1e-6, "{:?}", camera);
            }
        }
        Err(error) => {
            let error = error.to_string();
            let named = error.contains(&file.display().to_string());
            prop_assert!(
                named && !error.contains('\n') && error.len() < 1000,
                "{}",
                error
            );
        }
    }
    Ok(())
}
