#!/bin/sh
# tissuectl new: writes a study for a shape's file, which runs as written; its lists, choices and refusals.
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
check "new without --held: exit 1" exited 1
check "new without --held: one line lists the named curves" one_line '^tissuectl: fem/loaf.geo: --held must name the curves that are fixed; its names: board, crust$'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --held board
check "a shape of 82 m: one line asks for the unit" one_line 'fem/loaf.geo: is 82 m long; is this in millimetres? give its unit as --unit mm, cm, m or inch'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held table
check "an unknown curve: one line lists the known ones" one_line "has no curve 'table' to fix; its names: board, crust"
tissuectl new loaf --shape fem/none.geo --unit mm --held table
check "a missing shape: one line names it" one_line 'fem/none.geo'
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit km --held board
check "an unknown unit: exit 2" exited 2
tissuectl new ../loaf --shape fem/loaf.geo --trust-geo --unit mm --held board
check "a study's name with a slash: one line states the cause" one_line "a study's name may have letters"
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board --preset bread
check "an unknown material: one line lists the known ones" one_line "'bread' is not a material; there are: brain, liver, muscle"
check "refusals of new write no study" absent "$work/fem/studies/loaf.toml" "$work/fem/studies/../loaf.toml"

tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board --preset brain
check "new writes a study: exit 0" exited 0
check "new prints size and fixed part of the shape" says '^fem/loaf.geo: in the plane, 82 x 52 mm; fixed: board$'
check "new prints the chosen spring length and its reason" says '^springs 8 mm long (lattice.size_m), an eighth of its mean size$'
check "new prints the command that runs the study" says '^fem/studies/loaf.toml is written; make all STUDY=loaf runs it$'
check "every length in the study has a comment" sh -c '! grep -n "^[a-z_]*_m = [^#]*$" "$1"' - "$work/fem/studies/loaf.toml"
cp -p "$work/fem/studies/loaf.toml" "$scratch/loaf.toml"
tissuectl new loaf --shape fem/loaf.geo --trust-geo --unit mm --held board
check "an existing study: exit 1" exited 1
check "an existing study: one line states the cause" one_line '^tissuectl: fem/studies/loaf.toml: exists'
check "an existing study is unchanged" cmp "$scratch/loaf.toml" "$work/fem/studies/loaf.toml"

# as written, with coarser springs, fewer contacts and refine = 4
sed -i -e 's/^size_m = .*/size_m = 0.014/' -e 's/^spacing_m = .*/spacing_m = 0.03/' -e 's/^angles_deg = .*/angles_deg = [0]/' -e 's/^count = .*/count = 2/' \
    -e 's/^refine = .*/refine = 4/' "$work/fem/studies/loaf.toml"
run make PYTHON="$PYTHON" STUDY=loaf eval -j2
check "make eval of the new study succeeds" exited 0
check "make eval of the new study writes an evaluation" exist "$work/results/loaf/eval.json"
cp "$scratch/loaf.toml" "$work/fem/studies/whole.toml"
run make PYTHON="$PYTHON" STUDY=whole mesh
check "make mesh of the study as written succeeds" exited 0
trains() { [ "$(grep -c '^train ' "$work/results/$1/plan/collect")" "$2" "$3" ] || { cat "$work/results/$1/plan/collect"; return 1; }; }
check "the study as written has at least 20 training load paths" trains whole -ge 20

# ---- the same outline as a mesh, and a surface in space
(cd "$work" && gmsh -v 0 -2 -clmin 10 -clmax 10 -format msh41 fem/loaf.geo -o fem/loaf.msh) >"$scratch/log" 2>&1
tissuectl new mesh --shape fem/loaf.msh --unit mm --held board
check "a mesh in MSH 4.1: exit 0" exited 0
check "a mesh in MSH 4.1: its edges are the springs" says "^springs: the edges of its [0-9]* nodes' mesh"
run make PYTHON="$PYTHON" STUDY=mesh mesh
check "make mesh of the mesh's study succeeds" exited 0
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
check "new of a surface with two solids: one line lists them" one_line '^tissuectl: fem/box.stl: --held must name the surfaces that are fixed; its names: \(free, under\|under, free\); or give a region in m: --held .below z = 0.01.$'
tissuectl new box --shape fem/box.stl --unit mm --held under
check "new of a surface in space: exit 0" exited 0
check "new of a surface in space prints its size and fixed part" says '^fem/box.stl: in space, 80 x 60 x 50 mm; fixed: under$'
sed 's/under/left under/' "$work/fem/box.stl" >"$work/fem/blank.stl" && cp "$work/fem/box.stl" "$work/fem/a box.stl"
tissuectl new blank --shape fem/blank.stl --unit mm --held 'left under'
check "a fixed surface with a blank in its name: one line states the cause" one_line "blank.toml: key 'geometry.fixed': 'left under': make does not support this name"
tissuectl new blank --shape 'fem/a box.stl' --unit mm --held under
check "a shape's file with a blank in its name: one line states the cause" one_line "blank.toml: key 'geometry.shape': '.*a box.stl': make does not support this name"
check "names with a blank: no study is written" absent "$work/fem/studies/blank.toml"
run make PYTHON="$PYTHON" STUDY=box mesh
check "make mesh of the surface's study succeeds" exited 0
check "the study of the surface has 24 training load paths" trains box = 24

# ---- fixed by a region: a surface without names
sed 's/^solid.*/solid skin/; s/^endsolid.*/endsolid skin/' "$work/fem/box.stl" | awk '/^solid/ && n++ {next} {print}' | grep -v '^endsolid' >"$work/fem/skin.stl"
echo 'endsolid skin' >>"$work/fem/skin.stl"
tissuectl new skin --shape fem/skin.stl --unit mm --held 'below z = 0.0125'
check "new of a surface fixed by a region: exit 0" exited 0
check "new of a surface fixed by a region prints the region" says 'fixed: below z = 0.0125$'
run make PYTHON="$PYTHON" STUDY=skin mesh
check "make mesh of the study fixed by a region succeeds" exited 0
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
check "the fixed part is the bottom and the walls below the region's limit" "$PYTHON" "$scratch/held.py" "$work/results/skin/mesh.msh"
table() { # Z: an STL of 200 x 200 mm with two facets
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
check "new of a surface fixed near another surface: exit 0" exited 0
check "the study contains the other surface's path relative to its own folder" grep -q '^fixed = \["within 0.0145 of ../bone/big_table.stl"\]' "$work/fem/studies/perch.toml"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "make mesh of the study fixed near another surface succeeds" exited 0
check "the fixed part is the surface within that distance" "$PYTHON" "$scratch/held.py" "$work/results/perch/mesh.msh"
check "every load path depends on the other surface's file" sh -c '[ "$(grep -c "cases/.*csv: .* fem/bone/big_table.stl$" "$1")" = "$(grep -c "PATH_ARGUMENTS = .* -fixed within_0.0145_of_fem/bone/big_table.stl " "$1")" ] &&
    grep -q PATH_ARGUMENTS "$1"' - "$work/results/perch/plan.mk"
table -20 >"$work/fem/bone/big_table.stl"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "the other surface too far away: make mesh runs again, and one line states that nothing is fixed" one_line "fem/skin.stl: 'within 0.0145 of fem/bone/big_table.stl' fixes no part of its surface"
rm "$work/fem/bone/big_table.stl"
tissuectl plan --study fem/studies/perch.toml --out "$scratch/plan.mk"
check "the other surface missing: one line names the key and the file" one_line "perch.toml:[0-9]*: key 'geometry.fixed': .*: there is no file fem/bone/big_table.stl"
sed 's|within 0.0145 of ../bone/big_table.stl|below z = 0.0125|' "$work/fem/studies/perch.toml" >"$scratch/perch.toml" && cp "$scratch/perch.toml" "$work/fem/studies/perch.toml"
run make PYTHON="$PYTHON" STUDY=perch mesh
check "a study without the other surface is planned again, although the earlier plan names it" exited 0
check "the fixed part is then that of the study's new region" "$PYTHON" "$scratch/held.py" "$work/results/perch/mesh.msh"
mkfifo "$work/fem/pipe.stl"
run timeout 20 "$TISSUECTL" new perch2 --shape fem/skin.stl --unit mm --held 'within 0.003 of fem/pipe.stl'
check "a pipe as the other surface: one line states the cause, without waiting" one_line 'there is no file fem/pipe.stl'
run timeout 20 "$TISSUECTL" new perch2 --shape fem/pipe.stl --unit mm --held 'below z = 0.01'
check "a pipe as the shape: one line states the cause, without waiting" one_line 'fem/pipe.stl: is a folder, a pipe or a device; give a regular file'
tissuectl new perch2 --shape fem/bone --unit mm --held 'below z = 0.01'
check "a folder as the shape: one line states the cause" one_line 'fem/bone: is a folder, a pipe or a device; give a regular file'
for name in bone surface-7; do
    tissuectl new perch2 --shape fem/skin.stl --unit mm --held "$name"
    check "an unknown surface '$name' of a shape without names: exit 1" exited 1
    check "an unknown surface '$name' of a shape without names: one line lists its parts" one_line "fem/skin.stl: has no surface '$name' to fix; its surfaces: surface-1, surface-2, surface-3, surface-4, surface-5, surface-6$"
done
check "refused fixed parts: no study is written" absent "$work/fem/studies/perch2.toml"
tissuectl new part --shape fem/skin.stl --unit mm --held surface-6
check "a part of a shape without names is accepted: exit 0" exited 0
tissuectl new perch2 --shape fem/skin.stl --unit mm --held 'within 0.003 of fem/none.stl'
check "a missing other surface for a new study: one line names it" one_line 'fem/none.stl'
tissuectl new skin2 --shape fem/skin.stl --unit mm --held 'below z = deep'
check "an invalid region: one line states how regions are written" one_line "'below z = deep' begins like a region of space but is not one; write regions in metres: below z = 0.01, above x = 0.1, ball"
for region in 'above z = 1' 'below z = 20'; do
    tissuectl new skin2 --shape fem/skin.stl --unit mm --held "$region"
    check "region $region: one line states the extent of the tissue" one_line "fem/skin.stl: '$region' fixes .* of it; in metres it extends from (-0.04, -0.03, 0) to (0.04, 0.03, 0.05)"
done
sed 's/below z = 0.0125/above z = 1/' "$work/fem/studies/skin.toml" >"$work/fem/studies/skin2.toml"
run make PYTHON="$PYTHON" STUDY=skin2 mesh
check "a region off the surface: one line names the region and the surface's extent" one_line "fem/skin.stl: 'above z = 1' fixes no part of its surface, which extends from (-0.04, -0.03, 0) m to (0.04, 0.03, 0.05) m"

# ---- other surface formats, and damaged files
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
check "surface of an .obj: exit 0" exited 0
check "surface prints triangles, points, size and volume" says '^fem/box.obj: 12 triangles, 8 points, 80 x 60 x 50 mm, 240 ml$'
tissuectl new object --shape fem/box.obj --unit mm --held under
check "new of an .obj: exit 0" exited 0
check "new fixes a group of an .obj" says '^fem/box.obj: in space, 80 x 60 x 50 mm; fixed: under$'
run make PYTHON="$PYTHON" STUDY=object mesh
check "make mesh of the study of an .obj succeeds" exited 0
check "the mesh of an .obj has the labels of the same surface in .stl" "$PYTHON" -c 'import sys
of = [sorted(l.split()[3] for l in open(f).read().split("$Elements")[1].split("\n")[2:-2] if l.split()[1] == "2") for f in sys.argv[1:]]
assert of[0] == of[1] and len(of[0]) > 100, [len(o) for o in of]' "$work/results/object/mesh.msh" "$work/results/box/mesh.msh"
tissuectl new torn --shape fem/torn.obj --unit mm --held under
check "new of a surface with a hole: one line states cause, place and remedy" one_line '^tissuectl: fem/torn.obj: cannot be filled: 1 hole, perimeter [0-9]* mm; at (.*); .tissuectl surface. reports all faults'
check "new of a surface with a hole: no study is written" absent "$work/fem/studies/torn.toml"
tissuectl surface fem/torn.obj --unit mm --json; grep '^{' "$said" >"$said.json"
check "surface of a surface with a hole: exit 3" exited 3
run sh -c '"$1" surface fem/torn.obj --unit mm --json >/dev/full' - "$TISSUECTL"
check "surface with standard output on a full disk: exit 1" exited 1
check "surface with standard output on a full disk: a line states the cause" says '^tissuectl: standard output: cannot write'
run sh -c '"$1" surface fem/torn.obj --unit mm --json >&-' - "$TISSUECTL"
check "surface with closed standard output: exit 1" exited 1
run sh -c '"$1" surface fem/torn.obj --unit mm --json --repair fem/closed.stl >&-' - "$TISSUECTL"
check "surface with closed standard output: the repaired file contains no printed text" sh -c '[ -s "$1" ] && ! grep -qa "\"given\"" "$1"' - "$work/fem/closed.stl"
check "surface --json of a surface with a hole: not usable, one hole with its place and size" "$PYTHON" -c 'import json, sys
r = json.load(open(sys.argv[1]))
assert not r["usable"] and r["faults"]["holes"]["count"] == 1 and len(r["faults"]["holes"]["first"][0]) == 3 and r["faults"]["holes"]["largest_m"] > 0.1, r' "$said.json"
tissuectl surface fem/torn.obj --unit mm --repair fem/mended.stl --closes 0.2
check "surface --repair of a surface with a hole: exit 0" exited 0
check "surface --repair prints the distance from the given surface" says 'wrapped around the input at 10 mm, holes and gaps narrower than 200 mm closed; distance from the input: median [0-9.]* mm, largest [0-9.]* mm'
tissuectl new mended --shape fem/mended.stl --unit mm --held 'below z = 0.01'
check "new of the repaired surface: exit 0" exited 0
run make PYTHON="$PYTHON" STUDY=mended mesh
check "make mesh of the repaired surface succeeds" exited 0
tissuectl surface fem/box.geo
check "surface of a .geo: one line states the cause" one_line "fem/box.geo: is not a surface file; its name must end in .stl, .obj"
tissuectl surface fem/torn.obj --unit mm --repair fem/mended.obj
check "surface --repair to an .obj: one line states the cause" one_line "fem/mended.obj: the repaired surface is an .stl file"
finish
