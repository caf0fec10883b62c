//! Checks of the packer: vectors in flight, and each pair in its lane.

use potamoi_netlist::{Instance, ModuleBuilder, Signal, Ty};

use crate::circuits::bits_for;

/// The vector that is filled.
pub(super) struct Filling {
    /// Powers and infos of the lanes, the first lane lowest once the vector is full.
    pub(super) powers: Signal,
    pub(super) infos: Signal,
    /// Lanes that are filled.
    pub(super) count: Signal,
    pub(super) lanes: u32,
    /// Vectors in flight at most.
    pub(super) depth: u32,
}

/// Checks of `splat_powers`, whose lanes are `exponentials` and whose infos wait in `words`.
pub(super) fn packing_checks(
    m: &mut ModuleBuilder,
    (exponentials, words): (Instance, Instance),
    filling: &Filling,
) {
    let Filling { lanes, depth, .. } = *filling;
    m.begin_checks();
    m.inside(exponentials, "in_flight");
    m.inside_as("lanes_take", exponentials, "s_axis_vec_tready");
    m.inside(words, "count");
    m.assume(
        "takes_offered",
        "pop -> out_valid",
        "A vector of results is taken only if one is offered.",
    );
    m.invariant("in_flight_fits", &format!("in_flight <= {depth}"), "");
    m.invariant("count_fits", &format!("count <= {lanes}"), "");
    m.assert(
        "balance",
        "in_flight == exponentials_in_flight & in_flight == info_fifo_count",
        "Every vector in flight has its opacities, colours and pixels: none is lost, none is there twice.",
    );
    m.assert(
        "sent_is_taken",
        "sent -> lanes_take",
        "The lanes take each vector that is sent.",
    );
    let (power, info) = ("power_past", "info_past");
    let number = bits_for(lanes) + 1;
    m.free("pick", number);
    let taken = m.ghost_reg("taken", number);
    m.ghost_next(taken, "accepts", "taken + 1");
    let tracked = m.ghost_reg("tracked", 1);
    let place = m.ghost_reg("place", bits_for(lanes));
    let [power, info] = [(power, "power"), (info, "info")].map(|(name, port)| {
        let width = m.named(port).width();
        (m.ghost_reg(name, width), port)
    });
    m.ghost("enters", "accepts & taken == pick & ~tracked");
    m.ghost("leaves", "sent & tracked");
    m.ghost_next(tracked, "enters | leaves", "enters");
    m.ghost_next(place, "enters", "count_held");
    for (register, port) in [power, info] {
        m.ghost_next(register, "enters", port);
    }
    pair_in_its_lane(m, filling, place);
    m.assert(
        "packed_in_order",
        "tracked -> place < count & is_pair & power_kept & info_kept",
        "The n-th pair that is taken is in its lane of the vector, unchanged, until the vector is sent, for every n.",
    );
    let pairs = m.ghost_reg("pairs", bits_for(lanes));
    m.ghost_next(pairs, "1", "if(sent, 0, pairs) + accepts");
    m.assert(
        "none_lost",
        "ones(pairs_held) == pairs",
        "A vector has as many pairs as were taken since the one before: none is lost, none is there twice.",
    );
    m.cover("fills", "full & pairs == count", "A vector of pairs alone.");
    m.cover("passes", "leaves", "A pair leaves for the lanes.");
}

/// What is in the lane of the pair at `place`: `is_pair`, `power_kept`, `info_kept`; and the lanes with
/// pairs, `pairs_held`.
fn pair_in_its_lane(m: &mut ModuleBuilder, filling: &Filling, place: Signal) {
    let Filling {
        powers,
        infos,
        count,
        lanes,
        ..
    } = *filling;
    let wide = Ty::u(bits_for(2 * lanes));
    let [place, count] = [place, count].map(|value| m.extend(value, wide.width));
    let all = m.lit(lanes, wide);
    let empty = m.sub(all, count);
    let at = m.add(empty, place);
    let at = m.name(at, "lane_of_pair");
    let lane_of = |m: &mut ModuleBuilder, all: Signal| {
        let width = all.width() / lanes;
        let each: Vec<Signal> = (0..lanes).map(|i| m.slice(all, i * width, width)).collect();
        match each[..] {
            [only] => only,
            _ => m.select(at, &each),
        }
    };
    let power = lane_of(m, powers);
    m.name(power, "power_at_place");
    let info = lane_of(m, infos);
    let width = info.width() - 1;
    let is_pair = m.bit(info, width);
    m.name(is_pair, "is_pair");
    let info = m.slice(info, 0, width);
    m.name(info, "info_at_place");
    m.same("power_kept", "power_at_place", "power_past");
    m.same("info_kept", "info_at_place", "info_past");
    let held: Vec<Signal> = (0..lanes)
        .rev()
        .map(|i| {
            let flag = m.bit(infos, i * (width + 1) + width);
            let own = m.lit(i, wide);
            let filled = m.ge(own, empty);
            m.and(flag, filled)
        })
        .collect();
    let held = m.cat(&held);
    m.name(held, "pairs_held");
}
