//! `potamoi layouts`: every organisation has the cycles of its own unit.

use crate::common::{expect, json};

#[test]
fn organisations_of_both_built_in_scenes_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    // 16 splats in the order of their rows do not conflict; 64 do.
    for (scene, conflicting) in [("garden", [64].as_slice()), ("lantern", &[16, 64])] {
        let size = ["--scene", scene, "--width", "20"];
        let arguments = [&["layouts"], &size[..], &["--json", "r.json"]].concat();
        let said = expect(folder.path(), 0, &arguments);
        assert!(said.contains("feature-major, 16 banks, 64 lanes"), "{said}");
        let r = json(&folder.path().join("r.json"));
        let rows = r["layouts"].as_array().unwrap();
        assert_eq!(rows.len(), 9);
        // Splats are no cells.
        let refused = rows.iter().filter(|row| row["refused"].is_string());
        assert_eq!(refused.count(), if scene == "garden" { 2 } else { 0 });
        for row in rows.iter().filter(|row| row["refused"].is_null()) {
            let n = |field: &str| row[field].as_u64().unwrap();
            let stalls = n("stall_mft") + n("stall_rit") + n("stall_bank");
            assert_eq!(n("cycles"), n("busy") + stalls, "{row}");
            assert!(n("bandwidth_cycles") > 0);
            let conflicts = row["lanes"]
                .as_u64()
                .is_some_and(|n| conflicting.contains(&n));
            let turns = row["extra_ports"] == "split";
            assert_eq!(n("stall_bank") > 0, conflicts || turns, "{row}");
            assert_eq!(row["conflict_rate"].as_f64().unwrap() > 0.0, conflicts);
        }
        // Parts of banks cost turns, and nothing else.
        let [copies, split] = [&rows[7], &rows[8]];
        assert_eq!(copies["busy"], split["busy"]);
        assert_eq!(copies["stall_bank"], 0);
        // What is counted is what the verified unit takes for the same frame.
        let verify = ["--config", "feature-major", "verify"];
        let arguments = [&verify[..], &size[..], &["--json", "v.json"]].concat();
        expect(folder.path(), 0, &arguments);
        let v = json(&folder.path().join("v.json"));
        assert_eq!(v["samples"], r["samples"]);
        let same =
            |row: &&serde_json::Value| row["organisation"] == "feature-major" && row["lanes"] == 16;
        let unit = rows.iter().find(same).unwrap();
        for field in ["cycles", "busy", "stall_mft", "stall_rit", "stall_bank"] {
            assert_eq!(v[field], unit[field], "{field}");
        }
    }
}

/// Whatever the configuration, each row is of its own unit.
#[test]
fn presets_of_other_units_are_compared_too() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = vec![];
    for preset in ["parity", "compact", "feature-major"] {
        let arguments = [
            "--config",
            preset,
            "layouts",
            "--scene",
            "cairn:voxels",
            "--width",
            "24",
            "--json",
            "r.json",
        ];
        expect(folder.path(), 0, &arguments);
        let r = json(&folder.path().join("r.json"));
        let row = &r["layouts"][3];
        assert_eq!(
            (&row["organisation"], &row["entry"]),
            (&"parity".into(), &"compact".into())
        );
        assert!(
            row["refused"].is_null() || preset == "feature-major",
            "{row}"
        );
        if row["refused"].is_null() {
            seen.push(row["busy"].as_u64().unwrap());
        }
    }
    // Of 16 banks, as that preset has, two channels are read at once: two segments.
    let [first, ..] = seen[..] else {
        panic!("{seen:?}");
    };
    assert_eq!(seen, [first, first, 2 * first]);
}
