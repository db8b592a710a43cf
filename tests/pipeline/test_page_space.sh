#!/bin/sh
# Alone: its ticks keep real time. The page of `tissuectl serve` with a solid, driven in headless Chromium: tests/serve/test_page_space.py says what is looked at.
. "$(dirname "$0")/common"
make_copy
make_tiny train -j2
check "a model of the plane is trained to begin with" exited 0
solid_study | sed "s/^cells = .*/cells = [6, 6, 3]/" >"$work/fem/studies/solid.toml"   # with a node of the surface in the middle of the top
run make PYTHON="$PYTHON" STUDY=solid eval -j2
check "and one in space, and evaluated" exited 0
"$PYTHON" -B "$root/tests/serve/test_page_space.py" "$TISSUECTL" "$work/results/solid/model.h5" "$R/model.h5" || failures=$((failures + 1))
finish
