//! Starts engines and runs jobs on them.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::{Interpreter, Module};
use potamoi_verilated::{Library, PortId, Toolchain, Trace};

use super::engine::{Engine, EngineKind, Job, Verilated, pass_on};
use super::icarus;
use super::model::{RtlError, compile, model_of_others};
use super::port_trace::{Traced, traced};
use super::wave_dump::{TracedModel, TracedPorts, Window};

/// Records the inputs of every clock.
struct Recording {
    inner: Verilated,
    inputs: Vec<PortId>,
    words: Vec<u32>,
}

impl Engine for Recording {
    pass_on!(PortId);

    fn settle(&mut self) -> Result<(), RtlError> {
        for &port in &self.inputs {
            let at = self.words.len();
            self.words.resize(at + port.words(), 0);
            self.inner.get_words(port, &mut self.words[at..])?;
        }
        self.inner.settle()
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        self.inner.edge()
    }
}

/// A module that can run on an engine any number of times.
pub(super) struct Runner {
    module: Arc<Module>,
    /// Verilog of others in place of the module's own.
    files: Option<BTreeMap<String, String>>,
    program: Program,
}

enum Program {
    Verilator(Library),
    Interpreter,
    Icarus(icarus::Program),
}

impl Runner {
    pub(super) fn new(kind: EngineKind, module: &Arc<Module>) -> Result<Self, RtlError> {
        let program = match kind {
            EngineKind::Verilator => Program::Verilator(compile(module, false)?),
            EngineKind::Interpreter => Program::Interpreter,
            EngineKind::Icarus => Program::Icarus(icarus::Program::new(module)?),
        };
        Ok(Self {
            module: module.clone(),
            files: None,
            program,
        })
    }

    /// A runner for other Verilog with the module's ports, such as its gate-level netlist.
    pub(super) fn of_files(
        kind: EngineKind,
        module: &Arc<Module>,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        let program = match kind {
            EngineKind::Verilator => {
                let model = model_of_others(module, files);
                Program::Verilator(model.build(&Toolchain::detect()?)?)
            }
            EngineKind::Icarus => Program::Icarus(icarus::Program::of_files(module, files)?),
            EngineKind::Interpreter => {
                let text = "the interpreter runs no Verilog: use verilator or icarus";
                return Err(RtlError::Usage(text.to_owned()));
            }
        };
        Ok(Self {
            module: module.clone(),
            files: Some(files.clone()),
            program,
        })
    }

    /// Runs a job on a new instance; state without reset is drawn from the seed.
    pub(super) fn run<J: Job>(&self, seed: u64, job: J) -> Result<J::Output, RtlError> {
        match &self.program {
            Program::Verilator(library) => job.run(&mut Verilated::new(library, seed)?),
            Program::Interpreter => job.run(&mut Interpreter::new(&self.module, seed)),
            Program::Icarus(program) => job.run(&mut program.start()?),
        }
    }

    /// As [`Runner::run`], with the ports recorded in every clock.
    pub(super) fn run_traced<J: Job>(
        &self,
        seed: u64,
        job: J,
    ) -> Result<Traced<J::Output>, RtlError> {
        let module = &self.module;
        match &self.program {
            Program::Verilator(library) => traced(Verilated::new(library, seed)?, module, job),
            Program::Interpreter => traced(Interpreter::new(module, seed), module, job),
            Program::Icarus(program) => traced(program.start()?, module, job),
        }
    }

    /// Runs a job, and records the named inputs in this order in every clock, those in reset
    /// included.
    pub(super) fn run_recorded<J: Job>(
        &self,
        seed: u64,
        inputs: &[&str],
        job: J,
    ) -> Result<Vec<u32>, RtlError> {
        let library = compile(&self.module, false)?;
        let inner = Verilated::new(&library, seed)?;
        let inputs = inputs
            .iter()
            .map(|name| Engine::port(&inner, name))
            .collect::<Result<_, _>>()?;
        let mut recording = Recording {
            inner,
            inputs,
            words: vec![],
        };
        job.run(&mut recording)?;
        Ok(recording.words)
    }

    /// Runs a job, and dumps a window of it: every signal of a Verilated model, otherwise the
    /// ports.
    pub(super) fn run_dumped<J: Job>(
        &self,
        seed: u64,
        window: Window,
        job: J,
    ) -> Result<J::Output, RtlError> {
        match &self.program {
            Program::Verilator(_) => {
                let library = match &self.files {
                    None => compile(&self.module, true)?,
                    Some(files) => model_of_others(&self.module, files)
                        .trace(Trace::Vcd)
                        .build(&Toolchain::detect()?)?,
                };
                let model = Verilated::new(&library, seed)?;
                job.run(&mut TracedModel::new(model, window))
            }
            Program::Interpreter => {
                let unit = Interpreter::new(&self.module, seed);
                job.run(&mut TracedPorts::new(unit, &self.module, window)?)
            }
            Program::Icarus(program) => {
                let unit = program.start()?;
                job.run(&mut TracedPorts::new(unit, &self.module, window)?)
            }
        }
    }
}
