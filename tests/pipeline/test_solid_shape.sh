#!/bin/sh
# Long: A closed surface in space, end to end: a .geo on its bed, the same as a mesh of tetrahedra and as an .stl,
# exports, and refusals with one line.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
make_copy
R=$work/results/dome
study=fem/studies/dome.toml
cat >"$work/fem/dome.geo" <<'GEO'
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
Dilate{ {0, 0, 0}, {50, 45, 35} }{ Volume{1}; }
Box(2) = {-60, -60, 0, 120, 120, 60};
BooleanIntersection(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
bed[] = Surface In BoundingBox{-60, -60, -0.01, 60, 60, 0.01};
Physical Surface("table") = {bed[]};
Physical Volume("flesh") = {3};
GEO
cat >"$work/$study" <<'TOML'
based_on = "organ3"

[geometry]
shape = "../dome.geo"
trust_geo = true
fixed = ["table"]

[lattice]
size_m = 0.014

[mesh]
sizes_m = [0.005, 0.02]
check_fraction = 0

[loads]
magnitudes_m = [0.002, 0.004]

[loads.spread]
count = 2
pushes_deg = [[0, 0]]

[draws.validation]
count = 1
depth_m = [0.002, 0.004]

[draws.held_out]
count = 2
depth_m = [0.002, 0.004]

[springs]
topology = "embedded"
spacing_m = 0.008
terms = ["spring.all", "cell.all", "contact.normal", "contact.imprint_normal", "contact.hardening"]
TOML
# ---- the surface is meshed again if its unit changes; the substitute for gmsh notes its arguments
mkdir "$scratch/fake"
cat >"$scratch/fake/gmsh" <<'SH'
#!/bin/sh
echo "$*" >>"$0.calls"
for word; do out=$word; done
echo '$EndElements' >"$out"
SH
chmod +x "$scratch/fake/gmsh"
for unit in 0.001 0.01 0.001; do
    (cd "$work" && PATH="$scratch/fake:$PATH" TISSUECTL=false scripts/solve_path results/unit one -shape fem/dome.geo -unit_m $unit -springs none.msh \
        -size_near 0.005 -size_far 0.02) >"$said" 2>&1
done
check "a stored surface is used for its unit alone: each unit is meshed once" sh -c \
    'grep -o "clmin [^ ]*" "$0" | tr "\n" " " | grep -qx "clmin 5 clmin 0.5 " || { cat "$0"; exit 1; }' "$scratch/fake/gmsh.calls"

make_dome() { run make PYTHON="$PYTHON" STUDY=dome "$@"; }
make_dome contacts
check "make contacts succeeds before any load path is solved" exited 0
check "make contacts prints the numbers of places and load paths, and the fixed part of the surface" says '^results/dome/contacts.png: train 2 places, 2 load paths; validation 1 places, 1 load paths; held_out 2 places, 2 load paths; [34][0-9] % of the surface is fixed$'
check "make contacts writes a picture and solves no load path" sh -c 'head -c 8 "$1/contacts.png" | tail -c 7 | grep -q PNG && ! ls "$1"/cases/*.csv 2>/dev/null' - "$R"
run make PYTHON="$PYTHON" STUDY=tiny contacts
check "make contacts of a study in the plane: one line states the cause" one_line 'contacts are drawn of a study with a solid shape'
head -c 20000 "$R/mesh.msh" >"$scratch/mesh.msh"
cp -pR "$R" "$scratch/cut" && cp "$scratch/mesh.msh" "$scratch/cut/mesh.msh"
run "$PYTHON" "$root/scripts/figures/contacts.py" "$scratch/cut" "$scratch/cut.png"
check "contacts.py of a truncated mesh: one line states the cause" one_line 'mesh.msh: is no whole mesh of a solid shape'
make_dome first -j2
check "make first succeeds" exited 0
check "make first prints its number of load paths" says '^first  2 of 2 load paths to train on$'
check "make first solves two load paths and writes no model of the whole study" sh -c '[ "$(ls "$1"/cases/*.csv | wc -l)" = 2 ] && [ ! -e "$1/model.h5" ]' - "$R"
cp -p "$R/cases/c01-t00-a000.csv" "$scratch/first.csv"
run "$TISSUE_HAPTIC" "$R/first/model.h5" --seconds 0.1
check "tissue-haptic plays the first model" exited 0
run make PYTHON="$PYTHON" STUDY=measured first
check "make first of a measured study: one line states the cause" one_line "first: study 'measured' has no load paths to train on"
touch -d '1 hour ago' "$R/cases/c02-t00-a000.csv"
cp -p Makefile "$scratch/Makefile"; sed 's/^first: .*/first:/' "$scratch/Makefile" >"$work/Makefile.late"
run make -f Makefile.late PYTHON="$PYTHON" STUDY=dome first
check "make first ignores a load path that is older than the mesh" says '^first  1 of 2 load paths to train on$'
rm "$work/Makefile.late"
make_dome all -j2
check "make all keeps the load paths of make first" sh -c '[ -z "$(find "$1/cases/c01-t00-a000.csv" -newer "$2")" ]' - "$R" "$scratch/first.csv"
check "make all of a solid shape's study succeeds" exited 0
# ---- a mesh with a sliver is made again; the substitute for FreeFEM reports a sliver twice
mkdir "$scratch/finds"
cat >"$scratch/finds/FreeFem++-nw" <<SH
#!/bin/sh
echo >>"\$0.calls"
[ "\$(wc -l <"\$0.calls")" -gt 2 ] || { echo "solve_path: in x.msh the element at (1, 2, 3) mm is a sliver: quality 0.01, wanted 0.1"; exit 1; }
exec "$(command -v FreeFem++-nw)" "\$@"
SH
chmod +x "$scratch/finds/FreeFem++-nw"
cp -p "$R/cases/c01-t00-a000.csv" "$scratch/before.csv" && rm "$R/cases/c01-t00-a000.csv"
PATH="$scratch/finds:$PATH" make_dome "results/dome/cases/c01-t00-a000.csv"
check "a load path whose mesh has a sliver twice is solved on a third mesh" exited 0
check "the third mesh gives a complete load path, different from the first one" sh -c '[ "$(wc -l <"$2.calls")" = 3 ] && tail -n 1 "$1" | grep -q "^end" && ! cmp -s "$1" "$3"' - "$R/cases/c01-t00-a000.csv" "$scratch/finds/FreeFem++-nw" "$scratch/before.csv"
mv "$scratch/before.csv" "$R/cases/c01-t00-a000.csv"
check "make all of a solid shape's study writes all results" exist "$R/mesh.msh" "$R/cases.h5" "$R/model.h5" "$R/eval.json" "$R/report.html" "$R/figures/solid.png"
check "the lattice has the solid's volume and first nodes, the surface is closed, and forces balance" "$PYTHON" - "$R" <<'PY'
import sys
import h5py
import numpy as np
with h5py.File(sys.argv[1] + "/model.h5") as m, h5py.File(sys.argv[1] + "/cases.h5") as c:
    nodes, springs, tetrahedra, facets = (m["mesh/" + k][()] for k in ("nodes", "springs", "tetrahedra", "facets"))
    least, most = m["law/curved_range"][()]
    assert least < most, (least, most)
    table = m["law/lattice_correction"][()]
    assert table.shape[0] == len(facets) and 0.01 < np.abs(table).max() <= 0.5, (table.shape, np.abs(table).max())
    assert m.attrs["topology"] == b"embedded" and m.attrs["format_version"] == 12, dict(m.attrs)
    own = c["nodes"][()]
    assert np.array_equal(nodes[: len(own)], own)
    edges = {tuple(sorted((a, b))) for t in tetrahedra for i, a in enumerate(t) for b in t[:i]}
    assert len(own) - len(edges) + (4 * len(tetrahedra) + len(facets)) // 2 - len(tetrahedra) == 1
    lattice = m["mesh/lattice"]
    volume = lattice["fraction"][()].sum() * lattice.attrs["spacing_m"] ** 3
    x = nodes[tetrahedra]
    filled = (np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) * (x[:, 3] - x[:, 0])).sum() / 6
    assert abs(volume / filled - 1) < 0.01, (volume, filled)
    assert 0.8 < filled / (2 / 3 * np.pi * 0.050 * 0.045 * 0.035) < 1.01, filled
    assert (m["node_mass"][: len(own)] == 0).all() and (m["node_mass"][len(own) :] > 0).all()
    assert len(m["law/constants"]) == len(springs) + len(lattice["cubes"]) + len(m["mesh/fixed"])
    for name in c["path_names"].asstr():
        p = c["paths"][name]
        f, u = p["force"][()], p["displacement"][()]
        assert np.abs(f.sum(axis=1)).max() < 1e-6 * np.abs(f).max(), (name, np.abs(f.sum(axis=1)).max() / np.abs(f).max())
        assert np.abs(u).max() < 1.5 * p["magnitude"][-1], name
PY
check "the test set has errors of the learned model" "$PYTHON" - "$R" <<'PY'
import json, sys
loop = json.load(open(sys.argv[1] + "/eval.json"))["closed_loop"]["held_out"]
assert loop["learned"]["n"] == 2 and 0 < loop["learned"]["median"] < 0.5, loop["learned"]
PY
check "the report states that tools act on the free surface" grep -q "^Tools press the free surface of the tissue" "$R/report.md"
run make PYTHON="$PYTHON" STUDY=dome -q all
check "make all of a solid shape's study is then up to date" exited 0
tissuectl info results/dome/model.h5
check "info prints that the model is in 3 dimensions" says "in 3 dimensions"

# ---- exports read back
solid_exports "a solid shape"
tissuectl export results/dome/model.h5 --to vtp --out "$out/model-vtp"
check "VTK reads the displayed surface of each case" exported law-vtp "$out/model-vtp" "$R/model.h5" "$out/model-csv"
first=$(basename "$(find "$out/model-vtp" -name '*.vtp' | sort | head -n 1)" .vtp)
tissuectl export results/dome/model.h5 --to glb --out "$out/rest" --set "$first"
check "export of one case to glTF succeeds" exited 0
printf 'v 0 0 0\nv 90 0 0\nv 0 90 0\nf 1 2 3\n' >"$out/millimetres.obj"
tissuectl export results/dome/model.h5 --to glb --out "$out/none" --set "$first" --surface "$out/millimetres.obj"
check "--surface in another unit is refused" says "millimetres.obj: is up to .* mm from the model, .* is its unit not 1 m"
tissuectl export results/dome/model.h5 --to vtu --out "$out/none" --surface fem/dome.geo
check "--surface is refused for --to vtu" says "surface: needs --to vtp or --to glb"
tissuectl export results/dome/cases.h5 --to glb --out "$out/none"
check "export of load cases to glTF is refused" says "cases.h5: has load cases; --to glb draws the surface of a model.h5"

run "$TISSUE_HAPTIC" results/dome/model.h5 --seconds 0.2
check "tissue-haptic plays the model of a solid shape" exited 0
check "Python sessions have named surfaces that move with the tissue" env PYTHONPATH="$root/build/release/python" "$PYTHON" - "$work/results/dome/model.h5" "$scratch/boundary.obj" <<'PY'
import sys
import numpy as np
import tissue
model, file = sys.argv[1:]
session = tissue.Simulation(tissue.Model(model))
assert session.surfaces == ["boundary"], session.surfaces
rest, triangles = session.surface("boundary")
assert rest.shape[1] == triangles.shape[1] == 3 and triangles.min() == 0 and triangles.max() == len(rest) - 1
top = rest[rest[:, 2].argmax()]
session.ticks([[top[0], top[1], top[2] + 0.002 - 0.005 * min(1, k / 300)] for k in range(400)])
moved = session.surface("boundary")[0] - rest
assert 0.001 < np.abs(moved).max() < 0.004 and moved[rest[:, 2].argmax(), 2] < -0.001, np.abs(moved).max()
with open(file, "w") as obj:
    obj.writelines(f"v {x} {y} {z}\n" for x, y, z in 1e3 * rest)
    obj.writelines(f"f {a} {b} {c}\n" for a, b, c in triangles + 1)
session.add_surface("organ", file, unit_m=0.001)
assert session.surfaces == ["boundary", "organ"] and len(session.surface("organ")[0]) == len(rest)
for wrong in (lambda: session.surface("liver"), lambda: session.add_surface("organ", file, unit_m=0.001)):
    try:
        wrong()
    except tissue.Error:
        continue
    assert False
PY

# ---- one half of the support is an elastic bed, about as stiff as the tissue, the other half is rigid
sed 's/^fixed = .*/fixed = ["box -1 -1 -1 to 1 0.006 0.00001", "box -1 0.006 -1 to 1 1 0.00001"]\nbed_Pa_m = [2e5, 0.0]/' "$work/$study" >"$work/fem/studies/bedded.toml"
run make PYTHON="$PYTHON" STUDY=bedded eval -j2
check "make eval with one half on an elastic bed succeeds" exited 0
check "only nodes on the elastic bed move, forces balance, and the test error is below twice that on a rigid bed" "$PYTHON" - "$R" "$work/results/bedded" <<'PY'
import json, sys
import h5py
import numpy as np
rigid, bedded = sys.argv[1:]
with h5py.File(bedded + "/cases.h5") as c, h5py.File(rigid + "/cases.h5") as r, h5py.File(bedded + "/model.h5") as m:
    fixed = m["mesh/fixed"][()]
    assert set(c["shape/bed"][()]) == {0, 1} and "shape/bed" not in r
    for name in c["path_names"].asstr():
        p, q = c["paths"][name], r["paths"][name]
        u = np.linalg.norm(p["displacement"][-1], axis=1)
        f = p["force"][-1]
        assert np.abs(f.sum(axis=0)).max() < 1e-6 * np.abs(f).max(), f.sum(axis=0)
        on_bed, on_rock = (fixed[side] for side in (c["nodes"][()][fixed, 1] < 5e-3, c["nodes"][()][fixed, 1] > 7e-3))
        assert u[on_bed].max() > 0.01 * u.max() and u[on_rock].max() == 0 and np.abs(q["displacement"][-1][fixed]).max() == 0, name
        contact, bed = (np.linalg.norm(p[k][-1]) for k in ("contact_force", "support_force"))
        assert 0.5 < np.linalg.norm(p["contact_force"][-1]) / np.linalg.norm(q["contact_force"][-1]) < 0.99, name
        assert bed > 0.5 * contact, (name, contact, bed)
errors = [json.load(open(folder + "/eval.json"))["closed_loop"]["held_out"]["learned"] for folder in (rigid, bedded)]
assert errors[1]["n"] == errors[1]["of"] == 2 and errors[1]["max"] < 2 * errors[0]["max"] and errors[1]["shape"]["max"] < errors[0]["shape"]["max"], errors
PY

# ---- a nodule: contacts over it, and at its mirror image without a nodule
stone=fem/studies/stone.toml
cat >"$work/$stone" <<'TOML'
based_on = "dome"

[nodule]
centre_m = [0.020, 0.0, 0.016]
radius_m = 0.008
C1_Pa = 4000.0

[loads]
magnitudes_m = [0.002, 0.004]
contacts = [
  { at_m = [0.020, 0.0, 0.032], pushes_deg = [[0, 0]] },
  { at_m = [-0.020, 0.0, 0.032], pushes_deg = [[0, 0]] },
  { at_m = [0.008, 0.008, 0.034], pushes_deg = [[0, 0]] },
]

[springs]
terms = ["spring.all", "cell.all", "spring.nodule", "contact.normal", "contact.imprint_normal", "contact.hardening", "contact.normal.ground"]
TOML
run make PYTHON="$PYTHON" STUDY=stone eval
check "make eval of a solid shape with a nodule succeeds" exited 0
tissuectl export results/stone/model.h5 --to csv --out "$out/stone"
check "the force over a nodule exceeds that at the mirror image, in finite elements and in the energy model" "$PYTHON" - "$work/results/stone" "$out/stone/presses.csv" <<'PY'
import csv, json, sys
import h5py
import numpy as np
with h5py.File(sys.argv[1] + "/cases.h5") as c:
    fe = {name: np.linalg.norm(c["paths"][name]["contact_force"][()], axis=1) for name in c["path_names"].asstr()}
over, beside = (max(v[-1] for k, v in fe.items() if k.startswith(p)) for p in ("c01", "c02"))
law = {row["case"]: np.linalg.norm([float(row["force_%s_N" % a]) for a in "xyz"]) for row in csv.DictReader(open(sys.argv[2]))}
law_over, law_beside = (max(v for k, v in law.items() if k.startswith(p)) for p in ("c01", "c02"))
learned = json.load(open(sys.argv[1] + "/eval.json"))["closed_loop"]
print("over / beside: finite elements %.3f, law %.3f; held out %s" % (over / beside, law_over / law_beside, learned["held_out"]["learned"]))
assert over / beside > 1.1, (over, beside)
assert law_over / law_beside > 1 + 0.5 * (over / beside - 1), (law_over, law_beside, over / beside)
assert learned["trained"]["learned"]["max"] < 0.1, learned["trained"]["learned"]
PY

# ---- the same nodule as a surface: finite elements and energy model give almost the same results
"$PYTHON" - "$work/fem/stone.obj" <<'PY'
import sys
import numpy as np
points, facets = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float), [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
for _ in range(4):
    corners = points[facets]
    middles = (corners + np.roll(corners, -1, 1)) / 2
    every = np.concatenate([np.stack([corners[:, 0], middles[:, 0], middles[:, 2]], 1), np.stack([middles[:, 0], corners[:, 1], middles[:, 1]], 1),
                            np.stack([middles[:, 2], middles[:, 1], corners[:, 2]], 1), middles])
    every /= np.linalg.norm(every, axis=2, keepdims=True)
    points, facets = np.unique(every.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    facets = facets.reshape(-1, 3)
with open(sys.argv[1], "w") as out:
    for p in points: out.write("v %.12g %.12g %.12g\n" % tuple(1e3 * np.array([0.020, 0, 0.016]) + 8 * p))
    for f in facets: out.write("f %d %d %d\n" % tuple(f + 1))
PY
sed -e '/^centre_m/d' -e 's|^radius_m.*|shape = "../stone.obj"|' -e '/at_m = \[-0.020/d' -e '/at_m = \[0.008/d' "$work/$stone" >"$work/fem/studies/carved.toml"
printf '\n[draws.validation]\ncount = 1\n[draws.held_out]\ncount = 1\n' >>"$work/fem/studies/carved.toml"
run make PYTHON="$PYTHON" STUDY=carved train
check "make train with a nodule given by its surface succeeds" exited 0
check "a nodule given by its surface has the FE force of the ball within 1 % and its extent in the model within 2 %" "$PYTHON" - "$work/results/stone" "$work/results/carved" <<'PY'
import sys
import h5py
import numpy as np
def force(folder):
    with h5py.File(folder + "/cases.h5") as c:
        name = next(n for n in c["path_names"].asstr() if n.startswith("c01"))
        return np.linalg.norm(c["paths"][name]["contact_force"][()], axis=1)[-1]
ball, carved = (force(folder) for folder in sys.argv[1:])
print("by its surface / ball: %.4f" % (carved / ball))
assert abs(carved / ball - 1) < 0.01, (carved, ball)
places = [h5py.File(folder + "/model.h5")["law/ground"][:, :3] for folder in sys.argv[1:]]
spread = [np.sqrt((np.linalg.norm(p - [0.020, 0, 0.016], axis=1)**2).mean()) for p in places]
assert abs(spread[1] / spread[0] - 1) < 0.02, spread
PY
touch "$work/fem/stone.obj"
run make PYTHON="$PYTHON" STUDY=carved -n cases
check "a changed nodule surface solves load paths again" says "solve_path results/carved c01"
knows() { # SENTENCE STUDY: compares the stiffness of springs in the nodule with that of all springs
    check "$1" "$PYTHON" - "$work/results/$2" <<'PY'
import sys
import h5py
import numpy as np
with h5py.File(sys.argv[1] + "/model.h5") as m:
    own = m["law/constants"][()][: len(m["mesh/springs"])]
    nodes, springs = m["mesh/nodes"][()], m["mesh/springs"][()]
    inside = np.linalg.norm(nodes[springs].mean(axis=1) - [0.020, 0.0, 0.016], axis=1) < 0.006
    assert inside.sum() > 5
    print("springs in the nodule over all: %.2f" % (np.median(own[inside]) / np.median(own)))
    assert np.median(own[inside]) > 2 * np.median(own)
PY
}
knows "springs inside the nodule are more than twice as stiff as the median spring" stone
cp -p "$work/$stone" "$scratch/stone.toml"
wrong() { # SENTENCE SED LINE-PATTERN
    sed "$2" "$scratch/stone.toml" >"$work/$stone"
    run make PYTHON="$PYTHON" STUDY=stone mesh
    check "$1: make fails" failed
    check "$1: one line states the cause" one_line "$3"
}
wrong "a nodule outside of the shape" 's/^centre_m.*/centre_m = [0.020, 0.0, 0.040]/' "stone.toml: key 'nodule.centre_m': (0.02, 0, 0.04) m is not inside fem/dome.geo"
wrong "a nodule too near to the surface" 's/^radius_m.*/radius_m = 0.0125/' "stone.toml: key 'nodule.radius_m': .* mm from the surface of fem/dome.geo; a nodule of 12.5 mm needs 15.375 mm"
rm "$work/$stone"

# ---- the same ball as a named volume of the .geo
sed 's/^Physical Volume.*/Sphere(9) = {20, 0, 16, 8}; BooleanFragments{ Volume{3}; Delete; }{ Volume{9}; Delete; }\nPhysical Volume("stone") = {9};\nrest[] = Volume{:}; rest[] -= {9}; Physical Volume("flesh") = {rest[]};/
  /^bed/d; s/^Physical Surface.*//' "$work/fem/dome.geo" >"$work/fem/pit.geo"
cat >>"$work/fem/pit.geo" <<'GEO'
bed[] = Surface In BoundingBox{-60, -60, -0.01, 60, 60, 0.01};
Physical Surface("table") = {bed[]};
GEO
pit=fem/studies/pit.toml
sed -e 's|^\[nodule\]|[geometry]\nshape = "../pit.geo"\ntrust_geo = true\n[lattice]\nsize_m = 0.014\n[material.regions.stone]|' -e 's/^\[springs\]/[springs]\nspacing_m = 0.008/' -e '/^centre_m/d' -e '/^radius_m/d' "$scratch/stone.toml" >"$work/$pit"
run make PYTHON="$PYTHON" STUDY=pit eval
check "make eval of a solid shape with a named volume succeeds" exited 0
check "forces over a ball as a named volume are within 3 % of those over the nodule" "$PYTHON" - "$work/results/pit" "$work/results/stone" <<'PY'
import sys
import h5py
import numpy as np
def forces(folder):
    with h5py.File(folder + "/cases.h5") as c:
        return {n: np.linalg.norm(c["paths"][n]["contact_force"][()], axis=1)[-1] for n in c["path_names"].asstr() if n.startswith("c0")}
pit, stone = forces(sys.argv[1]), forces(sys.argv[2])
assert sorted(pit) == sorted(stone) and len(pit) == 3, (pit, stone)
off = {n: pit[n] / stone[n] - 1 for n in pit}
print(off)
assert max(map(abs, off.values())) < 0.03, off
PY
knows "springs inside the named volume are more than twice as stiff as the median spring" pit
sed -i 's/regions.stone/regions.peach/' "$work/$pit"
run make PYTHON="$PYTHON" STUDY=pit mesh
check "an unknown named volume: one line states the cause" one_line "fem/pit.geo: has no physical volume 'peach'; it has: .*stone"
rm "$work/$pit"

# ---- the same tissue as a mesh of tetrahedra, and as an .stl
cp -p "$work/$study" "$scratch/geo.toml"
(cd "$work/fem" && gmsh -v 1 -3 -clmin 14 -clmax 14 -format msh41 dome.geo -o dome.msh >/dev/null 2>&1)
sed -i -e 's/dome.geo/dome.msh/' -e '/^\[lattice\]/,/^size_m/d' "$work/$study"
make_dome mesh
check "tetrahedra in MSH 4.1 are accepted" exited 0
cp -p "$work/$study" "$scratch/good.toml"
cp -p "$work/fem/dome.msh" "$scratch/dome.msh"
"$PYTHON" - "$work/fem/dome.stl" "$R/mesh.msh" <<'PY'
import sys
lines = open(sys.argv[2]).read().split("\n")
k, e = lines.index("$Nodes"), lines.index("$Elements")
nodes = {l.split()[0]: l.split()[1:] for l in lines[k + 2:k + 2 + int(lines[k + 1])]}
with open(sys.argv[1], "w") as out:
    for name, tag in (("skin", "2"), ("table", "1")):
        print("solid", name, file=out)
        for l in lines[e + 2:e + 2 + int(lines[e + 1])]:
            w = l.split()
            if w[1] == "2" and w[3] == tag:
                print("facet normal 0 0 0\nouter loop", *("vertex " + " ".join(repr(1e3 * float(x)) for x in nodes[n]) for n in w[5:]), "endloop\nendfacet", sep="\n", file=out)
        print("endsolid", name, file=out)
PY
sed 's/dome.geo/dome.stl/' "$scratch/geo.toml" >"$work/$study"
make_dome mesh
check "make mesh of an .stl with named surfaces succeeds" exited 0
check "the tetrahedra fill the volume of the .stl, and fixed nodes lie on its table" "$PYTHON" - "$R/mesh.msh" <<'PY'
import sys
import numpy as np
lines = open(sys.argv[1]).read().split("\n")
k, e = lines.index("$Nodes"), lines.index("$Elements")
x = np.array([[float(w) for w in l.split()[1:]] for l in lines[k + 2:k + 2 + int(lines[k + 1])]])
elements = [[int(w) for w in l.split()] for l in lines[e + 2:e + 2 + int(lines[e + 1])]]
t = np.array([w[5:] for w in elements if w[1] == 4]) - 1
volume = (np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]]) * (x[t[:, 3]] - x[t[:, 0]])).sum() / 6
assert 0.8 < volume / (2 / 3 * np.pi * 0.050 * 0.045 * 0.035) < 1.01, volume
held = np.unique([n - 1 for w in elements if w[1] == 2 and w[3] == 1 for n in w[5:]])
assert len(held) > 8 and np.abs(x[held, 2]).max() < 1e-9
PY
# damaged files, TISSUE_DAMAGED of each kind (15)
damaged() { (cd "$work" && "$PYTHON" "$root/tests/fuzz/damaged_shapes.py" "$1" dome "${TISSUE_DAMAGED:-15}"); }
check "every damaged .stl gives a mesh or one line" damaged fem/dome.stl

# ---- refusals: one line that names file, place and cause; the earlier mesh is unchanged
cp -p "$scratch/good.toml" "$work/$study"
make_dome mesh
check "every damaged .msh gives a mesh or one line" damaged fem/dome.msh
edit3() { sed -i "s|$1|$2|" "$work/$study"; }
refused() { # SENTENCE LINE-PATTERN
    cp -p "$R/mesh.msh" "$scratch/mesh.msh"
    make_dome mesh
    check "$1: make fails" failed
    check "$1: one line states the cause" one_line "$2"
    check "$1: the earlier mesh is unchanged" cmp "$R/mesh.msh" "$scratch/mesh.msh"
    cp -p "$scratch/good.toml" "$work/$study"
    cp "$scratch/dome.msh" "$work/fem/dome.msh"
}
edit3 'fixed = .*' 'fixed = ["chair"]'
refused "an unknown fixed surface" "fem/dome.msh: has no physical surface 'chair'; it has: table"
edit3 'dome.msh' 'cone.msh'
refused "a missing shape" "dome.toml:[0-9]*: key 'geometry.shape': there is no file fem/cone.msh"
edit3 'dome.msh' 'dome.step'
refused "a shape's file of another kind" "dome.step' must be a file that ends in .geo, .msh, .stl, .obj"
(cd "$work/fem" && sed '/Physical Volume/d' dome.geo >skin.geo && gmsh -v 1 -2 -clmin 14 -clmax 14 -format msh41 skin.geo -o dome.msh >/dev/null 2>&1)
refused "a surface without tetrahedra" "fem/dome.msh: has no tetrahedra: is its surface closed, and its volume in a physical group?"
head -c 3000 "$scratch/dome.msh" >"$work/fem/dome.msh"
refused "a truncated mesh" "fem/dome.msh: gmsh cannot read"
(cd "$work/fem" && sed 's/^Physical Volume.*/Box(9) = {200, 0, 0, 30, 30, 30}; Physical Volume("flesh") = {3, 9};/' dome.geo >two.geo &&
    gmsh -v 1 -3 -clmin 14 -clmax 14 -format msh41 two.geo -o dome.msh >/dev/null 2>&1)
refused "a tissue of two pieces" "fem/dome.msh: the surface is not a single closed surface: the tissue has a cavity or a second part at (.*) m"
(cd "$work/fem" && sed 's/^bed.*/Cylinder(9) = {0, 0, -1, 0, 0, 80, 15}; BooleanDifference(10) = { Volume{3}; Delete; }{ Volume{9}; Delete; }; &/; s/Volume("flesh") = {3}/Volume("flesh") = {10}/' dome.geo >ring.geo &&
    gmsh -v 1 -3 -clmin 14 -clmax 14 -format msh41 ring.geo -o dome.msh >/dev/null 2>&1)
refused "a tissue with a hole through it" "fem/dome.msh: the surface has a hole through it.*is 0, not 2"
sed -i '/^\[loads.spread\]/,/^pushes_deg/d' "$work/$study"
sed -i 's/^magnitudes_m.*/&\ncontacts = [{ at_m = [0.0, 0.0, 0.2], pushes_deg = [[0, 0]] }]/' "$work/$study"
tissuectl plan --study $study --mesh results/dome/mesh.msh --out results/dome/plan.mk  # the shape differs from that of the refusals above
tissuectl plan --study $study --mesh results/dome/mesh.msh --out results/dome/plan.mk
check "a contact off the surface: one line states the cause" one_line "key 'loads.contacts\[0\].at_m': (0, 0, 0.2) m is [0-9.]* mm from the free surface"
finish
