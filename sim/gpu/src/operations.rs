//! Operations of eager programs: element-wise tensors, selection by a mask, dense layers.
//!
//! An eager framework writes every intermediate tensor to memory and reads it again, unless it
//! fits in the second-level cache.

use crate::kernel::{LINE, WARP};
use crate::{Device, Kernel};

/// Part of L2 that a tensor may fill and still be there when it is read again: the other half
/// holds what is written next.
const KEPT: f64 = 0.5;

/// Bytes that go to memory: all, unless each operation's part stays in L2.
fn spilled(bytes: f64, operations: f64, device: &Device) -> f64 {
    if bytes / operations.max(1.0) > device.l2_bytes * KEPT {
        bytes
    } else {
        0.0
    }
}

/// Element-wise operations over `elements` rows. `row_bytes` are read and written a row, all
/// operations together. Each takes 12 instructions a row and operation: two loads or stores with
/// their addresses, bounds and arithmetic (unrolled kernels of PyTorch).
pub(crate) fn elementwise(
    name: &'static str,
    elements: f64,
    row_bytes: f64,
    operations: f64,
    device: &Device,
) -> Kernel {
    let bytes = elements * row_bytes;
    let rows = operations * elements / WARP;
    Kernel {
        instructions: rows * 12.0,
        fp32: rows * 4.0,
        int: rows * 5.0,
        l1_lines: bytes / LINE,
        l2_bytes: bytes,
        dram_bytes: spilled(bytes, operations, device),
        operations,
        ..Kernel::new(name)
    }
}

/// The same with more instructions a row and operation, for fused kernels.
pub(crate) fn heavier(instructions: f64, kernel: Kernel) -> Kernel {
    let factor = instructions / 12.0;
    Kernel {
        instructions: kernel.instructions * factor,
        fp32: kernel.fp32 * factor,
        int: kernel.int * factor,
        ..kernel
    }
}

/// The kernel, after which the host waits.
pub(crate) fn waited(kernel: Kernel) -> Kernel {
    Kernel {
        waits: true,
        ..kernel
    }
}

/// `tensor[mask]`: counts (the host waits), compacts into 64-bit indices, gathers rows. The mask
/// is read twice; five kernels, of which the framework launches four as operations.
pub(crate) fn select(
    name: &'static str,
    elements: f64,
    kept: f64,
    row_bytes: f64,
    device: &Device,
) -> Kernel {
    let bytes = 2.0 * elements + kept * (16.0 + 2.0 * row_bytes);
    Kernel {
        instructions: (elements * 12.0 + kept * 15.0) / WARP,
        int: (elements * 6.0 + kept * 8.0) / WARP,
        l1_lines: bytes / LINE,
        l2_bytes: bytes,
        dram_bytes: spilled(bytes, 1.0, device),
        operations: 4.0,
        waits: true,
        ..Kernel::new(name)
    }
}

/// A dense layer in single precision on the usual lanes: a multiply-add each, and 15 % for loads
/// of tiles. Operands pass L2 about twice.
pub(crate) fn layer(
    name: &'static str,
    rows: f64,
    (inputs, outputs): (f64, f64),
    device: &Device,
) -> Kernel {
    let macs = rows * inputs * outputs / WARP;
    Kernel {
        instructions: macs * 1.15,
        fp32: macs,
        ..operands(name, rows * (inputs + outputs) * 4.0, device)
    }
}

/// A dense layer in half precision on the tensor cores, padded to multiples of 8.
pub(crate) fn half_layer(
    name: &'static str,
    rows: f64,
    (inputs, outputs): (f64, f64),
    device: &Device,
) -> Kernel {
    let padded = |n: f64| (n / 8.0).ceil() * 8.0;
    Kernel {
        tensor_flops: 2.0 * rows * padded(inputs) * padded(outputs),
        ..operands(name, rows * (inputs + outputs) * 2.0, device)
    }
}

/// Operations that both kinds of layers share: product and bias.
fn operands(name: &'static str, bytes: f64, device: &Device) -> Kernel {
    Kernel {
        l1_lines: bytes / LINE,
        l2_bytes: 2.0 * bytes,
        dram_bytes: spilled(bytes, 1.0, device),
        operations: 2.0,
        ..Kernel::new(name)
    }
}

/// A picture copied to the host, which waits for it.
pub(crate) fn copied(name: &'static str, bytes: f64, operations: f64) -> Kernel {
    Kernel {
        copied_bytes: bytes,
        operations,
        waits: true,
        ..Kernel::new(name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn device() -> Device {
        Device::builtin("v100").unwrap()
    }

    #[test]
    fn tensors_that_fit_in_half_of_l2_stay_there() {
        let fits = device().l2_bytes * 0.4;
        assert_eq!(elementwise("a", fits, 1.0, 1.0, &device()).dram_bytes, 0.0);
        let large = device().l2_bytes;
        assert_eq!(
            elementwise("a", large, 1.0, 1.0, &device()).dram_bytes,
            large
        );
        // Three operations of a third each.
        assert_eq!(elementwise("a", large, 1.0, 3.0, &device()).dram_bytes, 0.0);
    }

    #[test]
    fn selection_waits_and_layers_are_padded() {
        assert!(select("s", 1e6, 1e3, 12.0, &device()).waits);
        let layer = half_layer("l", 10.0, (31.0, 3.0), &device());
        assert_eq!(layer.tensor_flops, 2.0 * 10.0 * 32.0 * 8.0);
    }
}
