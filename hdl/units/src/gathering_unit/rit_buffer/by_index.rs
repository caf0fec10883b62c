//! Tables in formulas.

/// A formula with the value for each index: `if(index == 0, v0, if(index == 1, v1, ...))`, the last
/// value from its index on.
pub(super) fn by_index(index: &str, values: &[String]) -> String {
    match values {
        [] => "0".to_owned(),
        [only] => only.clone(),
        [rest @ .., last] => {
            let mut text = last.clone();
            for (i, value) in rest.iter().enumerate().rev() {
                if *value != text || i + 1 < rest.len() {
                    text = format!("if({index} == {i}, {value}, {text})");
                }
            }
            text
        }
    }
}
