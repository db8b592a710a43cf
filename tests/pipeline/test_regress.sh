#!/bin/sh
# The regression from cron: silent when nothing moved, a report and exit 1 when something did, and proof that it bites:
# five defects, each put into the copy by itself. PROOF=paper does the proof alone, on the paper study against the
# committed reference (`make regress-proof`).
. "$(dirname "$0")/common"
make_copy
# one defect needs a compiler: sources and objects with their times, so that only what is touched is compiled
cp -pR "$root/lib" "$root/cli" "$work"
build=$(dirname "$TISSUECTL")
cp -pR "$build/lib" "$build/cli" "$build/libtissue.a" "$build/flags" "$build"/*.list "$work/build/release"
mkdir -p "$work/results"
[ "$PYTHON" = /usr/bin/python3 ] || sed -i "1s|.*|#!$PYTHON|" "$work/scripts/regress"
study=${PROOF:-tiny}
reference=$work/results/reference/$study.json history=$work/results/regress.tsv
mkdir -p "$work/results/reference"

# as cron does: from elsewhere, next to no environment (one that names OpenBLAS's kernels would change last bits)
as_cron() { (cd / && exec env -i PATH=/usr/bin:/bin HOME="$HOME" "$work/scripts/regress" --study "$study" "$@") </dev/null; }
regress() {
    as_cron "$@" >"$said" 2>&1
    status=$?
}
last_outcome() { tail -n 1 "$history" | cut -f 4; }
outcome_is() { [ "$(last_outcome)" = "$1" ] || { tail -n 2 "$history"; return 1; }; }
runs() { echo $(($(wc -l <"$history") - 1)); }
few_lines() { [ "$(wc -l <"$said")" -le 22 ] || { cat "$said"; return 1; }; }

# defect SENTENCE PATTERN FILE SED...: the run must turn red and name a value that matches
defect() {
    what=$1 pattern=$2 file=$work/$3
    shift 3
    cp -p "$file" "$scratch/whole"
    sed -i "$@" "$file"
    check "$what: it is in the copy" sh -c '! cmp -s "$0" "$1"' "$file" "$scratch/whole"
    regress
    check "$what: exit 1" exited 1
    check "$what: the report says what moved, from what to what" says "$pattern"
    check "$what: the report is short" few_lines
    cp "$scratch/whole" "$file"
}
proof() {
    defect "C1 off by 1 %" '^    paths/left/contact_force_N/0: [-0-9.e]* -> [-0-9.e]* (allowed ' fem/studies/paper.toml \
        's/^C1_Pa = 263.0/C1_Pa = 265.63/'
    # Newton either needs other counts or does not get there: its residuals are then in the report
    defect "a tangent term's sign flipped" \
        "^    paths/left/newton: [0-9]* -> [0-9]* (exact)\|load path '.*': no equilibrium found .* relative residuals" \
        fem/plane_stress.idp 's/+ (d1112 \* dx(w1) + d1212/+ (-d1112 * dx(w1) + d1212/'
    # of the hash on the reference's type of machine, of the iterations on another
    defect "a seed shifted" '^    trained/spsa/' "fem/studies/$study.toml" 's/^seed = 2008/seed = 2009/'
    defect "two cases swapped" '^    paths/left/' "fem/studies/$study.toml" \
        -e 's/name = "left",/name = "@",/' -e "s/name = \"$mirror\",/name = \"left\",/" \
        -e "s/name = \"@\",/name = \"$mirror\",/"
    defect "one spring dropped" '^    trained/spsa/' lib/mesh/topology.cpp \
        's/^    mesh.springs.resize(/    springs.pop_back();\n&/'
    regress
    check "without them it is silent again" silent
    check "without them it ends with 0" exited 0
}
if [ -n "${PROOF:-}" ]; then
    mirror=right
    cp -p "$root/results/reference/$study.json" "$reference"
    proof
    finish
fi
mirror=top

# ---- the user's results are not its business
mkdir -p "$R"
echo "mine" >"$R/eval.json"
snapshot "$R" >"$scratch/before"

# ---- references
regress
check "a missing reference: exit 1" exited 1
check "a missing reference: one line names it" one_line "^regress: study tiny: .*results/reference/tiny.json: there is no such reference"
check "a missing reference: the history says failed" outcome_is failed
regress --accept
check "--accept without a reference writes one" exited 0
check "--accept without a reference says that there was none" says 'nothing to compare with'
regress
check "nothing moved: exit 0" exited 0
check "nothing moved: silent" silent
check "nothing moved: the history says same" outcome_is same
check "one line of history a run, under a heading" test "$(runs)" = 3
check "each line has as many fields as the heading" sh -c '[ "$(awk -F "\t" "{ print NF }" "$0" | sort -u)" = 8 ]' "$history"

sed 's/"schema": 2/"schema": 1/' "$reference" >"$scratch/older"
regress --reference "$scratch/older"
check "a reference of an older schema: exit 1" exited 1
check "a reference of an older schema: one line says so" one_line 'schema 1, wanted 2'
echo "{" >"$scratch/cut"
regress --reference "$scratch/cut"
check "a reference that is cut off: exit 1 and one line" one_line 'cannot read'

# ---- tolerances: change SED of the reference, then compare the same results with it
against() { # SED...
    sed "$@" "$reference" >"$scratch/changed"
    cmp -s "$reference" "$scratch/changed" && echo "not ok - the test changes nothing: $*" && failures=$((failures + 1))
    regress --reference "$scratch/changed" --history "$scratch/other.tsv"
}
force='s/\("left": .*"contact_force_N": \[0.[0-9]*\)'
against "$force/\1000001/"
check "a force off in its eleventh digit has not moved" exited 0
against -e 's/\("left": .*"contact_force_N": \[0.00[0-9][0-9]\)[0-9]/\1x/' -e 's/\([0-9]\)x\([0-8]\)/\15\2/'
check "a force off in its third digit has moved" exited 1
other='s/"cpu": "[^"]*"/"cpu": "another"/'
hash='s/"theta_hash": "[0-9a-f]*"/"theta_hash": "0000000000000000"/'
against -e "$hash"
check "another hash of theta on the same machine type: exit 1" exited 1
check "another hash of theta: both are shown" says 'trained/spsa/theta_hash: 0000000000000000 -> [0-9a-f]* (exact)'
against -e "$hash" -e "$other"
check "on another machine type hashes are not compared: exit 0" exited 0
check "on another machine type it is silent all the same" silent
sed -e "$hash" -e "$other" "$reference" >"$scratch/changed"
regress --reference "$scratch/changed" --verbose --history "$scratch/other.tsv"
check "--verbose says that hashes were not compared, and why" says '^  cpu: another -> '
against 's/\("left": .*"newton": \)[0-9]*/\11/'
check "another count of Newton iterations on the same machine type: exit 1" says 'paths/left/newton: 1 -> [0-9]* (exact)'

# ---- results that are finished, and all studies that have a record
alone() { (cd / && exec env -i PATH=/usr/bin:/bin HOME="$HOME" "$work/scripts/regress" "$@") </dev/null >"$said" 2>&1; status=$?; }
before=$(runs)
alone --finished --study tiny
check "results that are not finished: exit 1 and one line" one_line 'results/tiny: is not finished'
alone --finished --all
check "no finished results at all: exit 1 and one line" one_line 'none of 1 studies with a record is finished'
cp -p "$work/fem/studies/tiny.toml" "$work/fem/studies/done.toml"
run make PYTHON="$PYTHON" STUDY=done eval -j2
check "a study to compare is finished" exited 0
alone --finished --study done --accept
check "--finished --accept: the record is that of the finished results" exist "$work/results/reference/done.json"
snapshot "$work/results/done" >"$scratch/done"
alone --finished --study done
check "finished results that say what the record says: exit 0" exited 0
check "finished results that say what the record says: silent" silent
alone --finished --all
check "--all --finished: exit 0" exited 0
check "--all --finished says in one line what was not compared" one_line '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny)$'
cp -p "$work/fem/studies/tiny.toml" "$work/fem/studies/bare.toml" && cp -pR "$work/results/done" "$work/results/bare"
alone --finished --all
check "--all --finished names finished results that have no record" one_line '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny); finished, but without a record: bare$'
rm -r "$work/results/bare" "$work/fem/studies/bare.toml"
alone --finished --all --verbose
check "--all --finished: exit 0" exited 0
check "--all --finished counts those that are not finished" says '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny)$'
sed -i 's/\("left": .*"newton": \)[0-9]*/\199/' "$work/results/reference/done.json"
alone --finished --all
check "--all --finished with a record that moved: exit 1" exited 1
check "--all --finished: the value that moved is named" says '^    paths/left/newton: 99 -> [0-9]* (exact)'
check "--all --finished: the last line counts" sh -c 'tail -n 1 "$1" | grep -q "of 2 studies with a record: 1 moved (done), 1 not finished (tiny)"' - "$said"
printf 'based_on = "tiny"\n[geometry]\nshape = "../organs/brought.stl"\n' >"$work/fem/studies/brought.toml" && cp "$work/results/reference/done.json" "$work/results/reference/brought.json"
alone --all
check "--all runs every study with a record anew: exit 1 where one moved" exited 1
check "--all goes on after one that moved, and passes over one whose shape is not there" sh -c \
    'tail -n 1 "$1" | grep -q "of 3 studies with a record: 1 moved (done), 1 same, 1 without the shape (brought)$"' - "$said"
rm "$work/fem/studies/brought.toml" "$work/results/reference/brought.json"
check "--all: a line of history a study, --finished none" test "$(runs)" = $((before + 2))
touch "$work/fem/newton.idp"
alone --finished --study done
check "results older than what they are made of: exit 1 and one line" one_line 'results/done: is older than what it is made of; run make eval STUDY=done'
check "--finished writes nothing beside them" only_changed "$scratch/done" "$work/results/done" ""
rm "$work/fem/studies/done.toml"
alone --all
check "a record whose study is gone: exit 1" exited 1
check "a record whose study is gone: a line names it" says '^regress: study done: there is no .*fem/studies/done.toml'
alone --all --study tiny
check "--all with one study: exit 2" exited 2
alone --all --reference x.json
check "--all with one reference: exit 2" exited 2
rm -rf "$work/results/done" "$work/results/reference/done.json"

# ---- killed, and two at a time
# every FE run takes two seconds more, so that a kill finds one at work
printf '#!/bin/sh\nsleep 2\nexec "$@"\n' >"$scratch/slowly"
chmod +x "$scratch/slowly"
begin() { # sets $killed when FE is at work
    rm -rf "$work/build/regress/tiny"
    RUN=$scratch/slowly setsid "$work/scripts/regress" --study tiny >"$said" 2>&1 </dev/null &
    killed=$!
    wait_for test -e "$work/build/regress/tiny/mesh.msh"
}
before=$(runs)
begin
kill -9 $killed  # alone: what it started works on, and keeps the lock
wait $killed 2>/dev/null
check "after kill -9 what is left keeps the lock" sh -c '! flock -n "$0" true' "$work/build/regress.lock"
regress
check "after kill -9 the next run waits for what is left, and ends with 0" exited 0
check "after kill -9 it is silent" silent
check "a killed run leaves no line, the next leaves one" test "$(runs)" = $((before + 1))
begin
kill -TERM $killed
wait $killed
check "SIGTERM ends it with 1" test $? = 1
check "SIGTERM: the history says interrupted" outcome_is interrupted
check "SIGTERM: nothing it started works on" flock -w 600 "$work/build/regress.lock" true
head -c 100000 "$TISSUECTL" >"$scratch/cut_program"
touch -d '1 second ago' "$work/build/regress.unfinished"
cp "$scratch/cut_program" "$work/build/release/tissuectl"
regress
check "a program that a killed run left half linked is linked anew" exited 0
as_cron >"$scratch/first" 2>&1 &
first=$!
regress
check "two at a time: the one ends with 0" exited 0
wait $first
check "two at a time: so does the other" test $? = 0
check "two at a time: both are silent" sh -c '[ ! -s "$0" ] && [ ! -s "$1" ]' "$said" "$scratch/first"
check "two at a time: two lines of history, no more" test "$(runs)" = $((before + 5))
exec 8>>"$work/build/regress.lock"
flock 8
regress --wait 0
check "--wait 0 beside another run: exit 1 and one line" one_line 'another run is at work'
exec 8>&-

# ---- what cannot be run
cp -p "$work/fem/newton.idp" "$scratch/newton.idp"
echo "no such statement" >>"$work/fem/newton.idp"
regress
check "FE that fails: exit 1" exited 1
check "FE that fails: the end of make's words" says "load path '.*FreeFEM failed"
check "FE that fails: the history says failed" outcome_is failed
cp -p "$scratch/newton.idp" "$work/fem/newton.idp"
study=nowhere regress
check "a study that is not there: exit 2" exited 2
regress --jobs none
check "a bad number: exit 2" exited 2
regress --help
check "--help: exit 0, and units" says '--wait MINUTES .*\|\[min\]'

# ---- it bites
proof

# ---- a change that is meant
sed -i 's/^iterations = 300/iterations = 310/' "$work/fem/studies/tiny.toml"
regress --accept
check "--accept shows the difference" says '^    trained/spsa/theta_hash: '
check "--accept ends with 0" exited 0
check "--accept: the history says accepted" outcome_is accepted
regress
check "after --accept it is silent" silent
check "the user's results were not touched" only_changed "$scratch/before" "$R" ""
check "nothing half-written is left" no_half_files "$work/results"
finish
