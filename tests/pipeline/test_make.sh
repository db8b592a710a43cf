#!/bin/sh
# `make all` of a small study: its files, that it runs once, and the stages that an edit runs again.
. "$(dirname "$0")/common"
make_copy
figures="contours force learning springs errors"

# ---- from an empty folder
make_tiny all -j2
check "make all succeeds from an empty folder" exited 0
check "make all writes mesh, load paths with logs, cases, model, evaluation and report" exist "$R/mesh.msh" \
    "$R/cases/left.csv" "$R/cases/left.log" "$R/cases/top.csv" "$R/cases/top.log" "$R/cases.h5" "$R/model.h5" \
    "$R/eval.json" "$R/report.md"
for figure in $figures; do check "make all draws $figure" exist "$R/figures/$figure.png"; done
check "make all leaves no incomplete file" no_half_files "$R"
check "make all compiles no source" test "$(grep -c '^c++' "$said")" = 0
check "the progress counts up to the last load path" says 'cases \[2/2\]'

# ---- a second make
snapshot "$work/results" >"$scratch/before"
make_tiny all -q
check "make all is up to date after make all" exited 0
make_tiny all
check "a second make all prints nothing of any stage" test -z "$(grep -v '^make' "$said")"
check "a second make all writes nothing" only_changed "$scratch/before" "$work/results" ""

# ---- the same results from one job
cp -R "$R" "$scratch/two_jobs"
rm -rf "$R"
make_tiny eval -j1
check "make eval succeeds with one job" exited 0
check "one job and two jobs give the same datasets" same_contents "$R" "$scratch/two_jobs"

# ---- an edit runs only the stages that depend on it
snapshot "$R" >"$scratch/before"
touch "$work/fem/studies/tiny.toml"
make_tiny eval
check "a study with a new time stamp is only planned again" only_changed "$scratch/before" "$R" "plan.mk"

edit 'iterations = 300' 'iterations = 301'
make_tiny eval
check "an edit of the training trains and evaluates again, without FE" only_changed "$scratch/before" "$R" \
    "eval.json model.h5 plan.mk plan/train report.md"

snapshot "$R" >"$scratch/before"
edit 'push = \[1, 0\]' 'push = [1, -0.1]'
make_tiny eval
check "an edit of one direction runs that load path and the later stages again, and no other load path" only_changed "$scratch/before" "$R" \
    "cases.h5 cases/left.csv cases/left.log eval.json model.h5 plan.mk plan/path-left report.md"

snapshot "$R" >"$scratch/before"
edit '^  { name = "top".*' '  { name = "top", contact_m = [0.05, 0.10], push = [0, -1] },\n  { name = "right", contact_m = [0.1, 0.05], push = [-1, 0] },'
make_tiny eval
check "a new load path is solved, and no other" only_changed "$scratch/before" "$R" \
    "cases.h5 cases/right.csv cases/right.log eval.json model.h5 plan.mk plan/collect plan/path-right report.md"

snapshot "$R" >"$scratch/before"
edit '^magnitudes_m = .*' 'magnitudes_m = [0.006, 0.008]'
make_tiny eval
check "another magnitude among the records runs collect, train and eval again, without FE" \
    only_changed "$scratch/before" "$R" "cases.h5 eval.json model.h5 plan.mk plan/collect report.md"

rm "$R/cases/top.csv"
snapshot "$R" >"$scratch/before"
make_tiny cases
check "a deleted load path is solved again, and no other" only_changed "$scratch/before" "$R" "cases.h5 cases/top.csv cases/top.log"

# ---- other studies, and a prefix of commands
snapshot "$R" >"$scratch/before"
make_tiny -n mesh STUDY=paper
check "make -n of another study does not change this study's results" only_changed "$scratch/before" "$R" ""

cat >"$scratch/prefix" <<'SH'
#!/bin/sh
echo x >>"$0.calls"
exec "$@"
SH
chmod +x "$scratch/prefix"
rm -f "$R"/cases/*.csv
make_tiny cases -j2 RUN="$scratch/prefix"
check "RUN= precedes every run of a load path" test "$(wc -l <"$scratch/prefix.calls")" = 3

# ---- help
run make help
check "make help names the stages and STUDY" sh -c 'for word in mesh cases train eval figures test STUDY=NAME; do
    grep -q -- "$word" "$0" || { echo "no $word"; exit 1; }; done' "$said"
check "make help prints a target's whole text" says 'test-fe  *the long checks of finite elements: memory'
finish
