//! Files of rows: what is read, and what is refused.
#![allow(clippy::unwrap_used)]

use super::*;

#[test]
fn all_rows_are_read_and_each_has_a_name_of_its_own() {
    let rows = Row::all().unwrap();
    let ids: std::collections::BTreeSet<_> = rows.iter().map(|r| &r.id).collect();
    assert_eq!(ids.len(), rows.len());
    assert!(rows.len() >= 20);
}

#[test]
fn half_and_twice_leave_the_picture_alone() {
    let rows = Row::all().unwrap();
    let row = rows.iter().find(|r| r.id == "a6000-m360-30k").unwrap();
    let (once, twice) = (row.at(At::Mid), row.times(2.0, |_| true));
    assert_eq!(twice["pairs"], 2.0 * once["pairs"]);
    assert_eq!(twice["width"], once["width"]);
    assert_eq!(twice["walked"], 1.0);
    let one = row.times(2.0, |name| name == "pairs");
    assert_eq!(one["gaussians"], once["gaussians"]);
}

#[test]
fn files_are_refused_with_what_to_do() {
    let refused = |text: &str| file::rows(text).unwrap_err().to_string();
    let head = "[set.a]\nsamples = { low = 1, mid = 2, high = 3, source = \"s\" }\n\
                layers = { low = 0, mid = 0, high = 0, source = \"s\" }\n[[row]]\nid = \"r\"\n\
                title = \"t\"\nprogram = \"eager-hash\"\ndevice = \"a6000\"\nsets = [\"a\"]\n";
    assert!(file::rows(head).is_ok());
    let message = refused(&head.replace("sets = [\"a\"]", "sets = [\"b\"]"));
    assert!(message.contains("no set is called `b`"), "{message}");
    let message = refused(&head.replace("mid = 2", "mid = 9"));
    assert!(
        message.contains("has to rise from low to high"),
        "{message}"
    );
    let message = refused(&head.replacen(", source = \"s\"", "", 1));
    assert!(message.contains("needs either a `source`"), "{message}");
    let message = refused(&head.replace("a6000", "a600"));
    assert!(
        message.contains("row `r`") && message.contains("did you mean"),
        "{message}"
    );
    let message = refused(&head.replace("samples =", "sample ="));
    assert!(message.contains("no count `sample`"), "{message}");
}

#[test]
fn measurements_are_read_and_belong_to_rows() {
    let all = Measured::all().unwrap();
    assert!(all.iter().filter(|m| m.judged()).count() >= 12);
    for own in all {
        assert!(own.least <= own.frames_s() && own.frames_s() <= own.most);
    }
    let rows = Row::all().unwrap();
    let text = include_str!("../../rows/measured.toml");
    let refused = |text: &str| file::measured(text, &rows).unwrap_err().to_string();
    let message = refused(&text.replacen("a6000-m360-30k", "a6000-m360", 1));
    assert!(
        message.contains("no row of rows/counts.toml is called `a6000-m360`"),
        "{message}"
    );
    let message = refused(&text.replacen("least = 134", "least = 135", 1));
    assert!(message.contains("135 to 134"), "{message}");
}
