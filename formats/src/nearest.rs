//! The known name that is nearest to a misspelt one.

/// The name that takes the fewest edits, if a third of its letters or fewer are to be edited.
#[must_use]
pub fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let edits = |known: &str| strsim::levenshtein(&name.to_lowercase(), known);
    let best = names.iter().min_by_key(|known| edits(known))?;
    (edits(best) <= best.len().div_ceil(3)).then_some(*best)
}
