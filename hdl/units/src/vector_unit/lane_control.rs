//! Control signals common to all lanes.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::operation_kinds::OperationKinds;

/// Control signals common to all lanes.
pub(super) struct LaneControl {
    pub(super) accept: Signal,
    pub(super) code: Signal,
    pub(super) one_minus: Signal,
    pub(super) shift: Signal,
    pub(super) rounding: Signal,
    pub(super) is_exp: Signal,
    pub(super) was_one_minus: Signal,
    pub(super) was_softplus: Signal,
}

impl LaneControl {
    pub(super) fn declare(m: &mut ModuleBuilder, kinds: OperationKinds) -> Self {
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
        Self {
            accept: port(
                true,
                "accept",
                bit,
                "takes the operands at the clock edge",
                none,
            ),
            code: port(
                elementwise,
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
            shift: port(
                elementwise,
                "shift",
                Ty::u(6),
                "of the result stage: bits dropped",
                unused,
            ),
            rounding: port(
                elementwise,
                "rounding",
                Ty::u(2),
                "of the result stage",
                unused,
            ),
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
