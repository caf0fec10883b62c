//! Traces in the "Trace Event Format" (the Chromium project), for Perfetto and chrome://tracing.

use serde::Serialize;
use serde_json::{Value, json};

/// Process of all tracks.
const PROCESS: u32 = 1;

/// A track, numbered from 1, and a time in microseconds.
pub(crate) type At = (usize, f64);

/// The events of one process, in order of insertion.
pub(crate) struct TraceEvents {
    events: Vec<Value>,
}

impl TraceEvents {
    /// A process of this name without tracks.
    pub(crate) fn new(process: &str) -> Self {
        let name = json!({
            "ph": "M", "name": "process_name", "pid": PROCESS, "args": {"name": process},
        });
        Self { events: vec![name] }
    }

    /// Names a track.
    pub(crate) fn track(&mut self, track: usize, name: impl Serialize) {
        self.events.push(json!({
            "ph": "M", "name": "thread_name", "pid": PROCESS, "tid": track, "args": {"name": name},
        }));
    }

    /// A complete event of `us` microseconds from `at`, with an optional category.
    pub(crate) fn span(
        &mut self,
        (track, from): At,
        us: f64,
        (name, category): (&str, Option<&str>),
        args: Value,
    ) {
        let mut event = json!({"ph": "X", "name": name});
        if let Some(category) = category {
            event["cat"] = category.into();
        }
        event["pid"] = PROCESS.into();
        event["tid"] = track.into();
        event["ts"] = from.into();
        event["dur"] = us.into();
        event["args"] = args;
        self.events.push(event);
    }

    /// An instant event.
    pub(crate) fn instant(&mut self, (track, at): At, (name, category): (&str, &str), args: Value) {
        self.events.push(json!({
            "ph": "i", "s": "t", "name": name, "cat": category, "pid": PROCESS, "tid": track,
            "ts": at, "args": args,
        }));
    }

    /// Values of a counter from `us` microseconds on.
    pub(crate) fn counter(&mut self, us: f64, name: &str, values: Value) {
        self.events.push(json!({
            "ph": "C", "name": name, "pid": PROCESS, "ts": us, "args": values,
        }));
    }

    /// A flow arrow with a number of its own.
    pub(crate) fn arrow(
        &mut self,
        from: At,
        to: At,
        (name, category): (&str, &str),
        number: usize,
    ) {
        self.events.push(json!({
            "ph": "s", "name": name, "cat": category, "id": number, "pid": PROCESS,
            "tid": from.0, "ts": from.1,
        }));
        self.events.push(json!({
            "ph": "f", "bp": "e", "name": name, "cat": category, "id": number, "pid": PROCESS,
            "tid": to.0, "ts": to.1,
        }));
    }

    /// The trace as JSON.
    pub(crate) fn finish(self) -> Value {
        json!({"displayTimeUnit": "ns", "traceEvents": self.events})
    }
}
