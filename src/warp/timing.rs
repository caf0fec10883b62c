//! Arguments of the timing of references and targets: scheduled by given times, or measured.

use std::path::PathBuf;

use clap::Args;
use potamoi_explore::warping::{GivenTimes, Times, Timetable, Timing};

use crate::failure::Failure;
use crate::stdout::say;

/// Options of the runtime.
#[derive(Debug, Args)]
pub(super) struct TimingArgs {
    /// Render time of a full frame, for the schedule; a target takes its rendered share of it
    /// [default: no schedule]
    #[arg(long, value_name = "MS", conflicts_with = "live")]
    frame_ms: Option<f64>,
    /// Time to warp a reference to a target [default: 0, which the report notes]
    #[arg(long, value_name = "MS", requires = "frame_ms")]
    warp_ms: Option<f64>,
    /// Render time of a reference on a server, which sends it over the paper's wireless link of 10
    /// MB/s [default: references are rendered on the device]
    #[arg(long, value_name = "MS", requires = "frame_ms")]
    server_ms: Option<f64>,
    /// Timeout of a reference from the server
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 1000.0,
        requires = "server_ms"
    )]
    timeout_ms: f64,
    /// Share one renderer between references and targets
    #[arg(long)]
    one_renderer: bool,
    /// Render references and targets concurrently, on two threads, and measure their times
    #[arg(long)]
    live: bool,
    /// Write the schedule as a Chrome trace, for Perfetto; with several variants, that of the last
    #[arg(long, value_name = "FILE")]
    pub(super) chrome_trace: Option<PathBuf>,
}

impl TimingArgs {
    /// Whether any timing is requested.
    pub(super) const fn is_asked(&self) -> bool {
        self.is_live() || self.is_scheduled()
    }

    /// Whether frames are rendered live, on two threads.
    pub(super) const fn is_live(&self) -> bool {
        self.live
    }

    /// Whether the schedule has a remote server for references.
    pub(super) const fn has_server(&self) -> bool {
        self.server_ms.is_some()
    }

    /// Whether times are given.
    pub(super) const fn is_scheduled(&self) -> bool {
        self.frame_ms.is_some()
    }

    pub(super) fn check(&self) -> Result<(), Failure> {
        let options = [
            ("--frame-ms", self.frame_ms),
            ("--warp-ms", self.warp_ms),
            ("--server-ms", self.server_ms),
            ("--timeout-ms", Some(self.timeout_ms)),
        ];
        for (name, value) in options {
            let fits = |v: f64| (0.0..=1e9).contains(&v);
            if let Some(value) = value.filter(|v| !fits(*v)) {
                return Err(Failure::Usage(format!(
                    "{name} {value}: expected 0 to 1e9 milliseconds"
                )));
            }
        }
        if self.live && (self.server_ms.is_some() || self.warp_ms.is_some()) {
            return Err(Failure::Usage(
                "--live measures times on this machine: leave out --server-ms, --timeout-ms and \
                 --warp-ms, or schedule with --frame-ms"
                    .to_owned(),
            ));
        }
        if self.chrome_trace.is_some() && !self.is_asked() {
            return Err(Failure::Usage(
                "--chrome-trace: there is no schedule to write: give --frame-ms, or --live to measure times"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// The timing options.
    pub(super) fn timetable(&self) -> Timetable {
        let given = self.frame_ms.map(|frame| {
            Times::Given(GivenTimes {
                frame,
                warp: self.warp_ms,
                server: self.server_ms,
                timeout: self.timeout_ms,
            })
        });
        Timetable {
            times: match self.live {
                true => Times::Measured,
                false => given.unwrap_or(Times::None),
            },
            one_renderer: self.one_renderer,
        }
    }
}

/// Prints the summary of a schedule.
pub(super) fn print(timing: &Timing, name: &str, trace: Option<&PathBuf>) {
    say!(
        "  {name}, with {} times: {:.1} ms in total, {} frames per second; latency from pose to \
         frame {:.1} ms on average, {:.1} ms at most; references and targets overlap for {:.1} \
         ms",
        timing.times,
        timing.span_ms,
        timing
            .frames_per_second
            .map_or_else(|| "-".to_owned(), |fps| format!("{fps:.1}")),
        timing.latency_mean_ms,
        timing.latency_max_ms,
        timing.overlap_ms
    );
    if let Some(late) = timing.deadline_misses {
        say!("    deadline misses: {late} frames not shown within a frame's time of their pose");
    }
    if timing.warping_is_free {
        say!("    warping is assumed to take no time; set its time with --warp-ms");
    }
    let list = |parts: &[(&str, f64)], unit: &str, scale: f64| {
        let parts = parts.iter().filter(|(_, value)| *value > 0.0);
        let parts = parts.map(|(name, value)| format!("{name} {:.1}{unit}", scale * value));
        parts.collect::<Vec<_>>().join(", ")
    };
    say!(
        "    waiting time of frames: {}",
        list(&timing.waits_ms, " ms", 1.0)
    );
    say!(
        "    utilisation: {}",
        list(&timing.utilisation, " %", 100.0)
    );
    if timing.link.bytes > 0 {
        say!(
            "    over the link: {:.2} MB, {:.1} mJ (the paper's 100 nJ/B)",
            timing.link.bytes as f64 / 1e6,
            timing.link.nanojoules as f64 / 1e6
        );
    }
    if let Some(path) = trace {
        say!("    trace for Perfetto: {}", path.display());
    }
}
