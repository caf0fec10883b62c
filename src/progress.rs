//! Progress on standard error: a bar where that is a terminal, otherwise a line now and then.

use std::iter;
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use potamoi_explore::Progress;

use crate::stdout;

/// A bar or a spinner that shows the progress of a study.
pub(crate) struct Shown<'a>(pub(crate) &'a ProgressBar);

impl Progress for Shown<'_> {
    fn expect(&self, steps: u64) {
        self.0.inc_length(steps);
    }

    fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }

    fn pass_over(&self, steps: u64) {
        self.0.dec_length(steps);
    }

    fn now(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }
}

/// A bar over `total` steps, with a message.
pub(crate) fn bar(total: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(total);
    let style = ProgressStyle::with_template(
        "{prefix} [{bar:30}] {percent:>3} % {elapsed} (about {eta} left) {msg}",
    );
    if let Ok(style) = style {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_prefix(what.to_owned());
    shown(bar)
}

/// A spinner, for work of unknown length.
pub(crate) fn spinner(what: &str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    bar.set_message(what.to_owned());
    shown(bar)
}

fn shown(bar: ProgressBar) -> ProgressBar {
    match bar.is_hidden() {
        true => print_lines(&bar),
        false => bar.enable_steady_tick(Duration::from_millis(200)),
    }
    bar
}

/// Pauses between lines in seconds: the first line comes after two seconds of work, others each ten
/// seconds, and each half minute after the first minute.
fn pauses() -> impl Iterator<Item = u64> {
    iter::once(2)
        .chain(iter::repeat_n(10, 6))
        .chain(iter::repeat(30))
}

/// Prints lines until the work is done. Where standard error is a file or a pipe, a bar would be one long
/// line, and nothing would look like a hang.
fn print_lines(bar: &ProgressBar) {
    let bar = bar.downgrade();
    thread::spawn(move || {
        for pause in pauses() {
            thread::sleep(Duration::from_secs(pause));
            let Some(bar) = bar.upgrade().filter(|own| !own.is_finished()) else {
                return;
            };
            let told = Told {
                what: [bar.prefix(), bar.message()],
                done: bar.position(),
                of: bar.length(),
                elapsed: bar.elapsed(),
            };
            stdout::progress(format_args!("{}", told.line()));
        }
    });
}

/// What a line of progress tells.
struct Told {
    /// The command's work, and the part of it that is under way.
    what: [String; 2],
    /// Steps.
    done: u64,
    of: Option<u64>,
    elapsed: Duration,
}

impl Told {
    fn line(&self) -> String {
        let what: Vec<&str> = self.what.iter().map(|own| own.trim()).collect();
        let what = what.into_iter().filter(|own| !own.is_empty());
        let what = what.collect::<Vec<_>>().join(": ");
        let so_far = format!("{what}, {} so far", time(self.elapsed, u64::div_euclid));
        let Some(of) = self.of.filter(|of| *of > 0) else {
            return so_far;
        };
        let done = self.done.min(of);
        let percent = 100 * u128::from(done) / u128::from(of);
        match percent {
            0 if done == 0 => so_far,
            // The first steps say too little of the others.
            0 => format!("{so_far}, less than 1 %"),
            _ => {
                let left = self.elapsed.mul_f64((of - done) as f64 / done as f64);
                format!(
                    "{so_far}, {percent} %, about {} left",
                    time(left, u64::div_ceil)
                )
            }
        }
    }
}

/// A time in the unit that suits it, with minutes rounded by this division.
fn time(of: Duration, divided: fn(u64, u64) -> u64) -> String {
    match of.as_secs() {
        seconds if seconds < 100 => format!("{seconds} s"),
        seconds => format!("{} min", divided(seconds, 60)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_the_work_its_share_and_the_time_left() {
        let line = |done, of| {
            Told {
                what: ["sweeping".to_owned(), "garden".to_owned()],
                done,
                of,
                elapsed: Duration::from_secs(30),
            }
            .line()
        };
        assert_eq!(
            line(25, Some(100)),
            "sweeping: garden, 30 s so far, 25 %, about 90 s left"
        );
        assert_eq!(
            line(10, Some(100)),
            "sweeping: garden, 30 s so far, 10 %, about 5 min left"
        );
        for (done, of) in [(0, Some(100)), (0, Some(0)), (3, None)] {
            assert_eq!(line(done, of), "sweeping: garden, 30 s so far");
        }
        assert_eq!(
            line(3, Some(1000)),
            "sweeping: garden, 30 s so far, less than 1 %"
        );
        assert!(line(200, Some(100)).ends_with("100 %, about 0 s left"));
    }

    #[test]
    fn lines_come_after_two_seconds_and_then_more_rarely() {
        let mut at = 0;
        let times: Vec<u64> = pauses()
            .map(|pause| {
                at += pause;
                at
            })
            .take(9)
            .collect();
        assert_eq!(times, [2, 12, 22, 32, 42, 52, 62, 92, 122]);
    }
}
