//! Why points of a sweep or a search have no figures, counted by the rule that they break.

/// Start of the line of a broken rule, before which the machine is named.
const RULE: &str = "rule `";

/// A reason, and how many points have it: of a rule that several values break, the words of the first.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Reason<'a> {
    pub(crate) text: &'a str,
    pub(crate) points: usize,
    /// Whether the words are the same at all of these points.
    pub(crate) is_same: bool,
}

/// The reasons in these texts, the most frequent first. A point that breaks two rules counts for both.
pub(crate) fn reasons<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<Reason<'a>> {
    let mut all: Vec<Reason<'a>> = vec![];
    for text in texts {
        let is_rules = text.contains(RULE);
        let each = match is_rules {
            true => text.lines().collect(),
            false => vec![text],
        };
        for text in each {
            match all.iter_mut().find(|own| key(own.text) == key(text)) {
                Some(known) => {
                    known.points += 1;
                    known.is_same &= words(known.text) == words(text);
                }
                None => all.push(Reason {
                    text,
                    points: 1,
                    is_same: true,
                }),
            }
        }
    }
    // The order of the first is kept among equals.
    all.sort_by_key(|own| std::cmp::Reverse(own.points));
    all
}

/// The words about a rule, without the machine before them, or else the whole text.
fn words(text: &str) -> &str {
    text.find(RULE).map_or(text, |at| &text[at..])
}

/// The name of the rule that a line tells of, or else the whole text.
fn key(text: &str) -> &str {
    let name = text
        .split_once(RULE)
        .and_then(|(_, rest)| rest.split_once('`'));
    name.map_or(text, |(name, _)| name)
}

impl Reason<'_> {
    /// The reason, and that it has other values at other points.
    pub(crate) fn words(&self) -> String {
        match self.is_same {
            true if self.points > 1 => words(self.text).to_owned(),
            true => self.text.to_owned(),
            false => format!("at one of them: {}", self.text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counted_by_rule() {
        let texts = [
            "paper: rule `a`: x = 3; expected 2\nrule `b`: y = 1",
            "paper: rule `b`: y = 1",
            "paper: rule `a`: x = 4; expected 2",
            "rule `b`: y = 1",
            "scene: too large",
        ];
        let found: Vec<(String, usize)> = reasons(texts.into_iter())
            .iter()
            .map(|own| (own.words(), own.points))
            .collect();
        assert_eq!(
            found,
            [
                ("rule `b`: y = 1".to_owned(), 3),
                (
                    "at one of them: paper: rule `a`: x = 3; expected 2".to_owned(),
                    2
                ),
                ("scene: too large".to_owned(), 1),
            ]
        );
    }
}
