//! Invalid images and numbers in SOG files.

use super::pack::{archive, members};
use super::refuse::refused;
use super::*;

/// Pixels are codes: an image that differs in any property is refused.
#[test]
fn sog_images_are_not_taken_at_face_value() {
    use image::{DynamicImage, ImageFormat};
    let good = members(&fixture("cloud.sog"));
    let with = |name: &str, change: &dyn Fn(DynamicImage) -> DynamicImage| {
        let mut members = good.clone();
        let own = members.iter_mut().find(|(n, _)| n == name).unwrap();
        let image = image::load_from_memory(&own.1).unwrap();
        let mut bytes = std::io::Cursor::new(vec![]);
        (change(image).write_to(&mut bytes, ImageFormat::Png)).unwrap();
        own.1 = bytes.into_inner();
        archive(&members)
    };
    let known = sog_cloud(&fixture("cloud.sog"), "f").unwrap();
    let same = with("scales.webp", &|image| image.to_rgb8().into());
    assert_eq!(sog_cloud(&same, "f").unwrap(), known);
    let wider = |image: DynamicImage| {
        let mut wider = image::RgbaImage::new(image.width() + 1, image.height());
        image::imageops::replace(&mut wider, &image, 0, 0);
        wider.into()
    };
    refused(
        sog_cloud,
        &with("scales.webp", &wider),
        "size of `scales.webp` is 21 x 16: expected 20 x 16, as of `means_l.webp`",
    );
    for name in ["quats.webp", "sh0.webp"] {
        let expected = format!("image `{name}` is without alpha");
        let bytes = with(name, &|image| image.to_rgb8().into());
        refused(sog_cloud, &bytes, &expected);
    }
    let grey = with("scales.webp", &|image| image.to_luma8().into());
    refused(sog_cloud, &grey, "image `scales.webp` is grey");
    let deep = with("scales.webp", &|image| image.to_rgba16().into());
    refused(
        sog_cloud,
        &deep,
        "image `scales.webp` is of more than 8 bits",
    );
    // A chunk of pixels with loss, behind one that says what is in the file.
    let mut lossy = b"RIFF\x2a\0\0\0WEBPVP8X\x0a\0\0\0".to_vec();
    lossy.extend([0; 10]);
    lossy.extend(b"VP8 \x0a\0\0\0");
    lossy.extend([0; 10]);
    for bytes in [&lossy[..], &[&lossy[..12], &lossy[30..]].concat()] {
        let mut members = good.clone();
        let own = members.iter_mut().find(|(n, _)| n == "means_l.webp");
        own.unwrap().1 = bytes.to_vec();
        refused(
            sog_cloud,
            &archive(&members),
            "image `means_l.webp` is WebP with loss",
        );
    }
}

/// Some writers add a decimal point to whole numbers.
#[test]
fn sog_whole_numbers_may_have_a_point() {
    let mut all = members(&fixture("cloud.sog"));
    let meta = &mut all.iter_mut().find(|(n, _)| n == "meta.json").unwrap().1;
    let text = String::from_utf8(meta.clone()).unwrap();
    let text = text.replace("\"version\":2", "\"version\":2.0");
    *meta = text
        .replace("\"count\":300", "\"count\":300.0")
        .into_bytes();
    let known = sog_cloud(&fixture("cloud.sog"), "f").unwrap();
    assert_eq!(sog_cloud(&archive(&all), "f").unwrap(), known);
}
