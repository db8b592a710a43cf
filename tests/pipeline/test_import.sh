#!/bin/sh
# Measured contact forces through make: data -> cases -> springs -> train -> eval, the stages that an edit runs again,
# and refusals.
. "$(dirname "$0")/common"
make_copy
data=$work/fem/data/tiny.csv

# A synthetic tissue with 50 N/m along the normal and 30 N/m across it at every contact, with 1 % of noise.
"$PYTHON" >"$data" <<'PY'
import random
random.seed(8)
print("# NOT A MEASUREMENT: made up by tests/pipeline/test_import.sh")
print("contact_x [mm],contact_y [m],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [N],push")
push = 0
for i in range(24):
    x, y, n = [(100, 20 + 10 * i, (-1, 0)), (100 - 10 * (i - 8), 100, (0, -1)), (0, 100 - 10 * (i - 16), (1, 0))][i // 8]
    for across in (-3, 3):
        push += 1
        for _ in range(2):
            u = [5 * n[0] - across * n[1], 5 * n[1] + across * n[0]]
            f = [50 * 5 * n[0] - 30 * across * n[1], 50 * 5 * n[1] + 30 * across * n[0]]
            f = [v + 2.5 * random.gauss(0, 1) for v in f]
            print(f"{x},{y / 1e3},{u[0]},{u[1]},{f[0]:.3f},{f[1] / 1e3:.6f},{push}")
PY
sed -e 's/^cells = .*/cells = [4, 4]/' -e 's/block_measured/tiny/' -e 's/^thickness_m = .*/thickness_m = 0.005/' \
    "$root/fem/studies/measured.toml" >"$work/fem/studies/tiny.toml"

# ---- from the CSV to the report
make_tiny all -j2
check "make all succeeds from a CSV" exited 0
check "make all writes cases, model, evaluation, report and figures" exist "$R/cases.h5" "$R/model.h5" "$R/eval.json" \
    "$R/report.md" "$R/figures/held_out.png"
check "figures and report.html are drawn without answers of the model" "$PYTHON" "$root/tests/pipeline/without_answers.py" "$R"
check "no mesh is made and no load path is solved" absent "$R/mesh.msh" "$R/cases"
check "import prints rows, contacts and split" says 'import .*tiny.csv: 96 rows at 24 contacts: .* 20 test rows'
check "the noise estimated from repeats is 0.6 % to 1.2 %, with 1 % applied" "$PYTHON" -c 'import json, sys
m = json.load(open(sys.argv[1]))["measurement"]
assert m["noise_source"] == "repeats" and 0.006 < m["force_noise"] < 0.012, m' "$R/eval.json"
check "the report contains the origin of the data" grep -q 'NOT A MEASUREMENT: made up by' "$R/report.md"
check "the report states the model's training data and the scaling of the heuristic" \
    grep -q 'parameters from .* measured paths.*fitted to the forces' "$R/report.md"
rivals() { # FILE MODEL...: each has 20 test rows, and the learned model a smaller error than one uniform stiffness
    "$PYTHON" -c 'import json, sys
held_out = json.load(open(sys.argv[1]))["closed_loop"]["held_out"]
for model in sys.argv[2:]:
    assert held_out[model]["n"] == 20, (model, held_out[model])
assert held_out["learned"]["median"] < held_out["uniform"]["median"], held_out' "$@"
}
check "every baseline is evaluated on the test set, and the learned model is better than uniform stiffness" rivals "$R/eval.json" learned force_table heuristic_a heuristic_b uniform repeat

# ---- exports contain measured quantities only
tissuectl export results/tiny/cases.h5 --to csv --out "$scratch/csv"
check "export of measured forces to CSV: exit 0" exited 0
check "fields of quantities that were not measured are empty: energy, supports, J" "$PYTHON" -c 'import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
assert rows and all(float(row["contact_y_N"]) == float(row["contact_y_N"]) and row["energy_J"] == row["support_x_N"] == row["support_y_N"] == row["smallest_J"] == "" for row in rows), rows[0]' "$scratch/csv/records.csv"
tissuectl export results/tiny/cases.h5 --to vtu --out "$scratch/vtu"
check "export of measured forces to vtu: exit 1" exited 1
check "export of measured forces to vtu: one line states the cause" one_line 'cases.h5: has measured forces and no displacement'
check "export of measured forces to vtu: nothing is written" absent "$scratch/vtu"

# ---- a second make, and make after an edit
snapshot "$R" >"$scratch/before"
make_tiny all
check "a second make all writes nothing" only_changed "$scratch/before" "$R" ""
edit '^starts = .*' 'starts = 2'
make_tiny eval
check "editing the training does not import again" only_changed "$scratch/before" "$R" \
    "eval.json model.h5 plan.mk plan/train report.md"
cp -R "$R" "$scratch/one"
echo "# one comment more" >>"$data"
make_tiny eval
check "an edited CSV is imported, trained and evaluated again" sh -c "[ '$R/cases.h5' -nt '$data' ] && [ '$R/eval.json' -nt '$R/cases.h5' ]"
check "a comment in the CSV changes no dataset" same_contents "$R" "$scratch/one"

# ---- refusals
snapshot "$R" >"$scratch/before"
sed -i '$s/^/#/; 4s/,5,/,nan,/; 4s/-5/nan/' "$data"
make_tiny eval
check "a NaN field: make fails" failed
check "a NaN field: one line names file, line and column" one_line "tissuectl: fem/data/tiny.csv:4: column 'displacement_[xy]' is 'nan'"
check "a NaN field: earlier results are unchanged" only_changed "$scratch/before" "$R" ""
rm "$data"
tissuectl import fem/data/tiny.csv --study fem/studies/tiny.toml --out results/tiny/cases.h5
check "a missing CSV: exit 1" exited 1
check "a missing CSV: one line names it" one_line '^tissuectl: fem/data/tiny.csv: '
mkfifo "$data"
run timeout 60 build/release/tissuectl import fem/data/tiny.csv --study fem/studies/tiny.toml --out results/tiny/cases.h5
check "a pipe as CSV: one line states the cause, without waiting" one_line '^tissuectl: fem/data/tiny.csv: is a pipe; give a file'
rm "$data"
tissuectl import fem/data/block_measured.csv --study fem/studies/paper.toml --out results/tiny/cases.h5
check "a study without [data]: one line states the cause" one_line '^tissuectl: fem/studies/paper.toml: has no \[data\]'
tissuectl train --study fem/studies/paper.toml --cases results/tiny/cases.h5 --out results/tiny/model.h5
check "a study of spring sets, trained on measured cases: one line states the cause" one_line "^tissuectl: these cases are measured: .*'paper' has spring sets"
printf 'based_on = "tiny"\n[springs]\nstiffness = "sets"\nlaw = "axial"\n' >"$work/fem/studies/tiny-sets.toml"
tissuectl plan --study fem/studies/tiny-sets.toml --out results/tiny/plan.mk
check "spring sets together with [data]: one line names key and cause" one_line "^tissuectl: fem/studies/tiny-sets.toml:[0-9]*: key 'springs.stiffness': must be .*is not measured"
tissuectl collect --study fem/studies/tiny.toml --paths results/tiny/cases --out results/tiny/cases.h5
check "load paths for a study of measured data: one line states the cause" one_line '^tissuectl: fem/studies/tiny.toml: has \[data\]'
check "refusals do not change earlier results" only_changed "$scratch/before" "$R" ""
finish
