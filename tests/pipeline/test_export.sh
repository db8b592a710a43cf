#!/bin/sh
# tissuectl export: VTK, an XML parser, csv and NumPy read back the content of the HDF5 files; refusals change no file.
. "$(dirname "$0")/common"
make_copy
make_tiny results/tiny/model.h5 -j2
check "make trains the study" exited 0
out=$scratch/out
mkdir "$out"
convert() { tissuectl export "$@"; }

convert results/tiny/cases.h5 --to vtu --out "$out/cases"
check "export of load paths to vtu: exit 0" exited 0
check "VTK reads the displacements, forces and positions of every record in cases.h5" \
    exported cases-vtu "$out/cases" "$R/cases.h5"
others=${TISSUE_READERS:-$root/build/venv/bin/python}  # a Python with pyvista and meshio (PyPI); one that is named must have them
if [ -n "${TISSUE_READERS-}" ] || "$others" -c 'import h5py, meshio, pyvista' 2>/dev/null; then
    check "pyvista steps through the collection and meshio reads its files, with the values of cases.h5" "$others" "$root/tests/pipeline/exported.py" cases-vtu "$out/cases" "$R/cases.h5" others
else
    skip "pyvista and meshio read the collection" "scripts/venv has not installed them, and TISSUE_READERS names no Python with them"
fi
convert results/tiny/model.h5 --to vtu --out "$out/model"
check "export of spring sets to vtu: exit 0" exited 0
check "VTK reads the deformed spring mesh: stiffnesses of model.h5, prescribed contact displacement, equilibrium" \
    exported model-vtu "$out/model" "$R/model.h5"
convert results/tiny/model.h5 --to sofa --set top-8mm --out "$out/top.scn"
check "export of a spring set to SOFA: exit 0" exited 0
check "export to SOFA prints how the spring law is represented" says "spring law 'isotropic': exact in SOFA, by springs of zero length and a constant force"
check "the SOFA scene is well-formed XML with the model's nodes, springs, stiffnesses, fixed nodes and masses" \
    exported sofa "$out/top.scn" "$R/model.h5" top-8mm
convert results/tiny/cases.h5 --to csv --out "$out/cases-csv"
check "load paths exported as CSV are identical when read back" exported cases-csv "$out/cases-csv" "$R/cases.h5"
convert results/tiny/model.h5 --to csv --out "$out/model-csv"
check "spring sets exported as CSV are identical when read back" exported model-csv "$out/model-csv" "$R/model.h5"
for file in cases model; do
    convert "results/tiny/$file.h5" --to numpy --out "$out/$file-npy"
    check "$file.h5 exported as NumPy has every dataset with its type, shape and values" exported numpy "$out/$file-npy" "$R/$file.h5"
done

# ---- an energy model, trained on the same cases
cat >"$work/fem/studies/law.toml" <<'TOML'
based_on = "tiny"

[material]
formulation = "plane-strain"     # so that it has regions

[springs]
topology = "grid8"
stiffness = "law"
terms = ["spring.all", "contact.normal", "contact.tangent.phase", "contact.rotation.corner", "contact.stretch.edge"]
TOML
tissuectl train --study fem/studies/law.toml --cases results/tiny/cases.h5 --out results/tiny/law.h5
check "train of an energy model on the same cases: exit 0" exited 0
convert results/tiny/law.h5 --to csv --out "$out/law-csv"
check "export of an energy model to CSV: exit 0" exited 0
check "the energy computed from the CSV tables gives the tool's force and equilibrium" exported law-csv "$out/law-csv" "$R/law.h5"
convert results/tiny/law.h5 --to numpy --out "$out/law-npy"
check "the energy computed from the NumPy arrays gives the tool's force and equilibrium" exported law-numpy "$out/law-npy" "$R/law.h5" "$out/law-csv"
convert results/tiny/law.h5 --to vtu --out "$out/law"
check "VTK reads the energy model's equilibrium at each case, as in the tables" exported law-vtu "$out/law" "$R/law.h5" "$out/law-csv"
convert results/tiny/law.h5 --to vtu --set top-8mm --out "$out/law-one"
check "--set exports one case of an energy model" test "$(ls "$out/law-one")" = top-8mm.vtu
"$PYTHON" - "$R/law.h5" "$R/relaxing.h5" <<'PY'
import shutil, sys
import h5py, numpy as np
shutil.copy(*sys.argv[1:])
with h5py.File(sys.argv[2], "r+") as f:
    f["law/relaxation_time"], f["law/contact_share"] = np.ones(1), np.full(1, 0.5)
    f["law/share"] = np.full((len(f["law/constants"]), 1), 0.5)
    for name, unit in (("relaxation_time", "s"), ("share", "1"), ("contact_share", "1")):
        f["law"][name].attrs["unit"] = np.bytes_(unit)
PY
for to in csv vtu; do
    convert results/tiny/relaxing.h5 --to $to --out "$out/relaxing-$to"
    check "export of a relaxing energy model to $to: exit 0" exited 0
    check "export of a relaxing energy model to $to: a line states that the instantaneous constants are used" says '^tissuectl export: results/tiny/relaxing.h5 relaxes: it is exported with its instantaneous constants'
done
mkdir "$R/lost"
cp "$R/cases/"*.csv "$R/lost"
printf 'tissuectl load path,1\nlost,0,folded on the way\n' >"$R/lost/left.csv"
tissuectl collect --study fem/studies/tiny.toml --paths results/tiny/lost --out results/tiny/lost.h5
check "collect accepts a load path that ended before its first record" exited 0
convert results/tiny/lost.h5 --to vtu --out "$out/lost"
check "export of the other load paths to vtu: exit 0" exited 0
check "export of the other load paths to vtu: a line names the omitted path" says '^tissuectl export: left, left out: no FE reference at its first record: folded on the way'
convert results/tiny/lost.h5 --to vtu --path left --out "$out/left"
check "export of a load path without records: exit 1" exited 1
check "export of a load path without records: nothing is written" absent "$out/left"

# ---- the same energy model after it has learned from one measurement, with contact stiffness that varies in place
tissuectl export results/tiny/law.h5 --to csv --set top-8mm --out "$out/top"
"$PYTHON" - "$out/top/presses.csv" >"$work/pokes.csv" <<'PY'
import csv, sys
press, = csv.DictReader(open(sys.argv[1]))
value = lambda name: [float(press[f"{name}_{axis}_{'N' if name == 'force' else 'm'}"]) for axis in "xy"]
print("contact_x [m],contact_y [m],displacement_x [m],displacement_y [m],force_x [N],force_y [N]")
print(",".join(map(repr, [*value("contact"), *value("push"), *(1.3 * f for f in value("force"))])))
PY
tissuectl adapt results/tiny/law.h5 --data pokes.csv --out results/tiny/adapted.h5
check "adapt of the energy model to one measurement: exit 0" exited 0
convert results/tiny/adapted.h5 --to csv --out "$out/adapted-csv"
check "export of the adapted model to CSV: exit 0" exited 0
check "the exported contact stiffness of the adapted model differs from the trained one" sh -c '! cmp -s "$1" "$2"' - "$out/adapted-csv/surface.csv" "$out/law-csv/surface.csv"
check "the energy of the adapted model computed from the CSV tables gives the tool's force and equilibrium" exported law-csv "$out/adapted-csv" "$R/adapted.h5"
convert results/tiny/adapted.h5 --to numpy --out "$out/adapted-npy"
check "the energy of the adapted model computed from the NumPy arrays gives the tool's force and equilibrium" exported law-numpy "$out/adapted-npy" "$R/adapted.h5" "$out/adapted-csv"

convert results/tiny/cases.h5 --to vtu --path top --out "$out/one"
check "--path exports one load path" test "$(ls "$out/one" | tr '\n' ' ')" = "top top.pvd "
convert results/tiny/model.h5 --to csv --sets optimum --set left-4mm --out "$out/optimum"
check "--sets and --set export one set" grep -qx 'spring,left-4mm' "$out/optimum/stiffness.csv"
check "--sets changes the exported stiffness" sh -c '! [ "$(cut -d, -f2 "$1")" = "$(cut -d, -f2 "$2")" ]' - \
    "$out/optimum/stiffness.csv" "$out/model-csv/stiffness.csv"
check "export --help prints --to as required, with its type" sh -c '"$1" export --help | grep -q "^  --to  *required  *NAME"' - "$TISSUECTL"

# ---- refusals: one line, and earlier exports are unchanged
snapshot "$out" >"$scratch/before"
head -c 3000 "$R/model.h5" >"$work/cut.h5"
refused() { # SENTENCE STATUS WORDS OPTION...
    sentence=$1 wanted=$2 words=$3
    shift 3
    convert "$@"
    check "$sentence: exit $wanted" exited "$wanted"
    check "$sentence: one line states the cause" one_line "$words"
}
refused "an unknown spring set" 1 "^tissuectl: spring set 'top-9mm' is not in the model" results/tiny/model.h5 --to sofa --set top-9mm --out "$out/top.scn"
refused "spring sets of an unknown optimiser" 1 "^tissuectl: spring sets 'adam' are not in the model" results/tiny/model.h5 --to csv --sets adam --out "$out/model-csv"
refused "a SOFA scene of all sets at once" 1 'name it with --set' results/tiny/model.h5 --to sofa --out "$out/top.scn"
refused "a SOFA scene of load cases" 1 'cases.h5: has load cases; a SOFA scene needs the springs' results/tiny/cases.h5 --to sofa --set top-8mm --out "$out/top.scn"
refused "an unknown load path" 1 "has no load path 'up'" results/tiny/cases.h5 --to vtu --path up --out "$out/cases"
refused "spring sets of an energy model" 1 'law.h5: is an energy model; --sets chooses among spring sets' results/tiny/law.h5 --to csv --sets spsa --out "$out/law-csv"
refused "an unknown case of an energy model" 1 "load case 'top-9mm' is not in the model" results/tiny/law.h5 --to csv --set top-9mm --out "$out/law-csv"
refused "a SOFA scene of an energy model" 1 'law.h5: is an energy model, and SOFA has no force field that keeps the area' results/tiny/law.h5 --to sofa --set top-8mm --out "$out/top.scn"
refused "a truncated file" 1 '^tissuectl: cut.h5: is not an HDF5 file, or is truncated' cut.h5 --to vtu --out "$out/model"
refused "a file in place of the output folder" 1 'top.scn: is a file; give a folder' results/tiny/model.h5 --to vtu --out "$out/top.scn"
convert results/tiny/model.h5 --to obj --out "$out/model"
check "an unknown format: exit 2" exited 2
check "refused exports change no earlier file" only_changed "$scratch/before" "$out" ""
check "refused exports leave no incomplete file" no_half_files "$out"
finish
