//! Demands of a kernel, and the time that each takes on a device.
//!
//! A kernel's time lies between the largest of these times, where its demands overlap wholly, and
//! their sum, where they do not overlap at all. Which of both is nearer depends on occupancy and
//! on the order of instructions, which this model does not know. It therefore gives both.

use crate::Device;

/// Lanes of a warp.
pub(crate) const WARP: f64 = 32.0;
/// Bytes of a line of the first-level cache (L1).
pub(crate) const LINE: f64 = 128.0;
/// Bytes of a sector, the least that moves between caches.
pub(crate) const SECTOR: f64 = 32.0;
/// Schedulers of an SM, an instruction of a warp each a clock (CUDA C++ programming guide,
/// compute capabilities 7.x and 8.x).
const SCHEDULERS: f64 = 4.0;
/// Lines that L1 looks up a clock (Jia et al. 2018, Volta: 128 bytes a clock and SM at most).
const LINES_CLOCK: f64 = 1.0;
/// Share of a pipe's peak that a busy kernel reaches: from 80 % on, Nsight Compute calls a unit
/// saturated.
const ISSUE_SHARE: f64 = 0.8;
/// Share of the tensor peak that layers of 64 outputs reach: fragments are 16 rows, and weights
/// are loaded again for each block (fully fused layers of tiny-cuda-nn, Müller et al. 2021).
const TENSOR_SHARE: f64 = 0.5;

/// Resource that bounds a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// Instructions, on the busiest pipe.
    Issue,
    /// Lines of the first-level cache, and of shared memory.
    L1,
    /// Bytes of the second-level cache.
    L2,
    /// Bytes of the memory, intermediate tensors included.
    Dram,
    /// Operations of the tensor cores.
    Tensor,
    /// Chains of requests that wait for each other.
    Latency,
    /// Copies to the host.
    Copy,
    /// Start and end of kernels on the device.
    Ramp,
    /// The host, which launches kernels.
    Host,
    /// Waits of the host for the device.
    Wait,
}

impl Term {
    /// All terms, those of kernels first.
    pub const ALL: [Self; 10] = [
        Self::Issue,
        Self::L1,
        Self::L2,
        Self::Dram,
        Self::Tensor,
        Self::Latency,
        Self::Copy,
        Self::Ramp,
        Self::Host,
        Self::Wait,
    ];

    /// Short name, for tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Issue => "issue",
            Self::L1 => "L1",
            Self::L2 => "L2",
            Self::Dram => "DRAM",
            Self::Tensor => "tensor",
            Self::Latency => "latency",
            Self::Copy => "copy",
            Self::Ramp => "ramp",
            Self::Host => "host",
            Self::Wait => "wait",
        }
    }
}

/// Demands of a kernel, of all its threads together.
///
/// Instructions are those of warps: 32 lanes count once, however many are active.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    /// Function of the program, and why it asks for this.
    pub name: &'static str,
    /// Instructions, all.
    pub instructions: f64,
    /// Of these, single-precision arithmetic.
    pub fp32: f64,
    /// Of these, integer arithmetic and addresses.
    pub int: f64,
    /// Of these, exponentials, square roots and reciprocals.
    pub sfu: f64,
    /// Lines of 128 bytes that requests of 32 lanes touch, and passes over shared memory.
    pub l1_lines: f64,
    /// Bytes through L2.
    pub l2_bytes: f64,
    /// Bytes from and to the memory.
    pub dram_bytes: f64,
    /// Floating-point operations of the tensor cores.
    pub tensor_flops: f64,
    /// Requests of warps to L2 that wait for the one before.
    pub chained_l2: f64,
    /// Requests of warps to the memory that wait for the one before.
    pub chained_dram: f64,
    /// Clocks of warps that wait for the instruction before, other than for L2.
    pub chained_clocks: f64,
    /// Share of the SM's warps that wait at the same time.
    pub resident: f64,
    /// Clocks of the longest chain within one block, which nothing else hides.
    pub serial_clocks: f64,
    /// Bytes copied to pageable memory of the host.
    pub copied_bytes: f64,
    /// Operations that the host launches for it.
    pub operations: f64,
    /// Whether the host waits for its result.
    pub waits: bool,
}

impl Kernel {
    /// A kernel of one operation that asks for nothing.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self {
            name,
            instructions: 0.0,
            fp32: 0.0,
            int: 0.0,
            sfu: 0.0,
            l1_lines: 0.0,
            l2_bytes: 0.0,
            dram_bytes: 0.0,
            tensor_flops: 0.0,
            chained_l2: 0.0,
            chained_dram: 0.0,
            chained_clocks: 0.0,
            resident: 1.0,
            serial_clocks: 0.0,
            copied_bytes: 0.0,
            operations: 1.0,
            waits: false,
        }
    }

    /// Seconds of each demand on the device.
    #[must_use]
    pub fn terms(&self, device: &Device) -> [(Term, f64); 7] {
        let clock = device.clock_ghz * 1e9;
        let sm_hz = device.sm_hz();
        let on = |warps: f64, lanes: f64| warps * WARP / (lanes * sm_hz);
        let issue = (self.instructions / (SCHEDULERS * sm_hz))
            .max(on(self.fp32, device.fp32_lanes))
            .max(on(self.int, device.int_lanes))
            .max(on(self.sfu, device.sfu_lanes));
        let waiting = self.chained_l2 * device.l2_latency_clocks + self.chained_clocks;
        let waiting = waiting / clock + self.chained_dram * device.dram_latency_ns * 1e-9;
        let waiters = self.resident * device.warps * device.multiprocessors;
        let dram = device.dram_gb_s * 1e9 * device.dram_share;
        [
            (Term::Issue, issue / ISSUE_SHARE),
            (Term::L1, self.l1_lines / (LINES_CLOCK * sm_hz)),
            (Term::L2, self.l2_bytes / (device.l2_bytes_clock * sm_hz)),
            (Term::Dram, self.dram_bytes / dram),
            (
                Term::Tensor,
                self.tensor_flops / (device.tensor_tflops * 1e12 * TENSOR_SHARE),
            ),
            (
                Term::Latency,
                (waiting / waiters).max(self.serial_clocks / clock),
            ),
            (Term::Copy, self.copied_bytes / (device.copy_gb_s * 1e9)),
        ]
    }

    /// Seconds if the demands overlap wholly, and if they do not overlap.
    ///
    /// ```
    /// use potamoi_gpu::{Device, Kernel};
    /// # fn main() -> Result<(), potamoi_gpu::DeviceError> {
    /// let device = Device::builtin("a6000")?;
    /// let kernel = Kernel { dram_bytes: 1e9, instructions: 1e8, ..Kernel::new("example") };
    /// let (largest, sum) = kernel.bounds(&device);
    /// assert!(largest < sum && sum < 2.0 * largest);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn bounds(&self, device: &Device) -> (f64, f64) {
        let terms = self.terms(device);
        let largest = terms.iter().map(|(_, s)| *s).fold(0.0, f64::max);
        (largest, terms.iter().map(|(_, s)| s).sum())
    }

    /// The kernel with all demands times a factor; operations and waits stay.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut own = self.clone();
        for demand in own.demands() {
            *demand *= factor;
        }
        own
    }

    /// All demands on the device, for scaling and for tests.
    pub(crate) fn demands(&mut self) -> [&mut f64; 13] {
        [
            &mut self.instructions,
            &mut self.fp32,
            &mut self.int,
            &mut self.sfu,
            &mut self.l1_lines,
            &mut self.l2_bytes,
            &mut self.dram_bytes,
            &mut self.tensor_flops,
            &mut self.chained_l2,
            &mut self.chained_dram,
            &mut self.chained_clocks,
            &mut self.serial_clocks,
            &mut self.copied_bytes,
        ]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::device::{Better, FIELDS};

    /// Asks for something of everything.
    fn busy() -> Kernel {
        let mut own = Kernel::new("busy");
        for (place, demand) in own.demands().into_iter().enumerate() {
            *demand = 1e6 * (place + 1) as f64;
        }
        own.resident = 0.5;
        own
    }

    #[test]
    fn the_largest_is_at_most_the_sum() {
        for name in Device::names() {
            let device = Device::builtin(name).unwrap();
            for scale in [1e-3, 1.0, 1e3] {
                let (largest, sum) = busy().scaled(scale).bounds(&device);
                assert!(0.0 < largest && largest <= sum, "{name}");
            }
        }
    }

    /// Each pipe of the multiprocessors by itself bounds the issue of its instructions.
    #[test]
    fn each_pipe_takes_a_lane_clock_an_operation() {
        let device = Device::builtin("xavier-maxn").unwrap();
        let clocks = |set: fn(&mut Kernel)| {
            let mut own = Kernel::new("one pipe");
            set(&mut own);
            let of_issue = own
                .terms(&device)
                .into_iter()
                .find(|(term, _)| *term == Term::Issue);
            of_issue.unwrap().1 * device.sm_hz() * ISSUE_SHARE
        };
        for (found, lanes) in [
            (clocks(|own| own.fp32 = 1e6), device.fp32_lanes),
            (clocks(|own| own.int = 1e6), device.int_lanes),
            (clocks(|own| own.sfu = 1e6), device.sfu_lanes),
            (clocks(|own| own.instructions = 1e6), WARP * SCHEDULERS),
        ] {
            assert!(
                (found * lanes / (1e6 * WARP) - 1.0).abs() < 1e-12,
                "{lanes}: {found}"
            );
        }
    }

    #[test]
    fn a_kernel_scales_linearly() {
        let device = Device::builtin("orin-nx").unwrap();
        let (largest, sum) = busy().bounds(&device);
        let (largest_3, sum_3) = busy().scaled(3.0).bounds(&device);
        assert!((largest_3 / largest - 3.0).abs() < 1e-12);
        assert!((sum_3 / sum - 3.0).abs() < 1e-12);
    }

    #[test]
    fn more_demand_never_takes_less_time() {
        let device = Device::builtin("v100").unwrap();
        let (largest, sum) = busy().bounds(&device);
        for place in 0..13 {
            let mut more = busy();
            *more.demands()[place] *= 2.0;
            let (largest_more, sum_more) = more.bounds(&device);
            assert!(largest_more >= largest && sum_more >= sum, "{place}");
        }
    }

    #[test]
    fn a_better_device_never_takes_more_time() {
        let device = Device::builtin("3070").unwrap();
        let (largest, sum) = busy().bounds(&device);
        for field in &FIELDS {
            let mut better = device.clone();
            *(field.place)(&mut better) *= match field.better {
                Better::More => 2.0,
                Better::Less => 0.5,
            };
            let (largest_better, sum_better) = busy().bounds(&better);
            assert!(largest_better <= largest, "{}", field.key);
            assert!(sum_better <= sum, "{}", field.key);
        }
    }

    #[test]
    fn nothing_takes_no_time_and_an_infinite_device_needs_none() {
        let device = Device::builtin("xavier-maxn").unwrap();
        assert_eq!(Kernel::new("empty").bounds(&device), (0.0, 0.0));
        assert_eq!(busy().bounds(&Device::infinite()), (0.0, 0.0));
    }

    /// A copy of a gigabyte on the A6000: 0.8 of 768 GB/s.
    #[test]
    fn a_stream_takes_its_share_of_the_bandwidth() {
        let device = Device::builtin("a6000").unwrap();
        let copy = Kernel {
            dram_bytes: 2e9,
            ..Kernel::new("copy")
        };
        let expected = 2e9 / (768e9 * device.dram_share);
        assert!((copy.bounds(&device).0 - expected).abs() < 1e-12);
    }
}
