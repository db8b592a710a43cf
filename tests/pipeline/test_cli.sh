#!/bin/sh
# The command line: help, version, exit status 0 / 1 / 2 / 3, and commands run from another folder.
. "$(dirname "$0")/common"
make_copy
make_tiny cases -j2
check "make cases solves the study" exited 0
program=$work/build/release/tissuectl
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")

# ---- help and version
tissuectl --version
check "--version: exit 0" exited 0
check "--version prints the program's name and a version" says '^tissuectl [0-9]*\.[0-9]*\.[0-9]*$'
tissuectl --help
check "--help: exit 0" exited 0
for command in new plan collect import train eval serve info export doctor; do
    tissuectl --help
    check "--help names $command" says "^ *$command "
    tissuectl $command --help
    check "$command --help: exit 0" exited 0
    check "$command --help prints a table of option, default, unit and meaning" says 'option  *default  *unit  *meaning'
done
tissuectl train --help
check "train --help: --threads has a number as default" says '--threads  *[0-9][0-9]*  *threads.*spring sets trained at a time'
check "train --help: --study is a required file" says '--study  *required  *FILE  *study file'
for option in seed optimizer iterations json; do check "train --help has --$option" says "--$option "; done

for command in new plan shape rim collect import train eval ablate adapt serve info export doctor; do
    tissuectl $command --help
    check "$command --help: the unit column contains only units, and options no underscore" sh -c '! grep -q "^  --[a-z-]*_\|:FLOAT\|:INT\|:{\| in \[" "$1"' - "$said"
done
# cli/README.md: options and help texts are in SI units; mm, cm and inch are values of --unit
si_alone() {
    sed 's/: mm, cm, m or inch//' "$said" | grep -nE '(^|[^A-Za-z0-9])[0-9.]*(mm|cm|um|km|ms|us|ns|mN|kN|kPa|MPa|cN)([^A-Za-z0-9]|$)|%' && return 1
    grep -qi options "$said"
}
for command in "" $(tissuectl --help && sed -n 's/^  \([a-z][a-z]*\)  *[A-Z].*/\1/p' "$said"); do
    # shellcheck disable=SC2086  # none, or one
    tissuectl $command --help
    check "tissuectl $command --help: all units are SI" si_alone
done
run "$TISSUE_HAPTIC" --help
check "tissue-haptic --help: all units are SI" si_alone
for documented in "$TISSUECTL" "$TISSUE_HAPTIC"; do
    run "$documented" --generate man
    check "${documented##*/} --generate man: all units are SI" si_alone
done
tissuectl adapt --help
check "adapt --help: the meaning of --place-error states its range" says '--place-error  *0  *m  *standard deviation.*, 0 to 0.05'

run "$TISSUECTL" --generate options
check "lib/api/OPTIONS.md is the output of tissuectl --generate options" cmp "$said" "$root/lib/api/OPTIONS.md"
check "lib/api/OPTIONS.md: all units are SI" si_alone

# ---- exit status 2: a wrong command line
usage() { # SENTENCE ARGUMENT...
    sentence_of_usage=$1
    shift
    tissuectl "$@"
    check "$sentence_of_usage: exit 2" exited 2
}
usage "no command"
usage "an unknown command" fly
check "an unknown command: one line names it" one_line "^tissuectl: 'fly' is not a command"
usage "an unknown option" train --speed 3
usage "a required option missing" train --study fem/studies/tiny.toml
usage "a number of threads that is a word" train --study s --cases c --out m --threads many
usage "zero threads" train --study s --cases c --out m --threads 0
usage "zero iterations" train --study s --cases c --out m --iterations 0
usage "an extra argument" info a.h5 b.h5
usage "NaN seconds" serve model.h5 --seconds nan
check "NaN seconds: a line states the cause" says '--seconds: nan is not a number'
for words in "adapt model.h5 --data d --out o --noise" "adapt model.h5 --data d --out o --model-error" "adapt model.h5 --data d --out o --place-error" "adapt model.h5 --data d --out o --next-depth" \
    "new x --shape s.stl --size" "new x --shape s.stl --thickness" "new x --shape s.stl --bed" "surface s.stl --repair o.stl --closes" "surface s.stl --repair o.stl --offset"; do
    # shellcheck disable=SC2086  # words
    usage "$words nan" $words nan
    check "$words nan: a line states the cause" says "${words##* }: nan is not a "
done
usage "an infinite size" new x --shape s.stl --size inf
check "an infinite size: a line states the cause" says '--size: inf is not a finite number above 0'
run "$TISSUE_HAPTIC" model.h5 --seconds NaN
check "NaN seconds: exit 2 of tissue-haptic" exited 2
# values that session options refuse: see test_doors.sh
for wrong in 1e300 inf; do
    usage "serve --seconds $wrong" serve model.h5 --seconds $wrong
    run "$TISSUE_HAPTIC" model.h5 --seconds $wrong
    check "tissue-haptic --seconds $wrong: exit 2" exited 2
done

# ---- exit status 1: the command failed
mkdir "$scratch/without"
cat >"$scratch/without/sitecustomize.py" <<'PY'
import os, sys
class Without:
    def find_spec(self, name, path=None, target=None):
        if name in os.environ.get("WITHOUT", "matplotlib jinja2").split():
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)
sys.meta_path.insert(0, Without())
PY
run env PYTHONPATH="$scratch/without" "$PYTHON" scripts/figures/draw.py force results/tiny "$scratch/force.png"
check "no matplotlib: exit 1" exited 1
check "no matplotlib: one line names the package" one_line '^draw.py: .*; install python3-matplotlib'
for script in figures/contacts.py figures/motion.py figures/ablation.py figures/learned.py figures/trust.py gains_study.py patient_study.py; do
    run env PYTHONPATH="$scratch/without" "$PYTHON" scripts/$script
    check "no matplotlib for $script: exit 1" exited 1
    check "no matplotlib for $script: one line names the package" one_line "^${script##*/}: .*; install python3-matplotlib"
done
run env PYTHONPATH="$scratch/without" WITHOUT=h5py "$PYTHON" scripts/figures/learned.py
check "no h5py: one line names the package" one_line '^learned.py: .*; install python3-h5py'
run env PYTHONPATH="$scratch/without" "$PYTHON" scripts/report/page.py results/tiny "$scratch/report.html"
check "no jinja2: one line names the package" one_line '^page.py: .*; install python3-jinja2'
"$PYTHON" - "$R/cases.h5" "$scratch/held" <<'PY' &
import h5py, os, shutil, sys, time
shutil.copy(sys.argv[1], sys.argv[2] + ".h5")
with h5py.File(sys.argv[2] + ".h5", "a"):
    open(sys.argv[2], "w").close()
    while os.path.exists(sys.argv[2]):
        time.sleep(0.05)
PY
while [ ! -e "$scratch/held" ]; do sleep 0.05; done
tissuectl info "$scratch/held.h5"
check "a file that another program has open for writing: exit 1" exited 1
check "a file that another program has open for writing: one line names the lock" one_line 'held.h5: is open for writing in another program: close it there'
rm "$scratch/held"
wait
run sh -c '"$1" info "$2" >/dev/full' - "$TISSUECTL" results/tiny/cases.h5
check "standard output on a full disk: exit 1" exited 1
check "standard output on a full disk: one line states the cause" one_line '^tissuectl: standard output: cannot write'
for asked in --help --version "--generate man"; do
    # shellcheck disable=SC2086  # words of their own
    run sh -c '"$@" >/dev/full' - "$TISSUECTL" $asked
    check "$asked on a full disk: exit 1" exited 1
    check "$asked on a full disk: one line states the cause" one_line "^tissuectl: standard output: cannot write"
done
tissuectl info results/tiny/none.h5
check "a missing file: exit 1" exited 1
check "a missing file: one line names it" one_line '^tissuectl: results/tiny/none.h5: there is no such file'
tissuectl train --study fem/studies/tiny.toml --cases results/tiny/cases.h5 --out nowhere/model.h5 --iterations 1
check "a missing output folder: exit 1" exited 1
check "a missing output folder: one line names the file" one_line '^tissuectl: nowhere/model.h5: cannot write'
tissuectl train --study fem/studies/tiny.toml --cases results/tiny/cases.h5 --out "$scratch/m.h5" --optimizer adam
check "an unknown optimiser: exit 1" exited 1
check "an unknown optimiser: one line lists the known ones" one_line "'adam' is not known; allowed: .*spsa-2008"
check "an unknown optimiser: no model is written" absent "$scratch/m.h5" "$scratch/m.h5.tmp"

tissuectl ablate --study fem/studies/tiny.toml --cases results/tiny/cases.h5 --out "$scratch/ablation.json" --role held-out
check "an ablation of contacts without load paths: exit 1" exited 1
check "an ablation of contacts without load paths: one line lists the drawn contacts, before any training" \
    one_line "^tissuectl: results/tiny/cases.h5: has no drawn contacts of role 'held-out'; its roles: none$"
run "$root/scripts/mutate" --under lib/spring
check "mutate of a missing folder: exit 1" exited 1
check "mutate of a missing folder: one line states the cause, and nothing is built" one_line "^mutate: lib/spring: there is no code to change"

# ---- scripts: options, and failures of the programs that they start
for script in reference remote_device; do
    run "$PYTHON" scripts/$script.py --help
    check "$script.py --help: exit 0" exited 0
    check "$script.py --help describes the script" says "$script.py .*STUDY\|$script.py .*port"
    run "$PYTHON" scripts/$script.py --chek
    check "$script.py with an unknown option: exit 2" exited 2
done
run "$PYTHON" scripts/patient_study.py false "$scratch/patient" stiff
check "patient_study.py with a failing probe: exit 1" exited 1
check "patient_study.py with a failing probe: one line names it" one_line "^patient_study.py: false --model .*: exit status 1$"
mkdir "$scratch/fake"
printf '#!/bin/sh\necho "out of order" >&2\nexit 3\n' >"$scratch/fake/FreeFem++-nw"
chmod +x "$scratch/fake/FreeFem++-nw"
run env PATH="$scratch/fake:$PATH" "$PYTHON" scripts/trust_study.py --out "$scratch/trust.csv" --end-sizes-mm 5
check "trust_study.py with a failing FreeFEM: exit 1" exited 1
check "trust_study.py with a failing FreeFEM: one line states the cause" one_line "^trust_study.py: FreeFem++-nw: no record, exit status 3: out of order$"
check "trust_study.py with a failing FreeFEM: no table is left" absent "$scratch"/trust.csv*

# ---- commands run from another folder
mkdir "$scratch/elsewhere"
cp "$work/fem/studies/tiny.toml" "$work/fem/studies/paper.toml" "$R/cases.h5" "$scratch/elsewhere"
there() { (cd "$scratch/elsewhere" && "$program" "$@") >"$scratch/out" 2>"$said"; status=$?; }
there train --study tiny.toml --cases cases.h5 --out model.h5 --threads 3
check "train in another folder: exit 0" exited 0
check "train prints the options in use" says '^tissuectl train: study=tiny.toml cases=cases.h5 out=model.h5 threads=3'
check "train prints nothing on standard output" test ! -s "$scratch/out"
there eval --study tiny.toml --model model.h5 --cases cases.h5 --out eval.json --json
check "eval in another folder: exit 0" exited 0
check "eval --json prints the same as it writes to the file" cmp "$scratch/out" "$scratch/elsewhere/eval.json"
there info model.h5
check "info in another folder: exit 0" exited 0
check "info prints kind, study, format and seed" grep -q "model.h5: model of study 'tiny', format 1, tissuectl .*, seed 2008" \
    "$scratch/out"
check "info lists datasets with shape, unit and meaning" grep -q '/trained/spsa/theta  *4 x 40  *N/m  *trained spring sets' "$scratch/out"

# ---- exit status 3: the model is written, but training did not converge
cp "$scratch/elsewhere/tiny.toml" "$scratch/elsewhere/floppy.toml"
printf 'objective = "contact"\n\n[springs]\ntopology = "grid4"\nlaw = "axial"\n' >>"$scratch/elsewhere/floppy.toml"
there train --study floppy.toml --cases cases.h5 --out floppy.h5
check "objective contact on a mesh with zero-energy modes: exit 3" exited 3
check "objective contact on a mesh with zero-energy modes: one line gives the number of sets" one_line 'floppy.h5 is written, but .*objective contact: of 4 sets 4 floppy'
check "objective contact on a mesh with zero-energy modes: the model is written" exist "$scratch/elsewhere/floppy.h5"
there eval --study floppy.toml --model floppy.h5 --cases cases.h5 --out floppy.json --report floppy.md
check "objective contact on a mesh with zero-energy modes: the first 10 lines of the report contain it" sh -c 'sed 10q "$1" | grep -q "of 4 sets 4 floppy"' - "$scratch/elsewhere/floppy.md"

# ---- options change only what they are for
model() { # NAME OPTION...
    name=$1
    shift
    there train --study tiny.toml --cases cases.h5 --out "$name.h5" "$@"
}
compare() { # EXPRESSION of the files a and b (a.h5, b.h5)
    "$PYTHON" -c "
import h5py, numpy, sys
a, b = h5py.File(sys.argv[1]), h5py.File(sys.argv[2])
theta = lambda f: f['trained'][f['optimizers'][0].decode()]['theta'][:]
sys.exit(0 if $1 else 1)" "$scratch/elsewhere/a.h5" "$scratch/elsewhere/b.h5"
}
model a --threads 1
model b --threads 2
check "--threads changes no stiffness" compare "theta(a).tobytes() == theta(b).tobytes()"
model b --seed 7
check "--seed changes the node weights and is stored" compare "(a['cases/node_weight'][:] != b['cases/node_weight'][:]).any() and b.attrs['seed'] == 7"
model b --optimizer spsa-2008
check "--optimizer replaces the study's optimiser" compare "b['optimizers'][0] == b'spsa-2008' and len(b['optimizers']) == 1"
model b --iterations 5
check "--iterations replaces the study's number of iterations" compare "(b['trained/spsa-2008/iterations'][:] == 5).all()"
check "a missing answer of the gains study counts as infinite, and is printed as none" "$PYTHON" -c "
import sys
sys.path.insert(0, '$root/scripts')
from gains.page import percent
from gains.rules import q_ratios
row = lambda felt: {'near': 1, 'far': 1, 'resolved': 0.1, 'rel_loss': 0.2, 'closed_loop': felt}
last = lambda *felt: q_ratios({'weights-grid4-11': [row(f) for f in felt]}, 'grid4', 11, 1, 1)[0][2]
assert last(0.1, None, 0.3) == 0.3 and percent(last(0.1, None)) == 'none', last(0.1, None)"
model b --json
check "train --json prints a list with the loss and status of each set" "$PYTHON" -c "
import json, sys
sets = json.load(open(sys.argv[1]))
sys.exit(0 if len(sets) == 8 and all({'set', 'loss_N', 'status'} <= s.keys() for s in sets) else str(sets))" "$scratch/out"
there train --study "$scratch/elsewhere/tiny.toml" --cases "$scratch/elsewhere/cases.h5" --out "$scratch/elsewhere/b.h5"
check "train writes no absolute path into the model" sh -c '! grep -q "$1" "$2"' - "$scratch" "$scratch/elsewhere/b.h5"
check "the model contains its command and the hash of its cases" compare \
    "b.attrs['command'].startswith(b'tissuectl train --study tiny.toml') and len(b.attrs['input:cases.h5']) == 32"
there eval --study tiny.toml --model b.h5 --cases cases.h5 --out eval.json
check "every dataset has units and a description" "$PYTHON" -c "
import h5py, sys
missing = []
for name in sys.argv[1:]:
    h5py.File(name).visititems(lambda n, o: missing.append(n) if isinstance(o, h5py.Dataset) and not (
        o.attrs.get('units') and o.attrs.get('description')) else None)
sys.exit(str(missing) if missing else 0)" "$scratch/elsewhere/cases.h5" "$scratch/elsewhere/b.h5"
model b --seed 7
there eval --study tiny.toml --model b.h5 --cases cases.h5 --out eval.json
check "eval.json contains the seed of the model's training" grep -q '"seed": 7' "$scratch/elsewhere/eval.json"
finish
