//! Breaks long lines between operands.

use super::fill;

pub(super) const WIDTH: usize = 100;

/// `text` at an indent of two spaces a level; what passes the width goes on
/// two levels deeper. A trailing comment that does not fit moves above.
pub(super) fn wrap(text: &str, indent: usize) -> String {
    let pad = "  ".repeat(indent);
    if pad.len() + text.len() <= WIDTH {
        return format!("{pad}{text}");
    }
    if let Some((code, note)) = text.split_once("  // ") {
        let note = fill(note, WIDTH - pad.len() - "// ".len());
        let above: String = note.iter().map(|n| format!("{pad}// {n}\n")).collect();
        return above + &wrap(code, indent);
    }
    let deeper = "  ".repeat(indent + 2);
    let mut out = pad;
    let mut column = out.len();
    for (i, word) in text.split(' ').enumerate() {
        if i > 0 {
            if column + 1 + word.len() > WIDTH {
                out.push('\n');
                out.push_str(&deeper);
                column = deeper.len();
            } else {
                out.push(' ');
                column += 1;
            }
        }
        out.push_str(word);
        column += word.len();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn long_lines_go_on_deeper_and_lose_nothing() {
        let text = format!("wire x = {};", vec!["operand_name"; 30].join(" | "));
        let wrapped = wrap(&text, 1);
        assert!(wrapped.lines().all(|l| l.len() <= 100), "{wrapped}");
        assert!(
            wrapped
                .lines()
                .skip(1)
                .all(|l| l.starts_with("      o") || l.starts_with("      |"))
        );
        let joined: Vec<_> = wrapped.split_whitespace().collect();
        assert_eq!(joined, text.split_whitespace().collect::<Vec<_>>());
    }

    #[test]
    fn a_comment_that_does_not_fit_moves_above() {
        let long = format!("wire x;  // {}", vec!["word"; 40].join(" "));
        assert!(wrap(&long, 1).lines().all(|l| l.len() <= 100), "{long}");
        let text = format!("reg {};  // why", "x".repeat(95));
        assert_eq!(wrap(&text, 0), format!("// why\nreg {};", "x".repeat(95)));
    }
}
