#!/bin/sh
# Bad input gives a non-zero exit status and one line that names file, place and cause. Earlier results are unchanged.
. "$(dirname "$0")/common"
make_copy
make_tiny eval -j2
check "make eval solves the study" exited 0
snapshot "$R" >"$scratch/before"
untouched() { only_changed "$scratch/before" "$R" ""; }
study=fem/studies/tiny.toml
cp "$work/$study" "$scratch/good.toml"

# ---- studies
refused() { # SENTENCE LINE-PATTERN: the current study is refused by the program and by make
    tissuectl plan --study $study --out results/tiny/plan.mk
    check "$1: exit 1" exited 1
    check "$1: one line states the cause" one_line "$2"
    make_tiny eval
    check "$1: make fails too" failed
    check "$1: earlier results are unchanged" untouched
    cp -p "$scratch/good.toml" "$work/$study"
}
accepted() { # SENTENCE: the current study, similar to a refused one, is accepted; planned elsewhere, to keep the results
    tissuectl plan --study $study --out "$scratch/accepted/plan.mk"
    check "$1: accepted" exited 0
    cp -p "$scratch/good.toml" "$work/$study"
}
sed -i 's/^iterations = 300/&\niteratoins = 3/' "$work/$study"
refused "an unknown key" "$study:22: key 'training.iteratoins': is not known; allowed: "
sed -i 's/^iterations = 300/iterations = 3/' "$work/$study"
accepted "a known key"
sed -i 's/^iterations = 300/iterations = = 300/' "$work/$study"
refused "malformed TOML" "$study:21: "
sed -i 's/^iterations = 300/iterations =    300    # = 300/' "$work/$study"
accepted "TOML with blanks and a comment"
printf '\n[geometry]\nthickness_m = -1e-4\n' >>"$work/$study"
refused "a negative thickness" "$study:24: key 'geometry.thickness_m': must be a number > 0"
printf '\n[geometry]\nthickness_m = 1e-4\n' >>"$work/$study"
accepted "a positive thickness"
sed -i '3s/.*/[,lattice]/' "$work/$study"
refused "a table header that triggers an assertion of toml++" "$study:3: is not TOML"
sed -i '3s/.*/[ "lattice" ]/' "$work/$study"
accepted "a table header with blanks and quotes"
edit 'contact_m = \[0.00, 0.05\]' 'contact_m = [0.01, 0.05]'
refused "a contact off the surface" "$study:14: key 'loads.paths\[0\].contact_m': .*not on the free surface"
edit 'contact_m = \[0.00, 0.05\]' 'contact_m = [0.00, 0.075]'
accepted "a contact at another place of the surface"
edit 'also = .*' 'also = "spsa-2008"'
refused "a value of the wrong type" "$study:20: key 'training.also': must be a list of texts"
edit 'also = .*' 'also = []'
accepted "an empty list of texts"
edit '^based_on = .*' 'based_on = "tiny"'
refused "a study based on itself" "key 'based_on': .*without a circle"
edit '^based_on = .*' 'based_on = "nowhere"'
refused "a study based on a missing study" "fem/studies/nowhere.toml"
cp "$work/$study" "$work/fem/studies/base.toml"
edit '^based_on = .*' 'based_on = "base"'
accepted "a study based on a study that is based on a third one"
rm "$work/fem/studies/base.toml"
printf '\n[indenter]\nkind = "patch"\nhalf_width_m = 0.005\n' >>"$work/$study"
edit 'contact_m = \[0.00, 0.05\]' 'contact_m = [0.00, 0.02]'
accepted "a patch farther than 15 mm from the fixed edge"
printf '\n[indenter]\nkind = "patch"\nhalf_width_m = 0.005\n' >>"$work/$study"
edit 'contact_m = \[0.00, 0.05\]' 'contact_m = [0.00, 0.01]'
refused "a patch closer than 15 mm to the fixed edge" "$study:14: key 'loads.paths\[0\].contact_m': .*fixed edge"

run make PYTHON="$PYTHON" STUDY=nowhere eval
check "a missing study: make fails and names it" sh -c '[ "$0" != 0 ] && grep -q fem/studies/nowhere.toml "$1"' \
    "$status" "$said"
check "a missing study: no results folder is made" absent "$work/results/nowhere"

# ---- a mesh without the named boundary
make_tiny eval
snapshot "$R" >"$scratch/before"
cp -p "$R/mesh.msh" "$scratch/mesh.msh"
awk '/^\$Elements/ { inside = 1 } inside && $2 == 1 && $4 == 1 { $4 = 7 } { print }' "$scratch/mesh.msh" >"$R/mesh.msh"
make_tiny results/tiny/cases/left.csv
check "a mesh without the fixed boundary: the load path fails" failed
check "a mesh without the fixed boundary: one line states the cause" one_line "load path 'left'.*bottom"
head -c $(($(wc -c <"$scratch/mesh.msh") / 2)) "$scratch/mesh.msh" >"$R/mesh.msh"
make_tiny results/tiny/cases/left.csv
check "a truncated mesh: the load path fails" failed
check "a truncated mesh: one line names load path and log" one_line "load path 'left'.*left.log"
cp -p "$scratch/mesh.msh" "$R/mesh.msh"
check "a bad mesh changes no result but the log" sh -c '[ "$1" = cases/left.log ] || [ "$1" = "cases/left.log mesh.msh" ]' \
    - "$(changed "$scratch/before" "$R")"

# ---- load paths
collect() { tissuectl collect --study $study --paths results/tiny/cases --out results/tiny/cases.h5; }
bad_csv() { # SENTENCE LINE-PATTERN: the current left.csv is refused
    snapshot "$R" >"$scratch/before"
    collect
    check "$1: exit 1" exited 1
    check "$1: one line names the place" one_line "$2"
    check "$1: cases.h5 is unchanged" untouched
    cp -p "$scratch/left.csv" "$R/cases/left.csv"
}
cp -p "$R/cases/left.csv" "$scratch/left.csv"
good_csv() { # SENTENCE: the current left.csv is accepted
    tissuectl collect --study $study --paths results/tiny/cases --out "$scratch/accepted.h5"
    check "$1: accepted" exited 0
    cp -p "$scratch/left.csv" "$R/cases/left.csv"
}
head -c 4000 "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a truncated load path" 'results/tiny/cases/left.csv:[0-9]*: '
sed '$d' "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a load path without its end row" 'left.csv:[0-9]*: .*truncated'
sed '40s/[^,]*$/nan/' "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a load path with a NaN" "left.csv:40: field 7 is 'nan'"
sed '40s/[^,]*$/1.25E-4/' "$scratch/left.csv" >"$R/cases/left.csv"
good_csv "a load path with another number in that field"
sed 's/$/\r/' "$scratch/left.csv" >"$R/cases/left.csv"
good_csv "a load path with CR LF line ends"
sed '40d' "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a load path with a missing row" 'left.csv:[0-9]*: .*24 of 25 nodes'
sed '1s/1$/3/' "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a load path of a later version" 'left.csv:1: .*version'
sed '1s/1$/2/' "$scratch/left.csv" >"$R/cases/left.csv"
bad_csv "a load path of two discs in place of one" 'left.csv:1: has two discs, and the path has one'
: >"$R/cases/left.csv"
bad_csv "an empty load path" 'left.csv:'
rm "$R/cases/left.csv"
bad_csv "a missing load path" 'left.csv: cannot read: No such file'

# ---- HDF5
snapshot "$R" >"$scratch/before"
bad_h5() { # SENTENCE FILE LINE-PATTERN: the file is refused as cases by train and eval, and as a model by eval
    tissuectl train --study $study --cases "$2" --out results/tiny/model.h5
    check "$1, as cases to train: exit 1" sh -c '[ "$0" = 1 ]' "$status"
    check "$1, as cases to train: one line states the cause" one_line "$3"
    tissuectl eval --study $study --model results/tiny/model.h5 --cases "$2" --out results/tiny/eval.json
    check "$1, as cases to evaluate: exit 1" exited 1
    check "$1, as cases to evaluate: one line states the cause" one_line "$3"
    tissuectl eval --study $study --model "$2" --cases results/tiny/cases.h5 --out results/tiny/eval.json
    check "$1, as a model: exit 1" exited 1
    check "$1, as a model: one line names the file" one_line "${2##*/}: "
    check "$1: earlier results are unchanged" untouched
}
head -c 20000 "$R/cases.h5" >"$work/cut.h5"
bad_h5 "a truncated HDF5 file" cut.h5 "tissuectl: cut.h5: .*truncated"
"$PYTHON" -c "import h5py, sys; h5py.File(sys.argv[1], 'w')['x'] = 1" "$work/foreign.h5"
bad_h5 "a foreign HDF5 file" foreign.h5 "tissuectl: foreign.h5: .*not written by tissuectl"
cp "$R/cases.h5" "$work/future.h5"
tissuectl info future.h5
check "an HDF5 file of the current version: accepted" exited 0
"$PYTHON" -c "import h5py, sys; h5py.File(sys.argv[1], 'r+').attrs['format_version'] = 99.0" "$work/future.h5"
bad_h5 "an HDF5 file of a future version" future.h5 "tissuectl: future.h5: .*version 99 is later"
echo "not HDF5" >"$work/text.h5"
bad_h5 "a file that is not HDF5" text.h5 "tissuectl: text.h5: is not an HDF5 file"
# ---- invalid datasets of a model, read by every program that reads models
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}") || exit 1
bad_model() { # SENTENCE LINE-PATTERN PYTHON: the model h is refused after this change
    cp "$R/model.h5" "$work/bad.h5"
    "$PYTHON" -c "import h5py, sys
def put(name, value):
    words = dict(h[name].attrs)
    del h[name]
    h[name] = value
    h[name].attrs.update(words)
h = h5py.File(sys.argv[1], 'r+'); $3" "$work/bad.h5"
    run "$TISSUE_HAPTIC" bad.h5 --seconds 0.1 --no-realtime
    check "$1, played: exit 1" exited 1
    check "$1, played: one line names the dataset" one_line "tissue-haptic: bad.h5: $2"
    for reader in "eval --study $study --model bad.h5 --cases results/tiny/cases.h5 --out results/tiny/eval.json" \
        "serve bad.h5 --port 0" "export bad.h5 --to vtu --out bad" "export bad.h5 --to csv --out bad"; do
        run timeout 60 build/release/tissuectl $reader
        check "$1, ${reader%% *}: exit 1" exited 1
        check "$1, ${reader%% *}: one line names the dataset" one_line "tissuectl: bad.h5: $2"
    done
    tissuectl info bad.h5
    check "$1: info still lists the content of the file" exited 0
}
good_model() { # SENTENCE PYTHON: the model h is accepted after this change
    cp "$R/model.h5" "$work/bad.h5"
    "$PYTHON" -c "import h5py, sys
h = h5py.File(sys.argv[1], 'r+'); $2" "$work/bad.h5"
    run "$TISSUE_HAPTIC" bad.h5 --seconds 0.1 --no-realtime
    check "$1, played: accepted" exited 0
    tissuectl export bad.h5 --to numpy --out "$scratch/numpy"
    check "$1, exported: accepted" exited 0
}
good_model "one_set of the right size, compressed by gzip" "
values, words = h['one_set'][:], dict(h['one_set'].attrs)
del h['one_set']
h.create_dataset('one_set', data=values, chunks=True, compression='gzip', shuffle=True).attrs.update(words)"
good_model "another stiffness" "h['trained/spsa/theta'][0, 1] *= 1.5"
bad_model "one_set compressed by lzf" "/one_set: is compressed by a filter other than gzip" "
values, words = h['one_set'][:], dict(h['one_set'].attrs)
del h['one_set']
h.create_dataset('one_set', data=values, chunks=True, compression='lzf').attrs.update(words)"
bad_model "one_set of a wrong size" "/one_set: is 3, must be S = " "put('one_set', [1., 2., 3.])"
bad_model "contacts of one column" "/cases/contact: is 4 x 1, must be C = 4 x D = 2" "put('cases/contact', h['cases/contact'][:, :1])"
bad_model "a spring with NaN as a node" "/mesh/springs: value 0 is nan" "put('mesh/springs', h['mesh/springs'][:] * 1.); h['mesh/springs'][0, 0] = float('nan')"
bad_model "a spring from a node to itself" "/mesh/springs: row 5 names " "h['mesh/springs'][5] = [h['mesh/springs'][5, 0]] * 2"
bad_model "a NaN stiffness" "/trained/spsa/theta: value 1 is nan" "h['trained/spsa/theta'][0, 1] = float('nan')"
bad_model "a clockwise boundary" "/mesh/boundary: is clockwise" "put('mesh/boundary', h['mesh/boundary'][:][::-1])"
check "bad models do not change earlier results" untouched

for file in cut foreign future text; do
    tissuectl info $file.h5
    check "info refuses $file.h5 with exit 1" exited 1
done
tissuectl eval --study $study --model results/tiny/cases.h5 --cases results/tiny/cases.h5 --out results/tiny/eval.json
check "cases given as a model: one line names the wanted kind" one_line "has kind 'cases', must have kind 'model'"
tissuectl eval --study fem/studies/paper.toml --model results/tiny/model.h5 --cases results/tiny/cases.h5 --out results/tiny/eval.json
check "a model of another study: one line names both" one_line "'tiny', not 'paper'"
tissuectl train --study fem/studies/paper.toml --cases results/tiny/cases.h5 --out results/tiny/model.h5
check "cases of another lattice: one line names both" one_line "25 nodes.*11 x 11"
check "files of other kinds do not change earlier results" untouched
finish
