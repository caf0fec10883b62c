#![allow(clippy::unwrap_used)]

use serde::Deserialize;

use super::*;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Plain,
    Sized { side: u8 },
}

/// No `deny_unknown_fields` anywhere: the document refuses them.
#[derive(Debug, PartialEq, Deserialize)]
struct Inner {
    pair: [f32; 2],
}

#[derive(Debug, PartialEq, Deserialize)]
struct Outer {
    width: u32,
    #[serde(default)]
    rows: Vec<Inner>,
    name: Option<String>,
    kind: Option<Kind>,
    flag: Option<bool>,
}

fn of_json(text: &str) -> Result<Outer, String> {
    let value = json(text.as_bytes()).map_err(|e| e.to_string())?;
    value.read().map_err(|e| e.to_string())
}

fn of_toml_text(text: &str) -> Result<Outer, String> {
    let value = toml(text.as_bytes()).map_err(|e| e.to_string())?;
    value.read().map_err(|e| e.to_string())
}

#[test]
fn numbers_are_read_however_they_are_written() {
    for text in ["640", "640.0", "6.4e2", "64e1"] {
        assert_eq!(
            of_json(&format!("{{\"width\": {text}}}")).unwrap().width,
            640
        );
        assert_eq!(of_toml_text(&format!("width = {text}")).unwrap().width, 640);
    }
    let pair = of_json(r#"{"width": 1, "rows": [{"pair": [1, 2.5]}]}"#).unwrap();
    assert_eq!(pair.rows[0].pair, [1.0, 2.5]);
    const MOST: &str = ", 4294967295 at most";
    for (text, found, more) in [
        ("640.5", "640.5", ""),
        ("-1", "-1", ", 0 or more"),
        ("4294967296", "4294967296", MOST),
        ("18446744073709551615", "18446744073709551615", MOST),
        ("99999999999999999999", "1e20", MOST),
        ("\"640\"", "\"640\"", ", without quotation marks"),
        ("true", "true", ""),
        ("[1]", "[1]", ""),
    ] {
        let expected = format!("field `width`: found {found}, expected a whole number{more}");
        let error = of_json(&format!("{{\"width\": {text}}}")).unwrap_err();
        assert_eq!(error, expected);
    }
}

#[test]
fn lists_have_exactly_as_many_values_as_places() {
    for (values, found) in [("[1, 2, 3]", 3), ("[1]", 1), ("[]", 0)] {
        let expected = format!("field `rows[0].pair`: found {found} values, expected 2");
        let text = format!(r#"{{"width": 1, "rows": [{{"pair": {values}}}]}}"#);
        assert_eq!(of_json(&text).unwrap_err(), expected);
        let text = format!("width = 1\n[[rows]]\npair = {values}\n");
        assert_eq!(of_toml_text(&text).unwrap_err(), expected);
    }
    let far = of_json(r#"{"width": 1, "rows": [{"pair": [1e300, 0]}]}"#).unwrap_err();
    assert!(
        far.contains("rows[0].pair[0]") && far.contains("3.4e38"),
        "{far}"
    );
}

#[test]
fn keys_that_a_type_does_not_have_are_refused_at_every_depth() {
    for (text, field) in [
        (r#"{"width": 1, "hight": 2}"#, "hight"),
        (
            r#"{"width": 1, "rows": [{"pair": [1, 2], "more": 3}]}"#,
            "rows[0].more",
        ),
        (
            r#"{"width": 1, "kind": {"sized": {"side": 1, "depth": 2}}}"#,
            "kind.sized.depth",
        ),
    ] {
        let error = of_json(text).unwrap_err();
        assert!(
            error.starts_with(&format!("field `{field}`: no such field here")),
            "{error}"
        );
    }
    let missing = of_json(r#"{"width": 1, "rows": [{}]}"#).unwrap_err();
    assert_eq!(missing, "field `rows[0].pair`: it is missing");
    let twice = of_json(r#"{"width": 1, "rows": [], "width": 2}"#).unwrap_err();
    assert_eq!(twice, "field `width`: it stands twice: expected once");
}

#[test]
fn variants_are_read_by_name() {
    let kind = |text: &str| of_json(&format!(r#"{{"width": 1, "kind": {text}}}"#));
    assert_eq!(kind(r#""plain""#).unwrap().kind, Some(Kind::Plain));
    assert_eq!(kind("null").unwrap().kind, None);
    assert_eq!(
        kind(r#"{"sized": {"side": 3}}"#).unwrap().kind,
        Some(Kind::Sized { side: 3 })
    );
    for (text, expected) in [
        (
            r#""bent""#,
            "field `kind`: found \"bent\", expected one of plain, sized",
        ),
        (
            r#"{"plain": 1}"#,
            "field `kind.plain`: found 1, expected the name alone",
        ),
        ("7", "field `kind`: found 7, expected one of plain, sized"),
        (
            r#"{"sized": {"side": 300}}"#,
            "field `kind.sized.side`: found 300, expected a whole number, 255 at most",
        ),
    ] {
        assert_eq!(kind(text).unwrap_err(), expected);
    }
}

#[test]
fn marks_and_comments_do_no_harm_and_lost_text_is_refused() {
    let marked = [b"\xef\xbb\xbf", &b"width = 3\r\n"[..]].concat();
    assert_eq!(toml(&marked).unwrap().read::<Outer>().unwrap().width, 3);
    let marked = [b"\xef\xbb\xbf", &b"{\"width\": 3}"[..]].concat();
    assert_eq!(json(&marked).unwrap().read::<Outer>().unwrap().width, 3);
    let comment = b"# Gr\xfc\xdfe\nwidth = 3";
    assert_eq!(toml(comment).unwrap().read::<Outer>().unwrap().width, 3);
    let error = toml(b"width = 3\nname = \"Gr\xfc\xdfe\"").unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 2, column 11: the text is not UTF-8: save it as UTF-8"
    );
    assert!(
        json(b"{\"\xfc\": 1}")
            .unwrap_err()
            .to_string()
            .contains("UTF-8")
    );
    // What a file itself says of it is its own.
    assert!(json("{\"\u{fffd}\": 1}".as_bytes()).is_ok());
    assert!(
        json(b"\xff\xfe{\0}\0")
            .unwrap_err()
            .to_string()
            .contains("UTF-16")
    );
}

#[test]
fn documents_are_laid_over_one_another_section_by_section() {
    let base = toml(b"a = 1\n[t]\nb = 2\nc = 3").unwrap();
    let laid = toml(b"d = 4\n[t]\nc = 5").unwrap().over(base);
    assert_eq!(
        laid,
        json(b"{\"a\":1,\"t\":{\"b\":2,\"c\":5},\"d\":4}").unwrap()
    );
    let number = json(b"{\"t\":7}").unwrap().over(laid);
    assert_eq!(number.get("t"), Some(&Value::Int(7)));
}

#[test]
fn keys_that_a_reader_loses_are_found() {
    let own = json(b"{\"a\": 1, \"rows\": [{\"b\": 2}, {\"b\": 3, \"new\": 4, \"none\": null}]}")
        .unwrap();
    assert_eq!(own.lost_in(&own), None);
    let kept = json(b"{\"a\": 1, \"rows\": [{\"b\": 2}, {\"b\": 3}]}").unwrap();
    let lost = own.lost_in(&kept).unwrap().to_string();
    assert_eq!(lost, "field `rows[1].new`: no such field here");
}

/// The words of the readers beneath, none of which a user is to see.
const FOREIGN: [&str; 14] = [
    "u32",
    "f32",
    "i64",
    "struct",
    "invalid type",
    "invalid value",
    "expected value at",
    "EOF",
    "sequence",
    "serde",
    "trailing",
    "deserialize",
    "Error",
    "variant",
];

#[test]
fn what_is_wrong_is_said_in_words_of_our_own() {
    let mut said = String::new();
    for text in [
        "",
        "{",
        "[1, 2",
        "{\"width\" 1}",
        "{\"width\": 1} x",
        "{\"width\": 1e999}",
        "{\"width\": NaN}",
        "{\"width\": 1,}",
        "7",
        "[1]",
        "null",
        "{\"width\": {}}",
        "{\"width\": 1, \"name\": 3}",
        "{\"width\": 1, \"flag\": 1}",
        "{\"width\": 1, \"rows\": 1}",
        "{\"width\": 1, \"rows\": [1]}",
        "{\"width\": 1, \"rows\": [{\"pair\": 1}]}",
        "{}",
        "{\"width\": \"\n\"}",
    ] {
        said += &format!(
            "{}\n  {}\n",
            text.escape_default(),
            of_json(text).unwrap_err()
        );
    }
    said += &format!("nested\n  {}\n", of_json(&"[".repeat(200)).unwrap_err());
    for text in [
        "width",
        "width = ",
        "width = 1\nwidth = 2",
        "[a",
        "width = 99999999999999999999",
        "width = 1979-05-27",
        "width = nan",
        "name = \"a",
        "width = [1,",
    ] {
        said += &format!(
            "{}\n  {}\n",
            text.escape_default(),
            of_toml_text(text).unwrap_err()
        );
    }
    for word in FOREIGN {
        assert!(!said.contains(word), "{word}: {said}");
    }
    insta::assert_snapshot!(said);
}
