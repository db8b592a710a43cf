#!/bin/sh
# A tissue of a user's outline, end to end: as .geo, as a mesh in MSH 4.1, with a preset, with a region of another
# material; and refusals with one line.
. "$(dirname "$0")/common"
make_copy
study=fem/studies/tiny.toml
cat >"$work/fem/bean.geo" <<'GEO'
Point(1) = {20, 5, 0};  Point(2) = {60, 5, 0};  Point(3) = {82, 30, 0};  Point(4) = {55, 52, 0};  Point(5) = {30, 45, 0};  Point(6) = {2, 35, 0};
Line(1) = {1, 2};
Spline(2) = {2, 3, 4, 5, 6, 1};
Curve Loop(1) = {1, 2};
Point(11) = {52, 28, 0};  Point(12) = {40, 38, 0};  Point(13) = {28, 26, 0};  Point(14) = {40, 16, 0};
Line(11) = {11, 12};  Line(12) = {12, 13};  Line(13) = {13, 14};  Line(14) = {14, 11};
Curve Loop(2) = {11, 12, 13, 14};
Plane Surface(1) = {1, 2};
Plane Surface(2) = {2};
Physical Curve("table") = {1};
Physical Curve("inner") = {11};
Physical Surface("flesh") = {1};
Physical Surface("stone") = {2};
GEO
cat >"$work/$study" <<'TOML'
based_on = "surface"
variants = []

[geometry]
shape = "../bean.geo"
trust_geo = true
unit_m = 0.001
fixed = ["table"]

[lattice]
size_m = 0.014

[material]
preset = "liver"

[mesh]
refine = 4
check_refine = 0

[loads]
magnitudes_m = [0.002, 0.004]
record_step_m = 0.002

[loads.sweep]
spacing_m = 0.03
clearance_m = 0.02
angles_deg = [0]

[draws.validation]
count = 1
depth_m = [0.002, 0.004]

[draws.held_out]
count = 2
depth_m = [0.002, 0.004]

[draws.held_out_full]
count = 1
depth_m = [0.002, 0.004]

[springs]
topology = "edges"
terms = ["spring.all", "spring.held", "contact.normal", "contact.tangent"]
TOML
make_tiny eval -j2
check "make eval of a curved outline succeeds" exited 0
check "make eval of a curved outline writes all results" exist "$R/mesh.msh" "$R/cases.h5" "$R/model.h5" "$R/eval.json" "$R/report.md"
check "the springs are the mesh's edges, the outline is simply connected, and forces balance" "$PYTHON" - "$R" <<'PY'
import sys
import h5py
import numpy as np
with h5py.File(sys.argv[1] + "/model.h5") as m, h5py.File(sys.argv[1] + "/cases.h5") as c:
    nodes, springs, triangles = (m["mesh/" + k][()] for k in ("nodes", "springs", "triangles"))
    assert m.attrs["topology"] == b"edges", m.attrs["topology"]
    assert len(springs) == len(nodes) + len(triangles) - 1, (len(springs), len(nodes), len(triangles))
    area = m["mesh/node_area"][()].sum()
    assert 2e-3 < area < 5e-3, area
    assert set(c["shape/region"][()]) == {0}, "a region without a material is tissue like the rest"
    for name in c["path_names"].asstr():
        p = c["paths"][name]
        f, r = p["force"][()], p["contact_force"][()] + p["support_force"][()]
        assert np.abs(f.sum(axis=1)).max() < 1e-8 * np.abs(f).max(), name
        assert np.abs(r).max() < 1e-8 * np.abs(f).max(), name
PY
check "the test set has errors of the learned model and of the baselines" "$PYTHON" - "$R" <<'PY'
import json, sys
loop = json.load(open(sys.argv[1] + "/eval.json"))["closed_loop"]["held_out"]
assert loop["learned"]["n"] + 0 >= 1 and 0 < loop["learned"]["median"] < 0.5, loop["learned"]
assert loop["heuristic_a"]["median"] > 0 and "uniform_edges_axial" in loop and "untrained" in loop, sorted(loop)
PY
snapshot "$R" >"$scratch/before"
make_tiny eval
check "a second make eval changes no file" only_changed "$scratch/before" "$R" ""
touch "$work/$study"
make_tiny eval
check "a study with a new time stamp is only planned again" only_changed "$scratch/before" "$R" "plan.mk"
for made_of in build/release/stage/shape scripts/mesh; do
    snapshot "$R" >"$scratch/before"
    touch "$work/$made_of"
    make_tiny eval
    check "$made_of is newer: the mesh is made again, and no load path is solved if it is the same" \
        only_changed "$scratch/before" "$R" "mesh.made mesh.msh.log plan.mk"
    make_tiny eval -q
    check "$made_of is newer: make eval is then up to date" exited 0
done
cp -p "$R/mesh.msh" "$scratch/mesh.msh"
echo of-another-program >>"$R/mesh.msh"
touch "$work/build/release/stage/shape"
make_tiny mesh
check "a mesh that was changed is made again" cmp "$R/mesh.msh" "$scratch/mesh.msh"
run make -n PYTHON="$PYTHON" STUDY=tiny cases
check "after a changed mesh load paths are solved again" says "solve_path results/tiny s"
rm "$R/mesh.msh"
make_tiny mesh
check "a deleted mesh is made again" cmp "$R/mesh.msh" "$scratch/mesh.msh"

# ---- the same tissue as a mesh of another format version, with clockwise triangles
cp -p "$R/cases.h5" "$scratch/geo.h5"
(cd "$work/fem" && sed -i 's/Plane Surface(1) = {1, 2};/Plane Surface(1) = {-1, 2};/' bean.geo &&
    gmsh -v 1 -2 -clmin 14 -clmax 14 -format msh41 bean.geo -o bean.msh >/dev/null 2>&1)
sed -i -e 's/bean.geo/bean.msh/' -e '/^\[lattice\]/,/^size_m/d' "$work/$study"
make_tiny mesh
check "a mesh in MSH 4.1 is accepted" exited 0
check "clockwise triangles are reversed, with a note" says "triangles of fem/bean.msh were clockwise and were turned"
check "the mesh has the same number of nodes and the same extent as the .geo" "$PYTHON" - "$R/mesh.msh" "$scratch/geo.h5" <<'PY'
import sys
import h5py
import numpy as np
lines = open(sys.argv[1]).read().split("\n")
k = lines.index("$Nodes")
nodes = np.array([[float(w) for w in l.split()[1:3]] for l in lines[k + 2:k + 2 + int(lines[k + 1])]])
with h5py.File(sys.argv[2]) as c:
    assert len(nodes) == len(c["nodes"]) and np.ptp(nodes, axis=0).max() == np.ptp(c["nodes"][()], axis=0).max()
PY

# ---- a stiff region
printf '\n[material.regions.stone]\nC1_Pa = 8000\n' >>"$work/$study"
make_tiny cases -j2
check "make cases with a material for a named region succeeds" exited 0
check "the stiff region increases the force at the same contacts" "$PYTHON" - "$R/cases.h5" "$scratch/geo.h5" <<'PY'
import sys
import h5py
import numpy as np
with h5py.File(sys.argv[1]) as hard, h5py.File(sys.argv[2]) as soft:
    assert set(hard["shape/region"][()]) == {0, 1}
    ratio = [np.linalg.norm(hard["paths"][n]["contact_force"][-1]) / np.linalg.norm(soft["paths"][n]["contact_force"][-1])
             for n in hard["path_names"].asstr() if n.startswith("s")]
    assert min(ratio) > 1 and max(ratio) < 8, ratio
PY

# ---- refusals: one line that names file, place and cause; the earlier mesh is unchanged
cp -p "$work/$study" "$scratch/good.toml"
cp -p "$work/fem/bean.msh" "$scratch/bean.msh"
refused() { # SENTENCE LINE-PATTERN
    cp -p "$R/mesh.msh" "$scratch/mesh.msh"
    make_tiny mesh
    check "$1: make fails" failed
    check "$1: one line states the cause" one_line "$2"
    check "$1: the earlier mesh is unchanged" cmp "$R/mesh.msh" "$scratch/mesh.msh"
    cp -p "$scratch/good.toml" "$work/$study"
    cp "$scratch/bean.msh" "$work/fem/bean.msh"
}
edit 'fixed = .*' 'fixed = ["chair"]'
refused "an unknown curve" "fem/bean.msh: has no physical curve 'chair'; it has: table, inner"
edit 'fixed = .*' 'fixed = ["inner"]'
refused "a fixed curve inside the tissue" "fem/bean.msh: the fixed curve at (.*) m is not on the outline"
edit 'regions.stone' 'regions.pebble'
refused "an unknown region" "fem/bean.msh: has no physical surface 'pebble'; it has: flesh, stone"
edit 'bean.msh' 'pea.msh'
refused "a missing shape" "tiny.toml:[0-9]*: key 'geometry.shape': there is no file fem/pea.msh"
edit 'bean.msh' 'bean.stl'
refused "a shape's file of another kind" "key 'geometry.shape': 'bean.stl' must be block, or a file that ends in .geo or .msh\|ends in .geo or .msh"
edit 'preset = .*' 'preset = "granite"'
refused "an unknown material" "key 'material.preset': 'granite' is not a material; there are: brain, liver, muscle"
edit 'topology = .*' 'topology = "grid8"'
refused "a lattice on a shape" "key 'springs.topology': 'grid8' is not allowed; allowed: edges"
head -c 2000 "$scratch/bean.msh" >"$work/fem/bean.msh"
refused "a truncated mesh" "fem/bean.msh: gmsh cannot read"
(cd "$work/fem" && sed 's/^Plane Surface(1).*/Plane Surface(1) = {1, 2}; Recombine Surface{1};/' bean.geo >quad.geo &&
    gmsh -v 1 -2 -format msh41 quad.geo -o bean.msh >/dev/null 2>&1)
refused "quadrilaterals" "element [0-9]* is a quadrilateral; a tissue needs straight triangles"
printf 'Point(1)={0,0,0};Point(2)={100,0,0};Point(3)={100,100,0};Line(1)={1,2};Line(2)={2,3};Curve Loop(1)={1,2};Plane Surface(1)={1};Physical Curve("table")={1};Physical Surface("flesh")={1};\n' >"$work/fem/open.geo"
sed -e 's/bean.msh/open.geo/' -e '/regions.stone/,$d' "$scratch/good.toml" >"$work/$study"
printf '\n[lattice]\nsize_m = 0.01\n' >>"$work/$study"
make_tiny mesh
check "an outline that is not closed: make fails" failed
check "an outline that is not closed: a line states the cause" says "fem/open.geo: gmsh cannot read or mesh it: .*closed"
sed -e 's/^refine = .*/refine = 1/' -e 's/open.geo/bean.geo/' -i "$work/$study"
tissuectl plan --study $study --out results/tiny/plan.mk
check "finite elements longer than half a patch are refused" one_line "key 'mesh.refine': must make finite elements"
finish
