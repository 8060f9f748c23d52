# Everything that is built, checked or drawn. `make help` lists the targets.

SCENE ?= configs/paper/wetted_strip.toml
CASE  ?= cases/wetted_strip
# What the picture shows: the strip at its tightest, by its curvature. For another SCENE: make demo SCENE=... CASE=... DRAW=
DRAW  ?= --time 0.5 --scalar mean_curvature

SMOKE_SCENE := configs/analytic/smallest.toml
SMOKE_CASE  := cases/smoke
THINSHELL   := $(or $(CARGO_TARGET_DIR),target)/release/thinshell
HDF5_FLAGS  := .tools/hdf5.flags

# A cmake that .ci/hdf5.sh fetched is linked here.
export PATH := $(CURDIR)/.tools/bin:$(PATH)

# One profile for everything: building, testing, clippy and rustdoc then share build scripts, macros and metadata.
CARGO_FLAGS = --release $$(cat $(HDF5_FLAGS))

.PHONY: help build demo test lint doc unit bench stress post post-test clean-cases hdf5

help: ## list the targets (default)
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{ printf "%-20s %s\n", $$1, $$2 }'

build: hdf5 ## build the program into target/release
	cargo build $(CARGO_FLAGS)

demo: build ## build, run SCENE into CASE through all stages, draw its picture and film
	$(THINSHELL) all $(SCENE) --case $(CASE)
	@.ci/post.sh post/render.py $(CASE) $(DRAW) -o $(CASE)/picture.png --film $(CASE)/film.mp4

test: lint doc unit post-test ## everything that continuous integration checks

lint: hdf5 ## rustfmt and clippy, warnings are errors
	cargo fmt --check
	cargo clippy $(CARGO_FLAGS) --all-targets -- -D warnings

doc: hdf5 ## build the documentation, warnings are errors
	RUSTDOCFLAGS="-D warnings" cargo doc $(CARGO_FLAGS) --no-deps

unit: hdf5 ## all Rust tests, documentation examples included
	@if cargo nextest --version >/dev/null 2>&1; then \
	    echo "cargo nextest run"; cargo nextest run $(CARGO_FLAGS); \
	else \
	    echo "cargo-nextest is not installed: running the tests with cargo test"; cargo test $(CARGO_FLAGS) --tests; \
	fi
	cargo test $(CARGO_FLAGS) --doc

post-test: build ## run the smallest scene, draw it and look at the pixels
	rm -rf $(SMOKE_CASE)
	$(THINSHELL) all $(SMOKE_SCENE) --case $(SMOKE_CASE)
	@.ci/post.sh tests/post_smoke/smoke.py $(SMOKE_CASE)

bench: hdf5 ## benchmarks
	cargo bench $(subst --release,,$(CARGO_FLAGS))

stress: build ## run every cell of the stability matrix (cases/matrix)
	$(THINSHELL) report --matrix configs/stress/*.toml

post: ## make the Python environment for pictures and plots (post/.venv)
	@.ci/post.sh

clean-cases: ## delete every computed case
	rm -rf cases

# How the HDF5 library is found, installed or built: see the script.
hdf5:
	@mkdir -p .tools && .ci/hdf5.sh > $(HDF5_FLAGS)
