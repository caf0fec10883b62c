//! Composes a frame of jobs: resources, dependencies, bytes and energy.

use super::blocks::{Block, blocks};
use super::buffers::Buffered;
use super::costs::{Costs, sum};
use super::gpu_only::gpu_only_at;
use super::gpu_work::GpuWork;
use super::job_scheduler::{Job, JobId, Resource, Share, Shared};
use super::kernels::{self, PIXEL};
use super::memory::Memory;
use super::spent::Spent;
use super::system::System;
use super::transfers::{ReplayedRates, Transfers, unit_transfers};
use super::variant::Gathering;
use super::work::{FrameWork, PathReplay, Replayed};
use potamoi_cycles::batch::Batch;
use potamoi_gpu::Overlap;

/// Appends the jobs of frames to a list.
pub(super) struct Composer<'a> {
    system: &'a System,
    memory: &'a Memory,
    costs: &'a Costs,
    clock_ghz: f64,
    overlap: Overlap,
    replay: Option<&'a PathReplay>,
    /// Bytes of the model's weights, and whether the weight buffer holds them.
    weights: (f64, bool),
    /// Blocks of the feature buffer so far.
    blocks: u64,
    /// Jobs that read the blocks of the frames so far, where frames fill the buffer in order.
    read: Option<Vec<JobId>>,
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
    /// Gathering of the whole frame as GPU kernels.
    gathered: GpuWork,
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
    /// An empty list for a system whose accelerator has the clock `clock_ghz`, at one bound of the
    /// GPU's kernels.
    #[must_use]
    pub(super) fn new(
        system: &'a System,
        memory: &'a Memory,
        costs: &'a Costs,
        (clock_ghz, overlap): (f64, Overlap),
        weight_bytes: u64,
        replay: Option<&'a PathReplay>,
    ) -> Self {
        Self {
            system,
            memory,
            costs,
            clock_ghz,
            overlap,
            replay,
            weights: (weight_bytes as f64, false),
            blocks: 0,
            read: None,
            jobs: vec![],
            spent: Spent::default(),
        }
    }

    /// Frames under way share the blocks of the feature buffer, and fill them in order.
    pub(super) fn in_order(&mut self) {
        self.read = Some(vec![]);
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
        self.spent.memory_io_pj += transfers.io_pj(self.memory) + descriptors.io_pj(self.memory);
        self.spent.streamed_bytes += transfers.read;
        self.spent.written_bytes += transfers.written;
        self.spent.random_bytes += transfers.random;
        self.spent.feature_buffer_bytes += buffered.features;
        self.spent.weight_buffer_bytes += buffered.weights;
        let memory_ns = transfers.ns(self.memory) + descriptors.ns(self.memory);
        let wires = self.system.interconnect_gb_s();
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

    /// Appends work of the GPU, or a part of work that was launched before.
    fn kernel(&mut self, turn: Turn, work: &GpuWork, launched: bool) -> JobId {
        self.reading(turn, work, launched, [None; 2])
    }

    /// Appends work of the GPU whose reads are known.
    ///
    /// Where demands do not overlap, the bytes of the shared memory take a time of their own: that
    /// which they need alone. They still go through the memory meanwhile, where others wait for
    /// them.
    fn reading(
        &mut self,
        turn: Turn,
        work: &GpuWork,
        launched: bool,
        known: [Option<Replayed>; 2],
    ) -> JobId {
        let gpu = &self.system.gpu;
        let done = &mut self.spent.gpu;
        if !launched {
            done.launches += work.sum(|own| own.operations);
        }
        done.instructions += work.sum(|own| own.instructions);
        done.l1_lines += work.sum(|own| own.l1_lines);
        done.l2_bytes += work.sum(|own| own.l2_bytes);
        done.memory_bytes += work.memory_bytes();
        let own_ns = work.own_ns(gpu, self.overlap, launched);
        let transfers = match gpu.shares_memory {
            // It is in its own time.
            false => Transfers::default(),
            true => Transfers {
                read: work.read_bytes,
                written: work.written_bytes,
                random: work.random_bytes,
                run: work.run_bytes,
                known,
                dma_transfers: 0,
            },
        };
        let stands_ns = match self.overlap {
            Overlap::Whole => 0.0,
            Overlap::None => transfers.ns(self.memory),
        };
        self.push(turn, Resource::Gpu, own_ns + stands_ns, transfers)
    }

    fn cycles(&self, cycles: u64) -> f64 {
        cycles as f64 / self.clock_ghz
    }

    /// Renders a frame locally. Returns its last job.
    pub(super) fn frame(
        &mut self,
        work: &FrameWork,
        gathering: Gathering,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let total = work.total();
        let own = self.costs.of(
            &total,
            gathering == Gathering::Unit,
            self.system.array().units(),
        );
        self.spent.on_chip += own;
        self.spent.done += total;
        let indexing = kernels::indexing(work);
        let frame = Rendering {
            work,
            gathering,
            gathered: match gathering {
                Gathering::PixelOrder => kernels::gathering(work),
                Gathering::Streamed => kernels::streamed_gathering(work),
                Gathering::Unit => GpuWork::default(),
            },
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
            let finding = indexing.clone().writing(table(&total));
            self.kernel(frame.turn("indexing", after.to_vec()), &finding, false)
        });
        let features = total.feature_bytes.max(1) as f64;
        let held = self.system.feature_buffer_bytes / u64::from(self.system.feature_block_bytes);
        let flight = self.system.groups_in_flight as usize;
        let is_in_order = self.read.is_some();
        let mut computes = self.read.take().unwrap_or_default();
        let mut last: Vec<JobId> = vec![];
        for Block { group, work: step } in &blocks {
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
            let read = computes.len().checked_sub(held as usize);
            own.extend(read.map(|at| computes[at]));
            own.push(match sorted {
                Some(sorted) => sorted,
                None => {
                    let finding = indexing.part(part).writing(table(step));
                    self.kernel(frame.turn("indexing", before), &finding, launched)
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
        self.read = is_in_order.then_some(computes);
        // One or the other is there.
        last.last().copied().or(sorted).unwrap_or_default()
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
                self.reading(turn, &own_part, launched, known)
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
        let (unit, cycles) = match step.splat_jobs > 0 {
            true => (Resource::SplatUnits, step.splat_elapsed),
            false => (Resource::VectorUnit, step.vector_cycles),
        };
        let turn = frame.turn("compositing", vec![compute]);
        let buffered = Buffered::composited(block, step);
        self.buffered(turn, unit, self.cycles(cycles), shown, buffered)
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
        let buffers = &mut self.spent.on_chip.buffers_pj;
        *buffers = sum(*buffers, self.costs.memories.loaded_weights(bytes));
        bytes
    }

    /// Warps `pixels` of a reference.
    pub(super) fn warp(&mut self, pixels: u64, after: &[JobId], rank: u64) -> JobId {
        self.whole_picture("warping", &kernels::warping(pixels), after, rank)
    }

    /// Upscales a picture to `pixels`.
    pub(super) fn scale(&mut self, pixels: u64, after: &[JobId], rank: u64) -> JobId {
        self.whole_picture("scaling", &kernels::scaling(pixels), after, rank)
    }

    fn whole_picture(
        &mut self,
        stage: &'static str,
        work: &GpuWork,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let after = after.to_vec();
        self.kernel(Turn { stage, after, rank }, work, false)
    }

    /// Renders remotely, and sends so many bytes a pixel.
    pub(super) fn remote(
        &mut self,
        work: &FrameWork,
        bytes: f64,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let ns = gpu_only_at(&self.system.remote.device, work, self.overlap);
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
        // Received bytes are written to memory.
        let received = Transfers {
            written: bytes,
            dma_transfers: 1,
            ..Transfers::default()
        };
        self.push(turn("link", vec![made]), Resource::Link, ns, received)
    }
}
