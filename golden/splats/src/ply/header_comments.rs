//! Comments of a PLY header that affect rendering.

use glam::DVec3;
use ply_rs_bw::ply::Header as PlyHeader;

use super::PlyError;
use potamoi_base::file_keys::FileKeys;

/// Antialiased training, by Brush and its successors: `mip` or `default`.
pub(crate) const RENDER_MODE: &str = "comment SplatRenderMode";
/// Antialiased training, by Postshot: 1 or 0.
pub(crate) const ANTIALIASED: &str = "comment antialiased";
/// Vertical axis: `x`, `y` or `z`, with or without a sign.
pub(crate) const VERTICAL_AXIS: &str = "comment Vertical axis";

/// The comments' settings that change a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct HeaderComments {
    pub(crate) antialiased: bool,
    pub(crate) up: Option<DVec3>,
}

/// The keys of a header's comments and `obj_info` lines, with their values.
pub(crate) fn entries(header: &PlyHeader) -> Vec<(String, String)> {
    let comments = header.comments.iter().map(|line| ("comment", line));
    let infos = header.obj_infos.iter().map(|line| ("obj_info", line));
    (comments.chain(infos))
        .filter(|(_, line)| !line.is_empty())
        .map(|(kind, line)| {
            known(line).unwrap_or_else(|| (format!("{kind} {line}"), String::new()))
        })
        .collect()
}

/// Key and value of a known line, whatever separates them.
fn known(line: &str) -> Option<(String, String)> {
    [RENDER_MODE, ANTIALIASED, VERTICAL_AXIS]
        .into_iter()
        .find_map(|key| {
            let name = key.strip_prefix("comment ")?;
            let (head, value) = line.split_at_checked(name.len())?;
            let between = |c: char| c.is_whitespace() || c == ':' || c == '=';
            let is_whole = value.is_empty() || value.starts_with(between);
            (head.eq_ignore_ascii_case(name) && is_whole)
                .then(|| (key.to_owned(), value.trim_matches(between).to_owned()))
        })
}

/// Removes the known comments from the record and returns their settings.
pub(crate) fn take(
    record: &mut FileKeys<String>,
    origin: &str,
) -> Result<HeaderComments, PlyError> {
    let mut said: Option<bool> = None;
    for (key, [yes, no], expected) in [
        (RENDER_MODE, [&["mip"][..], &["default"]], "mip or default"),
        (
            ANTIALIASED,
            [
                &["1", "true", "yes", "on"][..],
                &["0", "false", "no", "off"],
            ],
            "1 or 0",
        ),
    ] {
        while let Some(value) = record.take(key) {
            let wrong = |expected| PlyError::Comment {
                origin: origin.to_owned(),
                message: format!("`{key}` is `{value}`: expected {expected}"),
            };
            let lower = value.to_lowercase();
            let own = match () {
                () if yes.contains(&lower.as_str()) => true,
                () if no.contains(&lower.as_str()) => false,
                () => return Err(wrong(expected)),
            };
            if said.is_some_and(|before| before != own) {
                return Err(wrong("what the comments before it say of antialiasing"));
            }
            said = Some(own);
        }
    }
    let up = record.peek(VERTICAL_AXIS).and_then(|value| axis(value));
    if up.is_some() {
        record.take(VERTICAL_AXIS);
    }
    Ok(HeaderComments {
        antialiased: said.unwrap_or(false),
        up,
    })
}

fn axis(value: &str) -> Option<DVec3> {
    let lower = value.to_lowercase();
    let (sign, name) = match lower.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, lower.strip_prefix('+').unwrap_or(&lower)),
    };
    let own = match name {
        "x" => DVec3::X,
        "y" => DVec3::Y,
        "z" => DVec3::Z,
        _ => return None,
    };
    Some(own * sign)
}
