//! The Makefile beside the benches, and the command lines of their headers.

use potamoi_formats::units::{GATHERING_UNIT, NPU_EXT, VECTOR_UNIT};

/// The runs of a bench: gaps in percent of the clocks, and their seed.
pub const RUNS: &str = "0:1 25:2 60:3 85:4";

const TEXT: &str = r#"# Simulates the units against golden vectors. It needs make and a simulator, nothing else.
#
#   make                  Icarus Verilog
#   make SIM=verilator    Verilator 5 or later
#   make RUNS='0:1 40:7'  these runs: gaps in percent of the clocks, and their seed
#   make DUMP=1           also writes BUILD/UNIT.vcd, of the last run
#   make CHECKS=1         also holds the units to the assertions in their Verilog
#   make RTL=DIR          other Verilog with the same ports, in DIR/gathering_unit, DIR/vector_unit, ...
#   make MACROS=FILES     the modules NAME_macro of these files in place of the memories
#
# The exit status is not 0 if a unit fails.

SIM   ?= icarus
RUNS  ?= @RUNS@
UNITS ?= @UNITS@
RTL   ?= ..
BUILD ?= build
DUMP  ?=
CHECKS ?=
MACROS ?=

IVERILOG  ?= iverilog
VVP       ?= vvp
VERILATOR ?= verilator

.PHONY: all clean FORCE $(UNITS)
all: $(UNITS)

ifneq ($(filter $(SIM),icarus verilator),$(SIM))
$(error SIM=$(SIM): expected icarus or verilator)
endif
ifeq ($(strip $(RUNS)),)
$(error RUNS is empty: expected GAPS:SEED, as 25:2)
endif
$(foreach file,$(MACROS),$(if $(wildcard $(file)),,\
  $(error MACROS: no file $(file); a path is relative to $(CURDIR))))

run_icarus    = $(VVP) -n $(BUILD)/$@_tb.vvp
run_verilator = $(BUILD)/$@/V$@_tb +verilator+rand+reset+2 +verilator+seed+1

$(UNITS): %: $(BUILD)/%.$(SIM)
	@for run in $(RUNS); do \
	  case $$run in *[!0-9:]*|:*|*:|*:*:*) run= ;; *:*) ;; *) run= ;; esac; \
	  test "$$run" || { echo "RUNS=$(RUNS): expected GAPS:SEED, as 25:2"; exit 1; }; \
	  $(run_$(SIM)) +gaps=$${run%%:*} +seed=$${run##*:} \
	    $(if $(DUMP),+dump=$(BUILD)/$@.vcd) $(if $(CHECKS),+pick=$${run##*:}) || exit 1; \
	done

# Of Verilog elsewhere, the checks are there too.
checks = $(if $(CHECKS),$(wildcard $(RTL)/checks/*.v))

defines = $(if $(CHECKS),-DPOTAMOI_CHECKS) $(if $(MACROS),-DPOTAMOI_MACROS)

# Folders of what a unit consists of besides its own.
PARTS_potamoi_npu_ext = gathering_unit vector_unit
folders = $(PARTS_$1) $1
sources = $(foreach folder,$(folders),$(wildcard $(RTL)/$(folder)/*.v))
missing = $(foreach folder,$(folders),$(if $(wildcard $(RTL)/$(folder)/*.v),,$(RTL)/$(folder)))
complete = $(if $(strip $(call missing,$1)),$(error no Verilog in $(call missing,$1)))

# What a build depends on besides the time of its files.
settings = $(abspath $(call sources,$1) $(checks) $(MACROS)) $(defines)

.PRECIOUS: $(BUILD)/%.settings
FORCE:
$(BUILD)/%.settings: FORCE
	$(call complete,$*)@mkdir -p $(BUILD)
	@echo '$(call settings,$*)' | cmp -s - $@ || echo '$(call settings,$*)' > $@

.SECONDEXPANSION:
$(BUILD)/%.icarus: %_tb.v $(BUILD)/%.settings $$(call sources,$$*) $$(checks) $(MACROS)
	$(IVERILOG) -g2005 $(defines) -Wall -Wno-timescale -s $*_tb -o $(BUILD)/$*_tb.vvp $(filter-out %.settings,$^)
	@touch $@

# Verilator 5.006 rewrites some trees of bit operations wrongly.
$(BUILD)/%.verilator: %_tb.v $(BUILD)/%.settings $$(call sources,$$*) $$(checks) $(MACROS)
	$(VERILATOR) $(if $(CHECKS),--assert) $(defines) --binary --timing --trace -Wno-fatal -Wno-WIDTH -Wno-lint -fno-const-bit-op-tree \
	  --x-assign unique --x-initial unique --top-module $*_tb -Mdir $(BUILD)/$* $(filter-out %.settings,$^) \
	  > $(BUILD)/$*.log 2>&1 || { cat $(BUILD)/$*.log; exit 1; }
	@touch $@

clean:
	rm -rf $(BUILD)
"#;

/// The Makefile for these units with further targets, and lines about them for its head.
pub(super) fn with_targets(units: &[&str], help: &str, targets: &str) -> String {
    const END: &str = "#\n# The exit status";
    text(units).replace(END, &format!("{help}{END}")) + targets
}

/// The Makefile for these units.
pub(super) fn text(units: &[&str]) -> String {
    TEXT.replace("@UNITS@", &units.join(" "))
        .replace("@RUNS@", RUNS)
}

/// Command lines of a bench beside that Makefile.
pub(super) fn commands(unit: &str) -> Vec<String> {
    // The top has both units inside.
    let modules = match unit {
        NPU_EXT => &[NPU_EXT, GATHERING_UNIT, VECTOR_UNIT][..],
        _ => &[unit],
    };
    let folders: Vec<_> = modules.iter().map(|own| format!("../{own}/*.v")).collect();
    let mut all = vec!["make".to_owned()];
    let build = format!("iverilog -g2005 -o {unit}_tb {unit}_tb.v");
    let run = format!("&& vvp -n {unit}_tb");
    match &folders[..] {
        [folder] => all.push(format!("{build} {folder} {run}")),
        _ => all.extend([
            format!("{build} \\"),
            format!("  {} {run}", folders.join(" ")),
        ]),
    }
    all
}

/// Command lines of a bench of a trace.
pub(super) fn of_trace(emit: &str, unit: &str) -> Vec<String> {
    vec![
        format!("{emit} --out-dir rtl"),
        format!("iverilog -g2005 -o {unit}_tb {unit}_tb.v rtl/{unit}/*.v && vvp -n {unit}_tb"),
    ]
}
