//! The known name that is nearest to a misspelt one.

/// The name that takes the fewest edits, if a third of its letters or fewer are to be edited; a name of one
/// letter is near to none.
#[must_use]
pub fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let edits = |known: &str| strsim::levenshtein(&name.to_lowercase(), known);
    let best = names.iter().min_by_key(|known| edits(known))?;
    let count = edits(best);
    (count <= best.len().div_ceil(3) && count < best.len()).then_some(*best)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn near_names_are_found_and_others_are_not() {
        let names = ["two", "restoring", "e"];
        for (given, near) in [
            ("tow", None),
            ("tw", Some("two")),
            ("Restorin", Some("restoring")),
            ("restring", Some("restoring")),
            ("x", None),
            ("literal", None),
        ] {
            assert_eq!(nearest(given, &names), near, "{given}");
        }
        assert_eq!(nearest("two", &[]), None);
    }
}
