//! Work of a GPU: kernels, and bytes of memory by access pattern.

use potamoi_gpu::{Device, Frame, Kernel, Launch, Overlap};

use super::gpu::Gpu;

/// Work that is launched together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GpuWork {
    /// The launched operations, in this order.
    pub kernels: Vec<Kernel>,
    /// Bytes read sequentially from memory.
    pub read_bytes: f64,
    /// Bytes written sequentially to memory.
    pub written_bytes: f64,
    /// Bytes read at random from memory.
    pub random_bytes: f64,
    /// Bytes of a random access.
    pub run_bytes: f64,
}

impl GpuWork {
    /// One kernel; its bytes of memory are those given: read and written in sequence.
    pub(super) fn streaming(kernel: Kernel, read_bytes: f64, written_bytes: f64) -> Self {
        Self {
            kernels: vec![Kernel {
                dram_bytes: read_bytes + written_bytes,
                ..kernel
            }],
            read_bytes,
            written_bytes,
            ..Self::default()
        }
    }

    /// A share of the work.
    #[must_use]
    pub fn part(&self, share: f64) -> Self {
        Self {
            kernels: self.kernels.iter().map(|k| k.scaled(share)).collect(),
            read_bytes: self.read_bytes * share,
            written_bytes: self.written_bytes * share,
            random_bytes: self.random_bytes * share,
            run_bytes: self.run_bytes,
        }
    }

    /// The work with further bytes written by its last kernel.
    #[must_use]
    pub fn writing(mut self, bytes: f64) -> Self {
        self.written_bytes += bytes;
        if let Some(last) = self.kernels.last_mut() {
            last.dram_bytes += bytes;
            last.l2_bytes += bytes;
            last.l1_lines += bytes / 128.0;
        }
        self
    }

    /// Bytes of memory, read and written.
    #[must_use]
    pub const fn memory_bytes(&self) -> f64 {
        self.read_bytes + self.written_bytes + self.random_bytes
    }

    /// Sum of a demand over all kernels.
    pub(super) fn sum(&self, of: impl Fn(&Kernel) -> f64) -> f64 {
        self.kernels.iter().map(of).sum()
    }

    /// Nanoseconds on a device. Without `with_memory` bytes of memory take none of them: they go
    /// through a memory that others share. A part of work that is `launched` already adds neither
    /// launches nor waits.
    #[must_use]
    pub fn ns(&self, device: &Device, overlap: Overlap, with_memory: bool, launched: bool) -> f64 {
        let kernels = self.kernels.iter().map(|own| Kernel {
            dram_bytes: if with_memory { own.dram_bytes } else { 0.0 },
            operations: if launched { 0.0 } else { own.operations },
            waits: own.waits && !launched,
            ..own.clone()
        });
        let frame = Frame {
            launch: Launch::Native,
            kernels: kernels.collect(),
        };
        frame.time(device, overlap, None).seconds * 1e9
    }

    /// Nanoseconds of its own on a system's GPU.
    pub(super) fn own_ns(&self, gpu: &Gpu, overlap: Overlap, launched: bool) -> f64 {
        let ns = |own: &Self| own.ns(&gpu.device, overlap, !gpu.shares_memory, launched);
        if gpu.moved.is_empty() {
            return ns(self);
        }
        let mut left = self.clone();
        left.kernels.retain(|own| !gpu.moved.contains(&own.name));
        match left.kernels.is_empty() {
            true => 0.0,
            false => ns(&left),
        }
    }
}
