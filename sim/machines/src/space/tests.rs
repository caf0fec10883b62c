#![allow(clippy::unwrap_used)]
use super::*;

fn space(axes: &[&str]) -> Result<Space, SpaceError> {
    let axes = axes.iter().map(|own| Axis::parse(own).unwrap());
    Space::new(Machine::named("paper").unwrap(), axes.collect())
}

#[test]
fn values_are_lists_or_ranges() {
    let values = |text: &str| -> Vec<String> {
        let own = Axis::parse(text).unwrap();
        own.values.iter().map(|own| shown(&own[0])).collect()
    };
    assert_eq!(values("vu.lanes=12,24"), ["12", "24"]);
    assert_eq!(values("vu.lanes=12..48:*2"), ["12", "24", "48"]);
    assert_eq!(values("gu.ports=1..3:+1"), ["1", "2", "3"]);
    assert_eq!(values("clock_ghz=reached,1.0"), ["reached", "1.0"]);
    assert_eq!(values("render.step=0.1..0.5:+0.1").len(), 5);
    assert_eq!(values("vu.exp.pipelined=true,false"), ["true", "false"]);
    assert_eq!(
        values("vu.ops=[[\"exp\"], [\"exp\", \"pass\"]]"),
        ["[\"exp\"]", "[\"exp\", \"pass\"]"]
    );
    assert_eq!(values("render.step=0.1..0.3:+0.1")[2], "0.3");
    for wrong in [
        "vu.lanes=1..1e9:+1",
        "vu.lanes=1..9",
        "vu.lanes",
        "=3",
        "a=1..2:3",
        "a=2..1:+1",
        "a=1..9:*1",
        "a=0..9:*2",
        "a=x..9:+1",
    ] {
        let error = Axis::parse(wrong).unwrap_err();
        assert!(
            error.contains(wrong) && error.contains("expected"),
            "{error}"
        );
    }
}

#[test]
fn every_combination_is_a_point() {
    let own = space(&["vu.lanes=12,24,48", "system.memory_channels=1,2"]).unwrap();
    assert_eq!(own.len(), 6);
    for point in 0..own.len() {
        assert_eq!(own.number(&own.places(point)), point);
    }
    let machine = own.machine(&own.places(3)).unwrap();
    assert_eq!(machine.hardware.as_ref().unwrap().config.vu.lanes, 24);
    assert_eq!(machine.system.memory_channels, 2);
    let setting = own.setting(&own.places(3));
    assert_eq!(setting[0], ("vu.lanes".to_owned(), "24".to_owned()));
}

#[test]
fn a_space_without_points_has_a_reason() {
    let of = |axes: &[&str]| space(axes).unwrap().without_points();
    for alone in [
        "vu.lanes=0",
        "clock=0",
        "gu.ports=3",
        "vu.exp.form=piecewise",
    ] {
        let axis = alone.replace("clock", "clock_ghz");
        assert!(of(&[&axis]).is_some_and(|own| own.is_rule()), "{alone}");
    }
    assert!(of(&["vu.lanes=0,12"]).is_none());
    // Three ports need entries that three divides.
    assert!(of(&["gu.ports=3", "rit.entries=126,128"]).is_none());
}

/// Mistakes of a plan are refused before any work; what breaks a rule is a point without figures.
#[test]
fn mistakes_are_refused_and_broken_rules_are_points() {
    for (axes, said) in [
        (&["vu.lnes=3"][..], "vu.lnes"),
        (&["vu.lanes=many"], "many"),
        (&["system.memory_channels=1,3"], "1, 2, 4, 8 or 16"),
        (&["path.variant=potmoi"], "did you mean"),
        (&["vu.lanes=12", "vu.lanes=24"], "varies twice"),
        (&["vu.lanes=12,24,12"], "`vu.lanes` has the value 12 twice"),
    ] {
        let error = space(axes).unwrap_err().to_string();
        assert!(error.contains(said), "{axes:?}: {error}");
    }
    // A device whose name is a number needs no quotation marks.
    let own = space(&["system.gpu.device=3090,xavier-maxn"]).unwrap();
    assert_eq!(own.machine(&[0]).unwrap().system.gpu.device.name, "3090");
    // Each alone does not go with the base's other value.
    let banks = [
        "system.feature_banks=8,48",
        "system.feature_block_banks=8,48",
    ];
    let own = space(&banks).unwrap();
    let legal = (0..4).filter(|at| own.machine(&own.places(*at)).is_ok());
    assert_eq!(legal.count(), 3);
    let own = space(&["gu.banks=16,0,32"]).unwrap();
    assert_eq!(own.len(), 3);
    assert!((0..3).any(|point| own.machine(&own.places(point)).is_err()));
}
