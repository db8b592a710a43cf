#!/bin/sh
# tissuectl new: a study of one's own from the file of a shape, which runs as it was written; what it lists, chooses and refuses.
. "$(dirname "$0")/common"
make_copy
cat >"$work/fem/loaf.geo" <<'GEO'
Point(1) = {0, 0, 0};  Point(2) = {70, 0, 0};  Point(3) = {76, 30, 0};  Point(4) = {35, 52, 0};  Point(5) = {-6, 30, 0};
Line(1) = {1, 2};
Spline(2) = {2, 3, 4, 5, 1};
Curve Loop(1) = {1, 2};
Plane Surface(1) = {1};
Physical Curve("board") = {1};
Physical Curve("crust") = {2};
Physical Surface("crumb") = {1};
GEO
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm
check "nothing said of what is held: exit 1" exited 1
check "nothing said of what is held: one line lists the named curves" one_line '^tissuectl: fem/loaf.geo: --held must say which curves are held; it names board, crust$'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --held board
check "metres for millimetres: one line asks for the unit" one_line 'fem/loaf.geo: is 82 m long; is this in millimetres? --unit mm, cm, m or inch'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held table
check "a curve that is not there: one line lists those there are" one_line "has no curve 'table' to hold; it names board, crust"
tissuectl new loaf --shape fem/none.geo --unit mm --held table
check "a shape that is not there: one line" one_line 'fem/none.geo'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit km --held board
check "an unknown unit: exit 2" exited 2
tissuectl new ../loaf --shape fem/loaf.geo --trust-geo --unit mm --held board
check "a name that is a path: one line" one_line "a study's name is of letters"
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board --preset bread
check "a material that is not there: one line lists those there are" one_line "'bread' is not a material; there are: brain, liver, muscle"
check "nothing is written where it was refused" absent "$work/fem/studies/loaf.toml" "$work/fem/studies/../loaf.toml"

tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board --preset brain
check "a study is written: exit 0" exited 0
check "it says how large the shape is and what is held" says '^fem/loaf.geo: in the plane, 82 x 52 mm; held: board$'
check "it says which springs it chose, and from what" says '^springs 8 mm long (lattice.size_m), an eighth of its mean size$'
check "it says what to run" says '^fem/studies/loaf.toml is written; make all STUDY=loaf runs it$'
check "every number of the study has its unit or its meaning beside it" sh -c '! grep -n "^[a-z_]*_m = [^#]*$" "$1"' - "$work/fem/studies/loaf.toml"
cp -p "$work/fem/studies/loaf.toml" "$scratch/loaf.toml"
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board
check "a study that is there: exit 1" exited 1
check "a study that is there: one line, and it stays" one_line '^tissuectl: fem/studies/loaf.toml: is there already'
check "a study that is there stays as it was" cmp "$scratch/loaf.toml" "$work/fem/studies/loaf.toml"

# as it was written, but for how many contacts there are
sed -i -e 's/^size_m = .*/size_m = 0.014/' -e 's/^spacing_m = .*/spacing_m = 0.03/' -e 's/^angles_deg = .*/angles_deg = [0]/' -e 's/^count = .*/count = 2/' \
    -e 's/^refine = .*/refine = 4/' "$work/fem/studies/loaf.toml"
run make PYTHON="$PYTHON" STUDY=loaf eval -j2
check "its study is meshed, solved, trained and evaluated" exited 0
check "its study has an evaluation" exist "$work/results/loaf/eval.json"
cp "$scratch/loaf.toml" "$work/fem/studies/whole.toml"
run make PYTHON="$PYTHON" STUDY=whole mesh
check "the study as it was written is meshed" exited 0
trains() { [ "$(grep -c '^train ' "$work/results/$1/plan/collect")" "$2" "$3" ] || { cat "$work/results/$1/plan/collect"; return 1; }; }
check "the study as it was written is planned on its mesh: some thirty contacts and pushes to train on" trains whole -ge 20

# ---- the same outline as a mesh, and a surface in space
(cd "$work" && gmsh -v 0 -2 -clmin 10 -clmax 10 -format msh41 fem/loaf.geo -o fem/loaf.msh) >"$scratch/log" 2>&1
tissuectl new mesh --shape fem/loaf.msh --unit mm --held board
check "a mesh in MSH 4.1: exit 0" exited 0
check "a mesh in MSH 4.1: its elements are the springs" says "^springs: the edges of its [0-9]* nodes' mesh"
run make PYTHON="$PYTHON" STUDY=mesh mesh
check "the mesh's study is checked" exited 0
"$PYTHON" - "$work/fem/box.stl" <<'PY'
import itertools, sys
corners = [(-40, 40), (-30, 30), (0, 50)]
names = {}
for axis, side in itertools.product(range(3), range(2)):
    a, b = [i for i in range(3) if i != axis]
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    points = []
    for u, v in ring if (side == 1) == (axis != 1) else ring[::-1]:
        p = [0, 0, 0]
        p[axis], p[a], p[b] = corners[axis][side], corners[a][u], corners[b][v]
        points.append(p)
    names.setdefault("under" if (axis, side) == (2, 0) else "free", []).extend([(points[0], points[1], points[2]), (points[0], points[2], points[3])])
with open(sys.argv[1], "w") as out:
    for name, triangles in names.items():
        print("solid", name, file=out)
        for t in triangles:
            print(" facet normal 0 0 0\n  outer loop", *("   vertex %g %g %g" % tuple(p) for p in t), "  endloop\n endfacet", sep="\n", file=out)
        print("endsolid", name, file=out)
PY
tissuectl new box --shape fem/box.stl --unit mm
check "a surface of two solids: they are listed" one_line '^tissuectl: fem/box.stl: --held must say which surfaces are held; it names \(free, under\|under, free\); or a region, in m: --held .below z = 0.01.$'
tissuectl new box --shape fem/box.stl --unit mm --held under
check "a surface in space: exit 0" exited 0
check "a surface in space: its size, and what is held" says '^fem/box.stl: in space, 80 x 60 x 50 mm; held: under$'
sed 's/under/left under/' "$work/fem/box.stl" >"$work/fem/blank.stl" && cp "$work/fem/box.stl" "$work/fem/a box.stl"
tissuectl new blank --shape fem/blank.stl --unit mm --held 'left under'
check "a held surface with a blank in its name: one line, before it is meshed" one_line "blank.toml: key 'geometry.fixed': 'left under': make cannot carry this name"
tissuectl new blank --shape 'fem/a box.stl' --unit mm --held under
check "a file with a blank in its name: one line" one_line "blank.toml: key 'geometry.shape': '.*a box.stl': make cannot carry this name"
check "and no study is written" absent "$work/fem/studies/blank.toml"
run make PYTHON="$PYTHON" STUDY=box mesh
check "its study is meshed" exited 0
check "its study is planned on its mesh: 24 pushes to train on" trains box = 24

# ---- held by a region: a surface that names nothing
sed 's/^solid.*/solid skin/; s/^endsolid.*/endsolid skin/' "$work/fem/box.stl" | awk '/^solid/ && n++ {next} {print}' | grep -v '^endsolid' >"$work/fem/skin.stl"
echo 'endsolid skin' >>"$work/fem/skin.stl"
tissuectl new skin --shape fem/skin.stl --unit mm --held 'below z = 0.0125'
check "a surface held by a region: exit 0" exited 0
check "a surface held by a region: it is said" says 'held: below z = 0.0125$'
run make PYTHON="$PYTHON" STUDY=skin mesh
check "its study is meshed" exited 0
cat >"$scratch/held.py" <<'PY'
import sys
import numpy as np
lines = open(sys.argv[1]).read().split("\n")
k, e = lines.index("$Nodes"), lines.index("$Elements")
x = np.array([[float(w) for w in l.split()[1:]] for l in lines[k + 2:k + 2 + int(lines[k + 1])]])
facets = np.array([[int(w) for w in l.split()[3:]] for l in lines[e + 2:e + 2 + int(lines[e + 1])] if l.split()[1] == "2"])
at = x[facets[:, 2:] - 1]
area = np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1) / 2
held = facets[:, 0] == 1
assert abs(area[held].sum() / (0.08 * 0.06 + 0.0125 * 2 * (0.08 + 0.06)) - 1) < 1e-3, area[held].sum()
assert at[held][..., 2].max() < 0.0126 and at[~held][..., 2].min() > 0.0124
PY
check "held is what lies there: the bottom, and the walls as high as that" "$PYTHON" "$scratch/held.py" "$work/results/skin/mesh.msh"
table() { # Z: of 200 by 200 mm, two facets
    printf 'solid table\n'
    for corners in '-100 -100 100 -100 100 100' '-100 -100 100 100 -100 100'; do
        printf 'facet normal 0 0 1\nouter loop\n'
        echo "$corners" | awk -v z="$1" '{ for (i = 1; i < 6; i += 2) print "vertex", $i, $(i + 1), z }'
        printf 'endloop\nendfacet\n'
    done
    printf 'endsolid table\n'
}
mkdir "$work/fem/bone" && table -2 >"$work/fem/bone/big_table.stl"
tissuectl new perch --shape fem/skin.stl --unit mm --held 'within 0.0145 of fem/bone/big_table.stl'
check "a surface held near another one: exit 0" exited 0
check "the study names that file from its own folder" grep -q '^fixed = \["within 0.0145 of ../bone/big_table.stl"\]' "$work/fem/studies/perch.toml"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "its study is meshed" exited 0
check "held is what lies so near" "$PYTHON" "$scratch/held.py" "$work/results/perch/mesh.msh"
check "every path is solved anew where that file changes" sh -c '[ "$(grep -c "cases/.*csv: .* fem/bone/big_table.stl$" "$1")" = "$(grep -c "PATH_ARGUMENTS = .* -fixed within_0.0145_of_fem/bone/big_table.stl " "$1")" ] &&
    grep -q PATH_ARGUMENTS "$1"' - "$work/results/perch/plan.mk"
table -20 >"$work/fem/bone/big_table.stl"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "another one farther away: it is meshed anew, and one line says that it holds nothing" one_line "fem/skin.stl: 'within 0.0145 of fem/bone/big_table.stl' holds nothing of its surface"
rm "$work/fem/bone/big_table.stl"
tissuectl plan --study fem/studies/perch.toml --out "$scratch/plan.mk"
check "none at all: one line names the key and the file" one_line "perch.toml:[0-9]*: key 'geometry.fixed': .*: there is no file fem/bone/big_table.stl"
sed 's|within 0.0145 of ../bone/big_table.stl|below z = 0.0125|' "$work/fem/studies/perch.toml" >"$scratch/perch.toml" && cp "$scratch/perch.toml" "$work/fem/studies/perch.toml"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "a study that does without it is planned again, though the plan of before named it" exited 0
check "and is held as it says now" "$PYTHON" "$scratch/held.py" "$work/results/perch/mesh.msh"
mkfifo "$work/fem/pipe.stl"
run timeout 20 "$TISSUECTL" new perch2 --shape fem/skin.stl --unit mm --held 'within 0.003 of fem/pipe.stl'
check "a pipe: one line, and nothing waits for it" one_line 'there is no file fem/pipe.stl'
run timeout 20 "$TISSUECTL" new perch2 --shape fem/pipe.stl --unit mm --held 'below z = 0.01'
check "a pipe as the shape: one line, and nothing waits for it" one_line 'fem/pipe.stl: is a folder, a pipe or a device, wanted a file'
tissuectl new perch2 --shape fem/bone --unit mm --held 'below z = 0.01'
check "a folder as the shape: one line" one_line 'fem/bone: is a folder, a pipe or a device, wanted a file'
for name in bone surface-7; do
    tissuectl new perch2 --shape fem/skin.stl --unit mm --held "$name"
    check "a surface '$name' of one that names none: exit 1" exited 1
    check "a surface '$name' of one that names none: its parts are listed" one_line "fem/skin.stl: has no surface '$name' to hold; it has surface-1, surface-2, surface-3, surface-4, surface-5, surface-6$"
done
check "and no study is written" absent "$work/fem/studies/perch2.toml"
tissuectl new part --shape fem/skin.stl --unit mm --held surface-6
check "a part that there is: exit 0" exited 0
tissuectl new perch2 --shape fem/skin.stl --unit mm --held 'within 0.003 of fem/none.stl'
check "none for a new study: one line names it" one_line 'fem/none.stl'
tissuectl new skin2 --shape fem/skin.stl --unit mm --held 'below z = deep'
check "a region that is none: one line says how they are written" one_line "'below z = deep' begins like a region of space and is none; regions are written, in metres: below z = 0.01, above x = 0.1, ball"
for region in 'above z = 1' 'below z = 20'; do
    tissuectl new skin2 --shape fem/skin.stl --unit mm --held "$region"
    check "$region: one line says how far the tissue reaches" one_line "fem/skin.stl: '$region' holds .* of it; in metres it reaches from (-0.04, -0.03, 0) to (0.04, 0.03, 0.05)"
done
sed 's/below z = 0.0125/above z = 1/' "$work/fem/studies/skin.toml" >"$work/fem/studies/skin2.toml"
run make PYTHON="$PYTHON" STUDY=skin2 mesh
check "a region beside the surface: one line names both" one_line "fem/skin.stl: 'above z = 1' holds nothing of its surface, which reaches from (-0.04, -0.03, 0) m to (0.04, 0.03, 0.05) m"

# ---- other files of a surface, and damaged ones
"$PYTHON" - "$work/fem/box.stl" "$work/fem" <<'PY'
import sys
points, named, name = [], {}, None
for line in open(sys.argv[1]):
    words = line.split()
    if words[0] == "solid":
        name = words[1]
    if words[0] == "vertex":
        named.setdefault(name, []).append(tuple(words[1:]))
points = sorted({p for all in named.values() for p in all})
with open(sys.argv[2] + "/box.obj", "w") as out:
    for p in points:
        print("v", *p, file=out)
    for name, corners in named.items():
        print("g", name, file=out)
        for k in range(0, len(corners), 3):
            print("f", *(points.index(p) + 1 for p in corners[k:k + 3]), file=out)
lines = open(sys.argv[2] + "/box.obj").read().split("\n")
del lines[-2]  # the last facet
with open(sys.argv[2] + "/torn.obj", "w") as out:
    print("\n".join(lines), file=out)
PY
tissuectl surface fem/box.obj --unit mm
check "a surface is told of: exit 0" exited 0
check "its triangles and its volume" says '^fem/box.obj: 12 triangles, 8 points, 80 x 60 x 50 mm, 240 ml$'
tissuectl new object --shape fem/box.obj --unit mm --held under
check "a study of an .obj: exit 0" exited 0
check "its group is held" says '^fem/box.obj: in space, 80 x 60 x 50 mm; held: under$'
run make PYTHON="$PYTHON" STUDY=object mesh
check "its study is meshed" exited 0
check "as the same surface in .stl is" "$PYTHON" -c 'import sys
of = [sorted(l.split()[3] for l in open(f).read().split("$Elements")[1].split("\n")[2:-2] if l.split()[1] == "2") for f in sys.argv[1:]]
assert of[0] == of[1] and len(of[0]) > 100, [len(o) for o in of]' "$work/results/object/mesh.msh" "$work/results/box/mesh.msh"
tissuectl new torn --shape fem/torn.obj --unit mm --held under
check "a surface with a hole: one line says what, where and what to do" one_line '^tissuectl: fem/torn.obj: cannot be filled: 1 hole, perimeter [0-9]* mm; at (.*); .tissuectl surface. tells all of it'
check "and no study is written" absent "$work/fem/studies/torn.toml"
tissuectl surface fem/torn.obj --unit mm --json; grep '^{' "$said" >"$said.json"
check "it is told of: exit 3" exited 3
run sh -c '"$1" surface fem/torn.obj --unit mm --json >/dev/full' - "$TISSUECTL"
check "where standard output takes nothing: exit 1, not 3" exited 1
check "where standard output takes nothing: a line says so" says '^tissuectl: standard output: cannot write'
run sh -c '"$1" surface fem/torn.obj --unit mm --json >&-' - "$TISSUECTL"
check "where standard output is closed: exit 1, not 3" exited 1
run sh -c '"$1" surface fem/torn.obj --unit mm --json --repair fem/closed.stl >&-' - "$TISSUECTL"
check "where standard output is closed: what is written has nothing of what is printed" sh -c '[ -s "$1" ] && ! grep -qa "\"given\"" "$1"' - "$work/fem/closed.stl"
check "in JSON, with the place" "$PYTHON" -c 'import json, sys
r = json.load(open(sys.argv[1]))
assert not r["usable"] and r["faults"]["holes"]["count"] == 1 and len(r["faults"]["holes"]["first"][0]) == 3 and r["faults"]["holes"]["largest_m"] > 0.1, r' "$said.json"
tissuectl surface fem/torn.obj --unit mm --repair fem/mended.stl --closes 0.2
check "it is repaired: exit 0" exited 0
check "and said how far it lies from the given one" says 'wrapped about it at 10 mm, holes and gaps narrower than 200 mm closed: [0-9.]* mm from it in the median, [0-9.]* mm at most'
tissuectl new mended --shape fem/mended.stl --unit mm --held 'below z = 0.01'
check "a study of what was repaired" exited 0
run make PYTHON="$PYTHON" STUDY=mended mesh
check "is meshed" exited 0
tissuectl surface fem/box.geo
check "another file: one line" one_line "fem/box.geo: is not a surface's file, which ends in .stl, .obj"
tissuectl surface fem/torn.obj --unit mm --repair fem/mended.obj
check "another ending: one line" one_line "fem/mended.obj: what is repaired is written as .stl"
finish
