#!/bin/sh
# Shapes in another unit than in the study, far from the origin, or with far too many points: reported within seconds,
# before a mesher is started that would not end.
. "$(dirname "$0")/common"
make_copy
sed -e 's/based_on = .*/based_on = "organ"/' -e '/^\[/,$d' "$work/fem/studies/tiny.toml" >"$work/fem/studies/plane.toml"
printf '[geometry]\nunit_m = 1\n' >>"$work/fem/studies/plane.toml"
printf 'based_on = "organ3"\n[geometry]\nunit_m = 1\n' >"$work/fem/studies/space.toml"
for study in plane space; do
    run timeout 120 make PYTHON="$PYTHON" STUDY=$study mesh
    check "$study, in millimetres with unit_m = 1: make fails, in seconds" exited 2
    check "$study, in millimetres with unit_m = 1: one line asks about the unit" one_line "$study.toml: key 'geometry.unit_m': fem/organ.*geo is .* m long with geometry.unit_m = 1.*in millimetres?"
done
sed 's/Point(\([0-9]*\)) = {\([0-9]*\)/Point(\1) = {2000000 + \2/g' "$work/fem/organ.geo" >"$work/fem/far.geo"
sed -i 's|\[geometry\]|[geometry]\nshape = "../far.geo"\ntrust_geo = true|; s/unit_m = 1/unit_m = 0.001/; $a [lattice]\nsize_m = 0.01' "$work/fem/studies/plane.toml"
run timeout 120 make PYTHON="$PYTHON" STUDY=plane mesh
check "a shape two kilometres from the origin: one line states the cause" one_line "plane.toml: key 'geometry.shape': fem/far.geo .* 2e+03 m from the origin"
"$PYTHON" - >"$work/fem/fine.geo" <<'PY'
import math
n = 600
print("\n".join(f"Point({i + 1}) = {{{50 + 40 * math.cos(2 * math.pi * i / n):.6f}, {40 + 30 * math.sin(2 * math.pi * i / n):.6f}, 0}};" for i in range(n)))
print("\n".join(f"Line({i + 1}) = {{{i + 1}, {(i + 1) % n + 1}}};" for i in range(n)))
print(f"Curve Loop(1) = {{1:{n}}}; Plane Surface(1) = {{1}}; Physical Curve(\"bed\") = {{{3 * n // 4 - 80}:{3 * n // 4 + 80}}}; Physical Surface(\"tissue\") = {{1}};")
PY
sed -i 's|far.geo|fine.geo|' "$work/fem/studies/plane.toml"
rm -rf "$work/results/plane"
run make PYTHON="$PYTHON" STUDY=plane mesh
check "a contour much finer than lattice.size_m is meshed" exited 0
check "a contour much finer than lattice.size_m: a warning states the number of nodes" says "^shape: warning: fem/fine.geo has an outline much finer than lattice.size_m = 0.01 m: [0-9]* nodes"
cat >"$work/fem/honest.geo" <<'GEO'
Point(1) = {0, 0, 0};  Point(2) = {100, 0, 0};  Point(3) = {100, 60, 0};  Point(4) = {0, 60, 0};  Point(5) = {50, -19940, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Circle(3) = {3, 5, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Periodic Curve {4} = {-2};
Physical Curve("bed") = {1};
Physical Surface("tissue") = {1};
GEO
sed -i 's|fine.geo|honest.geo|' "$work/fem/studies/plane.toml"
rm -rf "$work/results/plane"
run make PYTHON="$PYTHON" STUDY=plane mesh
check "an outline with an arc of 20 m radius and curves that are copies of each other is meshed" exited 0
finish
