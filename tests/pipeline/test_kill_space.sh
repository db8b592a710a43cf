#!/bin/bash
# As test_kill.sh in space, where every load path has a mesh of its own and training takes longer: TISSUE_KILLS kills
# (3) of TISSUE_KILL_STUDY (default: a small solid block).
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
make_copy
study=${TISSUE_KILL_STUDY:-solid}
[ "$study" != solid ] || solid_study >"$work/fem/studies/solid.toml"
R=$work/results/$study

undisturbed "$study"
kill_make "$study" 1 "${TISSUE_KILLS:-3}"
finish_kills "make all of a solid's study"
