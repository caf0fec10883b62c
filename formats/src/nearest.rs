//! The known name that is nearest to a misspelt one.

/// Least likeness of a name that is suggested.
const LEAST: f64 = 0.8;

/// The known name with the largest likeness to a given one (Jaro and Winkler, 0 to 1, in which equal
/// beginnings weigh more), if any is above 0.8; cases count as equal.
#[must_use]
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    let likeness = |name: &str| strsim::jaro_winkler(&given, &name.to_lowercase());
    let all = known.into_iter().map(|name| (likeness(name), name));
    let near = all.filter(|(like, _)| *like > LEAST);
    near.max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn near_names_are_found_and_others_are_not() {
        let names = ["two", "restoring", "e", "garden", "lantern", "cairn"];
        for (given, near) in [
            ("tow", None),
            ("tw", Some("two")),
            ("Restorin", Some("restoring")),
            ("restring", Some("restoring")),
            ("x", None),
            ("literal", None),
            ("gardn", Some("garden")),
            ("Lanten", Some("lantern")),
            ("carin", Some("cairn")),
        ] {
            assert_eq!(nearest(given, names), near, "{given}");
        }
        assert_eq!(nearest("two", []), None);
    }
}
