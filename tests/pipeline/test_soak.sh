#!/bin/sh
# Alone: its ticks keep real time. With TISSUE_SOAK set: scripts/soak for half a minute on a small solid. Two sessions
# learn at 1 kHz, with an open page and a hostile client, and satisfy every criterion of scripts/soak.
. "$(dirname "$0")/common"
[ "${TISSUE_SOAK:-}" ] || { skip "two sessions that learn in real time satisfy every criterion" "run with TISSUE_SOAK=1 on idle cores"; finish; }
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
export TISSUECTL TISSUE_HAPTIC
make_copy
solid_study >"$work/fem/studies/solid.toml"
run make PYTHON="$PYTHON" STUDY=solid train -j2
check "make trains a solid" exited 0
"$PYTHON" -B "$root/scripts/soak" --minutes 0.4 --model "$work/results/solid/model.h5" --out "$scratch/soak.json" --keep "$scratch/kept" >"$scratch/log" 2>&1
status=$?
check "the report states that all criteria are satisfied, with 24000 ticks" "$PYTHON" -c 'import json, sys
report = json.load(open(sys.argv[1]))
assert report["held"] and report["haptic"]["ticks"]["asked"] == 24000 and sys.argv[2] == "0", (report["broken"], open(sys.argv[3]).read())' "$scratch/soak.json" "$status" "$scratch/log"

# tests of the criteria, on a recording and session statistics with one fault at a time
cat >"$scratch/wrong.py" <<'PY'
import importlib.machinery, importlib.util, json, shutil, sys, types
import h5py
loader = importlib.machinery.SourceFileLoader("soak", sys.argv[1])
soak = importlib.util.module_from_spec(importlib.util.spec_from_loader("soak", loader))
loader.exec_module(soak)
folder, what = sys.argv[2], sys.argv[3]
shutil.copy(folder + "/haptic.h5", folder + "/wrong.h5")
statistics = json.load(open(folder + "/haptic.json"))
with h5py.File(folder + "/wrong.h5", "r+") as f:
    if what == "a tick later":
        time = f["time"][:]
        time[5000:] += 1e-3
        f["time"][...] = time
    elif what == "a force in the dark":
        force = f["device_force"][:]
        force[(abs(force).sum(1) > 0).argmax() + 50] *= 1.5
        f["device_force"][...] = force
    elif what == "a tick that nobody counted":
        statistics["ticks"] -= 1
    elif what == "energy from nowhere":
        statistics["energy_given_J"] += 1e-6
    elif what == "branches that burn more than there was":
        statistics["details"]["branches"]["dissipated_J"] *= 1e3
session = {"ledger": statistics, "record": folder + "/wrong.h5", "watch": types.SimpleNamespace(policy=None, waited_s=0)}
ticks, recording = soak.judge_ticks(session, 24000)
judged = {"ticks": ticks, "recording": recording, **soak.judge_energy(session)}
print(*(name for name, promise in judged.items() if not promise["held"]))
PY
broken() { # WHAT PROMISE: with this fault that criterion (or more) is not satisfied
    "$PYTHON" -B "$scratch/wrong.py" "$root/scripts/soak" "$scratch/kept" "$1" >"$said" 2>&1
    grep -q -w -- "$2" "$said" || { cat "$said"; return 1; }
}
check "without a fault every criterion is satisfied" sh -c '[ -z "$("$1" -B "$2" "$3" "$4" nothing)" ]' - "$PYTHON" "$scratch/wrong.py" "$root/scripts/soak" "$scratch/kept"
check "an overrun that the session statistics do not contain is detected" broken "a tick later" ticks
check "a tick that the session statistics do not contain is detected" broken "a tick that nobody counted" recording
check "a force that disagrees with the session statistics is detected" broken "a force in the dark" energy_at_the_port
check "energy that disagrees with the recorded motion is detected" broken "energy from nowhere" energy_at_the_port
check "Maxwell branches that dissipate more than the tool's work are detected" broken "branches that burn more than there was" energy_of_the_branches
finish
