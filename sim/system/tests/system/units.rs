//! The hardware in the renderers' place gives the twins' picture.
use potamoi_analytic::lantern;
use potamoi_base::mask::Mask;
use potamoi_cycles::mac_array::MacArray;
use potamoi_fields::voxels::StoredField;
use potamoi_fields::{FixedField, FixedOptions};
use potamoi_formats::config::Config;
use potamoi_netlist::{Change, Fault};
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_scene::{Scene, garden};
use potamoi_splats::{self as splats, Profile};
use potamoi_system::system_model::work::FrameWork;
use potamoi_units::vector_unit::vector_unit;

fn garden_picture(units: &mut dyn Units, [width, height]: [u32; 2]) -> splats::FixedFrame {
    let camera = garden::camera().resized(width, height);
    let options = splats::FixedOptions {
        background: garden::BACKGROUND,
        ..splats::FixedOptions::default()
    };
    splats::render_fixed(&garden::cloud(), &camera, Profile::Inria, &options, units).unwrap()
}

#[test]
fn splats_through_the_hardware_equal_the_twins_and_all_are_counted() {
    let config = Config::paper();
    let (mut twins, mut rtl) = (ReferenceUnits::new(&config), RtlUnits::new(&config));
    let expected = garden_picture(&mut twins, [32, 27]);
    let found = garden_picture(&mut rtl, [32, 27]);
    assert_eq!(found, expected);
    assert_eq!(rtl.counts(), twins.counts());
    assert_eq!(rtl.counts().feature_vectors, found.stats.gathers);
    assert_eq!(rtl.counts().elements, found.stats.vector_elements);
    assert!(found.stats.exponentials > 2_500);
    assert_eq!(rtl.gather_flags(), 0);
    assert!(rtl.cycles().gather >= found.stats.gathers / 2);
}

#[test]
fn voxels_through_the_hardware_equal_the_twins_and_all_are_counted() {
    let config = Config::paper();
    let field = StoredField::from(lantern::lantern().unwrap());
    let made = FixedField::new(&field, &config).unwrap();
    let camera = lantern::camera(32, 32);
    let render = |units: &mut dyn Units| {
        made.render(&camera, &FixedOptions::default(), units)
            .unwrap()
    };
    let (mut twins, mut rtl) = (ReferenceUnits::new(&config), RtlUnits::new(&config));
    let (expected, found) = (render(&mut twins), render(&mut rtl));
    assert_eq!(found, expected);
    assert_eq!(rtl.counts(), twins.counts());
    assert_eq!(rtl.counts().elements, found.stats.vector_elements);
    assert_eq!(rtl.gather_flags(), 0);
}

/// One bit of one constant in the Verilog is seen in the picture, so the
/// picture does come from the hardware.
#[test]
fn one_flipped_constant_changes_the_picture() {
    let text = "[gu]\nbanks = 8\nports = 1\n[vu]\nlanes = 4\n";
    let config = Config::from_toml(text, "test").unwrap();
    let right = vector_unit(&config).unwrap();
    let picture = |units: &mut RtlUnits| garden_picture(units, [10, 8]).picture;
    let expected = picture(&mut RtlUnits::new(&config));
    let flip = Fault {
        module: "exp_constants".to_owned(),
        // ln(1 + 2^-1), bit 12, woken from reset.
        register: "sr_sub[4]".to_owned(),
        change: Change::Reset({
            let exp = &config.vu.exp;
            let bits = exp.engine().constant_bits;
            let code = (1.5f64.ln() * 2f64.powi(bits as i32)).round() as u64;
            (code ^ 1 << 12).into()
        }),
    };
    let faulty = flip.inject(&right).unwrap();
    let mut units = RtlUnits::new(&config).with_vector_unit(&faulty).unwrap();
    assert_ne!(picture(&mut units), expected);
}

/// Cycles of a whole frame, composed of the cycle models, are those of the hardware: splats and
/// a structured scene, and some pixels of each.
#[test]
fn a_composed_frame_takes_the_cycles_of_the_hardware() {
    let few = "[gu]\nbanks = 8\nports = 1\n[vu]\nlanes = 4\n";
    let config = Config::from_toml(few, "few").unwrap();
    for name in ["garden", "lantern"] {
        let mut scene = Scene::open(name).unwrap();
        scene.set_size(Some(24), Some(20)).unwrap();
        let some = Mask::new([24, 20], |i| i % 7 < 2);
        for only in [None, Some(&some)] {
            let work = FrameWork::count(&scene, &config, MacArray::PAPER, 1 << 19, only).unwrap();
            let mut rtl = RtlUnits::new(&config);
            match only {
                None => scene.render_fixed(&config, &mut rtl).unwrap(),
                Some(mask) => scene.render_fixed_masked(&config, mask, &mut rtl).unwrap(),
            };
            let (total, cycles) = (work.total(), rtl.cycles());
            println!("{name}: {cycles:?}");
            assert_eq!(total.gather_cycles, cycles.gather, "{name}");
            assert_eq!(total.vector_cycles, cycles.vector, "{name}");
            assert!(cycles.gather > 100 && cycles.vector > 100);
        }
    }
}
