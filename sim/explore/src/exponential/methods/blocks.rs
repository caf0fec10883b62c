//! Exponentials that are priced as blocks by themselves.

use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm};

/// Every form with its usual settings, and settings that trade area, clocks and accuracy.
pub(super) fn blocks() -> Vec<ExpConfig> {
    let paper = Config::paper().vu.exp;
    let radix_4 = |iterations, tail| ExpConfig {
        form: ExpForm::Radix4,
        iterations,
        tail,
        ..paper.clone()
    };
    let pipelined = |exp: ExpConfig| ExpConfig {
        pipelined: true,
        ..exp
    };
    let iterations = [8, 12, 16, 20].map(|iterations| ExpConfig {
        iterations,
        ..paper.clone()
    });
    let tails = [6, 9].map(|iterations| ExpConfig {
        iterations,
        tail: true,
        ..paper.clone()
    });
    let early = ExpConfig {
        early_out: true,
        ..paper.clone()
    };
    let others = [
        early,
        pipelined(paper.clone()),
        radix_4(4, true),
        radix_4(5, true),
        radix_4(8, false),
        pipelined(radix_4(4, true)),
    ];
    let pieces = [ExpBase::E, ExpBase::Two].map(|base| {
        [64, 128].map(|pieces| ExpConfig {
            base,
            pieces,
            ..ExpForm::Piecewise.plain()
        })
    });
    let mut all = [&iterations[..], &tails, &others, pieces.as_flattened()].concat();
    for form in ExpForm::ALL {
        if !all.contains(&form.plain()) {
            all.push(form.plain());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_priced_and_no_block_twice() {
        let all = blocks();
        for form in ExpForm::ALL {
            assert!(all.contains(&form.plain()), "{form:?}");
        }
        for (i, own) in all.iter().enumerate() {
            assert!(!all[..i].contains(own), "{own:?}");
        }
    }
}
