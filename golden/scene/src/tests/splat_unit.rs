//! Frames that the splat unit composites: bit for bit those of the vector unit.

use potamoi_base::effects::{Choices, Effect};
use potamoi_base::mask::Mask;
use potamoi_base::precision::Precision;
use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::ReferenceUnits;
use potamoi_splats::Order;

use crate::{Rendered, Scene};

/// The same configuration with and without a splat unit.
fn configs(text: &str) -> [Config; 2] {
    let with = Config::from_toml(text, "test").unwrap();
    let without = Config {
        su: None,
        ..with.clone()
    };
    [with, without]
}

fn rendered(scene: &Scene, config: &Config, only: Option<&Mask>) -> (Rendered, ReferenceUnits) {
    let mut units = ReferenceUnits::new(config);
    let frame = match only {
        None => scene.render_fixed(config, &mut units),
        Some(mask) => scene.render_fixed_masked(config, mask, &mut units),
    };
    (frame.unwrap(), units)
}

/// Exponentials of the paper, straight pieces, and few iterations; jobs of 4 and of 16 tiles; both orders;
/// whole frames and masks. Sizes that end within a tile.
#[test]
fn frames_by_the_splat_unit_are_those_of_the_vector_unit() {
    let paper = "[su]\ntiles = 4\n";
    let pieces = "[vu.exp]\nform = \"piecewise\"\npipelined = true\npieces = 64\n[su]\nlanes = 1\n";
    let coarse = "[vu.exp]\niterations = 5\n[su]\ntiles = 2\n";
    for (name, size, text, order) in [
        ("garden", [100, 70], paper, Order::Exact),
        ("garden", [60, 90], pieces, Order::Approximate),
        ("cairn:splats", [40, 33], coarse, Order::Exact),
    ] {
        let mut scene = super::opened(name);
        scene.set_size(Some(size[0]), Some(size[1])).unwrap();
        scene.order = order;
        let [with, without] = configs(text);
        // The approximate order depends on ray groups.
        scene.group_tiles = with.su.as_ref().map(SuConfig::group_tiles);
        let (vector, _) = rendered(&scene, &without, None);
        let (splat, units) = rendered(&scene, &with, None);
        assert_eq!(splat.picture, vector.picture, "{name} {text}");
        assert_eq!(splat.covered, vector.covered, "{name} {text}");
        let [found, wanted] = [&splat, &vector].map(|own| own.counts.splats.unwrap());
        assert_eq!(
            (found.pairs_drawn, found.pairs_stopped),
            (wanted.pairs_drawn, wanted.pairs_stopped)
        );
        // An exponential for each pair that counts, and few others that the stored limits keep.
        let counted = found.pairs_drawn + found.pairs_stopped;
        let within = found.within_exact_limit.unwrap();
        // A coarse exponential rises here and there.
        assert!(
            within == counted || text == coarse && within > counted,
            "{found:?}"
        );
        let kept = found.exponentials;
        assert!(kept >= within && kept <= within * 105 / 100, "{found:?}");
        assert!(wanted.exponentials > 4 * counted, "{wanted:?}");
        assert!(splat.counts.elements.is_empty());
        assert!(units.counts().splat_jobs > 1);

        let half = Mask::new(size, |i| i % 7 < 3);
        let (part, _) = rendered(&scene, &with, Some(&half));
        let (expected, _) = rendered(&scene, &without, Some(&half));
        assert_eq!(part.picture, expected.picture, "{name} {text}, masked");
    }
}

/// What the unit does not have is refused with what to change, or named.
#[test]
fn what_the_splat_unit_cannot_do_is_said() {
    let mut scene = super::opened("garden");
    scene.set_size(Some(40), Some(40)).unwrap();
    let [with, _] = configs("[su]\ntiles = 4\n");
    let refused = |scene: &Scene| {
        let error = scene.render_fixed(&with, &mut ReferenceUnits::new(&with));
        error.unwrap_err().to_string()
    };
    let mut large = scene.clone();
    large.group_tiles = Some([3, 2]);
    let error = refused(&large);
    assert!(
        error.contains("su.tiles") && error.contains("8 or more"),
        "{error}"
    );
    let mut narrow = scene.clone();
    narrow
        .set_precision(Precision {
            transmittance_bits: Some(12),
            ..Precision::default()
        })
        .unwrap();
    let error = refused(&narrow);
    assert!(error.contains("transmittance_bits"), "{error}");

    // Without its exponential there is no cut: the vector unit composites.
    scene.set_choices(Choices::default().leave_out(Effect::Exponential));
    let (found, units) = rendered(&scene, &with, None);
    assert_eq!(units.counts().splat_jobs, 0);
    assert!(found.counts.splats.unwrap().within_exact_limit.is_none());
}
