# tissuectl: describe a tissue, `make all`, and get a spring model learned from finite elements.
#
#   mesh -> cases -> springs -> train -> eval -> haptic
#
# STUDY=NAME     which fem/studies/NAME.toml (default paper); its results go to results/NAME/
# RUN='srun -n1' put before every FreeFEM run
# NO_INSTALL=1   name missing packages instead of installing them
# PREFIX=PATH    where install puts programs, library, headers, man pages and completions (default /usr/local)
# DESTDIR=PATH   put before PREFIX, for packagers
# BENCH_OPTIONS=--quick  `make bench` without the whole study from clean and training in space, its longest parts
# -jN            that many jobs at a time (default: as many as there are cores)
# SANITIZE=1     build with clang's address and undefined-behaviour sanitizers, in a folder of its own; SANITIZE=thread: with g++'s for races

# ---- file names: make and the shell split names with other characters, or execute them

# strange TEXT: the characters of TEXT other than letters, digits and . _ - + /
strange = $(eval left := $$(1))$(strip $(foreach c,$(PLAIN),$(eval left := $$(subst $c,,$$(left)))))$(left)
PLAIN := a b c d e f g h i j k l m n o p q r s t u v w x y z A B C D E F G H I J K L M N O P Q R S T U V W X Y Z \
  0 1 2 3 4 5 6 7 8 9 . _ - + /
define newline


endef
quoted = '$(subst $(newline), ,$(1))'
# files PATTERN...: the files that exist. A name that make cannot handle is an error. A name with a blank is found as a
# word that matches no pattern.
files = $(foreach f,$(wildcard $(1)),$(call carried,$f,$(1))$f)
carried = $(if $(call strange,$(1))$(filter-out $(foreach p,$(2),$(call ends,$(subst *, ,$p))),$(1)),$(error \
  $(call quoted,$(1)), a file's name or part of it in $(sort $(dir $(2))): make cannot carry it; use letters, digits and . _ - + alone))
ends = $(firstword $(1))%$(lastword $(1))

STUDY ?= paper
ifneq (xy,x$(call strange,$(value STUDY))$(findstring /,$(value STUDY))$(filter -% .%,$(value STUDY))y)
$(error STUDY=$(call quoted,$(value STUDY)): a study's name is of letters, digits and . _ - + and begins with none of . -)
endif
ifeq (xy,x$(value STUDY)y)
$(error STUDY= is empty: name one of fem/studies, without its ending)
endif
STUDIES := $(call files,fem/studies/*.toml fem/materials/*.toml)
R := results/$(STUDY)
ifneq (xy,x$(call strange,$(value R))$(filter -%,$(value R))y)
$(error R=$(call quoted,$(value R)): a folder's name here is of letters, digits and . _ - + / alone and does not begin with -)
endif
RUN ?=
PYTHON ?= /usr/bin/python3
PREFIX ?= /usr/local
BUILD := build/$(if $(SANITIZE),$(or $(patsubst thread,tsan,$(filter thread,$(SANITIZE))),sanitize),release)
TISSUECTL := $(BUILD)/tissuectl
TISSUE_HAPTIC := $(BUILD)/tissue-haptic
PYTHON_MODULE := $(BUILD)/python/tissue.so
ifeq (0,$(MAKELEVEL))  # sub-makes share the jobs; nproc would return OMP_NUM_THREADS in place of the cores
MAKEFLAGS += -j$(shell env -u OMP_NUM_THREADS nproc 2>/dev/null || echo 1)
endif
MAKEFLAGS += --no-builtin-rules --no-print-directory
# FE and figures run in parallel under -j. Threads of BLAS would compete with them, and would change rounding from run
# to run.
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := all
# Two makes may run in one clone. A rule that writes a temporary file beside its target holds a lock on it, and so do
# the programs that it starts. The other make waits.
alone = exec 9>>$(1) && flock 9
# says FILE,VARIABLE: a rule for a file that contains the variable's value and is rewritten when the value changes. The
# variable is not evaluated before install_deps has installed the packages, since it may call pkg-config.
define says
ifneq ($$(strip $$(file <$(1))),$$(if $$(wildcard build/deps),$$(strip $$($(2)))))
$(1): FORCE
endif
$(1): | build/deps
	@mkdir -p $$(@D) && printf '%s\n' '$$(subst ','\'',$$(strip $$($(2))))' >$$@
endef
FORCE:

# ---- main targets

.PHONY: felupe realtime ablation all mesh contacts cases first train eval figures report reference regress regress-proof trust gains patient patient3 peers test test-fe sanitized sanitize tsan fuzz bench benches hands doors docs deps help clean build install uninstall doctor

## all: the whole study, from mesh to report
all: figures eval report

## mesh: gmsh meshes the block (Sec. 2.2), or your shape; a solid block's paths mesh for themselves
mesh:

## contacts: draw the fixed part and the contacts of a shape in space, before any path is solved: results/NAME/contacts.png
contacts: $(R)/contacts.png
$(R)/contacts.png: $(if $(SHAPE),$(R)/mesh.msh) $(R)/plan.mk scripts/figures/contacts.py scripts/figures/save.py
	@$(PYTHON) scripts/figures/contacts.py $(R) $@

## cases: FreeFEM solves every load path (Sec. 2)
cases: $(R)/cases.h5

## train: train the energy model, or a spring set for every load case (Sec. 3)
train: $(R)/model.h5

## first: solve 8 load paths of the training set and train a model on all that are solved: results/NAME/first/model.h5; run it again to include more

## eval: compare the trained model and its baselines with FE
eval: $(R)/eval.json

## figures: draw the figures of the study's plan
figures:

## report: write report and figures into one file, results/NAME/report.html
report: $(R)/report.html

## build: build the programs alone
build: $(TISSUECTL) $(TISSUE_HAPTIC)

## doors: build the bindings: the library for C and the module for Python
doors: $(BUILD)/libtissue.so.1 $(PYTHON_MODULE)

## docs: build the documents as one site with a search: build/docs/index.html; a link to nothing is an error
docs: $(PYTHON_MODULE) | build/deps-docs
	@rm -rf build/docs
	@TISSUE_MODULE=$(<D) $(PYTHON) -m sphinx -q -W --keep-going -E -c scripts/docs -d build/docs.cache . build/docs
	@echo "docs  build/docs/index.html"

## deps: name missing packages and install them
deps: build/deps

# Paths are passed by the environment, since they may contain blanks and quotes. In /opt/a$b, make would expand $b to
# nothing and install to /opt/a.
references := $$( $${
bare_dollar = $(findstring $$,$(subst $(word 2,$(references)),,$(subst $(word 1,$(references)),,$(subst $$$$,,$(value $1)))))
ifneq (,$(filter install uninstall,$(MAKECMDGOALS)))
$(foreach v,PREFIX DESTDIR,$(if $(call bare_dollar,$v),$(error $v=$(value $v): write $$$$ for a $$ in it)))
endif
install uninstall: export PREFIX := $(PREFIX)
install uninstall: export DESTDIR := $(DESTDIR)
install: export PYTHON := $(PYTHON)
install: export CXX := $(CXX)

## install: programs, libraries, headers, pkg-config files, Python module, man pages and completions, under PREFIX
install: build doors $(BUILD)/libtissue.a
	@PACKAGES='$(PACKAGES)' CXXFLAGS='$(filter -m% -DEIGEN_%,$(CXXFLAGS))' scripts/install $(BUILD)

## uninstall: remove what install put under PREFIX
uninstall:
	@scripts/install --remove

## doctor: print the version of every tool, the missing ones, and how to install them
doctor: $(TISSUECTL)
	@$(TISSUECTL) doctor

## help: this text
help:
	@sed -n 's/^## //p' $(MAKEFILE_LIST) | awk '{ name = $$1; sub(/:$$/, "", name); sub(/^[^ ]* /, ""); printf "  make %-13s %s\n", name, $$0 }'
	@sed -n 's/^# \([A-Z_]*=.*\|-j.*\)/  \1/p' Makefile

## clean: remove everything that was built and every result, but the committed ones and regress.tsv, which counts runs
clean:
	rm -rf build results/bench.json
	find results -mindepth 1 -maxdepth 1 -type d ! -name reference -exec rm -rf {} +

build/deps-test: ALSO = test
build/deps-sanitize: ALSO = sanitize
build/deps-docs: ALSO = docs
build/deps build/deps-test build/deps-sanitize build/deps-docs: scripts/install_deps
	@mkdir -p build && $(call alone,build/deps.lock) && scripts/install_deps $(ALSO) && touch $@

# ---- programs

CXX := g++
ifneq (,$(filter-out thread,$(SANITIZE)))
override CXX := $(CXX:g++=clang++)
endif
PACKAGES := hdf5 gsl fmt nlopt libxxhash lapacke openblas
# Assertions are off in release builds: no assertion may end a program that has a device open. Preconditions are checked
# before the tick, by exceptions. Eigen's macro is also set for programs that compile against the library
# (scripts/install): functions of its headers are compiled in both, and the linker takes either. Under sanitizers
# assertions are on, and Eigen's forbid allocation in the tick.
ASSERTIONS = $(if $(SANITIZE),-DEIGEN_RUNTIME_NO_MALLOC -D_GLIBCXX_ASSERTIONS,-DNDEBUG -DEIGEN_NO_DEBUG)
# gcc 12 reports an overflow in fmt's inlined parser, and under sanitizers uninitialised members in its own <regex>;
# both are false positives. Under SANITIZE=thread it warns of Boost.Asio's fences, which that sanitizer does not see; our
# code passes data between threads by atomics alone.
CXXFLAGS = -std=c++17 -O3 -g1 -pthread -fPIC -fvisibility=hidden -Wall -Wextra -Wpedantic -Wshadow -Werror -Wno-stringop-overflow $(ASSERTIONS) -MMD -MP \
  -Ilib -isystem /usr/include/eigen3 $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(PACKAGES))) \
  $(if $(SANITIZE),-O1 $(or $(FLAGS_$(SANITIZE)),$(FLAGS_SANITIZE)) -fno-sanitize-recover=all,$(HARDENED))
# Programs that read foreign files and datagrams abort on a corrupted stack or buffer. Sanitizers check this themselves.
HARDENED := -fstack-protector-strong -fstack-clash-protection -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2
FLAGS_thread := -Wno-maybe-uninitialized -Wno-tsan -fsanitize=thread
# One build serves tests and fuzzing. Warnings come from the build with g++.
FLAGS_SANITIZE := -w -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fsanitize-ignorelist=scripts/sanitize.ignore
LDLIBS = $(shell pkg-config --libs $(PACKAGES)) -pthread -Wl,-z,relro,-z,now
comma := ,

LIB_SOURCES := $(call files,lib/*/*.cpp)
# common to both programs: arguments, help, options of the realtime core, session statistics
SHARED_SOURCES := cli/command.cpp cli/generate.cpp cli/haptic_options.cpp cli/haptic_report.cpp cli/journal.cpp
HAPTIC_SOURCES := cli/tissue_haptic.cpp $(SHARED_SOURCES)
# the page's server; only its folder network uses Boost.Beast, so that its tests do not need that
SERVE_SOURCES := $(call files,cli/serve/*.cpp)
CLI_SOURCES := $(filter-out cli/tissue_haptic.cpp,$(call files,cli/*.cpp)) $(SERVE_SOURCES) $(call files,cli/serve/network/*.cpp)
TEST_SOURCES := $(filter-out tests/bench/% tests/fuzz/fuzz_server.cpp,$(call files,tests/*.cpp tests/*/*.cpp))
BENCH_SOURCES := $(call files,tests/bench/bench_*.cpp)
objects = $(patsubst %.cpp,$(BUILD)/%.o,$(1))

# A folder with programs but without sources, as in some tests, has nothing to build.
ifneq (,$(strip $(LIB_SOURCES)))
# flags that everything was compiled with (with or without ccache), and the source list of each program
FLAGS = $(filter-out ccache,$(CXX)) $(CXXFLAGS) $(LDLIBS)
$(eval $(call says,$(BUILD)/flags,FLAGS))
$(eval $(call says,$(BUILD)/libtissue.list,LIB_SOURCES))
$(eval $(call says,$(BUILD)/tissuectl.list,CLI_SOURCES))
$(eval $(call says,$(BUILD)/tissue-haptic.list,HAPTIC_SOURCES))
$(eval $(call says,$(BUILD)/test_tissue.list,TEST_SOURCES))

# Headers that most files include are precompiled. Not under sanitizers, so that a missing #include in library or
# programs is an error there.
PRECOMPILED := $(if $(SANITIZE),,$(BUILD)/precompiled.h.gch)
$(BUILD)/precompiled.h.gch $(BUILD)/tests/precompiled.h.gch: scripts/precompiled.h $(BUILD)/flags | build/deps
	@mkdir -p $(@D)
	@$(call alone,$@.lock) && cp $< $(@:.gch=) && $(CXX) $(CXXFLAGS) -x c++-header $(@:.gch=) -MF $@.d -o $@.tmp && mv $@.tmp $@

$(BUILD)/%.o: %.cpp $(BUILD)/flags | build/deps $(PRECOMPILED)
	@mkdir -p $(@D)
	@echo "c++   $<"
	@exec 9<$< && flock 9 && $(CXX) $(CXXFLAGS) $(if $(PRECOMPILED),-include $(PRECOMPILED:.gch=)) -MF $(@:.o=.d) -MT $@ -c $< -o $@.tmp && mv $@.tmp $@

$(BUILD)/libtissue.a: $(call objects,$(LIB_SOURCES)) $(BUILD)/libtissue.list
	@$(call alone,$@.lock) && rm -f $@.tmp && ar rcs $@.tmp $(filter %.o,$^) && mv $@.tmp $@

# the library for C; symbols of the C++ library are not exported
$(BUILD)/libtissue.so.1: $(BUILD)/lib/api/tissue.o $(BUILD)/libtissue.a lib/api/tissue.map
	@$(call alone,$@.lock) && $(CXX) $(CXXFLAGS) -s -shared -Wl,-soname,libtissue.so.1 -Wl,--version-script=lib/api/tissue.map -Wl,-z,defs -Wl,--as-needed \
	  $(filter %.o %.a,$^) $(LDLIBS) -lcsv -lcholmod -lgmp -lmpfr -ldl -o $@.tmp && mv $@.tmp $@

# the module for Python (without precompiled headers: with them gcc 12 warns of uninitialised values in Eigen beside
# pybind11)
$(BUILD)/lib/api/python/%.o: private PRECOMPILED :=
$(BUILD)/lib/api/python/%.o: private CXXFLAGS += $(patsubst -I%,-isystem %,$(shell $(PYTHON)-config --includes))
$(PYTHON_MODULE): $(BUILD)/lib/api/python/tissue_module.o $(BUILD)/libtissue.a
	@mkdir -p $(@D)
	@$(call alone,$@.lock) && $(CXX) $(CXXFLAGS) -s -shared -Wl,--as-needed $(filter %.o %.a,$^) $(LDLIBS) -lcsv -lcholmod -lgmp -lmpfr -ldl -o $@.tmp && mv $@.tmp $@

STAGES := shape rim collect import train eval
link = $(call alone,$@.lock) && $(CXX) $(CXXFLAGS) $(1) $(filter %.o %.a,$^) $(LDLIBS) -lcsv -lcholmod -lgmp -lmpfr -ldl -o $@.tmp
$(TISSUECTL): $(call objects,$(CLI_SOURCES)) $(BUILD)/libtissue.a $(BUILD)/tissuectl.list
	@$(call link) && scripts/stage_code $(BUILD) $(STAGES) && mv $@.tmp $@

# stage/COMMAND: a time stamp for the code of a stage, newer only when code that this stage can reach has changed. It is
# written with the program.
$(BUILD)/stage/%: | $(TISSUECTL)
	@scripts/stage_code $(BUILD) $(STAGES)

# The objects keep their symbols; the program for devices is stripped and small.
$(TISSUE_HAPTIC): $(call objects,$(HAPTIC_SOURCES)) $(BUILD)/libtissue.a $(BUILD)/tissue-haptic.list
	@$(call link,-s -Wl$(comma)--as-needed) && mv $@.tmp $@

# Sanitizers check the library. Its tests are linked from the release build, except for files that replace or configure
# the allocator and the page's server (INSTRUMENTED).
INSTRUMENTED := tests/allocations.cpp tests/leaks.cpp $(SERVE_SOURCES)
TEST_OBJECTS := $(call objects,$(TEST_SOURCES) $(SERVE_SOURCES))
ifneq (,$(filter-out thread,$(SANITIZE)))
TEST_OBJECTS := $(call objects,$(INSTRUMENTED)) $(patsubst %.cpp,build/release/%.o,$(filter-out $(INSTRUMENTED),$(TEST_SOURCES)))
endif
# Of a function that several files define inline, the linker takes the first copy. With the library first this is the
# library's: optimised, and instrumented under sanitizers.
$(BUILD)/test_tissue: $(TEST_OBJECTS) $(BUILD)/libtissue.a $(BUILD)/test_tissue.list
	@$(call link,-Wl$(comma)--whole-archive $(BUILD)/libtissue.a -Wl$(comma)--no-whole-archive) && mv $@.tmp $@

# A fuzz target links only what it calls from this archive. --defsym makes its own function the one that libFuzzer
# calls.
FUZZ_READERS := $(patsubst tests/fuzz/fuzz_%.cpp,%,$(call files,tests/fuzz/fuzz_*.cpp))
$(BUILD)/libfuzzed.a: $(call objects,tests/fuzz/edited_store.cpp tests/solid_model_example.cpp tests/haptic/haptic_example.cpp \
  $(SERVE_SOURCES) $(call files,cli/serve/network/*.cpp))
	@$(call alone,$@.lock) && rm -f $@.tmp && ar rcs $@.tmp $^ && mv $@.tmp $@

$(FUZZ_READERS:%=build/sanitize/fuzz_%): build/sanitize/%: build/sanitize/tests/fuzz/%.o $(BUILD)/tests/leaks.o $(BUILD)/libfuzzed.a $(BUILD)/libtissue.a
	@$(call link,-fsanitize=fuzzer -Wl$(comma)--defsym=LLVMFuzzerTestOneInput=$*) && mv $@.tmp $@

PROBES := $(BUILD)/gains_probe $(BUILD)/adapt_probe $(BUILD)/hand_probe
$(PROBES): $(BUILD)/%: $(BUILD)/scripts/%.o $(BUILD)/libtissue.a
	@$(call link) && mv $@.tmp $@

BENCHES := $(BENCH_SOURCES:tests/bench/%.cpp=$(BUILD)/bench/%)
$(BENCHES): $(BUILD)/bench/%: $(BUILD)/tests/bench/%.o $(BUILD)/libtissue.a
	@mkdir -p $(@D)
	@$(call link) && mv $@.tmp $@
endif

# The page is part of the program, and so is the library for its 3-D view.
THREE := /usr/share/javascript/three/three.module.js
$(BUILD)/cli/serve/page.o: $(call files,cli/view/*.html cli/view/*.css cli/view/*.js) $(THREE)
# This code runs rarely (files and command lines once, pages a few times a second) or waits for another program (Haply's
# service), so it is compiled faster with less optimisation.
$(call objects,$(wildcard cli/*.cpp cli/serve/*.cpp cli/serve/network/*.cpp lib/io/*.cpp lib/study/*.cpp lib/cases/*.cpp lib/export/*.cpp \
  lib/eval/report.cpp lib/eval/evaluation_json.cpp lib/haptic/haply_device.cpp)): private CXXFLAGS += -O1
# Test code runs once and is compiled without optimisation, except the ticks of tests/haptic. Fuzzing does not
# instrument it.
ONCE := $(call objects,$(filter-out tests/fuzz/% tests/haptic/%,$(TEST_SOURCES)) $(filter tests/haptic/test_haply_device.cpp,$(TEST_SOURCES)))
$(ONCE): private CXXFLAGS += -O0 -U_FORTIFY_SOURCE
ifneq (,$(PRECOMPILED))
$(ONCE): private PRECOMPILED := $(BUILD)/tests/precompiled.h.gch
$(ONCE): | $(BUILD)/tests/precompiled.h.gch
$(BUILD)/tests/precompiled.h.gch: private CXXFLAGS += -O0 -U_FORTIFY_SOURCE
endif
ifneq (,$(filter-out thread,$(SANITIZE)))
$(call objects,$(filter-out tests/fuzz/%,$(TEST_SOURCES))): private CXXFLAGS += -fno-sanitize=fuzzer-no-link
endif
$(call objects,lib/springs/sparse_factor.cpp): private CXXFLAGS += -isystem /usr/include/suitesparse
# ccache does not detect changes of files that the assembler includes
$(BUILD)/cli/serve/page.o: export CCACHE_DISABLE := 1
$(THREE): | build/deps
	@[ -r $@ ] || { echo "make: there is no $@, of Debian's package libjs-three: the page cannot be built" >&2; exit 1; }

-include $(patsubst %.o,%.d,$(call objects,$(LIB_SOURCES) lib/api/python/tissue_module.cpp $(CLI_SOURCES) $(HAPTIC_SOURCES) $(TEST_SOURCES) tests/fuzz/fuzz_server.cpp $(BENCH_SOURCES) scripts/gains_probe.cpp scripts/adapt_probe.cpp scripts/hand_probe.cpp))

# ---- stages: one rule per kind of file

# The plan lists the load paths with their arguments. Its parts state what each stage depends on and keep their time
# stamp while their text is unchanged. Variables that the plan does not set are empty, whatever the environment has.
SHAPE :=
SHAPE_ARGUMENTS :=
SOLID :=
TRAINED :=
FIRST_TRAINED :=
TRAINED_MADE_OF :=
PATHS :=
FIGURES :=
CASES_COMMAND :=
MESH_ARGUMENTS :=
PATH_ARGUMENTS :=
ifneq (,$(filter-out help clean deps build doors install uninstall doctor reference regress regress-proof trust felupe gains patient patient3 peers test test-fe sanitized sanitize tsan fuzz bench benches $(BUILD)/%,$(or $(MAKECMDGOALS),all)))
include $(R)/plan.mk
endif
# Contacts on a shape are planned on its mesh. The first plan of a shape therefore gives only its source, SHAPE and
# SHAPE_ARGUMENTS, and the dependence of the plan on the mesh.
MESH_OPTION = $(if $(SHAPE),--mesh $(R)/mesh.msh)
figures: $(FIGURES:%=$(R)/figures/%.png)

# A solid block has no mesh of its own: scripts/solve_path makes one for each load path from SOLID, finest at the
# contact.
ifneq (,$(SOLID))
mesh:
	@echo "mesh  none of $(STUDY) itself: every load path of a solid block gets its own, of $(SOLID)"
else
mesh: $(R)/mesh.msh
endif

$(R)/plan.mk: $(STUDIES) $(TISSUECTL)
	@$(TISSUECTL) plan --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $@

$(R)/plan/%:
	@$(TISSUECTL) plan --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $(R)/plan.mk

# Any shape: gmsh fills an outline with triangles, or converts a mesh to format 2.2; then the mesh is checked. The mesh
# keeps its time stamp while it is unchanged, so that a new program does not solve every load path again. mesh.made has
# the time when the mesh was last made. After it make reads the plan again, and with it the mesh's time stamp.
FILLED := $(if $(filter-out %.geo %.msh,$(SHAPE)),fem/fill3.geo)
ifneq (,$(SHAPE))
# The arguments come from the study itself, since the old plan may have another unit or file.
shape_mesh = echo "mesh  $(R)/mesh.msh" && words=$$($(TISSUECTL) shape --study fem/studies/$(STUDY).toml --words) && \
  scripts/mesh $(R)/mesh.msh $$words -- $(TISSUECTL) shape --study fem/studies/$(STUDY).toml
$(R)/plan.mk: $(R)/mesh.made
$(R)/mesh.made: $(wildcard $(SHAPE)) $(R)/plan/shape $(BUILD)/stage/shape scripts/mesh scripts/run_gmsh $(FILLED) | $(TISSUECTL)
	@$(shape_mesh) && scripts/own_file $@ && touch $@

$(R)/mesh.msh: | $(R)/mesh.made  # makes a missing mesh
	@[ -e $@ ] || { $(shape_mesh); }
else
$(R)/mesh.msh $(R)/mesh-fine.msh: fem/block.geo scripts/mesh scripts/run_gmsh
	@echo "mesh  $@"
	@scripts/mesh $@ $< -2 $(MESH_ARGUMENTS)
endif

$(R)/cases/%.csv: $(call files,fem/*.edp fem/*.idp) scripts/solve_path
	@TISSUECTL=$(TISSUECTL) $(RUN) scripts/solve_path $(R) $* $(PATH_ARGUMENTS)

# The plan adds the dependence on the stage, collect or import.
$(R)/cases.h5: $(PATHS:%=$(R)/cases/%.csv) | $(TISSUECTL)
	@$(TISSUECTL) $(CASES_COMMAND) --study fem/studies/$(STUDY).toml $(MESH_OPTION) --out $@

FIRST := $(R)/first
first: $(patsubst %,$(R)/cases/%.csv,$(FIRST_TRAINED)) | $(TISSUECTL)
	@[ -n "$(TRAINED)" ] || { echo "first: study '$(STUDY)' has no load paths to train on" >&2; exit 2; }
	@scripts/folder $(FIRST)
	@newest=$$(ls -td $(TRAINED_MADE_OF) $(call files,fem/*.edp fem/*.idp) scripts/solve_path | head -n 1); solved=; for path in $(TRAINED); do \
	    [ ! $(R)/cases/$$path.csv -nt $(R)/plan/path-$$path ] || [ ! $(R)/cases/$$path.csv -nt "$$newest" ] || solved=$$solved,$$path; \
	  done; echo "first  $$(echo $$solved | tr -cd , | wc -c) of $(words $(TRAINED)) load paths to train on"; \
	  $(TISSUECTL) collect --study fem/studies/$(STUDY).toml $(MESH_OPTION) --paths $(R)/cases --only="$${solved#,}" --out $(FIRST)/cases.h5
	@$(TISSUECTL) train --study fem/studies/$(STUDY).toml --cases $(FIRST)/cases.h5 --out $(FIRST)/model.h5 || [ $$? = 3 ]

$(R)/model.h5: $(R)/cases.h5 $(BUILD)/stage/train | $(TISSUECTL)
	@# 3: something in it did not reach the convergence it promises; its line says what, and so does the report's head
	@$(TISSUECTL) train --study fem/studies/$(STUDY).toml --cases $< --out $@ || [ $$? = 3 ]

$(R)/eval.json $(R)/report.md &: $(R)/model.h5 $(R)/cases.h5 $(BUILD)/stage/eval | $(TISSUECTL)
	@$(TISSUECTL) eval --study fem/studies/$(STUDY).toml --model $< --cases $(R)/cases.h5 --out $(R)/eval.json \
	  --report $(R)/report.md

$(R)/figures/%.png: $(R)/cases.h5 $(R)/model.h5 $(R)/eval.json $(call files,scripts/figures/*.py)
	@scripts/folder $(@D)
	@echo "draw  $@"
	@$(PYTHON) scripts/figures/draw.py $* $(R) $@

$(R)/report.html: $(R)/report.md $(R)/eval.json $(R)/cases.h5 $(R)/model.h5 $(FIGURES:%=$(R)/figures/%.png) \
  scripts/figures/results.py scripts/figures/save.py $(call files,scripts/report/*.py scripts/report/*.html scripts/report/*.css scripts/report/*.js)
	@echo "draw  $@"
	@$(PYTHON) scripts/report/page.py $(R) $@

REFERENCE_STUDIES := paper paper-axial paper-grid8 paper-grid8-turning surface surface-quick surface-sets \
  surface-stress organ organ-lump measured measured-relax block3 block3-quick block3-tools nodule3 organ3 relax nodule-relax block3-relax
## reference: run the 20 studies of REFERENCE_STUDIES anew where they are not finished (hours), then write results/reference and the tables of README and results/RESULTS.md anew
reference:
	@for study in $(REFERENCE_STUDIES); do $(MAKE) all STUDY=$$study || exit 1; done
	@for study in $(filter surface block3,$(REFERENCE_STUDIES)); do $(MAKE) ablation STUDY=$$study || exit 1; done
	@$(PYTHON) scripts/reference.py $(REFERENCE_STUDIES)

## regress: run the study from the start in build/regress; no output if the result equals results/reference/STUDY.json; REGRESS_OPTIONS='--all --finished'
regress: | build/deps
	@scripts/regress $(if $(filter --all,$(REGRESS_OPTIONS)),,--study $(STUDY)) $(REGRESS_OPTIONS)

## trust: draw the displacements up to which FE has a solution, results/reference/trust.png
trust: | build/deps
	@scripts/folder results/trust
	@FF_LOADPATH="$$(scripts/freefem_plugins)" $(PYTHON) scripts/trust_study.py --out results/trust/trust.csv
	@$(PYTHON) scripts/figures/trust.py results/trust/trust.csv results/reference/trust.png

## realtime: indent the 1 kHz simulation at the study's contacts until the force is constant; drawn as figures/motion.png
realtime: $(R)/realtime.json
	@scripts/folder $(R)/figures
	@$(PYTHON) scripts/figures/motion.py $< $(R)/figures/motion.png

$(R)/realtime.json: $(R)/model.h5 $(R)/cases.h5 $(TISSUE_HAPTIC)
	@$(TISSUE_HAPTIC) $< --check $(R)/cases.h5 --out $@ $(REALTIME_OPTIONS)

## ablation: train the study's variants and evaluate them on its test set
ablation: $(R)/cases.h5 $(TISSUECTL)
	@$(TISSUECTL) ablate --study fem/studies/$(STUDY).toml --cases $< --out $(R)/ablation.json
	@scripts/folder $(R)/figures
	@$(PYTHON) scripts/figures/ablation.py $(R)/ablation.json $(R)/figures/ablation.png

FELUPE := tests/fem/felupe_patch.py tests/fem/felupe_solid.py
.PHONY: $(FELUPE:%=%-run)
$(FELUPE:%=%-run): %-run: | build/deps
	@PYTHON=$(PYTHON) scripts/venv
	@FF_LOADPATH="$$(scripts/freefem_plugins)" build/venv/bin/python $*

## felupe: compare contact forces with an independent finite-element program on the same mesh
felupe: $(FELUPE:%=%-run)

## gains: measure gains, iterations and Q as functions of mesh size and displacement: results/reference/gains.md
gains: $(TISSUECTL) $(BUILD)/gains_probe
	@for nodes in 6 11 21 41; do $(MAKE) cases STUDY=lattice-$$nodes || exit 1; done
	@$(PYTHON) scripts/gains_study.py $(BUILD)/gains_probe results/reference/gains

## peers: compare block3-quick with MuJoCo and felupe on the same lattice (results/reference/peers.md), or a solid shape, STUDY=NAME, whose evaluation is finished, with tetrahedra (peers-NAME.md)
peers: doors $(TISSUECTL)
	@PYTHON=$(PYTHON) scripts/venv || echo "peers: goes on without them" >&2
ifeq (file,$(origin STUDY))
	@$(MAKE) train STUDY=block3-quick
	@$(PYTHON) scripts/peers_study.py block3-quick results/reference/peers.md
else
	@$(PYTHON) scripts/peers_organ.py $(STUDY) results/reference/peers-$(STUDY).md
endif

PATIENTS := stiff soft ogden lump layers
## patient: measure the error of a model that adapts to synthetic target tissues: results/reference/patient.md
patient: $(TISSUECTL) $(BUILD)/adapt_probe
	@$(MAKE) train STUDY=surface-quick
	@for patient in $(PATIENTS); do $(MAKE) cases STUDY=patient-$$patient || exit 1; done
	@$(PYTHON) scripts/patient_study.py $(BUILD)/adapt_probe results/reference/patient $(PATIENTS)
	@$(PYTHON) scripts/make_pokes.py results/patient-lump/cases.h5 held_out_full results/patient-lump/pokes.csv --seed 11
	@for n in 5 10 20 40; do $(TISSUECTL) adapt results/surface-quick/model.h5 --data results/patient-lump/pokes.csv --first $$n \
	  --out results/patient-lump/learned-$$n.h5 || exit 1; done
	@$(PYTHON) scripts/figures/learned.py results/reference/patient-map.png $(foreach n,5 10 20 40,results/patient-lump/learned-$n.h5) --truth 42 73 21

## patient3: the same in space: results/reference/patient3.md
patient3: $(TISSUECTL) $(BUILD)/adapt_probe
	@$(MAKE) train STUDY=block3-quick
	@$(MAKE) cases STUDY=nodule3
	@$(PYTHON) scripts/patient_study.py $(BUILD)/adapt_probe results/reference/patient3 stiff3 nodule3

# ---- tests and benches

## test: library, FE and pipeline tests; the last line counts them
test: $(TISSUECTL) $(TISSUE_HAPTIC) doors $(BUILD)/test_tissue | build/deps-test
	@TISSUE_HAPTIC=$(TISSUE_HAPTIC) PYTHON=$(PYTHON) TISSUECTL=$(TISSUECTL) tests/run $(BUILD)/test_tissue $$(env -u OMP_NUM_THREADS nproc)

FE_LONG := tests/fem/test_fem.sh tests/fem/test_solid.sh
.PHONY: $(FE_LONG:%=%-long)
$(FE_LONG:%=%-long): %-long: $(TISSUECTL) | build/deps
	@log=$$(mktemp) && trap 'rm -f "$$log"' EXIT && TISSUECTL=$(TISSUECTL) $* long >"$$log" 2>&1 || { grep -v '^ok' "$$log"; exit 1; }; echo "passed  $* long: $$(tail -n 1 "$$log")"

## test-fe: the long checks of finite elements: memory, mass, refinement, shapes in space
test-fe: $(FE_LONG:%=%-long)

SANITIZED := tissue-haptic tissuectl test_tissue
TESTS :=
## sanitized: build the programs of sanitize and fuzz without running them
sanitized: $(BUILD)/test_tissue | build/deps-sanitize
	@$(MAKE) SANITIZE=1 $(addprefix build/sanitize/,$(SANITIZED) $(FUZZ_READERS:%=fuzz_%))

## sanitize: library tests and the server under address and undefined-behaviour sanitizers; TESTS='~[long]' without the tests that take longest
sanitize: $(BUILD)/test_tissue | build/deps-sanitize
	@$(MAKE) SANITIZE=1 $(SANITIZED:%=build/sanitize/%)
	@TISSUE_HAPTIC=build/sanitize/tissue-haptic tests/parts build/sanitize/test_tissue $$(env -u OMP_NUM_THREADS nproc) '$(TESTS)'
	@TISSUECTL=build/sanitize/tissuectl PYTHON=$(PYTHON) tests/pipeline/test_serve.sh

## tsan: tests of code with threads (loop, recorder, devices, learning, page, parallel work) under the sanitizer for data races
tsan:
	@$(MAKE) SANITIZE=thread build/tsan/test_tissue
	@build/tsan/test_tissue -# '[loop],[recorder],[device],[pointer],[adapt],[serve],[api],[#test_parallel],[#test_indentation_solver],[#test_atomic_file]'

READERS ?= $(FUZZ_READERS)
SECONDS ?= 60
## fuzz: feed the readers of files, datagrams and pages bytes that are chosen by code coverage, SECONDS=60 of the processor each; READERS='study msh' selects some
fuzz: | build/deps-sanitize
	@$(MAKE) SANITIZE=1 $(READERS:%=build/sanitize/fuzz_%)
	@$(PYTHON) scripts/fuzz --seconds $(SECONDS) $(FUZZ_OPTIONS) $(READERS)

## regress-proof: put five defects into a copy, one at a time; regress must fail with each
regress-proof: $(TISSUECTL)
	@PROOF=paper PYTHON=$(PYTHON) TISSUECTL=$(TISSUECTL) tests/pipeline/test_regress.sh

## hands: simulated hands with mass rest on the study's tissue, tap, drag and let go; prints which do not come to rest, gain energy or oscillate
hands: $(R)/model.h5 $(BUILD)/hand_probe
	@$(BUILD)/hand_probe --stated $<

## benches: build the programs of bench, gains, patient and hands without running them
benches: $(BENCHES) $(PROBES)

## bench: measure the speed of tissuectl and of other programs: results/bench.json
bench: $(TISSUECTL) $(TISSUE_HAPTIC) $(BENCHES) | build/deps-test
	@$(MAKE) train STUDY=paper
	@PYTHON=$(PYTHON) scripts/venv || echo "bench: goes on without its peers" >&2
	@TISSUECTL=$(TISSUECTL) $(PYTHON) scripts/bench.py --make $(MAKE) $(BENCH_OPTIONS) $(TISSUE_HAPTIC) \
	  $(BENCHES) tests/bench/bench_serve.py
	@$(PYTHON) tests/bench/test_bench.py
