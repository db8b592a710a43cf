#!/bin/bash
# The same in space, where every path has a mesh of its own and training takes longer: TISSUE_KILLS times (3), of TISSUE_KILL_STUDY (a small
# solid block of the test's own).
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
make_copy
study=${TISSUE_KILL_STUDY:-solid}
[ "$study" != solid ] || solid_study >"$work/fem/studies/solid.toml"
R=$work/results/$study

undisturbed "$study"
kill_make "$study" 1 "${TISSUE_KILLS:-3}"
finish_kills "make all of a solid's study"
