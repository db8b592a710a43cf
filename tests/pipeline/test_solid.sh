#!/bin/sh
# A study of a solid block from mesh to report; exports of its files; and functions of the plane alone, which refuse
# them with one line.
. "$(dirname "$0")/common"
make_copy
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}") || exit 1
R=$work/results/solid
{
    solid_study | sed 's/"contact.hardening"\]/"contact.hardening", "contact.normal.ground", "spring.nodule"]/'
    cat <<'TOML'

[nodule]
centre_m = [0.050, 0.050, 0.030]
radius_m = 0.012
C1_Pa = 1052.0
C2_Pa = 1964.0

[map]
depth_m = 0.002
x_m = [0.050, 0.080]
y_m = [0.050, 0.080]

[draws.held_out_two]
seed = 9999
count = 1
depth_m = [0.002, 0.003]
tilt_deg = [0, 30]
clearance_m = [0.020, 0.050]
apart_m = [0.016, 0.030]
TOML
} >"$work/fem/studies/solid.toml"
make_solid() { run make PYTHON="$PYTHON" STUDY=solid "$@"; }
make_solid all -j2
check "make all of a solid's study succeeds" exited 0
figures="held_out held_out_force shape solid map"
check "every planned figure is drawn, and the report lists the same figures" sh -c 'for f in $1; do [ -s "$2/figures/$f.png" ] || exit 1; done
    [ "$(sed -n "s/^!\[\(.*\)\].*/\1/p" "$2/report.md" | tr "\n" " ")" = "$1 " ]' - "$figures" "$R"
check "the report has columns x, y and tilt of contacts, errors over surface nodes, and no nan" sh -c \
    'grep -q "^| contact | x mm | y mm | tilt deg |" "$1" && grep -q "over the free nodes of the surface" "$1" && ! grep -q nan "$1"' - "$R/report.md"
check "the report explains every model and every role" sh -c 'for w in learned force_table untrained heuristic_a_patch uniform_patch; do grep -q "^- model \`$w\`: " "$1" || exit 1; done
    for w in held_out held_out_near held_out_sideways; do grep -q "^- contacts of \`$w\`: " "$1" || exit 1; done' - "$R/report.md"
check "the map has forces of FE and model at every place, and the report has the contrast of eval.json" "$PYTHON" -c "import json, sys
e, report = json.load(open(sys.argv[1] + '/eval.json')), open(sys.argv[1] + '/report.md').read()
places, contrast = e['map']['places'], e['map']['contrast']
assert [p['contact_m'] for p in places] == [[x, y, 0.05] for y in (0.05, 0.08) for x in (0.05, 0.08)], places
assert all(0 < p['learned_N'] < 2 * p['fe_N'] for p in places) and not e['map']['lost']
assert contrast['over_m'] == places[0]['contact_m'] and contrast['far_m'] == [places[3]['contact_m']]
assert abs(contrast['fe'] - places[0]['fe_N'] / places[3]['fe_N']) < 1e-9
assert '%.3f times the force far from it' % contrast['fe'] in report
assert not any('map' in role for role in e['closed_loop'])" "$R"
check "a pair of discs has two forces in the cases, and errors of both discs in eval.json and the report" "$PYTHON" -c "import h5py, json, sys
e, report = json.load(open(sys.argv[1] + '/eval.json')), open(sys.argv[1] + '/report.md').read()
two = e['two_tools']['held_out_two']
pair, = two['pairs']
assert two['learned']['n'] == two['alone']['n'] == 2 and not two['lost'], two
with h5py.File(sys.argv[1] + '/cases.h5') as cases:
    path = cases['paths/held-out-two-0001']
    assert cases.attrs['format_version'] == 13
    assert 0.016 <= pair['apart_m'] <= 0.030 and list(path['second_contact']) == pair['tools'][1]['contact_m']
    assert list(path['second_force'][-1]) == pair['tools'][1]['fe_force_N'] and path['second_force'].shape == path['contact_force'].shape
    assert list(path['contact_force'][-1]) == pair['tools'][0]['fe_force_N'] != pair['tools'][1]['fe_force_N']
    assert [name for name in cases['paths'] if 'second_force' in cases['paths'][name]] == ['held-out-two-0001']
assert all(0 < tool['error']['learned'] < 1 for tool in pair['tools'])
assert 'held_out_two' not in e['closed_loop'] and 'pairs of \`held_out_two\`' in report and '| held-out-two-0001 |' in report" "$R"
check "make all writes report.html" exist "$R/report.html"
check "figures and report.html are drawn without answers of the model" "$PYTHON" "$root/tests/pipeline/without_answers.py" "$R"
run make PYTHON="$PYTHON" STUDY=solid -q all
check "make all of a solid's study is then up to date" exited 0
for file in cases model; do
    tissuectl info results/solid/$file.h5
    check "info prints that $file.h5 is in 3 dimensions" says "in 3 dimensions"
done

# ---- exports read back
solid_exports "a solid"

# ---- functions of the plane refuse files in space, and change no file
snapshot "$R" >"$scratch/before"
refused() { # SENTENCE WORDS COMMAND...
    sentence=$1 words=$2
    shift 2
    run timeout 60 "$@"
    check "$sentence: exit 1" exited 1
    check "$sentence: one line states the cause" one_line "$words"
}
model=results/solid/model.h5 T=build/release/tissuectl
check "a session with a model in space has a device force above 0.01 N" "$PYTHON" -c "import json, subprocess, sys
words = sys.argv[1:] + '--seconds 1 --no-realtime --motion press --depth 0.005 --json'.split()
statistics = json.loads(subprocess.run(words, stdout=subprocess.PIPE, check=True, timeout=120).stdout)
assert statistics['force_max_N'] > 0.01, statistics" "$TISSUE_HAPTIC" "$R/model.h5"
check "the examples press.py and film.py press a model in space" env PYTHONPATH="$(dirname "$TISSUECTL")/python" MPLCONFIGDIR="$scratch" sh -c '
    "$1" "$2/press.py" "$3" "$4/press.png" && "$1" "$2/film.py" "$3" "$4/film.gif" 0.2 && [ -s "$4/press.png" ] && [ -s "$4/film.gif" ]' - "$PYTHON" "$root/lib/api/examples" "$R/model.h5" "$scratch"
run timeout 300 "$TISSUE_HAPTIC" $model --check results/solid/cases.h5 --out "$work/realtime.json"
check "tissue-haptic --check of the test contacts succeeds" exited 0
check "every moving indentation comes to rest within 1e-3 of the static answer" "$PYTHON" -c "import json, sys
j = json.load(open(sys.argv[1]))
assert all(p['rested'] for p in j['presses']) and j['static_error']['max'] < 1e-3, j['static_error']" "$work/realtime.json"
refused "a SOFA scene of a model in space" "model.h5: is an energy model, and SOFA has no force field" $T export $model --to sofa --out "$out/x.scn"
check "a refused SOFA scene leaves no file" absent "$out/x.scn"
refused "cases in space for a study in the plane" "144 nodes, which are not those of the 11 x 11 lattice" \
    $T train --study fem/studies/surface-quick.toml --cases results/solid/cases.h5 --out results/solid/model.h5
refused "an ablation with cases in space for a study in the plane" "144 nodes, which are not those of the 11 x 11 lattice" \
    $T ablate --study fem/studies/surface-quick.toml --cases results/solid/cases.h5 --out "$out/ablation.json"
# the same cases without their third axis
"$PYTHON" -c "import h5py, sys
with h5py.File(sys.argv[1]) as a, h5py.File(sys.argv[2], 'w') as b:
    b.attrs.update({key: value for key, value in a.attrs.items() if key != 'dimension'})
    b.attrs['format_version'] = 1.0
    def put(name, item):
        if not isinstance(item, h5py.Dataset) or '/second_' in item.name: return
        words = item.name.rsplit('/', 1)[-1] in ('nodes', 'contact', 'direction', 'displacement', 'force', 'contact_force', 'support_force')
        b[name] = item[..., :2] if words else item[()]
        b[name].attrs.update(item.attrs)
    a.visititems(put)" "$R/cases.h5" "$work/flat.h5"
tissuectl info flat.h5
check "info reads the flattened cases" exited 0
refused "cases in the plane for a study in space" "flat.h5: \|144 nodes, which are not" \
    $T train --study fem/studies/solid.toml --cases flat.h5 --out results/solid/model.h5
refused "cases in the plane for a model in space" "flat.h5: \|nodes" \
    $T eval --study fem/studies/solid.toml --model $model --cases flat.h5 --out results/solid/eval.json
printf 'x_m,y_m,ux_m,uy_m,fx_N,fy_N\n' >"$work/data.csv"
refused "measured data of a solid" "solid.toml: " $T import data.csv --study fem/studies/solid.toml --out "$out/import.h5"
refused "a shape of a solid" "study 'solid' has a block" $T shape --study fem/studies/solid.toml --mesh fem/block.geo --out "$out/shape.msh"
check "refusals do not change results" only_changed "$scratch/before" "$R" ""
finish
