//! Frames of which only some pixels are rendered.

use potamoi_base::mask::Mask;
use potamoi_formats::config::Config;
use potamoi_formats::units::VectorOp;
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::{Product, ReferenceUnits, UnitCounts, UnitError, Units};

use potamoi_reference::GatherTask;

/// ReferenceUnits, and the multiplications that they were told of.
struct Told {
    twins: ReferenceUnits,
    operations: u64,
}

impl Told {
    fn new(config: &Config) -> Self {
        Self {
            twins: ReferenceUnits::new(config),
            operations: 0,
        }
    }

    fn counts(&self) -> &UnitCounts {
        self.twins.counts()
    }
}

impl Units for Told {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.twins.gather(tasks, features)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.twins.sums(tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.twins.vector(op, a, b, out)
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.twins.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.operations += product.operations();
    }
}

/// Each pixel has the bits of the whole frame, the others are background; and the work of two
/// halves of rays is that of all of them.
#[test]
fn some_pixels_are_rendered_as_in_the_whole_frame() {
    let config = Config::preset("fields").unwrap();
    for name in [
        "garden",
        "lantern",
        "cairn:dvgo",
        "cairn:tensorf",
        "cairn:ngp",
    ] {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(16), Some(12)).unwrap();
        let mut units = Told::new(&config);
        let whole = scene.render_fixed(&config, &mut units).unwrap();
        let size = [16, 12];
        let halves = [true, false].map(|left| {
            let mask = Mask::new(size, |i| (i % 16 < 8) == left);
            let mut units = Told::new(&config);
            let part = scene.render_fixed_masked(&config, &mask, &mut units);
            let part = part.unwrap();
            for (i, colour) in part.picture.rgb.iter().enumerate() {
                let (expected, covered) = match mask.has(i) {
                    true => (whole.picture.rgb[i], whole.covered[i]),
                    false => (scene.background(), false),
                };
                assert_eq!(part.covered[i], covered, "{name}, pixel {i}");
                for (found, expected) in colour.iter().zip(expected) {
                    // Backgrounds are rounded to 12 bits.
                    assert!((found - expected).abs() < 2e-4, "{name}, pixel {i}");
                    assert!(!mask.has(i) || *found == expected, "{name}, pixel {i}");
                }
            }
            (
                units.counts().elements.values().sum::<u64>(),
                units.operations,
            )
        });
        let all = units.counts().elements.values().sum::<u64>();
        let once = [all, units.operations];
        let both = [halves[0].0 + halves[1].0, halves[0].1 + halves[1].1];
        assert_eq!(both, once, "{name}");
        assert!(halves[0].0 > 0 && halves[1].0 > 0, "{name}");
        assert!(units.operations > 0, "{name}");

        let other = Mask::new([12, 16], |_| true);
        let refused = scene.render_fixed_masked(&config, &other, &mut ReferenceUnits::new(&config));
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("mask"), "{said}");
    }
}
