//! One clear error for each defect of a file.

use std::time::Instant;

use super::pack::{archive, gunzip, gzip, members};
use super::*;

/// The error for a file: one line that names it. No refusal takes long.
#[track_caller]
pub(super) fn refused(parse: Parse, bytes: &[u8], expected: &str) {
    let start = Instant::now();
    let read = parse(bytes, "t.file").map(|cloud| cloud.len());
    let Err(error) = read else {
        panic!("read, not refused for: {expected}")
    };
    let text = error.to_string();
    assert!(start.elapsed().as_secs_f64() < 2.0, "{expected}");
    assert!(
        text.starts_with("t.file: ") && !text.contains('\n'),
        "{text}"
    );
    assert!(text.contains(expected), "{text} / {expected}");
}

#[test]
fn packed_ply() {
    let good = fixture("cloud.compressed.ply");
    let changed = |from: &str, to: &str| {
        let at = good.windows(from.len()).position(|w| w == from.as_bytes());
        let (head, tail) = good.split_at(at.unwrap());
        [head, to.as_bytes(), &tail[from.len()..]].concat()
    };
    for (from, to, expected) in [
        ("element vertex 300", "element vertex 9999999999", "cut off"),
        (
            "element vertex 300",
            "element vertex 0",
            "`vertex` is 0: expected at least 1",
        ),
        (
            "element vertex 300",
            "element vertex 200",
            "`chunk` is 2: expected 1",
        ),
        (
            "element chunk 2",
            "element chunk 1",
            "`chunk` is 1: expected 2",
        ),
        (
            "element chunk 2",
            "element block 2",
            "element `chunk` is missing",
        ),
        (
            "element sh 300",
            "element sh 299",
            "`sh` is 299: expected 300",
        ),
        (
            "uchar f_rest_44",
            "uchar f_rest_45",
            "`f_rest_44` is missing: expected uchar",
        ),
        (
            "property uchar f_rest_44\n",
            "",
            "number of properties of element `sh` is 44",
        ),
        (
            "float min_x",
            "uint min_x",
            "`min_x` is uint: expected float",
        ),
        (
            "uint packed_scale",
            "float packed_scale",
            "`packed_scale` is float: expected uint",
        ),
        (
            "float min_scale_y",
            "list uchar float min_scale_y",
            "`min_scale_y` is a list",
        ),
        (
            "binary_little_endian",
            "binary_big_endian",
            "format is binary_big_endian",
        ),
        ("end_header", "end_heather", "header"),
    ] {
        refused(packed_cloud, &changed(from, to), expected);
    }
    refused(packed_cloud, &good[..good.len() - 1], "cut off");
    let mut nan = good.clone();
    let body = good.len() - 300 * 61 - 2 * 72;
    nan[body + 72 + 4..body + 72 + 8].copy_from_slice(&f32::NAN.to_le_bytes());
    refused(packed_cloud, &nan, "chunk 1, property `min_y` is NaN");
}

#[test]
fn spz_headers() {
    let three = gunzip(&fixture("cloud.v3.spz"));
    let four = fixture("cloud.v4.spz");
    for (at, bytes, expected) in [
        (4, &[0][..], "version is 0: expected 1, 2, 3 or 4"),
        (4, &[5], "version is 5"),
        (8, &[0, 0, 0, 0], "number of Gaussians is 0"),
        (
            8,
            &[0, 0, 0, 0x70],
            "number of Gaussians is 1879048192: expected 1 to",
        ),
        (
            12,
            &[4],
            "degree of spherical harmonics is 4: expected 0 to 3",
        ),
        (13, &[25], "fractional bits is 25"),
    ] {
        for (good, pack) in [(&three, true), (&four, false)] {
            let mut bad = good.clone();
            bad[at..at + bytes.len()].copy_from_slice(bytes);
            let bad = if pack { gzip(&bad) } else { bad };
            refused(spz_cloud, &bad, expected);
        }
    }
    let mut other = three.clone();
    other[0] = b'X';
    refused(spz_cloud, &gzip(&other), "magic is 58 47 53 50: expected");
    refused(spz_cloud, b"neither", "gzip stream");
    refused(
        spz_cloud,
        &gzip(&three[..three.len() - 1]),
        "bytes after the header is",
    );
    let cut = fixture("cloud.v3.spz");
    refused(spz_cloud, &cut[..cut.len() - 9], "gzip stream");
    let (first, second) = three.split_at(three.len() / 2);
    refused(
        spz_cloud,
        &[gzip(first), gzip(second)].concat(),
        "gzip stream: it ends early, and another follows",
    );
    other[0] = b'N';
    other[4] = 4;
    refused(
        spz_cloud,
        &gzip(&other),
        "version is 4: expected 1, 2 or 3 in a gzip stream",
    );
    // Bare of version 3 it is the arrays that follow.
    let mut plain = four;
    plain[4] = 3;
    refused(spz_cloud, &plain, "bytes after the header is");
}

#[test]
fn spz_streams() {
    let four = fixture("cloud.v4.spz");
    for (at, bytes, expected) in [
        (15, &[5][..], "number of streams is 5: expected 6"),
        (16, &[31], "offset of the table of streams is 31"),
        (
            16,
            &[0, 0, 0, 0xff],
            "offset of the table of streams is 4278190080",
        ),
        (
            32,
            &[0xff; 8],
            "packed bytes of `positions` is 18446744073709551615",
        ),
        (
            40,
            &[0xff; 8],
            "unpacked bytes of `positions` is 18446744073709551615: expected 2700",
        ),
        (56, &[0], "unpacked bytes of `alphas`"),
        (128, &[0], "stream `positions`: no ZSTD frame"),
        // A window of 2 TB.
        (132, &[0, 0xf8], "stream `positions`: a window of"),
    ] {
        let mut bad = four.clone();
        bad[at..at + bytes.len()].copy_from_slice(bytes);
        refused(spz_cloud, &bad, expected);
    }
    let twice = |codes: [u8; 2]| {
        let one = |code: u8| [3, 0, 0xbe, 0xad, 4, 0, 0, 0, code, 0, 0, 0];
        let mut bytes = four[..32].to_vec();
        bytes[14] |= 2;
        bytes[16] = 56;
        [&bytes, codes.map(one).as_flattened(), &four[32..]].concat()
    };
    refused(
        spz_cloud,
        &twice([6, 4]),
        "coordinate system is given twice",
    );
    // 0 says nothing, before another or behind it.
    let turned = spz_cloud(&twice([6, 6]), "f").unwrap();
    for codes in [[6, 0], [0, 6]] {
        assert_eq!(spz_cloud(&twice(codes), "f").unwrap(), turned);
    }
    // Extensions are read past, but for one that says that the axes are others.
    let extended = |record: &[u8]| {
        let mut bytes = four[..32].to_vec();
        bytes[14] |= 2;
        bytes[16] = 32 + record.len() as u8;
        [&bytes, record, &four[32..]].concat()
    };
    let unknown = extended(&[9, 9, 9, 9, 3, 0, 0, 0, 1, 2, 3]);
    let known = spz_cloud(&four, "f").unwrap();
    assert_eq!(spz_cloud(&unknown, "f").unwrap(), known);
    let axes = |code: u8| extended(&[3, 0, 0xbe, 0xad, 4, 0, 0, 0, code, 0, 0, 0]);
    assert_eq!(spz_cloud(&axes(4), "f").unwrap(), known);
    assert_ne!(spz_cloud(&axes(6), "f").unwrap(), known);
    refused(
        spz_cloud,
        &axes(9),
        "coordinate system is 9: expected 0 to 8",
    );
    refused(
        spz_cloud,
        &extended(&[0, 0, 0, 0, 9, 0, 0, 0]),
        "length of an extension is 9",
    );
}

/// Small files that unpack to much more than their headers say.
#[test]
fn bombs() {
    let mut bytes = b"NGSP\x03\0\0\0\x01\0\0\0\0\x0c\0\0".to_vec();
    bytes.resize(64 << 20, 0);
    refused(
        spz_cloud,
        &gzip(&bytes),
        "bytes after the header is 1048597",
    );

    let four = fixture("cloud.v4.spz");
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0, 0];
    for _ in 0..10_000 {
        // A block of 128 KiB times the byte 7, not the last.
        frame.extend([2, 0, 0x10, 7]);
    }
    let packed = u64::from_le_bytes(four[32..40].try_into().unwrap()) as usize;
    let mut bad = four[..32].to_vec();
    bad.extend((frame.len() as u64).to_le_bytes());
    bad.extend(&four[40..128]);
    bad.extend(&frame);
    bad.extend(&four[128 + packed..]);
    refused(spz_cloud, &bad, "stream `positions`: ");
}

#[test]
fn sog() {
    let good = members(&fixture("cloud.sog"));
    let with = |name: &str, content: Option<&[u8]>| {
        let mut members = good.clone();
        members.retain(|(n, _)| content.is_some() || n != name);
        for (n, c) in &mut members {
            if let (true, Some(content)) = (n == name, content) {
                *c = content.to_vec();
            }
        }
        archive(&members)
    };
    let meta = &good.iter().find(|(n, _)| n == "meta.json").unwrap().1;
    let meta = String::from_utf8(meta.clone()).unwrap();
    for (from, to, expected) in [
        ("\"version\":2", "\"version\":3", "version is 3: expected 2"),
        ("\"version\":2,", "", "version is missing"),
        ("\"count\":300", "\"count\":0", "count is 0: expected 1 to"),
        (
            "\"count\":300",
            "\"count\":4000000000",
            "count is 4000000000",
        ),
        (
            "\"count\":300",
            "\"count\":500",
            "size of `means_l.webp` is 20 x 16",
        ),
        ("\"count\":300", "\"count\":-1", "field `count`"),
        ("\"mins\":[", "\"mins\":[-99,", "field `means.mins"),
        (
            "\"mins\":[",
            "\"mins\":[-1e3,0,0],\"x\":[",
            "means.mins is -1000",
        ),
        (
            "\"codebook\":[",
            "\"codebook\":[0,",
            "number of values of `scales.codebook` is 257",
        ),
        (
            "\"bands\":3",
            "\"bands\":4",
            "shN.bands is 4: expected 1 to 3",
        ),
        (
            "\"bands\":3",
            "\"bands\":2",
            "size of `shN_centroids.webp` is 960 x 4",
        ),
        (
            "\"shN\":{\"count\":256",
            "\"shN\":{\"count\":0",
            "shN.count is 0",
        ),
        (
            "\"shN\":{\"count\":256",
            "\"shN\":{\"count\":200",
            "label of `shN`",
        ),
        (
            "\"quats.webp\"",
            "\"../quats.webp\"",
            "quats.files[0] is `../quats.webp`",
        ),
        ("\"quats.webp\"", "\"/quats.webp\"", "quats.files[0]"),
        ("\"quats.webp\"", "\"q.webp\"", "q.webp"),
        (
            "\"quats.webp\"",
            &format!("\"{}\"", "q".repeat(256)),
            "of at most 255 bytes",
        ),
        (
            "\"quats.webp\"",
            "\"sh0.webp\"",
            "largest component of the rotation",
        ),
        (
            "\"shN\":{",
            "\"shN\":{},\"x\":{",
            "field `shN` is empty: expected an object with count",
        ),
        ("{", "[", "meta.json"),
    ] {
        assert!(meta.contains(from), "{from}");
        let text = meta.replacen(from, to, 1);
        refused(
            sog_cloud,
            &with("meta.json", Some(text.as_bytes())),
            expected,
        );
    }
    refused(sog_cloud, &with("scales.webp", None), "scales.webp");
    refused(
        sog_cloud,
        &with("scales.webp", Some(b"RIFF")),
        "scales.webp",
    );
    refused(sog_cloud, &with("meta.json", None), "meta.json");
    refused(sog_cloud, b"PK", "ZIP archive");
    // A picture of 16383 x 16383 by its header, which nothing is reserved for.
    let mut wide = good
        .iter()
        .find(|(n, _)| n == "scales.webp")
        .unwrap()
        .1
        .clone();
    assert_eq!(&wide[12..16], b"VP8L");
    wide[21..25].copy_from_slice(&(16382u32 | 16382 << 14 | 1 << 28).to_le_bytes());
    refused(
        sog_cloud,
        &with("scales.webp", Some(&wide)),
        "size of `scales.webp` is 16383 x 16383",
    );
    // Codebooks that begin with null are mended, not refused.
    let at = meta.find("\"codebook\":[").unwrap() + 12;
    let comma = at + meta[at..].find(',').unwrap();
    let text = [&meta[..at], "null", &meta[comma..]].concat();
    assert!(sog_cloud(&with("meta.json", Some(text.as_bytes())), "f").is_ok());
}

#[test]
fn paths() {
    let text = |name: &str| read_cloud(Path::new(name)).unwrap_err().to_string();
    for name in ["no/a.ply", "no/a.splat", "no/a.spz", "no/a.sog"] {
        assert!(
            text(name).contains(&format!("cannot read {name}: ")),
            "{}",
            text(name)
        );
    }
    assert!(text("a.obj").contains("expected a name that ends in .ply, .splat, .spz, .sog"));
    assert!(text(env!("CARGO_MANIFEST_DIR")).contains("a folder with a meta.json"));
    assert!(matches!(
        splat_cloud(&[], "f"),
        Err(FileError::Cloud {
            source: CloudError::Empty,
            ..
        })
    ));
}
