//! Descriptions that are read, and what is wrong with others.
#![allow(clippy::unwrap_used)]
use super::keys::DESCRIPTION;
use super::model::{MODEL_KINDS, field_kinds};
use super::*;

fn kinds() -> [(&'static str, Vec<&'static str>); 2] {
    let models = [&MODEL_KINDS[..], &field_kinds()].concat();
    let cameras = vec!["opencv-json", "transforms", "colmap", "trajectory", "orbit"];
    [("model", models), ("camera", cameras)]
}

fn parsed(text: &str) -> Result<Description, String> {
    Description::parse(text.as_bytes())
}

/// The fields that the readers themselves name, against the rows of the table.
#[test]
fn every_field_has_a_row_and_no_other_is_read() {
    let mut fields = vec!["model.kind".to_owned(), "camera.kind".to_owned()];
    let mut refused = |section: &str, text: &str| {
        let error = parsed(text).unwrap_err();
        let start = format!("field `{section}.kin`: no such field here: expected ");
        let names = error.strip_prefix(&start).unwrap();
        let names = names.split("; did you mean").next().unwrap();
        let names = names.trim_start_matches("one of ").replace('`', "");
        fields.extend(names.split(", ").map(|name| format!("{section}.{name}")));
    };
    for (section, kinds) in kinds() {
        for kind in kinds {
            let other = match section {
                "model" => "",
                _ => "[model]\nkind = \"builtin\"\nname = \"moons\"\n",
            };
            let text = format!("{other}[{section}]\nkind = \"{kind}\"\nkin = 1\n");
            refused(section, &text);
        }
    }
    refused(
        "render",
        "[model]\nkind = \"builtin\"\nname = \"a\"\n[render]\nkin = 1\n",
    );
    fields.sort();
    fields.dedup();
    let mut rows: Vec<_> = DESCRIPTION.keys.iter().map(|row| row.name).collect();
    rows.sort_unstable();
    assert_eq!(fields, rows);
    let kinds = DESCRIPTION.row("model.kind").unwrap().about;
    for kind in MODEL_KINDS {
        assert!(kinds.contains(kind), "the row of model.kind has no {kind}");
    }
    let error = parsed("modell = 1").unwrap_err();
    assert!(
        error.starts_with("field `modell`: no such section"),
        "{error}"
    );
}

#[test]
fn what_is_no_description_is_refused_by_field_in_words_of_our_own() {
    let model = "[model]\nkind = \"builtin\"\nname = \"moons\"\n";
    for (text, expected) in [
        ("", "section `[model]` is missing"),
        (
            "model = 3",
            "field `model`: found 3, expected a section with a `kind`",
        ),
        ("[model]\n", "field `model.kind`: it is missing"),
        (
            "[model]\nkind = 3",
            "field `model.kind`: found 3, expected a text",
        ),
        (
            "[model]\nkind = \"ply\"",
            "field `model.kind`: found \"ply\", expected one of builtin,",
        ),
        (
            "[model]\nkind = \"splats\"",
            "field `model.path`: it is missing",
        ),
        ("[model", "line 1, column 7: invalid TOML: "),
    ] {
        let error = parsed(text).unwrap_err();
        assert!(error.starts_with(expected), "{text}: {error}");
    }
    for (text, expected) in [
        (
            "background = [1, 0, 0, 9]",
            "render.background`: found 4 values, expected 3",
        ),
        (
            "background = [1, 0]",
            "render.background`: found 2 values, expected 3",
        ),
        (
            "group_tiles = [1, 2, 3]",
            "render.group_tiles`: found 3 values, expected 2",
        ),
        (
            "group_side = 1.5",
            "render.group_side`: found 1.5, expected a whole number",
        ),
        ("halo = 3", "render.halo`: found 3, expected a text"),
    ] {
        let error = parsed(&format!("{model}[render]\n{text}")).unwrap_err();
        assert!(
            error.starts_with(&format!("field `{expected}")),
            "{text}: {error}"
        );
    }
    let target = "[camera]\nkind = \"orbit\"\ntarget = [0, 0, 0, 1]";
    let error = parsed(&format!("{model}{target}")).unwrap_err();
    assert_eq!(error, "field `camera.target`: found 4 values, expected 3");
    let size = "[camera]\nkind = \"orbit\"\nwidth = 64.0\nheight = 4.8e1";
    let CameraDescription::Orbit { width, height, .. } =
        parsed(&format!("\u{feff}{model}{size}\r\n"))
            .unwrap()
            .camera
    else {
        unreachable!()
    };
    assert_eq!((width, height), (Some(64), Some(48)));
}
