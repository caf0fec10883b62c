//! Composes a frame of jobs: resources, dependencies, bytes and energy.

use serde::Serialize;

use super::blocks::{Block, blocks};
use super::buffers::Buffered;
use super::costs::{CostError, Costs, OnChip};
use super::gpu_only::gpu_only;
use super::job_scheduler::{Job, JobId, Resource, Share, Shared};
use super::kernels::{Kernel, PIXEL, Program};
use super::memory::Memory;
use super::system::System;
use super::transfers::{ReplayedRates, Transfers, unit_transfers};
use super::variant::Gathering;
use super::work::{FrameWork, PathReplay, Replayed};
use potamoi_cycles::frame_meter::Batch;

/// Bytes and energy of jobs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spent {
    /// Bytes read sequentially from memory.
    pub streamed_bytes: f64,
    /// Bytes written sequentially.
    pub written_bytes: f64,
    /// Bytes read at random.
    pub random_bytes: f64,
    /// Transfers of the DMA; the GPU moves its bytes itself.
    pub transfers: u64,
    /// Bytes of DMA descriptors, read at random.
    pub descriptor_bytes: f64,
    /// Bytes of weights, among those read sequentially.
    pub weight_bytes: f64,
    /// Rows of memory opened.
    pub rows_opened: f64,
    /// Work of the device's GPU.
    pub gpu: GpuDone,
    /// Energy of memory accesses without descriptors, in picojoules.
    pub memory_pj: f64,
    /// Energy of reading descriptors, in picojoules.
    pub descriptor_pj: f64,
    /// Bytes over the interconnect: all of the above, in whole bursts.
    pub interconnect_bytes: f64,
    /// Bytes read from and written to the global feature buffer.
    pub feature_buffer_bytes: f64,
    /// Bytes read from and written to the weight buffer.
    pub weight_buffer_bytes: f64,
    /// Bytes over the link.
    pub link_bytes: f64,
    /// Energy on chip.
    pub on_chip: OnChip,
    /// Work of the units.
    pub done: Batch,
}

/// Work of a GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct GpuDone {
    /// Kernels launched.
    pub launches: u64,
    /// Instructions of all threads, as [`Instructions`](super::Instructions) counts them.
    pub instructions: f64,
    /// Bytes through its cache, in whole sectors of 32.
    pub cache_bytes: f64,
    /// Bytes through shared memory; those that wait for a bank count again for each wait.
    pub shared_bytes: f64,
    /// Bytes of memory: cache misses and writes.
    pub memory_bytes: f64,
}

/// Appends the jobs of frames to a list.
pub(super) struct Composer<'a> {
    system: &'a System,
    memory: &'a Memory,
    costs: &'a Costs,
    clock_ghz: f64,
    replay: Option<&'a PathReplay>,
    /// Bytes of the model's weights, and whether the weight buffer holds them.
    weights: (f64, bool),
    /// Blocks of the feature buffer so far.
    blocks: u64,
    /// Jobs so far.
    pub jobs: Vec<Job>,
    /// Their bytes and energy.
    pub spent: Spent,
}

/// Stage, dependencies and rank of a job.
struct Turn {
    stage: &'static str,
    after: Vec<JobId>,
    rank: u64,
}

/// A frame that is rendered locally.
struct Rendering<'w> {
    work: &'w FrameWork,
    gathering: Gathering,
    /// Gathering of the whole frame as a GPU kernel, and the efficiency it reaches.
    gathered: Kernel,
    reached: f64,
    known: ReplayedRates,
    rank: u64,
}

impl Rendering<'_> {
    const fn turn(&self, stage: &'static str, after: Vec<JobId>) -> Turn {
        let rank = self.rank;
        Turn { stage, after, rank }
    }
}

/// A block of the feature buffer: its index, its work, and its share of the frame.
type BlockPart<'b> = (u64, &'b Batch, f64);

impl<'a> Composer<'a> {
    /// An empty list for a system whose accelerator has the clock `clock_ghz`.
    #[must_use]
    pub(super) fn new(
        system: &'a System,
        memory: &'a Memory,
        costs: &'a Costs,
        clock_ghz: f64,
        weight_bytes: u64,
        replay: Option<&'a PathReplay>,
    ) -> Self {
        Self {
            system,
            memory,
            costs,
            clock_ghz,
            replay,
            weights: (weight_bytes as f64, false),
            blocks: 0,
            jobs: vec![],
            spent: Spent::default(),
        }
    }

    pub(super) const fn system(&self) -> &'a System {
        self.system
    }

    /// Appends a job without bytes in the on-chip buffers.
    fn push(&mut self, turn: Turn, resource: Resource, own_ns: f64, transfers: Transfers) -> JobId {
        self.buffered(turn, resource, own_ns, transfers, Buffered::default())
    }

    fn buffered(
        &mut self,
        turn: Turn,
        resource: Resource,
        own_ns: f64,
        transfers: Transfers,
        buffered: Buffered,
    ) -> JobId {
        // The next descriptor is read while the bytes of the one before are moved.
        let descriptors = Transfers {
            random: transfers.dma_transfers as f64 * self.system.dma_descriptor_bytes,
            run: self.system.dma_descriptor_bytes,
            ..Transfers::default()
        };
        let wired = transfers.wired(self.memory) + descriptors.wired(self.memory);
        self.spent.transfers += transfers.dma_transfers;
        self.spent.descriptor_bytes += descriptors.random;
        self.spent.descriptor_pj += descriptors.pj(self.memory);
        self.spent.interconnect_bytes += wired;
        self.spent.rows_opened += transfers.rows(self.memory) + descriptors.rows(self.memory);
        self.spent.memory_pj += transfers.pj(self.memory);
        self.spent.streamed_bytes += transfers.read;
        self.spent.written_bytes += transfers.written;
        self.spent.random_bytes += transfers.random;
        self.spent.feature_buffer_bytes += buffered.features;
        self.spent.weight_buffer_bytes += buffered.weights;
        let memory_ns = transfers.ns(self.memory) + descriptors.ns(self.memory);
        let wires = self.system.interconnect_bytes_a_clock * self.clock_ghz;
        let moved = [
            (Shared::Memory, memory_ns),
            (Shared::Interconnect, wired / wires),
        ];
        let moved = moved.map(|(of, ns)| Share { of, ns });
        let moved = moved.into_iter().filter(|share| share.ns > 0.0);
        let on_chip = buffered.shares(self.system, self.clock_ghz);
        self.jobs.push(Job {
            stage: turn.stage,
            resource,
            own_ns,
            shares: moved.chain(on_chip).collect(),
            after: turn.after,
            rank: turn.rank,
        });
        self.jobs.len() - 1
    }

    /// Appends a GPU kernel, or a part of one that was launched before.
    fn kernel(&mut self, turn: Turn, kernel: &Kernel, efficiency: f64, launched: bool) -> JobId {
        self.reading(turn, kernel, efficiency, launched, [None; 2])
    }

    /// Appends a GPU kernel whose reads are known.
    fn reading(
        &mut self,
        turn: Turn,
        kernel: &Kernel,
        efficiency: f64,
        launched: bool,
        known: [Option<Replayed>; 2],
    ) -> JobId {
        let gpu = &self.system.gpu;
        let done = &mut self.spent.gpu;
        done.launches += u64::from(!launched);
        done.instructions += kernel.instructions;
        done.cache_bytes += kernel.cache_bytes;
        done.shared_bytes += kernel.shared_bytes;
        done.memory_bytes += kernel.memory_bytes();
        let launch_ns = if launched { 0.0 } else { gpu.launch_ns() };
        let own_ns = gpu.ns(kernel, efficiency) + launch_ns;
        let transfers = match gpu.memory_gb_s {
            // It is in its own time.
            Some(_) => Transfers::default(),
            None => Transfers {
                read: kernel.read_bytes,
                written: kernel.written_bytes,
                random: kernel.random_bytes,
                run: kernel.run_bytes,
                known,
                dma_transfers: 0,
            },
        };
        self.push(turn, Resource::Gpu, own_ns, transfers)
    }

    fn cycles(&self, cycles: u64) -> f64 {
        cycles as f64 / self.clock_ghz
    }

    /// Renders a frame locally. Returns its last job.
    ///
    /// # Errors
    /// An energy that is not known.
    pub(super) fn frame(
        &mut self,
        work: &FrameWork,
        gathering: Gathering,
        after: &[JobId],
        rank: u64,
    ) -> Result<JobId, CostError> {
        let total = work.total();
        let own = self.costs.of(
            &total,
            gathering == Gathering::Unit,
            self.system.array().units(),
        )?;
        self.spent.on_chip += own;
        self.spent.done += total;
        let reached = self.system.gpu.reached_by(Program::of(work));
        let instructions = &self.system.instructions;
        let indexing = instructions.indexing(work);
        let frame = Rendering {
            work,
            gathering,
            gathered: match gathering {
                Gathering::PixelOrder => instructions.gathering(work),
                Gathering::Streamed => instructions.streamed_gathering(work),
                Gathering::Unit => Kernel::default(),
            },
            reached: (self.system.gpu).reached_gathering_by(Program::that_gathers(work)),
            known: ReplayedRates::of(self.replay, work),
            rank,
        };
        let table = |batch: &Batch| match gathering {
            Gathering::PixelOrder => 0.0,
            Gathering::Streamed | Gathering::Unit => batch.rit_bytes as f64,
        };
        let blocks = blocks(work, self.system);
        // All Gaussians of a frame are sorted before the first is drawn, and of a frame without
        // work it is found out that there is none.
        let sorted = (work.gaussians > 0 || blocks.is_empty()).then(|| {
            let finding = indexing.writing(table(&total));
            self.kernel(
                frame.turn("indexing", after.to_vec()),
                &finding,
                reached,
                false,
            )
        });
        let features = total.feature_bytes.max(1) as f64;
        let held = self.system.feature_buffer_bytes / u64::from(self.system.feature_block_bytes);
        let flight = self.system.groups_in_flight as usize;
        let (mut computes, mut last): (Vec<JobId>, Vec<JobId>) = (vec![], vec![]);
        for (i, Block { group, work: step }) in blocks.iter().enumerate() {
            let part = match features > 1.0 {
                true => step.feature_bytes as f64 / features,
                false => 1.0 / blocks.len() as f64,
            };
            let launched = last.len() > *group;
            let mut before = after.to_vec();
            // Which rays go on is known where their last samples were composited.
            if work.gaussians == 0 {
                before.extend(group.checked_sub(flight).map(|group| last[group]));
            }
            let mut own = before.clone();
            // A block of the feature buffer is free when it was read.
            own.extend(i.checked_sub(held as usize).map(|at| computes[at]));
            own.push(match sorted {
                Some(sorted) => sorted,
                None => {
                    let finding = indexing.part(part).writing(table(step));
                    self.kernel(frame.turn("indexing", before), &finding, reached, launched)
                }
            });
            let block = (self.blocks, step, part);
            self.blocks += 1;
            let gather = self.gather(&frame, block, own, launched);
            let compute = self.compute(&frame, block, gather);
            computes.push(compute);
            let shown = self.composite(&frame, block, compute);
            match last.get_mut(*group) {
                Some(last) => *last = shown,
                None => last.push(shown),
            }
        }
        // One or the other is there.
        Ok(last.last().copied().or(sorted).unwrap_or_default())
    }

    /// Gathers the features of a block, on the GPU or the gathering unit.
    fn gather(
        &mut self,
        frame: &Rendering<'_>,
        (block, step, part): BlockPart<'_>,
        after: Vec<JobId>,
        launched: bool,
    ) -> JobId {
        let turn = frame.turn("gathering", after);
        match frame.gathering {
            Gathering::PixelOrder | Gathering::Streamed => {
                let features = step.feature_bytes as f64;
                let own_part = frame.gathered.part(part).writing(features);
                let known = frame.known.rates(frame.gathering);
                self.reading(turn, &own_part, frame.reached, launched, known)
            }
            Gathering::Unit => {
                let transfers = unit_transfers(frame.work, step, part, &frame.known);
                let ns = self.cycles(step.gather_cycles);
                let unit = Resource::GatheringUnit;
                let written = Buffered::gathered(block, step);
                self.buffered(turn, unit, ns, transfers, written)
            }
        }
    }

    /// Computes on the features of a block, on the array.
    fn compute(
        &mut self,
        frame: &Rendering<'_>,
        (block, step, _): BlockPart<'_>,
        gather: JobId,
    ) -> JobId {
        let mut transfers = match frame.gathering {
            // The accelerator reads what the GPU wrote.
            Gathering::PixelOrder | Gathering::Streamed => Transfers {
                read: step.feature_bytes as f64,
                dma_transfers: 1,
                ..Transfers::default()
            },
            Gathering::Unit => Transfers::default(),
        };
        let mut buffered = Buffered::computed(block, step, frame.gathering);
        if step.products > 0 {
            buffered = buffered.loading(self.load_weights(&mut transfers));
        }
        let ns = self.cycles(step.array_cycles);
        let turn = frame.turn("computation", vec![gather]);
        self.buffered(turn, Resource::Npu, ns, transfers, buffered)
    }

    /// Composites a block, and writes its pixels.
    fn composite(
        &mut self,
        frame: &Rendering<'_>,
        (block, step, part): BlockPart<'_>,
        compute: JobId,
    ) -> JobId {
        let shown = Transfers {
            written: part * frame.work.pixels as f64 * PIXEL,
            dma_transfers: 1,
            ..Transfers::default()
        };
        let ns = self.cycles(step.vector_cycles);
        let unit = Resource::VectorUnit;
        let turn = frame.turn("compositing", vec![compute]);
        let buffered = Buffered::composited(block, step);
        self.buffered(turn, unit, ns, shown, buffered)
    }

    /// Loads weights that the weight buffer does not hold; weights that do not fit are loaded again
    /// each time. Returns their bytes.
    fn load_weights(&mut self, transfers: &mut Transfers) -> f64 {
        let (bytes, held) = self.weights;
        if held || bytes <= 0.0 {
            return 0.0;
        }
        self.weights.1 = bytes <= self.system.weight_buffer_bytes as f64;
        transfers.read += bytes;
        transfers.dma_transfers += 1;
        self.spent.weight_bytes += bytes;
        self.spent.on_chip.buffers_pj += self.costs.loaded_weights(bytes);
        bytes
    }

    /// Warps `pixels` of a reference.
    pub(super) fn warp(&mut self, pixels: u64, after: &[JobId], rank: u64) -> JobId {
        let warping = self.system.instructions.warping(pixels);
        self.whole_picture("warping", &warping, after, rank)
    }

    /// Upscales a picture to `pixels`.
    pub(super) fn scale(&mut self, pixels: u64, after: &[JobId], rank: u64) -> JobId {
        let scaling = self.system.instructions.scaling(pixels);
        self.whole_picture("scaling", &scaling, after, rank)
    }

    fn whole_picture(
        &mut self,
        stage: &'static str,
        kernel: &Kernel,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let after = after.to_vec();
        let reached = self.system.gpu.pictures_efficiency;
        self.kernel(Turn { stage, after, rank }, kernel, reached, false)
    }

    /// Renders remotely, and sends so many bytes a pixel.
    pub(super) fn remote(
        &mut self,
        work: &FrameWork,
        bytes: f64,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let ns = gpu_only(
            &self.system.remote,
            &self.system.instructions,
            self.memory,
            work,
        )
        .total_ns();
        let transfers = Transfers::default();
        let turn = |stage, after| Turn { stage, after, rank };
        let made = self.push(
            turn("remote", after.to_vec()),
            Resource::Remote,
            ns,
            transfers,
        );
        let bytes = bytes * work.frame_pixels as f64;
        self.spent.link_bytes += bytes;
        let ns = bytes / self.system.link_bytes_per_second * 1e9;
        // What is received is written to memory.
        let received = Transfers {
            written: bytes,
            dma_transfers: 1,
            ..Transfers::default()
        };
        self.push(turn("link", vec![made]), Resource::Link, ns, received)
    }
}
