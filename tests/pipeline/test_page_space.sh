#!/bin/sh
# Alone: its ticks keep real time. The page of `tissuectl serve` with a solid in headless Chromium; the checks are in
# tests/serve/test_page_space.py.
. "$(dirname "$0")/common"
make_copy
make_tiny train -j2
check "make trains a model in the plane" exited 0
solid_study | sed "s/^cells = .*/cells = [6, 6, 3]/" >"$work/fem/studies/solid.toml"   # so that a surface node is at the centre of the top
run make PYTHON="$PYTHON" STUDY=solid eval -j2
check "make trains and evaluates a model in space" exited 0
"$PYTHON" -B "$root/tests/serve/test_page_space.py" "$TISSUECTL" "$work/results/solid/model.h5" "$R/model.h5" || failures=$((failures + 1))
finish
