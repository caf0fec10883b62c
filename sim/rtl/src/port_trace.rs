//! Records the ports of a unit in every clock after reset, on any engine, so that engines can be
//! compared with one another.

use std::sync::Arc;

use potamoi_netlist::Module;

use super::engine::{Engine, Job, pass_on};
use super::model::RtlError;

/// What a unit's ports showed in every clock after reset: all outputs, and the handshakes of its
/// streams. The payload of an output stream counts in clocks with `tvalid`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortTrace {
    ports: Vec<Recorded>,
    /// Words of a clock, and of each port the part that `Recorded::words` tells.
    words_a_clock: usize,
    values: Vec<u32>,
    /// Bits that are neither 0 nor 1.
    unknown: Vec<u32>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Recorded {
    name: String,
    words: std::ops::Range<usize>,
    /// Word of the `tvalid` without which the port is payload of nothing.
    valid: Option<usize>,
}

/// A recorded run.
#[derive(Debug)]
pub struct Traced<T> {
    /// The ports, up to the clock in which the run failed, if it did.
    pub trace: PortTrace,
    /// What the run would return without being recorded.
    pub result: Result<T, RtlError>,
}

impl<T> Traced<T> {
    /// The run with a result that is judged further.
    pub(super) fn and_then(self, judge: impl FnOnce(T) -> Result<T, RtlError>) -> Self {
        Self {
            trace: self.trace,
            result: self.result.and_then(judge),
        }
    }
}

/// The first clock and port in which two traces differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceDifference {
    /// Clocks since the first after reset.
    pub cycle: usize,
    /// The port, or `end of the run`.
    pub port: String,
    /// Value in the first trace, in hexadecimal digits; a digit with an unknown bit is x.
    pub first: String,
    /// Value in the second trace.
    pub second: String,
}

impl PortTrace {
    fn new(module: &Module) -> Self {
        let mut ports: Vec<Recorded> = vec![];
        let mut end = 0;
        for port in module.ports() {
            let is_handshake = port.name.ends_with("_tvalid") || port.name.ends_with("_tready");
            if port.output || is_handshake {
                let words = end..end + port.ty.width.div_ceil(32) as usize;
                end = words.end;
                ports.push(Recorded {
                    name: port.name,
                    words,
                    valid: None,
                });
            }
        }
        let valids: Vec<_> = ports
            .iter()
            .filter_map(|p| Some((p.name.strip_suffix("valid")?.to_owned(), p.words.start)))
            .filter(|(stream, _)| stream.starts_with("m_axis_"))
            .collect();
        for port in &mut ports {
            let is_handshake = port.name.ends_with("_tvalid") || port.name.ends_with("_tready");
            let own = valids
                .iter()
                .find(|(stream, _)| port.name.starts_with(stream));
            port.valid = own.filter(|_| !is_handshake).map(|(_, word)| *word);
        }
        Self {
            ports,
            words_a_clock: end,
            values: vec![],
            unknown: vec![],
        }
    }

    /// Clocks recorded.
    #[must_use]
    pub const fn cycles(&self) -> usize {
        self.values.len() / self.words_a_clock
    }

    /// Beats that were taken from the output streams.
    #[must_use]
    pub fn beats(&self) -> usize {
        let outputs = self.ports.iter().filter_map(|valid| {
            let stream = valid.name.strip_suffix("tvalid")?;
            let ready = format!("{stream}tready");
            let ready = self.ports.iter().find(|p| p.name == ready)?;
            let is_output = stream.starts_with("m_axis_");
            is_output.then_some((valid.words.start, ready.words.start))
        });
        outputs
            .map(|(valid, ready)| {
                let clocks = self.values.chunks_exact(self.words_a_clock);
                clocks.filter(|c| c[valid] & c[ready] & 1 == 1).count()
            })
            .sum()
    }

    /// The first difference of the traces of one unit. A bit that is unknown, in either trace,
    /// always differs.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<TraceDifference> {
        for cycle in 0..self.cycles().min(other.cycles()) {
            let at = cycle * self.words_a_clock;
            for port in &self.ports {
                let is_payload_of_nothing = |trace: &Self| {
                    let word = port.valid.map(|word| at + word);
                    word.is_some_and(|w| (trace.values[w] | trace.unknown[w]) & 1 == 0)
                };
                if is_payload_of_nothing(self) && is_payload_of_nothing(other) {
                    continue;
                }
                let words = at + port.words.start..at + port.words.end;
                let differs = self.values[words.clone()] != other.values[words.clone()];
                let is_unknown =
                    |trace: &Self| trace.unknown[words.clone()].iter().any(|w| *w != 0);
                if differs || is_unknown(self) || is_unknown(other) {
                    return Some(TraceDifference {
                        cycle,
                        port: port.name.clone(),
                        first: self.digits(words.clone()),
                        second: other.digits(words),
                    });
                }
            }
        }
        let [first, second] = [self, other].map(Self::cycles);
        (first != second).then(|| TraceDifference {
            cycle: first.min(second),
            port: "end of the run".to_owned(),
            first: format!("{first} cycles"),
            second: format!("{second} cycles"),
        })
    }

    fn digits(&self, words: std::ops::Range<usize>) -> String {
        let digit = |word: usize, low: u32| match self.unknown[word] >> low & 15 {
            0 => char::from_digit(self.values[word] >> low & 15, 16).unwrap_or('?'),
            _ => 'x',
        };
        let all = words.rev();
        all.flat_map(|word| (0..8).rev().map(move |i| digit(word, 4 * i)))
            .collect()
    }
}

/// An engine whose ports are recorded.
struct Recorder<E: Engine> {
    inner: E,
    ports: Vec<E::Port>,
    trace: PortTrace,
    is_on: bool,
}

impl<E: Engine> Recorder<E> {
    fn record(&mut self) -> Result<(), RtlError> {
        let at = self.trace.values.len();
        let end = at + self.trace.words_a_clock;
        self.trace.values.resize(end, 0);
        self.trace.unknown.resize(end, 0);
        for (&port, recorded) in self.ports.iter().zip(&self.trace.ports) {
            let words = at + recorded.words.start..at + recorded.words.end;
            self.inner
                .get_words(port, &mut self.trace.values[words.clone()])?;
            if let Some(unknown) = self.inner.unknown(port) {
                self.trace.unknown[words].copy_from_slice(unknown);
            }
        }
        Ok(())
    }
}

impl<E: Engine> Engine for Recorder<E> {
    pass_on!(E::Port);

    fn settle(&mut self) -> Result<(), RtlError> {
        self.inner.settle()?;
        if self.is_on { self.record() } else { Ok(()) }
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        self.inner.edge()
    }

    fn reset(&mut self) -> Result<(), RtlError> {
        self.inner.reset()?;
        self.is_on = true;
        Ok(())
    }
}

/// Runs a job on an engine of the module, and records its ports.
pub(super) fn traced<E: Engine, J: Job>(
    engine: E,
    module: &Arc<Module>,
    job: J,
) -> Result<Traced<J::Output>, RtlError> {
    let trace = PortTrace::new(module);
    let ports = trace.ports.iter().map(|port| engine.port(&port.name));
    let mut recorder = Recorder {
        ports: ports.collect::<Result<_, _>>()?,
        inner: engine,
        trace,
        is_on: false,
    };
    let result = job.run(&mut recorder);
    Ok(Traced {
        trace: recorder.trace,
        result,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two clocks of a stream with a payload of one word, and of a counter.
    fn trace(values: [[u32; 3]; 2]) -> PortTrace {
        let port = |name: &str, word: usize, valid| Recorded {
            name: name.to_owned(),
            words: word..word + 1,
            valid,
        };
        PortTrace {
            ports: vec![
                port("m_axis_a_tvalid", 0, None),
                port("m_axis_a_tdata", 1, Some(0)),
                port("stat_a", 2, None),
            ],
            words_a_clock: 3,
            values: values.concat(),
            unknown: vec![0; 6],
        }
    }

    #[test]
    fn the_first_difference_has_its_clock_port_and_values() {
        let one = trace([[0, 7, 1], [1, 0xab, 2]]);
        assert_eq!(one.first_difference(&one), None);
        // Payload without a beat.
        assert_eq!(
            one.first_difference(&trace([[0, 8, 1], [1, 0xab, 2]])),
            None
        );
        let found = one.first_difference(&trace([[0, 8, 1], [1, 0xaa, 3]]));
        let wanted = |cycle, port: &str, first: &str, second: &str| {
            Some(TraceDifference {
                cycle,
                port: port.to_owned(),
                first: first.to_owned(),
                second: second.to_owned(),
            })
        };
        assert_eq!(found, wanted(1, "m_axis_a_tdata", "000000ab", "000000aa"));
        let mut short = one.clone();
        for words in [&mut short.values, &mut short.unknown] {
            words.truncate(3);
        }
        let found = one.first_difference(&short);
        assert_eq!(found, wanted(1, "end of the run", "2 cycles", "1 cycles"));
    }

    #[test]
    fn an_unknown_bit_differs_even_from_itself_where_it_counts() {
        let mut open = trace([[0, 7, 1], [1, 0xa0, 2]]);
        open.unknown[1] = 15;
        assert_eq!(open.first_difference(&open), None);
        open.unknown[4] = 15;
        let first = |trace: &PortTrace| {
            let found = trace.first_difference(trace);
            found.map(|d| (d.cycle, d.port, d.first))
        };
        let wanted =
            |cycle, port: &str, digits: &str| Some((cycle, port.to_owned(), digits.to_owned()));
        assert_eq!(first(&open), wanted(1, "m_axis_a_tdata", "000000ax"));
        // A `tvalid` that is not known, and so its payload.
        let mut open = trace([[0, 7, 1], [1, 0xa0, 2]]);
        open.unknown[0] = 15;
        assert_eq!(first(&open), wanted(0, "m_axis_a_tvalid", "0000000x"));
    }
}
