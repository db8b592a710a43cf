# tissuectl: describe a tissue, `make all`, and get a spring model learned from finite elements.
#
#   mesh -> cases -> springs -> train -> eval -> haptic
#
# STUDY=NAME     which fem/studies/NAME.toml (default paper); its results go to results/NAME/
# RUN='srun -n1' put before every FreeFEM run
# NO_INSTALL=1   name missing packages instead of installing them
# PREFIX=PATH    where install puts programs, library, headers, man pages and completions (default /usr/local)
# DESTDIR=PATH   put before PREFIX, for packagers
# BENCH_OPTIONS=--quick  `make bench` without the whole study from clean, its longest part
# SANITIZE=1     build with address and undefined-behaviour sanitizers, in a folder of its own

STUDY ?= paper
STUDIES := $(wildcard fem/studies/*.toml fem/materials/*.toml)
R := results/$(STUDY)
RUN ?=
PYTHON ?= /usr/bin/python3
PREFIX ?= /usr/local
BUILD := build/$(if $(SANITIZE),sanitize,release)
TISSUECTL := $(BUILD)/tissuectl
TISSUE_HAPTIC := $(BUILD)/tissue-haptic
MAKEFLAGS += --no-builtin-rules --no-print-directory
# FE and figures run many at a time under -j; a BLAS with threads of its own would only get in the way, and change
# the last bits of results from run to run
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := all

# ---- front door

.PHONY: felupe realtime ablation all mesh cases train eval figures report reference regress regress-proof trust gains test sanitize bench benches deps help clean build install uninstall doctor

## all: the whole study, from mesh to report
all: figures eval report

## mesh: gmsh meshes the block (Sec. 2.2), or your shape
mesh: $(R)/mesh.msh

## cases: FreeFEM solves every load path (Sec. 2)
cases: $(R)/cases.h5

## train: learn a spring set for every load case (Sec. 3)
train: $(R)/model.h5

## eval: measure learned springs and baselines against FE
eval: $(R)/eval.json

## figures: draw what the plan says the study shows
figures:

## report: one file to mail with the figures inside, results/NAME/report.html
report: $(R)/report.html

## build: the programs alone
build: $(TISSUECTL) $(TISSUE_HAPTIC)

## deps: name and install missing packages
deps: build/deps

## install: programs, library, headers, pkg-config file, man pages and completions, under PREFIX
install: build $(BUILD)/libtissue.a
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' PACKAGES='$(PACKAGES)' CXX='$(CXX)' CXXFLAGS='$(filter -m%,$(CXXFLAGS))' scripts/install $(BUILD)

## uninstall: take away what install put under PREFIX
uninstall:
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' scripts/install --remove

## doctor: versions of every tool, what is missing and how to get it
doctor: $(TISSUECTL)
	@$(TISSUECTL) doctor

## help: this text
help:
	@sed -n 's/^## //p' $(MAKEFILE_LIST) | awk -F': ' '{ printf "  make %-13s %s\n", $$1, $$2 }'
	@sed -n 's/^# \([A-Z_]*=.*\)/  \1/p' Makefile

## clean: remove everything that was built and every result, but the committed ones
clean:
	rm -rf build results/bench.json $(filter-out results/reference/,$(wildcard results/*/))

build/deps: scripts/install_deps
	@scripts/install_deps
	@mkdir -p build && touch $@

build/deps-test: scripts/install_deps
	@scripts/install_deps test
	@mkdir -p build && touch $@

# ---- programs

CXX := g++
PACKAGES := hdf5 gsl fmt nlopt libxxhash lapacke openblas
# tests forbid Eigen to allocate in the tick (EIGEN_RUNTIME_NO_MALLOC);
# gcc 12 sees an overflow in fmt's own inlined parser that is not there, and under sanitizers uninitialised members in
# its own <regex>
CXXFLAGS = -std=c++17 -O3 -g1 -pthread -Wall -Wextra -Wpedantic -Wshadow -Werror -Wno-stringop-overflow -DEIGEN_RUNTIME_NO_MALLOC -MMD -MP \
  -Ilib -isystem /usr/include/eigen3 $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(PACKAGES))) \
  $(if $(SANITIZE),-O1 -Wno-maybe-uninitialized -fsanitize=address$(comma)undefined -fno-sanitize-recover=all)
LDLIBS = $(shell pkg-config --libs $(PACKAGES)) -pthread
comma := ,

LIB_SOURCES := $(wildcard lib/*/*.cpp)
# what both programs use: arguments, help, options of the realtime core, its ledger
SHARED_SOURCES := cli/command.cpp cli/generate.cpp cli/haptic_options.cpp cli/haptic_report.cpp
HAPTIC_SOURCES := cli/tissue_haptic.cpp $(SHARED_SOURCES)
# the page's server: what knows Boost is one file, so that tests can do without it
SERVE_SOURCES := $(filter-out cli/serve/server.cpp,$(wildcard cli/serve/*.cpp))
CLI_SOURCES := $(filter-out cli/tissue_haptic.cpp,$(wildcard cli/*.cpp)) $(wildcard cli/serve/*.cpp)
TEST_SOURCES := $(filter-out tests/bench/%,$(wildcard tests/*.cpp tests/*/*.cpp))
BENCH_SOURCES := $(wildcard tests/bench/bench_*.cpp)
objects = $(patsubst %.cpp,$(BUILD)/%.o,$(1))

$(BUILD)/%.o: %.cpp | build/deps
	@mkdir -p $(@D)
	@echo "c++   $<"
	@$(CXX) $(CXXFLAGS) -c $< -o $@

$(BUILD)/libtissue.a: $(call objects,$(LIB_SOURCES))
	@rm -f $@ && ar rcs $@ $^

$(TISSUECTL): $(call objects,$(CLI_SOURCES)) $(BUILD)/libtissue.a
	@$(CXX) $(CXXFLAGS) $^ $(LDLIBS) -o $@

# symbols stay in the objects; the program that a device waits for is small
$(TISSUE_HAPTIC): $(call objects,$(HAPTIC_SOURCES)) $(BUILD)/libtissue.a
	@$(CXX) $(CXXFLAGS) -s -Wl,--as-needed $^ $(LDLIBS) -ldl -o $@

$(BUILD)/test_tissue: $(call objects,$(TEST_SOURCES) $(SERVE_SOURCES)) $(BUILD)/libtissue.a
	@$(CXX) $(CXXFLAGS) $^ $(LDLIBS) -o $@

$(BUILD)/gains_probe: $(call objects,scripts/gains_probe.cpp) $(BUILD)/libtissue.a
	@$(CXX) $(CXXFLAGS) $^ $(LDLIBS) -o $@

BENCHES := $(BENCH_SOURCES:tests/bench/%.cpp=$(BUILD)/bench/%)
$(BENCHES): $(BUILD)/bench/%: $(BUILD)/tests/bench/%.o $(BUILD)/libtissue.a
	@mkdir -p $(@D)
	@$(CXX) $(CXXFLAGS) $^ $(LDLIBS) -o $@

# the page is part of the program
$(BUILD)/cli/serve/page.o: $(wildcard cli/view/*.html cli/view/*.css cli/view/*.js)

-include $(patsubst %.o,%.d,$(call objects,$(LIB_SOURCES) $(CLI_SOURCES) $(HAPTIC_SOURCES) $(TEST_SOURCES) $(BENCH_SOURCES) scripts/gains_probe.cpp))

# ---- stages: one rule per kind of file

# The plan says which load paths there are and with which arguments; its parts say what each stage depends on, and
# keep their time stamp while their text stays the same.
ifneq (,$(filter-out help clean deps build install uninstall doctor reference regress regress-proof trust felupe gains test sanitize bench benches $(BUILD)/%,$(or $(MAKECMDGOALS),all)))
include $(R)/plan.mk
endif
# A shape has no surface to plan contacts on until it is meshed: its first plan says where it comes from, SHAPE and
# SHAPE_ARGUMENTS, and that the plan depends on the mesh.
MESH_OPTION = $(if $(SHAPE),--mesh $(R)/mesh.msh)
figures: $(FIGURES:%=$(R)/figures/%.png)

$(R)/plan.mk: $(STUDIES) $(TISSUECTL)
	@$(TISSUECTL) plan --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $@

$(R)/plan/%:
	@$(TISSUECTL) plan --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $(R)/plan.mk

# any shape: gmsh fills an outline with triangles, or takes the format of a mesh to 2.2; then it is checked
ifneq (,$(SHAPE))
$(R)/mesh.msh: $(SHAPE) $(R)/plan/shape | $(TISSUECTL)
	@echo "mesh  $@"
	@mkdir -p $(@D)
	@: > $@.log
	@gmsh -v 2 $(SHAPE_ARGUMENTS) -format msh22 $< -o $@.raw > $@.log 2>&1 \
	  && tail -n 1 $@.raw | grep -qx '.EndElements' \
	  || { echo "$<: gmsh cannot read or mesh it: $$(sed -n 's/^Error *: *//p' $@.log | head -n 1); see $@.log" >&2; rm -f $@.raw; exit 1; }
	@$(TISSUECTL) shape --study fem/studies/$(STUDY).toml --mesh $@.raw --out $@; status=$$?; rm -f $@.raw; exit $$status
else
$(R)/mesh.msh $(R)/mesh-fine.msh: fem/block.geo
	@echo "mesh  $@"
	@: > $@.log
	@# gmsh ends with 0 on a full disk: a whole mesh is one that has its last line
	@gmsh -v 2 -2 -format msh22 $(MESH_ARGUMENTS) $< -o $@.tmp > $@.log 2>&1 \
	  && tail -n 1 $@.tmp | grep -qx '.EndElements' \
	  || { echo "$@: gmsh failed; see $@.log" >&2; rm -f $@.tmp; exit 1; }
	@mv $@.tmp $@
endif

$(R)/cases/%.csv: $(wildcard fem/*.edp fem/*.idp) scripts/solve_path
	@$(RUN) scripts/solve_path $(R) $* $(PATH_ARGUMENTS)

$(R)/cases.h5: $(PATHS:%=$(R)/cases/%.csv) $(TISSUECTL)
	@$(TISSUECTL) $(CASES_COMMAND) --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $@

$(R)/model.h5: $(R)/cases.h5 $(TISSUECTL)
	@# 3: something in it did not reach the convergence it promises; its line says what, and so does the report's head
	@$(TISSUECTL) train --study fem/studies/$(STUDY).toml --cases $< --out $@ || [ $$? = 3 ]

$(R)/eval.json $(R)/report.md &: $(R)/model.h5 $(R)/cases.h5 $(TISSUECTL)
	@$(TISSUECTL) eval --study fem/studies/$(STUDY).toml --model $< --cases $(R)/cases.h5 --out $(R)/eval.json \
	  --report $(R)/report.md

$(R)/figures/%.png: $(R)/cases.h5 $(R)/model.h5 $(R)/eval.json $(wildcard scripts/figures/*.py)
	@mkdir -p $(@D)
	@echo "draw  $@"
	@$(PYTHON) scripts/figures/draw.py $* $(R) $@

$(R)/report.html: $(R)/report.md $(R)/eval.json $(R)/cases.h5 $(R)/model.h5 $(FIGURES:%=$(R)/figures/%.png) \
  scripts/figures/results.py $(wildcard scripts/report/*)
	@echo "draw  $@"
	@$(PYTHON) scripts/report/page.py $(R) $@

REFERENCE_STUDIES := paper paper-axial paper-grid8 paper-grid8-turning surface organ
## reference: run the paper's studies, then write results/reference and README's tables anew
reference:
	@for study in $(REFERENCE_STUDIES); do $(MAKE) all STUDY=$$study || exit 1; done
	@$(PYTHON) scripts/reference.py $(REFERENCE_STUDIES)

## regress: run the study anew and elsewhere; silent when it says what results/reference/STUDY.json says
regress: | build/deps
	@scripts/regress --study $(STUDY) $(REGRESS_OPTIONS)

## trust: where FE stops being trustworthy, as results/reference/trust.png
trust: | build/deps
	@mkdir -p results/trust
	@FF_LOADPATH="$$(scripts/freefem_plugins)" $(PYTHON) scripts/trust_study.py --out results/trust/trust.csv
	@$(PYTHON) scripts/figures/trust.py results/trust/trust.csv results/reference/trust.png

## realtime: press the 1 kHz simulation at the study's contacts until it rests; drawn as figures/motion.png
realtime: $(R)/realtime.json
	@mkdir -p $(R)/figures
	@$(PYTHON) scripts/figures/motion.py $< $(R)/figures/motion.png

$(R)/realtime.json: $(R)/model.h5 $(R)/cases.h5 $(TISSUE_HAPTIC)
	@$(TISSUE_HAPTIC) $< --check $(R)/cases.h5 --out $@ $(REALTIME_OPTIONS)

## ablation: train and try the study's variants on its drawn contacts
ablation: $(R)/cases.h5 $(TISSUECTL)
	@$(TISSUECTL) ablate --study fem/studies/$(STUDY).toml --cases $< --out $(R)/ablation.json
	@mkdir -p $(R)/figures
	@$(PYTHON) scripts/figures/ablation.py $(R)/ablation.json $(R)/figures/ablation.png

## felupe: contact forces of an independent finite-element program on the same mesh
felupe: | build/deps
	@PYTHON=$(PYTHON) scripts/venv
	@FF_LOADPATH="$$(scripts/freefem_plugins)" build/venv/bin/python tests/fem/felupe_patch.py

## gains: how gains, iterations and Q follow mesh size and displacement, as results/reference/gains.md
gains: $(TISSUECTL) $(BUILD)/gains_probe
	@for nodes in 6 11 21 41; do $(MAKE) cases STUDY=lattice-$$nodes || exit 1; done
	@$(PYTHON) scripts/gains_study.py $(BUILD)/gains_probe results/reference/gains

# ---- tests and benches

## test: library, FE and pipeline tests; the last line counts them
test: $(TISSUECTL) $(TISSUE_HAPTIC) $(BUILD)/test_tissue | build/deps-test
	@TISSUE_HAPTIC=$(abspath $(TISSUE_HAPTIC)) PYTHON=$(PYTHON) TISSUECTL=$(abspath $(TISSUECTL)) tests/run $(BUILD)/test_tissue

## sanitize: library tests and the server under address and undefined-behaviour sanitizers
sanitize:
	@$(MAKE) SANITIZE=1 build/sanitize/tissue-haptic build/sanitize/tissuectl build/sanitize/test_tissue
	@TISSUE_HAPTIC=$(abspath build/sanitize/tissue-haptic) build/sanitize/test_tissue
	@TISSUECTL=$(abspath build/sanitize/tissuectl) PYTHON=$(PYTHON) tests/pipeline/test_serve.sh

## regress-proof: put five defects into a copy, one at a time; each must turn the regression of paper red
regress-proof: $(TISSUECTL)
	@PROOF=paper PYTHON=$(PYTHON) TISSUECTL=$(abspath $(TISSUECTL)) tests/pipeline/test_regress.sh

## benches: the programs of bench and gains, without running them
benches: $(BENCHES) $(BUILD)/gains_probe

## bench: our speed beside that of others, as results/bench.json
bench: $(TISSUECTL) $(TISSUE_HAPTIC) $(BENCHES) | build/deps-test
	@$(MAKE) train STUDY=paper
	@PYTHON=$(PYTHON) scripts/venv || echo "bench: goes on without its peers" >&2
	@TISSUECTL=$(abspath $(TISSUECTL)) $(PYTHON) scripts/bench.py --make $(MAKE) $(BENCH_OPTIONS) $(TISSUE_HAPTIC) \
	  $(BENCHES) tests/bench/bench_serve.py
	@$(PYTHON) tests/bench/test_bench.py
