//! Cell libraries.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use potamoi_gates::Truth;
use sha2::{Digest as _, Sha256};

use super::liberty::{self, Group};
use super::physical_units::Units;
use super::{SynthError, attributes, table_checks};

/// Largest size of an unpacked library, in bytes.
const LIMIT: u64 = 1 << 28;

/// A library of standard cells.
#[derive(Debug, Clone)]
pub struct Library {
    /// Its own name.
    pub name: String,
    /// SHA-256 of the unpacked Liberty text, 64 hexadecimal digits.
    pub sha256: String,
    /// Unit of time in picoseconds.
    pub time_ps: f64,
    /// Unit of capacitance in femtofarads.
    pub capacitance_ff: f64,
    /// Nominal supply voltage in volts.
    pub volts: Option<f64>,
    /// Cells by name.
    pub cells: BTreeMap<String, Cell>,
    /// The smallest buffer, which drives inputs; four of its inputs load outputs.
    pub buffer: String,
    /// Missing units, one sentence each with the assumed value.
    pub assumed: Vec<String>,
    /// Unit of voltage in volts, and unit of leakage in watts.
    pub(super) voltage_v: f64,
    pub(super) leakage_w: f64,
    pub(super) text: String,
    /// Its file, for errors.
    pub(super) path: String,
}

/// A standard cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Area in the library's unit, square micrometres in the libraries used here.
    pub area: f64,
    /// Input pins with their capacitance in the library's unit.
    pub inputs: BTreeMap<String, f64>,
    /// Output pins with their functions.
    pub outputs: BTreeMap<String, String>,
    /// Largest load of an output, in the library's unit of capacitance; 0 where the library does
    /// not state it.
    pub drive: f64,
    /// Clock pin, if any.
    pub clock: Option<String>,
    /// Whether it is a flip-flop.
    pub is_flop: bool,
    /// Whether the library marks it as not to be used.
    pub is_barred: bool,
}

impl Library {
    /// Reads a Liberty file, plain or gzipped.
    ///
    /// # Errors
    /// The file cannot be read or is not Liberty; a function, number or table is invalid; there is
    /// no flip-flop, inverter, buffer or gate of two inputs.
    pub fn read(path: &Path) -> Result<Self, SynthError> {
        let fail = |source| SynthError::Read {
            path: path.to_owned(),
            source,
        };
        let too_large = || fail(std::io::Error::other("larger than 256 MB"));
        let mut bytes = potamoi_base::files::read(path, LIMIT)
            .map_err(fail)?
            .ok_or_else(too_large)?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            let mut unpacked = vec![];
            let mut packed = GzDecoder::new(&*bytes).take(LIMIT + 1);
            packed.read_to_end(&mut unpacked).map_err(fail)?;
            if unpacked.len() as u64 > LIMIT {
                return Err(too_large());
            }
            bytes = unpacked;
        }
        let sha256 = format!("{:x}", Sha256::digest(&bytes));
        let text = String::from_utf8(bytes).map_err(|e| fail(std::io::Error::other(e)))?;
        Self::parse(text, sha256, path)
    }

    fn parse(text: String, sha256: String, path: &Path) -> Result<Self, SynthError> {
        let origin = path.display().to_string();
        let file = liberty::parse(&text, &origin)?;
        let units = Units::read(&file, &origin)?;
        attributes::check(&file, &units, &origin)?;
        table_checks::check(&file, &units, &origin)?;
        let reader = Attributes { origin: &origin };
        let mut cells = BTreeMap::new();
        for cell in file.groups("cell") {
            cells.insert(cell.name().to_owned(), reader.cell(cell)?);
        }
        let mut library = Self {
            name: file.name().to_owned(),
            sha256,
            time_ps: units.time_ps,
            capacitance_ff: units.load_ff,
            volts: reader.number(&file, "nom_voltage")?,
            cells,
            buffer: String::new(),
            assumed: units.assumed,
            voltage_v: units.volts,
            leakage_w: units.leakage_w,
            text,
            path: origin.clone(),
        };
        let cells = library.cells.len();
        let missing = |what| SynthError::MissingCell {
            path: PathBuf::from(&origin),
            what,
            cells,
        };
        if !library.cells.values().any(|c| c.is_flop && !c.is_barred) {
            return Err(missing("flip-flop"));
        }
        if library.inverters() == 0 {
            return Err(missing("inverter"));
        }
        library.buffer = library.smallest_buffer().ok_or_else(|| missing("buffer"))?;
        if !library.cells.values().any(Cell::combines_two) {
            return Err(missing("AND, OR, NAND or NOR of two inputs"));
        }
        Ok(library)
    }

    fn smallest_buffer(&self) -> Option<String> {
        let buffers = self.cells.iter().filter(|(_, c)| c.is_of_one_input(""));
        let smallest = buffers.min_by(|(_, a), (_, b)| a.area.total_cmp(&b.area));
        smallest.map(|(name, _)| name.clone())
    }

    fn inverters(&self) -> usize {
        let inverters = self.cells.values().filter(|c| c.is_of_one_input("!"));
        inverters.count()
    }

    /// Load of every output, in the library's unit of capacitance.
    pub(super) fn load(&self) -> f64 {
        let buffer = self.cells.get(&self.buffer);
        4.0 * buffer.map_or(0.0, |cell| cell.inputs.values().sum())
    }
}

impl Cell {
    /// Whether it is a usable buffer.
    pub(super) fn is_buffer(&self) -> bool {
        self.is_of_one_input("")
    }

    /// Whether it is an AND, OR, NAND or NOR of two inputs, possibly inverted: with an inverter it
    /// makes all logic.
    fn combines_two(&self) -> bool {
        let names: Vec<&str> = self.inputs.keys().map(String::as_str).collect();
        let (mut outputs, 2, false) = (self.outputs.values(), names.len(), self.is_barred) else {
            return false;
        };
        let (Some(function), None, false) = (outputs.next(), outputs.next(), self.is_flop) else {
            return false;
        };
        let truth = Truth::parse(function, &names);
        let ones = truth.map_or(0, |t| (0..4).filter(|bits| t.at(*bits)).count());
        [1, 3].contains(&ones)
    }

    /// Whether it has one input, and one output that is that input after a sign.
    fn is_of_one_input(&self, sign: &str) -> bool {
        let (mut inputs, mut outputs) = (self.inputs.keys(), self.outputs.values());
        let (Some(input), None, Some(function), None) =
            (inputs.next(), inputs.next(), outputs.next(), outputs.next())
        else {
            return false;
        };
        let function: String = function.chars().filter(|c| !" ()".contains(*c)).collect();
        let other = input.clone() + "'";
        !self.is_barred
            && (function == format!("{sign}{input}") || (sign == "!" && function == other))
    }
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

struct Attributes<'a> {
    origin: &'a str,
}

impl Attributes<'_> {
    fn wrong(&self, group: &Group, expected: &str, found: &str) -> SynthError {
        group.wrong(self.origin, expected, found)
    }

    fn number(&self, group: &Group, name: &str) -> Result<Option<f64>, SynthError> {
        let Some(text) = group.value(name) else {
            return Ok(None);
        };
        let number = text
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite() && *v >= 0.0);
        let expected = || format!("{name}, a number of 0 or more");
        number
            .map(Some)
            .ok_or_else(|| self.wrong(group, &expected(), text))
    }

    fn cell(&self, cell: &Group) -> Result<Cell, SynthError> {
        let area = self.number(cell, "area")?;
        let area = area.ok_or_else(|| self.wrong(cell, "area", "none"))?;
        let (mut inputs, mut outputs) = (BTreeMap::new(), BTreeMap::new());
        let mut drive: f64 = 0.0;
        for pin in cell.groups("pin") {
            let name = pin.name().to_owned();
            match pin.value("direction") {
                Some("input") => {
                    let capacitance = self.number(pin, "capacitance")?;
                    inputs.insert(name, capacitance.unwrap_or_default());
                }
                Some("output") => {
                    let function = pin.value("function").unwrap_or_default();
                    outputs.insert(name, function.to_owned());
                    let most = self.number(pin, "max_capacitance")?;
                    drive = drive.max(most.unwrap_or_default());
                }
                Some("inout" | "internal") | None => {}
                Some(other) => {
                    return Err(self.wrong(pin, "direction, input or output", other));
                }
            }
        }
        let flop = cell.groups("ff").next();
        let clocked_on = flop.and_then(|ff| ff.value("clocked_on"));
        let is_named = |pin: &&String| {
            let mut words = clocked_on
                .unwrap_or_default()
                .split(|c: char| !is_of_name(c));
            words.any(|word| word == pin.as_str())
        };
        Ok(Cell {
            area,
            clock: inputs.keys().find(is_named).cloned(),
            inputs,
            outputs,
            drive,
            is_flop: flop.is_some(),
            is_barred: cell.value("dont_use") == Some("true"),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SMALL: &str = "library (tiny) { time_unit : \"10ps\"; capacitive_load_unit (1, pf);\n\
        nom_voltage : 0.7;\n\
        cell (INV) { area : 1; pin (A) { direction : input; capacitance : 0.002; } \
        pin (Y) { direction : output; function : \"(!A)\"; } }\n\
        cell (BUF) { area : 2; pin (A) { direction : \"input\"; capacitance : 0.003; } \
        pin (Y) { direction : output; function : \"A\"; } }\n\
        cell (DFF) { area : 5; ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; } \
        pin (D) { direction : input; } pin (CK) { direction : input; } \
        pin (Q) { direction : output; function : \"IQ\"; } }\n\
        cell (NOR) { area : 2; pin (A) { direction : input; } pin (B) { direction : input; } \
        pin (Y) { direction : output; function : \"!(A + B)\"; } }\n}\n";

    fn read(text: &str) -> Result<Library, SynthError> {
        Library::parse(text.to_owned(), String::new(), Path::new("t.lib"))
    }

    #[test]
    fn units_cells_and_the_buffer_are_found() {
        let library = read(SMALL).unwrap();
        assert!((library.time_ps - 10.0).abs() < 1e-9);
        assert!((library.capacitance_ff - 1000.0).abs() < 1e-9);
        assert_eq!(library.volts, Some(0.7));
        let assumed = |name: &str| library.assumed.iter().any(|said| said.starts_with(name));
        assert!(!assumed("time_unit") && assumed("leakage_power_unit"));
        let library = read(&SMALL.replace("time_unit : \"10ps\";", "")).unwrap();
        let said = "time_unit is not there: 1ns is taken, as usual";
        assert_eq!((library.time_ps, &*library.assumed[0]), (1000.0, said));
        assert_eq!(library.buffer, "BUF");
        assert!((library.load() - 0.012).abs() < 1e-12);
        assert!(library.cells["DFF"].is_flop && !library.cells["INV"].is_flop);
    }

    #[test]
    fn packed_files_are_the_same_library() {
        let folder = tempfile::tempdir().unwrap();
        let [plain, packed] = ["t.lib", "t.lib.gz"].map(|name| folder.path().join(name));
        std::fs::write(&plain, SMALL).unwrap();
        let mut gzip = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
        std::io::Write::write_all(&mut gzip, SMALL.as_bytes()).unwrap();
        let bytes = gzip.finish().unwrap();
        std::fs::write(&packed, &bytes).unwrap();
        let [plain, found] = [plain, packed.clone()].map(|p| Library::read(&p).unwrap());
        assert_eq!((&plain.sha256, plain.sha256.len()), (&found.sha256, 64));
        std::fs::write(&packed, &bytes[..bytes.len() - 9]).unwrap();
        assert!(
            Library::read(&packed)
                .unwrap_err()
                .to_string()
                .contains("t.lib.gz")
        );
    }

    #[test]
    fn what_a_library_lacks_is_named() {
        for (from, to, expected) in [
            (
                "ff (IQ, IQN)",
                "latch (IQ, IQN)",
                "no flip-flop among its 4 cells",
            ),
            ("\"A\"", "\"A & A\"", "no buffer"),
            ("\"(!A)\"", "\"A A\"", "no inverter"),
            (
                "!(A + B)",
                "A ^ B",
                "no AND, OR, NAND or NOR of two inputs among its 4 cells",
            ),
            (
                "cell (NOR) {",
                "cell (NOR) { dont_use : true;",
                "no AND, OR, NAND or NOR",
            ),
            (
                "10ps",
                "10 parsec",
                "time_unit, as 1ps or 1ns in the library `tiny`, found `10 parsec`",
            ),
            ("(1, pf)", "(1, kf)", "capacitive_load_unit"),
            ("area : 2;", "", "area in the cell `BUF`"),
            (
                "area : 5",
                "area : -5",
                "area, a number of 0 to 1e8 um^2, which is 1 cm^2 in the cell `DFF`, found `-5`",
            ),
            (
                "nom_voltage : 0.7",
                "nom_voltage : O.7",
                "nom_voltage, a number",
            ),
            ("\"(!A)\"", "\"(! & )\"", "in the pin `Y` of the cell `INV`"),
            (
                "direction : \"input\"",
                "direction : sideways",
                "direction, input or output",
            ),
        ] {
            let error = read(&SMALL.replace(from, to)).unwrap_err().to_string();
            assert!(
                error.starts_with("t.lib") && error.contains(expected),
                "{error}"
            );
        }
    }

    /// Libraries in use pass all checks.
    #[test]
    fn libraries_in_use_are_read() {
        let asap7 = "data/liberty/asap7_rvt_tt_62cells.lib.gz";
        let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
            || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
            PathBuf::from,
        );
        let osu = PathBuf::from(crate::DEFAULT_LIBRARY);
        for (path, cells) in [(shared.join(asap7), 62), (osu, 32)] {
            if !path.is_file() {
                println!("skipped: {}: not here", path.display());
                continue;
            }
            let library = Library::read(&path).unwrap();
            assert_eq!((library.cells.len(), library.assumed.len()), (cells, 0));
        }
    }
}
