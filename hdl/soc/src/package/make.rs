//! `Makefile`: lint and simulation with free tools.

use super::Package;

const TEXT: &str = r#"#
#   make lint                 Verilator, Icarus Verilog and Yosys, each without a waiver
#   make lint-verilator       one of them; also lint-icarus, lint-yosys
#   make lint CHECKS=1        the same with the assertions in the Verilog
#   make sim [SIM=verilator]  the benches of the folder sim, whose Makefile has further options
#
# It needs make and the tools of the target, nothing else. A warning is a failure.

UNITS  = @UNITS@
PREFIX = @PREFIX@

VERILATOR ?= verilator
IVERILOG  ?= iverilog
YOSYS     ?= yosys
CHECKS    ?=

# Runs a command, and fails if it says anything but a report (lines that begin with "- ").
silent = said=$$($(1) 2>&1) && said=$$(echo "$$said" | sed '/^- /d') && test -z "$$said" \
  || { echo "$$said"; exit 1; }
checks = $(if $(CHECKS),$(sort $(wildcard checks/*.v)))
files  = $$(grep -v '^//' $$unit.f | tr '\n' ' ') $(checks)
top    = $(PREFIX)$$unit
each   = @for unit in $(UNITS); do $(call silent,$(1)) ; done

.PHONY: all lint lint-verilator lint-icarus lint-yosys sim clean
all: lint sim

lint: lint-verilator lint-icarus lint-yosys

lint-verilator:
	$(call each,$(VERILATOR) --lint-only -Wall $(if $(CHECKS),--assert -DPOTAMOI_CHECKS,--language 1364-2005) --top-module $(top) -f $$unit.f $(checks))

lint-icarus:
	$(call each,$(IVERILOG) -g2005 $(if $(CHECKS),-DPOTAMOI_CHECKS) -Wall -tnull -s $(top) $(files))

lint-yosys:
	$(call each,$(YOSYS) -q -e '.*' -p "read_verilog $(if $(CHECKS),-formal -DPOTAMOI_CHECKS) $(files); hierarchy -check -top $(top); proc; $(if $(CHECKS),flatten; )check -assert")

sim:
	$(MAKE) -C sim

clean:
	$(MAKE) -C sim clean
"#;

pub(super) fn text(package: &Package) -> String {
    let units: Vec<_> = package.units.iter().map(|unit| unit.name).collect();
    let text = TEXT
        .replace("@UNITS@", &units.join(" "))
        .replace("@PREFIX@", &package.prefix);
    let text: Vec<_> = text.lines().map(str::trim_end).collect();
    package.head("#") + &text.join("\n") + "\n"
}
