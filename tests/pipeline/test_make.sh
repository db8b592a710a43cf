#!/bin/sh
# `make all` of a small study: what it leaves, that it runs once, and what an edit runs again.
. "$(dirname "$0")/common"
make_copy
figures="contours force learning springs errors"

# ---- from nothing
make_tiny all -j2
check "make all succeeds from nothing" exited 0
check "it leaves mesh, load paths with logs, cases, model, evaluation and report" exist "$R/mesh.msh" \
    "$R/cases/left.csv" "$R/cases/left.log" "$R/cases/top.csv" "$R/cases/top.log" "$R/cases.h5" "$R/model.h5" \
    "$R/eval.json" "$R/report.md"
for figure in $figures; do check "it draws $figure" exist "$R/figures/$figure.png"; done
check "it leaves no half-written file" no_half_files "$R"
check "it compiles nothing that is compiled" test "$(grep -c '^c++' "$said")" = 0
check "progress counts the load paths to the last" says 'cases \[2/2\]'

# ---- once more
snapshot "$work/results" >"$scratch/before"
make_tiny all -q
check "a second make all has nothing to do" exited 0
make_tiny all
check "a second make all says nothing of any stage" test -z "$(grep -v '^make' "$said")"
check "a second make all writes nothing" only_changed "$scratch/before" "$work/results" ""

# ---- the same numbers from one job
cp -R "$R" "$scratch/two_jobs"
rm -rf "$R"
make_tiny eval -j1
check "make eval succeeds with one job" exited 0
check "one job and two give the same contents of every dataset" same_contents "$R" "$scratch/two_jobs"

# ---- an edit runs what depends on it and no more
snapshot "$R" >"$scratch/before"
touch "$work/fem/studies/tiny.toml"
make_tiny eval
check "a study touched but not changed is planned again and nothing else" only_changed "$scratch/before" "$R" "plan.mk"

edit 'iterations = 300' 'iterations = 301'
make_tiny eval
check "editing the training trains and evaluates again, without FE" only_changed "$scratch/before" "$R" \
    "eval.json model.h5 plan.mk plan/train report.md"

snapshot "$R" >"$scratch/before"
edit 'push = \[1, 0\]' 'push = [1, -0.1]'
make_tiny eval
check "editing one push solves that path and the later stages again, no other path" only_changed "$scratch/before" "$R" \
    "cases.h5 cases/left.csv cases/left.log eval.json model.h5 plan.mk plan/path-left report.md"

snapshot "$R" >"$scratch/before"
edit '^  { name = "top".*' '  { name = "top", contact_m = [0.05, 0.10], push = [0, -1] },\n  { name = "right", contact_m = [0.1, 0.05], push = [-1, 0] },'
make_tiny eval
check "a new load path is solved alone" only_changed "$scratch/before" "$R" \
    "cases.h5 cases/right.csv cases/right.log eval.json model.h5 plan.mk plan/collect plan/path-right report.md"

snapshot "$R" >"$scratch/before"
edit '^magnitudes_m = .*' 'magnitudes_m = [0.006, 0.008]'
make_tiny eval
check "another magnitude among the records is collected, trained and evaluated, without FE" \
    only_changed "$scratch/before" "$R" "cases.h5 eval.json model.h5 plan.mk plan/collect report.md"

rm "$R/cases/top.csv"
snapshot "$R" >"$scratch/before"
make_tiny cases
check "a lost load path is solved again alone" only_changed "$scratch/before" "$R" "cases.h5 cases/top.csv cases/top.log"

# ---- other studies, and a prefix
snapshot "$R" >"$scratch/before"
make_tiny -n mesh STUDY=paper
check "another study does not touch this one's results" only_changed "$scratch/before" "$R" ""

cat >"$scratch/prefix" <<'SH'
#!/bin/sh
echo x >>"$0.calls"
exec "$@"
SH
chmod +x "$scratch/prefix"
rm -f "$R"/cases/*.csv
make_tiny cases -j2 RUN="$scratch/prefix"
check "RUN= goes before every FreeFEM run" test "$(wc -l <"$scratch/prefix.calls")" = 3

# ---- help
run make help
check "make help names the stages and STUDY" sh -c 'for word in mesh cases train eval figures test STUDY=NAME; do
    grep -q -- "$word" "$0" || { echo "no $word"; exit 1; }; done' "$said"
check "make help says a target's text to its end" says 'test-fe  *the long checks of finite elements: memory'
finish
