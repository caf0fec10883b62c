//! Control signals common to all lanes.

use std::collections::BTreeMap;

use potamoi_formats::config::VuConfig;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::operation_kinds::OperationKinds;

/// Port that tells whether the operation of the operands is `op`.
pub(super) fn asked_port(op: OpCode) -> String {
    format!("is_{}", op.name().replace('-', "_"))
}

/// Control signals common to all lanes.
pub(super) struct LaneControl {
    pub(super) accept: Signal,
    pub(super) code: Signal,
    /// Of a registered unit, instead of the code: each element-wise operation, and whether it is that
    /// of the operands.
    pub(super) asked: BTreeMap<OpCode, Signal>,
    pub(super) one_minus: Signal,
    pub(super) shift: Signal,
    pub(super) rounding: Signal,
    pub(super) is_exp: Signal,
    pub(super) was_one_minus: Signal,
    pub(super) was_softplus: Signal,
}

impl LaneControl {
    pub(super) fn declare(m: &mut ModuleBuilder, vu: &VuConfig, kinds: OperationKinds) -> Self {
        let registered = vu.registered;
        let (shift_doc, rounding_doc) = match registered {
            true => (
                "before the result stage: bits dropped",
                "before the result stage",
            ),
            false => ("of the result stage: bits dropped", "of the result stage"),
        };
        let OperationKinds {
            exp,
            one_minus,
            elementwise,
            softplus,
            ..
        } = kinds;
        let bit = Ty::bit();
        let none = m.lit(0, bit);
        let unused = m.lit(0, Ty::u(6));
        let mut port = |on: bool, name: &str, ty: Ty, doc: &str, or: Signal| {
            if on { m.input(name, ty, doc) } else { or }
        };
        let asked = vu.ops.iter();
        let asked = asked.filter(|op| registered && !op.is_exponential());
        Self {
            accept: port(
                true,
                "accept",
                bit,
                "takes the operands at the clock edge",
                none,
            ),
            asked: asked
                .map(|op| {
                    let name = asked_port(*op);
                    (
                        *op,
                        port(true, &name, bit, "operation of the operands", none),
                    )
                })
                .collect(),
            code: port(
                elementwise && !registered,
                "code",
                Ty::u(4),
                "operation of the operands",
                unused,
            ),
            one_minus: port(
                one_minus,
                "one_minus",
                bit,
                "of the operands: 1 - exp(-s)",
                none,
            ),
            shift: port(elementwise, "shift", Ty::u(6), shift_doc, unused),
            rounding: port(elementwise, "rounding", Ty::u(2), rounding_doc, unused),
            is_exp: port(
                exp && elementwise,
                "result_is_exp",
                bit,
                "of the result stage",
                none,
            ),
            was_one_minus: port(
                one_minus,
                "result_is_one_minus",
                bit,
                "of the result stage",
                none,
            ),
            was_softplus: port(
                softplus,
                "result_is_softplus",
                bit,
                "of the result stage",
                none,
            ),
        }
    }
}
