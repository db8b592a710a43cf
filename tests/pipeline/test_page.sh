#!/bin/sh
# Alone: its ticks keep real time. The page of `tissuectl serve` in headless Chromium; the checks are in
# tests/serve/test_page.py.
. "$(dirname "$0")/common"
make_copy
sed -i '/name = "left"/a\
  { name = "left-20-down", contact_m = [0.00, 0.05], push = [0.9397, -0.3420] },\
  { name = "left-20-up", contact_m = [0.00, 0.05], push = [0.9397, 0.3420] },' "$work/fem/studies/tiny.toml"
make_tiny train -j2
check "make trains a model" exited 0
printf '\n[springs]\ntopology = "grid8"\nlaw = "axial"\n' >>"$work/fem/studies/tiny.toml"
tissuectl train --study fem/studies/tiny.toml --cases results/tiny/cases.h5 --out results/tiny/grid8.h5
check "a model of grid8 springs is trained" exited 0
"$PYTHON" -B "$root/tests/serve/test_page.py" "$TISSUECTL" "$R/model.h5" "$R/grid8.h5" || failures=$((failures + 1))
"$PYTHON" -B "$root/tests/serve/test_page_words.py" "$TISSUECTL" "$R/model.h5" || failures=$((failures + 1))
finish
