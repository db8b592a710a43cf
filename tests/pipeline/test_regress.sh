#!/bin/sh
# The regression check as cron runs it: no output if nothing changed, else a report and exit status 1. Five defects,
# each put into the copy alone, must be detected. PROOF=paper runs the defects alone, on study paper against the
# committed reference (`make regress-proof`).
. "$(dirname "$0")/common"
make_copy
# One defect needs a compiler: sources and objects are copied with their times, so only changed files are compiled.
cp -pR "$root/lib" "$root/cli" "$work"
build=$(dirname "$TISSUECTL")
cp -pR "$build/lib" "$build/cli" "$build/libtissue.a" "$build/flags" "$build"/*.list "$work/build/release"
mkdir -p "$work/results"
[ "$PYTHON" = /usr/bin/python3 ] || sed -i "1s|.*|#!$PYTHON|" "$work/scripts/regress"
study=${PROOF:-tiny}
reference=$work/results/reference/$study.json history=$work/results/regress.tsv
mkdir -p "$work/results/reference"

# As cron: from another folder, with almost no environment (a variable that selects OpenBLAS kernels would change the
# last bits).
as_cron() { (cd / && exec env -i PATH=/usr/bin:/bin HOME="$HOME" "$work/scripts/regress" --study "$study" "$@") </dev/null; }
regress() {
    as_cron "$@" >"$said" 2>&1
    status=$?
}
last_outcome() { tail -n 1 "$history" | cut -f 4; }
outcome_is() { [ "$(last_outcome)" = "$1" ] || { tail -n 2 "$history"; return 1; }; }
runs() { echo $(($(wc -l <"$history") - 1)); }
few_lines() { [ "$(wc -l <"$said")" -le 22 ] || { cat "$said"; return 1; }; }

# defect SENTENCE PATTERN FILE SED...: regress must fail and report a value that matches
defect() {
    what=$1 pattern=$2 file=$work/$3
    shift 3
    cp -p "$file" "$scratch/whole"
    sed -i "$@" "$file"
    check "$what: the defect is in the copy" sh -c '! cmp -s "$0" "$1"' "$file" "$scratch/whole"
    regress
    check "$what: exit 1" exited 1
    check "$what: the report names the value, with its old and new number" says "$pattern"
    check "$what: the report has at most 22 lines" few_lines
    cp "$scratch/whole" "$file"
}
proof() {
    defect "C1 off by 1 %" '^    paths/left/contact_force_N/0: [-0-9.e]* -> [-0-9.e]* (allowed ' fem/studies/paper.toml \
        's/^C1_Pa = 263.0/C1_Pa = 265.63/'
    # Newton's method needs another number of iterations, or fails; the report then contains its residuals.
    defect "a tangent term's sign flipped" \
        "^    paths/left/newton: [0-9]* -> [0-9]* (exact)\|load path '.*': no equilibrium found .* relative residuals" \
        fem/plane_stress.idp 's/+ (d1112 \* dx(w1) + d1212/+ (-d1112 * dx(w1) + d1212/'
    # detected by the hash on the reference's type of machine, by the iterations on another
    defect "a seed shifted" '^    trained/spsa/' "fem/studies/$study.toml" 's/^seed = 2008/seed = 2009/'
    defect "two cases swapped" '^    paths/left/' "fem/studies/$study.toml" \
        -e 's/name = "left",/name = "@",/' -e "s/name = \"$mirror\",/name = \"left\",/" \
        -e "s/name = \"@\",/name = \"$mirror\",/"
    defect "one spring dropped" '^    trained/spsa/' lib/mesh/topology.cpp \
        's/^    mesh.springs.resize(/    springs.pop_back();\n&/'
    regress
    check "without defects regress prints nothing" silent
    check "without defects: exit 0" exited 0
}
if [ -n "${PROOF:-}" ]; then
    mirror=right
    cp -p "$root/results/reference/$study.json" "$reference"
    proof
    finish
fi
mirror=top

# ---- the user's results must not change
mkdir -p "$R"
echo "mine" >"$R/eval.json"
snapshot "$R" >"$scratch/before"

# ---- references
regress
check "a missing reference: exit 1" exited 1
check "a missing reference: one line names it" one_line "^regress: study tiny: .*results/reference/tiny.json: there is no such reference"
check "a missing reference: the history records failed" outcome_is failed
regress --accept
check "--accept without a reference writes one" exited 0
check "--accept without a reference prints that there is nothing to compare with" says 'nothing to compare with'
regress
check "nothing changed: exit 0" exited 0
check "nothing changed: no output" silent
check "nothing changed: the history records same" outcome_is same
check "the history has a heading and one line per run" test "$(runs)" = 3
check "each line of the history has 8 fields" sh -c '[ "$(awk -F "\t" "{ print NF }" "$0" | sort -u)" = 8 ]' "$history"

sed 's/"schema": 2/"schema": 1/' "$reference" >"$scratch/older"
regress --reference "$scratch/older"
check "a reference of an older schema: exit 1" exited 1
check "a reference of an older schema: one line names both schemas" one_line 'schema 1, wanted 2'
echo "{" >"$scratch/cut"
regress --reference "$scratch/cut"
check "a truncated reference: one line states the cause" one_line 'cannot read'

# ---- tolerances: change SED of the reference, then compare the same results with it
against() { # SED...: runs regress against a changed reference
    sed "$@" "$reference" >"$scratch/changed"
    cmp -s "$reference" "$scratch/changed" && echo "not ok - the test changes nothing: $*" && failures=$((failures + 1))
    regress --reference "$scratch/changed" --history "$scratch/other.tsv"
}
force='s/\("left": .*"contact_force_N": \[0.[0-9]*\)'
against "$force/\1000001/"
check "a force that differs in its eleventh digit is within tolerance" exited 0
against -e 's/\("left": .*"contact_force_N": \[0.00[0-9][0-9]\)[0-9]/\1x/' -e 's/\([0-9]\)x\([0-8]\)/\15\2/'
check "a force that differs in its third digit is reported: exit 1" exited 1
other='s/"cpu": "[^"]*"/"cpu": "another"/'
hash='s/"theta_hash": "[0-9a-f]*"/"theta_hash": "0000000000000000"/'
against -e "$hash"
check "another hash of theta on the same machine type: exit 1" exited 1
check "another hash of theta: both hashes are printed" says 'trained/spsa/theta_hash: 0000000000000000 -> [0-9a-f]* (exact)'
against -e "$hash" -e "$other"
check "on another machine type hashes are not compared: exit 0" exited 0
check "on another machine type: no output" silent
sed -e "$hash" -e "$other" "$reference" >"$scratch/changed"
regress --reference "$scratch/changed" --verbose --history "$scratch/other.tsv"
check "--verbose prints the other machine type" says '^  cpu: another -> '
against 's/\("left": .*"newton": \)[0-9]*/\11/'
check "another number of Newton iterations on the same machine type is reported" says 'paths/left/newton: 1 -> [0-9]* (exact)'

# ---- finished results, and all studies with a record
alone() { (cd / && exec env -i PATH=/usr/bin:/bin HOME="$HOME" "$work/scripts/regress" "$@") </dev/null >"$said" 2>&1; status=$?; }
before=$(runs)
alone --finished --study tiny
check "unfinished results: one line names them" one_line 'results/tiny: is not finished'
alone --finished --all
check "no finished results: one line states the cause" one_line 'none of 1 studies with a record is finished'
cp -p "$work/fem/studies/tiny.toml" "$work/fem/studies/done.toml"
run make PYTHON="$PYTHON" STUDY=done eval -j2
check "make eval finishes a study to compare" exited 0
alone --finished --study done --accept
check "--finished --accept writes a record of the finished results" exist "$work/results/reference/done.json"
snapshot "$work/results/done" >"$scratch/done"
alone --finished --study done
check "finished results equal to the record: exit 0" exited 0
check "finished results equal to the record: no output" silent
alone --finished --all
check "--all --finished: exit 0" exited 0
check "--all --finished: one line counts what was not compared" one_line '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny)$'
cp -p "$work/fem/studies/tiny.toml" "$work/fem/studies/bare.toml" && cp -pR "$work/results/done" "$work/results/bare"
alone --finished --all
check "--all --finished: one line names finished results without a record" one_line '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny); finished, but without a record: bare$'
rm -r "$work/results/bare" "$work/fem/studies/bare.toml"
alone --finished --all --verbose
check "--all --finished: exit 0" exited 0
check "--all --finished --verbose counts unfinished studies" says '^regress: of 2 studies with a record: 1 same, 1 not finished (tiny)$'
sed -i 's/\("left": .*"newton": \)[0-9]*/\199/' "$work/results/reference/done.json"
alone --finished --all
check "--all --finished with a changed record: exit 1" exited 1
check "--all --finished with a changed record: the changed value is named" says '^    paths/left/newton: 99 -> [0-9]* (exact)'
check "--all --finished with a changed record: the last line counts the studies" sh -c 'tail -n 1 "$1" | grep -q "of 2 studies with a record: 1 moved (done), 1 not finished (tiny)"' - "$said"
printf 'based_on = "tiny"\n[geometry]\nshape = "../organs/brought.stl"\n' >"$work/fem/studies/brought.toml" && cp "$work/results/reference/done.json" "$work/results/reference/brought.json"
alone --all
check "--all runs every study with a record: exit 1 if one changed" exited 1
check "--all continues after a changed study, and skips one without its shape" sh -c \
    'tail -n 1 "$1" | grep -q "of 3 studies with a record: 1 moved (done), 1 same, 1 without the shape (brought)$"' - "$said"
rm "$work/fem/studies/brought.toml" "$work/results/reference/brought.json"
check "--all adds one line of history per study, --finished none" test "$(runs)" = $((before + 2))
touch "$work/fem/newton.idp"
alone --finished --study done
check "finished results older than their sources: one line states the cause" one_line 'results/done: is older than its inputs; run make eval STUDY=done'
check "--finished changes no file of the results" only_changed "$scratch/done" "$work/results/done" ""
rm "$work/fem/studies/done.toml"
alone --all
check "a record without its study: exit 1" exited 1
check "a record without its study: a line names it" says '^regress: study done: there is no .*fem/studies/done.toml'
alone --all --study tiny
check "--all with one study: exit 2" exited 2
alone --all --reference x.json
check "--all with one reference: exit 2" exited 2
rm -rf "$work/results/done" "$work/results/reference/done.json"

# ---- killed runs, and two simultaneous runs
# Every FE run takes two seconds more, so that a kill hits a running one.
printf '#!/bin/sh\nsleep 2\nexec "$@"\n' >"$scratch/slowly"
chmod +x "$scratch/slowly"
begin() { # starts regress, waits until FE runs, and sets $killed
    rm -rf "$work/build/regress/tiny"
    RUN=$scratch/slowly setsid "$work/scripts/regress" --study tiny >"$said" 2>&1 </dev/null &
    killed=$!
    wait_for test -e "$work/build/regress/tiny/mesh.msh"
}
before=$(runs)
begin
kill -9 $killed  # regress alone: its child processes continue and keep the lock
wait $killed 2>/dev/null
check "after kill -9 the child processes keep the lock" sh -c '! flock -n "$0" true' "$work/build/regress.lock"
regress
check "after kill -9 the next run waits for the child processes: exit 0" exited 0
check "after kill -9 the next run prints nothing" silent
check "a killed run adds no line to the history, the next run one" test "$(runs)" = $((before + 1))
begin
kill -TERM $killed
wait $killed
check "SIGTERM: exit 1" test $? = 1
check "SIGTERM: the history records interrupted" outcome_is interrupted
check "SIGTERM: the lock is released within 600 s" flock -w 600 "$work/build/regress.lock" true
head -c 100000 "$TISSUECTL" >"$scratch/cut_program"
touch -d '1 second ago' "$work/build/regress.unfinished"
cp "$scratch/cut_program" "$work/build/release/tissuectl"
regress
check "a truncated program of a killed run is linked again" exited 0
as_cron >"$scratch/first" 2>&1 &
first=$!
regress
check "two simultaneous runs: the second ends with 0" exited 0
wait $first
check "two simultaneous runs: the first ends with 0" test $? = 0
check "two simultaneous runs: no output" sh -c '[ ! -s "$0" ] && [ ! -s "$1" ]' "$said" "$scratch/first"
check "two simultaneous runs add two lines to the history" test "$(runs)" = $((before + 5))
exec 8>>"$work/build/regress.lock"
flock 8
regress --wait 0
check "--wait 0 during another run: one line states the cause" one_line 'another run was active for'
exec 8>&-

# ---- runs that fail
cp -p "$work/fem/newton.idp" "$scratch/newton.idp"
echo "no such statement" >>"$work/fem/newton.idp"
regress
check "failing FE: exit 1" exited 1
check "failing FE: the end of make's output is printed" says "load path '.*FreeFEM failed"
check "failing FE: the history records failed" outcome_is failed
cp -p "$scratch/newton.idp" "$work/fem/newton.idp"
study=nowhere regress
check "a missing study: exit 2" exited 2
regress --jobs none
check "a word as --jobs: exit 2" exited 2
regress --help
check "--help prints --wait with its unit" says '--wait MINUTES .*\|\[min\]'

# ---- the defects are detected
proof

# ---- an intended change
sed -i 's/^iterations = 300/iterations = 310/' "$work/fem/studies/tiny.toml"
regress --accept
check "--accept prints the difference" says '^    trained/spsa/theta_hash: '
check "--accept: exit 0" exited 0
check "--accept: the history records accepted" outcome_is accepted
regress
check "after --accept regress prints nothing" silent
check "the user's results are unchanged" only_changed "$scratch/before" "$R" ""
check "no incomplete file is left" no_half_files "$work/results"
finish
