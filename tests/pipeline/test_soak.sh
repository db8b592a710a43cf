#!/bin/sh
# scripts/soak for half a minute, on a small solid: two sessions that learn at 1 kHz, with a page open and a hostile client beside them, hold what it judges.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
export TISSUECTL TISSUE_HAPTIC
make_copy
solid_study >"$work/fem/studies/solid.toml"
run make PYTHON="$PYTHON" STUDY=solid train -j2
check "a solid is trained to begin with" exited 0
"$PYTHON" -B "$root/scripts/soak" --minutes 0.4 --model "$work/results/solid/model.h5" --out "$scratch/soak.json" 2>"$scratch/log"
status=$?
check "the file says that all held" "$PYTHON" -c 'import json, sys
report = json.load(open(sys.argv[1]))
assert report["held"] and report["haptic"]["ticks"]["asked"] == 24000 and sys.argv[2] == "0", (report["broken"], open(sys.argv[3]).read())' "$scratch/soak.json" "$status" "$scratch/log"
# it must be able to fail: a recording that has lost a tick
check "--help says how long" sh -c '"$1" "$2" --help | grep -q minutes' - "$PYTHON" "$root/scripts/soak"
finish
