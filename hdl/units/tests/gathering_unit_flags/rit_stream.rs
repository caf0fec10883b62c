//! The shape of a RIT stream: beats without bytes, `tuser`, MVoxels that are too large.

use potamoi_formats::config::Config;
use potamoi_units::gathering_unit::gathering_unit;

use super::{Beat, FULL, UNIT, Unit, entry, even};

/// The groups before may have been issued or not: the features end with a beat of
/// their own, the table is let go of, and the next MVoxel finds it.
#[test]
fn a_bare_last_beat_ends_its_mvoxel_after_any_gap() {
    let null = (u64::MAX, 0, true);
    // Two single ids fill a beat, an entry of eight vertices six.
    let ids = vec![(2 << 32 | 1, FULL, false)];
    let mut cell = entry(even());
    cell[5].2 = false;
    let one_port: &[&[(u64, u64)]] = &[&[(3, 0), (3, 0), (0, 1)], &[(3, 0), (0, 1)]];
    // A group of two that is only begun ends the features itself.
    let two_ports: &[&[(u64, u64)]] = &[&[(15, 0), (0, 1)], &[(3, 1)]];
    for (ports, wanted) in [(1, one_port), (2, two_ports)] {
        let text = UNIT.replace("ports = 1", &format!("ports = {ports}"));
        let text = text.replace("[rit]\n", "[rit]\nstream_bits = 64\n");
        let module = gathering_unit(&Config::from_toml(&text, "test").unwrap()).unwrap();
        for ((log2, beats), wanted) in [(0, &ids), (3, &cell)].into_iter().zip(wanted) {
            for gap in 0..24 {
                let mut unit = Unit::new(&module, log2, 1);
                let mut sent: Vec<_> = beats.iter().map(|beat| (*beat, 0)).collect();
                sent.push((null, gap));
                for mvoxel in 0..3 {
                    unit.rows(&[1, 2, 3, 4]);
                    let found = unit.play(&sent);
                    let label = format!("{ports} ports, {log2}, gap {gap}, MVoxel {mvoxel}");
                    assert_eq!(found, *wanted, "{label}");
                }
                assert_eq!(unit.flags(), 0);
            }
        }
    }
}

/// Wherever null beats stand and whatever they say: the same features.
#[test]
fn bare_beats_within_an_mvoxel_are_none() {
    let beats = entry(even());
    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    let null = ((u64::MAX, 0, false), 1);
    let sent: Vec<_> = beats.iter().flat_map(|b| [null, null, (*b, 0)]).collect();
    assert_eq!(unit.play(&sent), [(3, 1)]);
    assert_eq!(unit.get("stat_entries"), 1);
    assert_eq!(unit.flags(), 0);
}

/// Halfway through an entry, and before any.
#[test]
fn a_bare_last_beat_behind_no_whole_entry_is_flagged() {
    let null = ((0, 0, true), 0);
    for beats in [&entry(even())[..3], &[]] {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        let mut sent: Vec<_> = beats.iter().map(|beat| (*beat, 0)).collect();
        sent.push(null);
        unit.play(&sent);
        assert_eq!(unit.flags() & !0b111, 1 << 3, "{} beats", beats.len());
    }
}

/// An MVoxel is streamed once for every segment, or not.
#[test]
fn a_tuser_that_changes_within_an_mvoxel_is_flagged() {
    for turns_at in 0..7 {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        for (at, beat) in entry(even()).into_iter().enumerate() {
            unit.set("s_axis_rit_tuser", u64::from(at >= turns_at));
            unit.set("s_axis_rit_tvalid", 1);
            unit.set("s_axis_rit_tdata", beat.0);
            unit.set("s_axis_rit_tkeep", beat.1);
            unit.set("s_axis_rit_tlast", u64::from(beat.2));
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        let turns = (1..6).contains(&turns_at);
        assert_eq!(unit.flags(), u64::from(turns) << 4, "{turns_at}");
    }
}

/// More entries than both halves hold must be streamed once a segment.
#[test]
fn an_mvoxel_too_large_to_keep_raises_its_flag() {
    for (entries, segments, flag) in [(17, 2, 1 << 5), (16, 2, 0), (17, 1, 0)] {
        let mut unit = Unit::of("", 3, segments);
        for _ in 0..2 {
            unit.rows(&[1, 2, 3, 4]);
        }
        let mut beats: Vec<Beat> = (0..entries).flat_map(|_| entry(even())).collect();
        let last = beats.len() - 1;
        for (i, beat) in beats.iter_mut().enumerate() {
            beat.2 = i == last;
        }
        unit.set("s_axis_rit_tvalid", 1);
        for (data, keep, last) in beats {
            unit.set("s_axis_rit_tdata", data);
            unit.set("s_axis_rit_tkeep", keep);
            unit.set("s_axis_rit_tlast", u64::from(last));
            // Such an MVoxel is never let go of: do not wait for ever.
            for _ in 0..300 {
                if unit.get("s_axis_rit_tready") == 1 {
                    break;
                }
                unit.run.clock().unwrap();
            }
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        for _ in 0..300 {
            unit.run.clock().unwrap();
        }
        assert_eq!(
            unit.get("stat_errors"),
            flag,
            "{entries} entries, {segments}"
        );
    }
}
