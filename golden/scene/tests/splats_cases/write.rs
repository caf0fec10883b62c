//! Test files of splats in every dialect.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;

/// A column of a PLY file: its type, its name, and its values.
pub(crate) type Column = (&'static str, String, Vec<f64>);

/// An asymmetric cloud of degree 3, which looks different in all other axes.
#[derive(Clone)]
pub(crate) struct Shape {
    pub(crate) centres: Vec<[f64; 3]>,
    pub(crate) scales: Vec<[f64; 3]>,
    pub(crate) rotations: Vec<[f64; 4]>,
    pub(crate) opacities: Vec<f64>,
    /// 16 of red, then green, then blue.
    pub(crate) colours: Vec<[[f64; 16]; 3]>,
}

/// A number of 32 bits between -1 and 1, from a hash of two.
fn any(gaussian: usize, property: usize) -> f64 {
    let mut h = (gaussian as u32 * 64 + property as u32).wrapping_mul(0x9e37_79b1);
    h = (h ^ h >> 15).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    f64::from(((h ^ h >> 16) >> 8) as f32 / (1 << 23) as f32 - 1.0)
}

fn float(value: f64) -> f64 {
    f64::from(value as f32)
}

impl Shape {
    /// A bar to the left and a ball below on the right, with log scales about `size`.
    pub(crate) fn new(size: f64) -> Self {
        let all = 0..160usize;
        let of = |i: usize, p: usize| any(i, p);
        let centre = |i: usize| {
            let [x, y, z] = [of(i, 0), of(i, 1), of(i, 2)];
            match i % 3 {
                0 => [-0.7 + 0.1 * x, 0.9 * y, 0.2 * z],
                1 => [-0.1 + 0.5 * x, -0.8 + 0.1 * y, 0.4 + 0.2 * z],
                _ => [0.6 + 0.2 * x, 0.7 + 0.2 * y, -0.3 + 0.1 * z],
            }
            .map(float)
        };
        let rotation = |i: usize| {
            let q = [3, 4, 5, 6].map(|p| of(i, p));
            let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
            q.map(|v| float(v / length))
        };
        let colour = |i: usize| {
            [0, 1, 2].map(|channel| {
                let mut own = [0.0; 16];
                for (k, value) in own.iter_mut().enumerate() {
                    *value = float(0.15 * of(i, 10 + 16 * channel + k));
                }
                own[0] = float(if i % 3 == channel { 1.2 } else { -0.8 });
                own
            })
        };
        Self {
            centres: all.clone().map(centre).collect(),
            scales: (all.clone())
                .map(|i| [7, 8, 9].map(|p| float(size + 0.6 * of(i, p))))
                .collect(),
            rotations: all.clone().map(rotation).collect(),
            opacities: all.clone().map(|i| float(2.5 + of(i, 60))).collect(),
            colours: all.map(colour).collect(),
        }
    }

    /// The columns of a PLY file, all of them floats.
    pub(crate) fn columns(&self) -> Vec<Column> {
        let mut all: Vec<Column> = vec![];
        let mut add = |name: String, values: Vec<f64>| all.push(("float", name, values));
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            add(
                name.to_owned(),
                self.centres.iter().map(|c| c[axis]).collect(),
            );
        }
        for channel in 0..3 {
            let own = self.colours.iter().map(|c| c[channel][0]);
            add(format!("f_dc_{channel}"), own.collect());
        }
        for i in 0..45 {
            let own = self.colours.iter().map(|c| c[i / 15][1 + i % 15]);
            add(format!("f_rest_{i}"), own.collect());
        }
        add("opacity".to_owned(), self.opacities.clone());
        for axis in 0..3 {
            let own = self.scales.iter().map(|s| s[axis]);
            add(format!("scale_{axis}"), own.collect());
        }
        for k in 0..4 {
            add(
                format!("rot_{k}"),
                self.rotations.iter().map(|q| q[k]).collect(),
            );
        }
        all
    }
}

/// How a PLY file is written.
#[derive(Clone)]
pub(crate) struct Ply {
    pub(crate) columns: Vec<Column>,
    /// Lines of the header behind `format`.
    pub(crate) lines: Vec<Vec<u8>>,
    pub(crate) line_end: &'static str,
    pub(crate) start: &'static [u8],
    pub(crate) text: bool,
    pub(crate) tail: Vec<u8>,
}

impl Ply {
    pub(crate) fn of(shape: &Shape) -> Self {
        Self {
            columns: shape.columns(),
            lines: vec![],
            line_end: "\n",
            start: b"",
            text: false,
            tail: vec![],
        }
    }

    pub(crate) fn line(mut self, line: &[u8]) -> Self {
        self.lines.push(line.to_vec());
        self
    }

    pub(crate) fn column(&mut self, name: &str) -> &mut Column {
        self.columns.iter_mut().find(|own| own.1 == name).unwrap()
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.start.to_vec();
        let count = self.columns[0].2.len();
        let format = if self.text {
            "ascii"
        } else {
            "binary_little_endian"
        };
        let mut lines = vec![b"ply".to_vec(), format!("format {format} 1.0").into_bytes()];
        lines.extend(self.lines.clone());
        lines.push(format!("element vertex {count}").into_bytes());
        for (kind, name, _) in &self.columns {
            lines.push(format!("property {kind} {name}").into_bytes());
        }
        lines.push(b"end_header".to_vec());
        for line in lines {
            bytes.extend(line);
            bytes.extend(self.line_end.as_bytes());
        }
        for row in 0..count {
            if self.text {
                let words = self.columns.iter().map(|own| own.2[row].to_string());
                bytes.extend(words.collect::<Vec<_>>().join(" ").as_bytes());
                bytes.extend(self.line_end.as_bytes());
                continue;
            }
            for (kind, _, values) in &self.columns {
                let value = values[row];
                match *kind {
                    "double" => bytes.extend(value.to_le_bytes()),
                    "uchar" => bytes.push(value as u8),
                    "ushort" | "half" => bytes.extend((value as u16).to_le_bytes()),
                    _ => bytes.extend((value as f32).to_le_bytes()),
                }
            }
        }
        bytes.extend(&self.tail);
        bytes
    }

    pub(crate) fn write(&self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, self.bytes()).unwrap();
        path
    }
}

/// How an SPZ file is written, after nianticlabs/spz's readme: axes right, up, back.
pub(crate) struct Spz {
    pub(crate) version: u32,
    pub(crate) flags: u8,
    pub(crate) reserved: u8,
    /// Extensions, or what stands in their place.
    pub(crate) tail: Vec<u8>,
    pub(crate) packed: bool,
}

/// The extension of axes.
pub(crate) fn axes_extension(code: u32) -> Vec<u8> {
    [0xadbe_0003u32, 4, code].map(u32::to_le_bytes).concat()
}

impl Spz {
    pub(crate) fn new(version: u32) -> Self {
        Self {
            version,
            flags: 0,
            reserved: 0,
            tail: vec![],
            packed: true,
        }
    }

    /// `flip` turns right, down, front into the usual axes of the format.
    pub(crate) fn bytes(&self, shape: &Shape, flip: bool) -> Vec<u8> {
        let signs = if flip { [1.0, -1.0, -1.0] } else { [1.0; 3] };
        let mut arrays: [Vec<u8>; 6] = Default::default();
        let byte = |v: f64| v.round().clamp(0.0, 255.0) as u8;
        for i in 0..shape.centres.len() {
            for axis in 0..3 {
                let value = shape.centres[i][axis] * signs[axis];
                match self.version {
                    1 => arrays[0].extend(half::f16::from_f64(value).to_le_bytes()),
                    _ => {
                        let code = (value * 4096.0).round() as i32;
                        arrays[0].extend(&code.to_le_bytes()[..3]);
                    }
                }
            }
            arrays[1].push(byte(255.0 / (1.0 + (-shape.opacities[i]).exp())));
            for channel in 0..3 {
                let value = shape.colours[i][channel][0];
                arrays[2].push(byte((value * 0.15 + 0.5) * 255.0));
            }
            arrays[3].extend(shape.scales[i].map(|s| byte((s + 10.0) * 16.0)));
            let [w, x, y, z] = shape.rotations[i];
            self.rotation(
                [x * signs[0], y * signs[1], z * signs[2], w],
                &mut arrays[4],
            );
            // Powers of y and z in each polynomial: odd sums change sign.
            let odd = [false, true, true, false, true, false, false, true]
                .into_iter()
                .chain([false, true, false, true, true, false, true, false]);
            for (k, odd) in odd.enumerate().skip(1) {
                let sign = if odd && flip { -1.0 } else { 1.0 };
                for channel in 0..3 {
                    let value = sign * shape.colours[i][channel][k];
                    arrays[5].push(byte((value * 128.0).round() + 128.0));
                }
            }
        }
        let mut head = b"NGSP".to_vec();
        head.extend(self.version.to_le_bytes());
        head.extend((shape.centres.len() as u32).to_le_bytes());
        head.extend([3, 12, self.flags, self.reserved]);
        if self.version == 4 {
            head[15] = 6;
            head.extend((32 + self.tail.len() as u32).to_le_bytes());
            head.extend([0; 12]);
            head.extend(&self.tail);
            let pack = |array: &Vec<u8>| {
                let level = ruzstd::encoding::CompressionLevel::Fastest;
                ruzstd::encoding::compress_to_vec(array.as_slice(), level)
            };
            let packed = arrays.each_ref().map(pack);
            for (packed, array) in packed.iter().zip(&arrays) {
                head.extend((packed.len() as u64).to_le_bytes());
                head.extend((array.len() as u64).to_le_bytes());
            }
            return [head, packed.concat()].concat();
        }
        let all = [head, arrays.concat(), self.tail.clone()].concat();
        if !self.packed {
            return all;
        }
        let mut encoder = GzEncoder::new(vec![], Compression::fast());
        encoder.write_all(&all).unwrap();
        encoder.finish().unwrap()
    }

    fn rotation(&self, q: [f64; 4], out: &mut Vec<u8>) {
        if self.version <= 2 {
            let sign = if q[3] < 0.0 { -1.0 } else { 1.0 };
            out.extend([0, 1, 2].map(|k| (q[k] * sign * 127.5 + 127.5).round() as u8));
            return;
        }
        let largest = (0..4).max_by(|a, b| q[*a].abs().total_cmp(&q[*b].abs()));
        let largest = largest.unwrap();
        let mut word = largest as u32;
        for (k, value) in q.into_iter().enumerate() {
            if k != largest {
                let negative = (value < 0.0) != (q[largest] < 0.0);
                let magnitude = (511.0 * value.abs() * 2f64.sqrt() + 0.5) as u32;
                word = word << 10 | u32::from(negative) << 9 | magnitude.min(511);
            }
        }
        out.extend(word.to_le_bytes());
    }
}

/// The members of a ZIP archive.
pub(crate) fn members(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    (0..archive.len())
        .map(|i| {
            let mut file = archive.by_index(i).unwrap();
            let mut content = vec![];
            std::io::copy(&mut file, &mut content).unwrap();
            (file.name().to_owned(), content)
        })
        .collect()
}

/// An archive of members.
pub(crate) fn archive(members: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(vec![]));
    for (name, content) in members {
        let options = zip::write::SimpleFileOptions::default();
        writer.start_file(name.as_str(), options).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner()
}
