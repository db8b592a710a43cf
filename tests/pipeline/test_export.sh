#!/bin/sh
# tissuectl export: what VTK, an XML parser, csv and NumPy read back is what the HDF5 files hold; refusals harm nothing.
. "$(dirname "$0")/common"
make_copy
make_tiny results/tiny/model.h5 -j2
check "the study is trained to begin with" exited 0
out=$scratch/out
mkdir "$out"
exported() { "$PYTHON" "$root/tests/pipeline/exported.py" "$@"; }
convert() { tissuectl export "$@"; }

convert results/tiny/cases.h5 --to vtu --out "$out/cases"
check "load paths go to ParaView: exit 0" exited 0
check "VTK reads every record's displacement, force and place as cases.h5 has them" \
    exported cases-vtu "$out/cases" "$R/cases.h5"
others=${TISSUE_READERS:-$root/build/venv/bin/python}  # a Python that has pyvista and meshio, which are on PyPI alone; one that is named must have them
if [ -n "${TISSUE_READERS-}" ] || "$others" -c 'import h5py, meshio, pyvista' 2>/dev/null; then
    check "pyvista steps through the collection, meshio reads each of its files: the same" "$others" "$root/tests/pipeline/exported.py" cases-vtu "$out/cases" "$R/cases.h5" others
else
    skip "pyvista and meshio read the collection" "scripts/venv has not installed them, and TISSUE_READERS names no Python that has them"
fi
convert results/tiny/model.h5 --to vtu --out "$out/model"
check "spring sets go to ParaView: exit 0" exited 0
check "VTK reads the deformed spring mesh: stiffness as in model.h5, contact where it was pushed, in equilibrium" \
    exported model-vtu "$out/model" "$R/model.h5"
convert results/tiny/model.h5 --to sofa --set top-8mm --out "$out/top.scn"
check "a spring set goes to SOFA: exit 0" exited 0
check "it says what SOFA makes of the law" says "law 'isotropic': springs of no length and a constant force"
check "the scene is well-formed XML with the model's nodes, springs, stiffness, fixed nodes and masses" \
    exported sofa "$out/top.scn" "$R/model.h5" top-8mm
convert results/tiny/cases.h5 --to csv --out "$out/cases-csv"
check "load paths as CSV read back to the last bit" exported cases-csv "$out/cases-csv" "$R/cases.h5"
convert results/tiny/model.h5 --to csv --out "$out/model-csv"
check "spring sets as CSV read back to the last bit" exported model-csv "$out/model-csv" "$R/model.h5"
for file in cases model; do
    convert "results/tiny/$file.h5" --to numpy --out "$out/$file-npy"
    check "$file.h5 as NumPy: every dataset, type, shape and value" exported numpy "$out/$file-npy" "$R/$file.h5"
done

# ---- a law, trained on the same cases
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
check "a law is trained on the same cases" exited 0
convert results/tiny/law.h5 --to csv --out "$out/law-csv"
check "a law goes to CSV: exit 0" exited 0
check "its energy, worked out from the tables alone, has the hand's force and leaves nothing over" exported law-csv "$out/law-csv" "$R/law.h5"
convert results/tiny/law.h5 --to numpy --out "$out/law-npy"
check "and from the NumPy arrays alone" exported law-numpy "$out/law-npy" "$R/law.h5" "$out/law-csv"
convert results/tiny/law.h5 --to vtu --out "$out/law"
check "VTK reads the law pressed at its cases, as the tables have it" exported law-vtu "$out/law" "$R/law.h5" "$out/law-csv"
convert results/tiny/law.h5 --to vtu --set top-8mm --out "$out/law-one"
check "--set takes one case of a law" test "$(ls "$out/law-one")" = top-8mm.vtu
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
    check "a law that relaxes goes to $to: exit 0" exited 0
    check "and a line says that its presses are answered at once" says '^tissuectl export: results/tiny/relaxing.h5 relaxes: pushes are answered by its instantaneous constants'
done
mkdir "$R/lost"
cp "$R/cases/"*.csv "$R/lost"
printf 'tissuectl load path,1\nlost,0,folded on the way\n' >"$R/lost/left.csv"
tissuectl collect --study fem/studies/tiny.toml --paths results/tiny/lost --out results/tiny/lost.h5
check "paths of which finite elements lost one are collected" exited 0
convert results/tiny/lost.h5 --to vtu --out "$out/lost"
check "the others go to ParaView: exit 0" exited 0
check "and a line names the one that is left out" says '^tissuectl export: left, left out: finite elements lost it before its first record: folded on the way'
convert results/tiny/lost.h5 --to vtu --path left --out "$out/left"
check "nothing but a lost path: exit 1" exited 1
check "nothing but a lost path: nothing is written" absent "$out/left"

# ---- the same after it has learned from a poke: its contacts are stiffer in places
tissuectl export results/tiny/law.h5 --to csv --set top-8mm --out "$out/top"
"$PYTHON" - "$out/top/presses.csv" >"$work/pokes.csv" <<'PY'
import csv, sys
press, = csv.DictReader(open(sys.argv[1]))
value = lambda name: [float(press[f"{name}_{axis}_{'N' if name == 'force' else 'm'}"]) for axis in "xy"]
print("contact_x [m],contact_y [m],displacement_x [m],displacement_y [m],force_x [N],force_y [N]")
print(",".join(map(repr, [*value("contact"), *value("push"), *(1.3 * f for f in value("force"))])))
PY
tissuectl adapt results/tiny/law.h5 --data pokes.csv --out results/tiny/adapted.h5
check "a law learns from a poke" exited 0
convert results/tiny/adapted.h5 --to csv --out "$out/adapted-csv"
check "it goes to CSV: exit 0" exited 0
check "its contacts are written as they have become" sh -c '! cmp -s "$1" "$2"' - "$out/adapted-csv/surface.csv" "$out/law-csv/surface.csv"
check "its energy, worked out from the tables alone, has the hand's force" exported law-csv "$out/adapted-csv" "$R/adapted.h5"
convert results/tiny/adapted.h5 --to numpy --out "$out/adapted-npy"
check "and from the NumPy arrays alone" exported law-numpy "$out/adapted-npy" "$R/adapted.h5" "$out/adapted-csv"

convert results/tiny/cases.h5 --to vtu --path top --out "$out/one"
check "--path takes one load path" test "$(ls "$out/one" | tr '\n' ' ')" = "top top.pvd "
convert results/tiny/model.h5 --to csv --sets optimum --set left-4mm --out "$out/optimum"
check "--sets and --set take one set" grep -qx 'spring,left-4mm' "$out/optimum/stiffness.csv"
check "--sets changes the numbers" sh -c '! [ "$(cut -d, -f2 "$1")" = "$(cut -d, -f2 "$2")" ]' - \
    "$out/optimum/stiffness.csv" "$out/model-csv/stiffness.csv"
check "the help says unit and default of every option" sh -c '"$1" export --help | grep -q "^  --to  *required  *NAME"' - "$TISSUECTL"

# ---- refusals: one line, and what was there before stays
snapshot "$out" >"$scratch/before"
head -c 3000 "$R/model.h5" >"$work/cut.h5"
refused() { # SENTENCE STATUS WORDS OPTION...
    sentence=$1 wanted=$2 words=$3
    shift 3
    convert "$@"
    check "$sentence: exit $wanted" exited "$wanted"
    check "$sentence: one line says so" one_line "$words"
}
refused "a set that is not there" 1 "^tissuectl: spring set 'top-9mm' is not in the model" results/tiny/model.h5 --to sofa --set top-9mm --out "$out/top.scn"
refused "sets of nobody" 1 "^tissuectl: spring sets 'adam' are not in the model" results/tiny/model.h5 --to csv --sets adam --out "$out/model-csv"
refused "a scene of all sets at once" 1 'name it with --set' results/tiny/model.h5 --to sofa --out "$out/top.scn"
refused "a scene of load cases" 1 'cases.h5: holds load cases; a SOFA scene needs springs' results/tiny/cases.h5 --to sofa --set top-8mm --out "$out/top.scn"
refused "a path that is not there" 1 "there is no load path 'up'" results/tiny/cases.h5 --to vtu --path up --out "$out/cases"
refused "sets of a law" 1 'law.h5: is an energy model, one for all pushes' results/tiny/law.h5 --to csv --sets spsa --out "$out/law-csv"
refused "a case that a law does not have" 1 "load case 'top-9mm' is not in the model" results/tiny/law.h5 --to csv --set top-9mm --out "$out/law-csv"
refused "a scene of a law" 1 'law.h5: is an energy model, and SOFA has no force field that keeps the area' results/tiny/law.h5 --to sofa --set top-8mm --out "$out/top.scn"
refused "a truncated file" 1 '^tissuectl: cut.h5: is not an HDF5 file, or is truncated' cut.h5 --to vtu --out "$out/model"
refused "a folder where a file is wanted" 1 'top.scn: is a file, wanted a folder' results/tiny/model.h5 --to vtu --out "$out/top.scn"
convert results/tiny/model.h5 --to obj --out "$out/model"
check "an unknown format: exit 2" exited 2
check "none of them changed what was there" only_changed "$scratch/before" "$out" ""
check "none of them left a half" no_half_files "$out"
finish
