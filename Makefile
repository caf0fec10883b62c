# Each target first sees to it that the tools it needs are here (tools/setup).

export PATH := $(CURDIR)/.tools/bin:$(PATH)
export CARGO_TERM_COLOR ?= auto

step = @printf '\n==> %s\n' '$(1)'

.PHONY: help demo test test-full refresh figures plots docs book parameters grid forms memories lint bench setup dist

help:
	@printf '%s\n' \
	  'make demo       emit, verify and render the built-in scenes on simulated hardware' \
	  'make test       the checks of a change: formatting, lints, tests but for slow ones, checked-in Verilog' \
	  'make test-full  also the slow and the exhaustive tests, hard cases without their guards, the crate verilated, and that the benches build' \
	  'make refresh    regenerate rtl_out/, pictures and snapshots, to be reviewed with git diff' \
	  'make figures    write the figures between markers in the documents (slow ones: SLOW=1; of one page: PAGE=system)' \
	  'make plots      draw the plots of the documents again: docs/images/*.svg' \
	  'make book       build the documents as HTML: book/index.html' \
	  'make docs       both: plots, and the documents as HTML' \
	  'make parameters LIBERTY=FILE  synthesise again: synth/PRESET-asap7.json and synth/records-asap7.json' \
	  'make grid LIBERTY=FILE        the grid too, in an hour or two: synth/grid-asap7.json' \
	  'make forms LIBERTY=FILE       exponentials that no formula is of: synth/forms-asap7.json' \
	  'make memories   memories by shape, with their area by CACTI: synth/memories-cacti.json' \
	  'make lint       formatting and lints alone' \
	  'make bench      speed beside limits and peers (potamoi bench), and the other benches' \
	  'make dist       wheels and archives for Linux, x86-64 and aarch64: dist/' \
	  'make setup      install what is missing (tools/setup --check only reports)'

setup:
	@tools/setup

demo:
	@tools/setup demo
	@tools/demo

test: setup
	@$(MAKE) --no-print-directory lint-only
	$(call step,tests)
	@tools/run-tests

test-full: setup
	@tools/setup synth
	@tools/setup fpga
	@tools/setup oracles
	@tools/setup registers
	@tools/setup cocotb
	@tools/setup linters
	@tools/setup notebook
	@$(MAKE) --no-print-directory lint-only
	$(call step,documentation and its links)
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps --workspace
	$(call step,tests with the exhaustive ones)
	@tools/run-tests --all --include-ignored
	$(call step,the memory model against DRAMsim3)
	cargo test --locked --manifest-path sim/dram-oracle/Cargo.toml --target-dir target/dram-oracle
	$(call step,the crate verilated against Verilator 5)
	tools/show-verilated-crate
	$(call step,the page of a report in headless Chromium)
	mkdir -p out/report
	cargo run --locked --quiet -- report garden --width 48 --frames 2 --out out/report/page.html
	tools/check-report out/report/page.html out/report
	$(call step,the notebook and the Python package with pandas)
	.tools/bin/python3-notebook tools/run-notebook
	cd python && ../.tools/bin/python3-notebook -m unittest discover -s tests
	$(call step,hard cases without their guards)
	tools/hard-case-guards --batches
	tools/hard-case-guards --end-to-end
	$(call step,benches build)
	cargo bench --locked --no-run

.PHONY: lint-only
lint-only:
	$(call step,formatting)
	cargo fmt --all --check
	$(call step,lints)
	cargo clippy --locked --all-targets -- -D warnings

lint: setup
	@$(MAKE) --no-print-directory lint-only

refresh: setup
	$(call step,Verilog of the presets)
	POTAMOI_REFRESH=1 cargo test --locked --quiet --test end_to_end the_checked_in_verilog
	$(call step,pictures of the documents)
	for scene in garden lantern; do \
	  cargo run --locked --release --quiet -- render --scene $$scene --numerics rtl \
	    --out docs/images/$$scene.png || exit 1; \
	done
	cargo run --locked --release --quiet -- warp --scene cairn:voxels --width 320 --frames 42 \
	  --depth mesh --mesh-cells 128 --out-dir out/refresh-warp
	for kind in frame origin; do \
	  mv out/refresh-warp/$$kind.0032.png docs/images/warping-$$kind.png || exit 1; \
	done
	rm -rf out/refresh-warp
	cargo run --locked --release --quiet -p potamoi-scene --example contact_sheet -- \
	  scenes docs/images/scenes.png
	cargo run --locked --release --quiet -p potamoi-scene --example contact_sheet -- \
	  models docs/images/models.png 400
	@$(MAKE) --no-print-directory plots
	$(call step,snapshots)
	INSTA_UPDATE=always INSTA_FORCE_PASS=1 cargo test --locked --quiet
	INSTA_UPDATE=always cargo test --locked --workspace --quiet figures_are_what_they_were
	$(call step,what commands print)
	POTAMOI_REFRESH=1 cargo test --locked --quiet --test end_to_end commands_print
	$(call step,the tables of hard cases)
	POTAMOI_REFRESH=1 cargo test --locked --workspace --quiet the_table_of_the_book
	POTAMOI_REFRESH=1 cargo test --locked --quiet -p potamoi-rtl --test rtl cycle_budget
	$(call step,the command line and figures of the documents)
	POTAMOI_REFRESH=1 cargo test --locked --quiet --bin potamoi vocabulary
	POTAMOI_REFRESH=1 cargo test --locked --quiet --bin potamoi schemas
	@$(MAKE) --no-print-directory figures
	@git status --short -- rtl_out README.md docs ':(glob)**/*.snap' ':(glob)tests/**'

figures:
	POTAMOI_REFRESH=1 $(if $(PAGE),POTAMOI_PAGE=$(PAGE)) cargo test --locked --quiet --test end_to_end figures_in_the_documents -- $(if $(SLOW),--include-ignored)

# From the same specifications as the page of a report.
plots: setup
	$(call step,plots of the documents)
	for scene in garden lantern; do \
	  cargo run --locked --release --quiet -- cost --scene $$scene \
	    --plot docs/images/cost-$$scene.svg > /dev/null || exit 1; \
	done
	cargo run --locked --release --quiet -- cost --study methods \
	  --plot docs/images/cost-exponentials.svg > /dev/null
	cargo run --locked --release --quiet -- effects --scene garden --width 64 --pairs 5 \
	  --plot docs/images/effects-garden.svg > /dev/null

docs: plots book

book:
	@tools/setup book
	@tools/book

# The library is not the project's: docs/explanation/synthesis.md says which.
parameters: setup
	@test -n "$(LIBERTY)" || { echo 'make parameters: name the library, LIBERTY=FILE' >&2; exit 2; }
	@tools/setup synth
	cargo run --locked --release --quiet -- synth --liberty "$(LIBERTY)" --node 7 \
	  --json synth/paper-asap7.json
	for preset in fields piecewise pipelined small compact feature-major lean-fields; do \
	  cargo run --locked --release --quiet -- --config $$preset synth --liberty "$(LIBERTY)" \
	    --node 7 --json synth/$$preset-asap7.json || exit 1; \
	done
	cargo run --locked --release --quiet -- --config parity synth --activity lantern \
	  --liberty "$(LIBERTY)" --node 7 --json synth/parity-asap7.json
	for preset in lean-splats lean; do \
	  cargo run --locked --release --quiet -- --config $$preset synth --activity garden \
	    --liberty "$(LIBERTY)" --node 7 --json synth/$$preset-asap7.json || exit 1; \
	done
	cargo run --locked --release --quiet -- synth --unit gu --activity garden \
	  --liberty "$(LIBERTY)" --node 7 --json synth/records-asap7.json

grid: setup
	@test -n "$(LIBERTY)" || { echo 'make grid: name the library, LIBERTY=FILE' >&2; exit 2; }
	@tools/setup synth
	cargo run --locked --release --quiet -- synth --liberty "$(LIBERTY)" --node 7 \
	  --grid synth/grid-asap7.json

forms: setup
	@test -n "$(LIBERTY)" || { echo 'make forms: name the library, LIBERTY=FILE' >&2; exit 2; }
	@tools/setup synth
	cargo run --locked --release --quiet -- synth --liberty "$(LIBERTY)" --node 7 \
	  --forms synth/forms-asap7.json

memories:
	@tools/setup memories
	cargo run --locked --release --quiet -- synth --memories synth/memories-cacti.json

bench: setup
	$(call step,speed beside limits and peers)
	cargo run --locked --release --quiet -- bench
	$(call step,other benches)
	cargo bench --locked

dist:
	@tools/setup dist
	@tools/dist
