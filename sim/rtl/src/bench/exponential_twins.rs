//! Programs beside the bench of the exponential by itself: they compare the C function and the Python
//! package with the bench's own checksums.

use potamoi_formats::config::ExpConfig;
use potamoi_units::exponential::EXPONENTIAL;
use serde_json::Value;

use super::exponential_sums::{BLOCK, FILE, FNV, mask};
use super::makefile;

/// The program that compiles `../potamoi_exp.h`.
pub(super) const C_FILE: &str = "potamoi_exp_test.c";
/// The program that imports the package `potamoi`.
pub(super) const PYTHON_FILE: &str = "potamoi_exp_test.py";

/// Targets of the Makefile.
const TARGETS: &str = r#"
CC     ?= cc
PYTHON ?= python3

.PHONY: c python
c: $(BUILD)/potamoi_exp_test
	$(BUILD)/potamoi_exp_test

$(BUILD)/potamoi_exp_test: potamoi_exp_test.c ../potamoi_exp.h
	@mkdir -p $(BUILD)
	$(CC) -std=c99 -O2 -Wall -Wextra -pedantic -o $@ $<

python:
	$(PYTHON) potamoi_exp_test.py
"#;

/// Lines about those targets in the Makefile's head.
const HELP: &str = "\
#   make c                the C function ../potamoi_exp.h with the same checksums; CC=COMPILER
#   make python           the Python package potamoi with the same checksums; PYTHON=PROGRAM
";

/// The Makefile of the bench with targets for both.
pub(super) fn makefile() -> String {
    makefile::with_targets(&[EXPONENTIAL], HELP, TARGETS)
}

/// The C program. `prefix` begins the function's name.
pub(super) fn c(exp: &ExpConfig, prefix: &str) -> String {
    let extend = match exp.input.is_signed() {
        true => "code < OPERANDS / 2 ? code : code - OPERANDS",
        false => "code",
    };
    C.replace(
        "@COMMANDS@",
        "make c, or\n     cc -std=c99 -o test potamoi_exp_test.c && ./test",
    )
    .replace(
        "@OPERANDS@",
        &format!("(UINT32_C(1) << {})", exp.input.width()),
    )
    .replace("@EXTEND@", extend)
    .replace("@FUNCTION@", &format!("{prefix}potamoi_exp"))
    .replace("@MASK@", &format!("UINT32_C(0x{:x})", mask(exp)))
    .replace("@BLOCK@", &BLOCK.to_string())
    .replace("@START@", &format!("UINT32_C(0x{:08x})", FNV[0]))
    .replace("@FACTOR@", &format!("UINT32_C(0x{:08x})", FNV[1]))
    .replace("@SUMS@", FILE)
}

/// The Python program, which names every knob.
pub(super) fn python(exp: &ExpConfig) -> String {
    let knobs = match serde_json::to_value(exp) {
        Ok(Value::Object(knobs)) => knobs,
        _ => serde_json::Map::new(),
    };
    let knobs = knobs.iter().filter_map(|(name, value)| {
        let text = match value {
            Value::Null => return None,
            Value::Bool(true) => "True".to_owned(),
            Value::Bool(false) => "False".to_owned(),
            other => other.to_string(),
        };
        Some(format!("    {name}={text},\n"))
    });
    let last = 1u32 << exp.input.width();
    let operands = match exp.input.is_signed() {
        true => format!(
            "np.concatenate([np.arange({0}), np.arange(-{0}, 0)])",
            last / 2
        ),
        false => format!("np.arange({last})"),
    };
    PYTHON
        .replace("@KNOBS@", &knobs.collect::<String>())
        .replace("@OPERANDS@", &operands)
        .replace("@MASK@", &format!("0x{:x}", mask(exp)))
        .replace("@BLOCK@", &BLOCK.to_string())
        .replace("@START@", &format!("0x{:08x}", FNV[0]))
        .replace("@FACTOR@", &format!("0x{:08x}", FNV[1]))
        .replace("@SUMS@", FILE)
}

const C: &str = r#"/* Every operand of @FUNCTION@, in order, with the checksums of the bench: @BLOCK@ results each.

   Run in this folder: @COMMANDS@
   The last line says PASS or FAIL; the exit status of FAIL is not 0. */
#include <inttypes.h>
#include <stdio.h>

#include "../potamoi_exp.h"

#define OPERANDS @OPERANDS@

int main(void)
{
    FILE *sums = fopen("@SUMS@", "r");
    uint32_t code, expected, sum = @START@;
    if (sums == NULL) {
        puts("FAIL: @SUMS@ is missing: run in the folder of the .hex files");
        return 1;
    }
    for (code = 0; code < OPERANDS; code++) {
        sum = (sum ^ (@FUNCTION@(@EXTEND@) & @MASK@)) * @FACTOR@;
        if (code % @BLOCK@ == @BLOCK@ - 1) {
            if (fscanf(sums, "%" SCNx32, &expected) != 1) {
                puts("FAIL: @SUMS@ ends too early");
                return 1;
            }
            if (sum != expected) {
                printf("FAIL: operands %" PRIu32 " to %" PRIu32 ": checksum %08" PRIx32
                       ", expected %08" PRIx32 "\n", code - (@BLOCK@ - 1), code, sum, expected);
                return 1;
            }
            sum = @START@;
        }
    }
    if (fscanf(sums, "%" SCNx32, &expected) != EOF) {
        puts("FAIL: @SUMS@ goes on");
        return 1;
    }
    fclose(sums);
    printf("PASS: @FUNCTION@, %" PRIu32 " results\n", OPERANDS);
    return 0;
}
"#;

const PYTHON: &str = r#""""Every operand of this exponential in Python, with the checksums of the bench: @BLOCK@ results each.

Run in this folder: make python, or python3 potamoi_exp_test.py. It needs NumPy and the package
`potamoi` of the folder `python` in Potamoi's sources: pip install FOLDER.
The last line says PASS or FAIL; the exit status of FAIL is not 0.
"""

import sys

try:
    import numpy as np
    from potamoi import Exponential
except ModuleNotFoundError as error:
    sys.exit(
        f"FAIL: Python has no module {error.name}: it needs NumPy and the folder python of Potamoi's "
        "sources (pip install FOLDER)"
    )

exp = Exponential(
@KNOBS@)

operands = @OPERANDS@
results = exp(operands).astype(np.uint64) & @MASK@
sums = np.full(results.size // @BLOCK@, @START@, dtype=np.uint64)
for column in results.reshape(-1, @BLOCK@).T:
    sums = (sums ^ column) * @FACTOR@ & 0xFFFFFFFF

try:
    with open("@SUMS@") as file:
        expected = [int(line, 16) for line in file]
except FileNotFoundError:
    sys.exit("FAIL: @SUMS@ is missing: run in the folder of the .hex files")
if len(expected) != sums.size:
    sys.exit(f"FAIL: @SUMS@ has {len(expected)} checksums, expected {sums.size}")
for block, (found, wanted) in enumerate(zip(sums.tolist(), expected)):
    if found != wanted:
        first = block * @BLOCK@
        sys.exit(
            f"FAIL: operands {first} to {first + @BLOCK@ - 1}: checksum {found:08x}, "
            f"expected {wanted:08x}"
        )
print(f"PASS: potamoi.Exponential, {operands.size} results")
"#;
