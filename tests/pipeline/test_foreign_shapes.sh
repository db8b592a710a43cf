#!/bin/sh
# Untrusted files are never executed: a script with the ending .msh, gmsh options files beside a mesh or in the home
# folder, a .geo that the study does not trust. Nothing is written through a planted link. Each script would create a
# file `ran`.
. "$(dirname "$0")/common"
make_copy
ran=$scratch/ran
script="SystemCall \"touch '$ran'\";"
not_run() { [ ! -e "$ran" ] || { echo "the script was run"; rm "$ran"; return 1; }; }
study=fem/studies/foreign.toml
cat >"$work/$study" <<'TOML'
based_on = "organ3"

[geometry]
shape = "foreign.msh"
unit_m = 0.001
fixed = ["bed"]

[springs]
spacing_m = 0.008
TOML
shapes=$work/fem/studies
cat >"$scratch/cube.geo" <<'GEO'
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 60, 60, 60};
Physical Surface("bed") = {5};
Physical Volume("tissue") = {1};
GEO
gmsh -v 1 -3 -clmin 20 -clmax 20 -format msh41 "$scratch/cube.geo" -o "$scratch/cube.msh" >/dev/null 2>&1
gmsh -v 1 -2 -clmin 30 -clmax 30 -save_all -format stl "$scratch/cube.geo" -o "$scratch/cube.stl" >/dev/null 2>&1
make_foreign() { run make PYTHON="$PYTHON" STUDY=foreign mesh; }
surface_of() { # SHAPE: meshes its surface, as before a load path
    run env TISSUECTL=build/release/tissuectl scripts/solve_path results/foreign one -shape "$1" -unit_m 0.001 -fixed bed \
        -springs none.msh -size_near 0.005 -size_far 0.02 -contact_x 0.03 -contact_y 0.03 -contact_z 0.06 -disc_radius 0.007
}
R=$work/results/foreign

cp "$scratch/cube.msh" "$shapes/foreign.msh"
make_foreign
check "a mesh is accepted" exited 0

(printf '$Comments\nby a scanner\n$EndComments\n' && cat "$scratch/cube.msh") >"$shapes/foreign.msh"
make_foreign
check "a mesh that begins with comments is accepted" exited 0

refused_unrun() { # SENTENCE
    make_foreign
    check "$1: make fails" failed
    check "$1: one line states the cause" one_line "fem/studies/foreign.msh: is not a gmsh mesh"
    check "$1: no script is run" not_run
    surface_of fem/studies/foreign.msh
    check "$1, before a load path: one line states the cause" one_line "fem/studies/foreign.msh: is not a gmsh mesh"
    check "$1, before a load path: no script is run" not_run
}
echo "$script" >"$shapes/foreign.msh"
refused_unrun "a script with the ending .msh"
(echo " $script" && cat "$scratch/cube.msh") >"$shapes/foreign.msh"
refused_unrun "a script before a mesh"
(printf '\n' && cat "$scratch/cube.msh" && echo "$script") >"$shapes/foreign.msh"
refused_unrun "a mesh after an empty line, followed by a script"
printf '$N\000OD\n%s\n' "$script" >"$shapes/foreign.msh"
refused_unrun "a script after a header with a null byte"
printf '$MeshForma\n%s\n' "$script" >"$shapes/foreign.msh"
refused_unrun "a script after a header similar to a mesh's"
(cat "$scratch/cube.msh" && echo "$script") >"$shapes/foreign.msh"
make_foreign
check "a script after a complete mesh is not run" not_run
for first in MeshFormat Comments CommentsX 'Comments\nno mesh\n$EndComments'; do
    what="a script after \$$(printf "$first" | tr '\n' ' ')"
    printf "\$$first\\n%s\\n" "$script" >"$shapes/foreign.msh"
    make_foreign
    check "$what: make fails" failed
    check "$what is not run" not_run
done

# ---- gmsh options files
cp "$scratch/cube.msh" "$shapes/foreign.msh"
touch "$shapes/foreign.msh"
for option_file in foreign.msh.opt .gmshrc .gmsh-options; do
    echo "$script" >"$shapes/$option_file"
    echo "$script" >"$work/$option_file"
    touch "$shapes/foreign.msh"
    HOME=$shapes make_foreign
    check "$option_file: the mesh is made" exited 0
    check "$option_file beside the mesh, in the home folder and in the current one is not run" not_run
    surface_of fem/studies/foreign.msh
    check "$option_file is not run before a load path" not_run
    rm "$shapes/$option_file" "$work/$option_file"
done
echo "$script" >"$work/fem/fill3.geo.opt"
surface_of fem/studies/foreign.msh
check "an options file beside a .geo of the project is refused" one_line "fem/fill3.geo: gmsh would run fem/fill3.geo.opt"
rm "$work/fem/fill3.geo.opt"

# ---- .stl files are not read by gmsh
sed -i 's/foreign.msh/foreign.stl/; s/"bed"/"surface-1"/' "$work/$study"
printf '\n[lattice]\nsize_m = 0.02\n' >>"$work/$study"
cp "$scratch/cube.stl" "$shapes/foreign.stl"
echo "$script" >"$shapes/foreign.stl.opt"
make_foreign
check "an .stl with an options file: the mesh is made" exited 0
check "an .stl with an options file: the options are not run" not_run
rm "$shapes/foreign.stl.opt"
echo "$script" >"$shapes/foreign.stl"
make_foreign
check "a script with the ending .stl: one line states the cause" one_line "fem/studies/foreign.stl: is not an .stl"
check "a script with the ending .stl is not run" not_run
printf 'solid \033]0;title\007\nfacet normal 0 0 1\n\033[31mouter\nendsolid\n' >"$shapes/foreign.stl"
make_foreign
check "control bytes of an .stl are not printed" sh -c '! LC_ALL=C grep -q "$(printf "[\033\007]")" "$0" && grep -q "foreign.stl:3: is not .outer loop" "$0"' "$said"

# ---- a .geo is run only if the study trusts it
cp "$scratch/cube.geo" "$shapes/foreign.geo"
echo "$script" >>"$shapes/foreign.geo"
sed -i 's/foreign.stl/foreign.geo/; s/"surface-1"/"bed"/' "$work/$study"
make_foreign
check "a .geo that the study does not trust: one line names the key" one_line "foreign.toml:[0-9]*: key 'geometry.shape': fem/studies/foreign.geo is a program.*trust_geo = true"
check "a .geo that the study does not trust is not run, although the base study trusts its own" not_run
tissuectl shape --study $study --mesh "$scratch/cube.msh" --out "$scratch/out.msh"
check "tissuectl shape refuses a study with an untrusted .geo" failed
sed -i 's/^shape = .*/&\ntrust_geo = true/' "$work/$study"
echo "$script" >"$shapes/foreign.geo.opt"
make_foreign
check "an options file beside a trusted .geo: one line names it" one_line "fem/studies/foreign.geo: gmsh would run fem/studies/foreign.geo.opt"
check "an options file beside a trusted .geo is not run" not_run
rm "$shapes/foreign.geo.opt"
make_foreign
check "a .geo that the study trusts is run" sh -c '[ "$2" = 0 ] && [ -e "$1" ]' sh "$ran" "$status"
rm -f "$ran"

# ---- planted links
# Logs and locks have predictable names; other files are made in folders with random names (io/beside.h). Written
# through a link, a log would truncate `precious`, and a lock or counter would create a missing file.
echo precious >"$scratch/precious"
touch "$shapes/foreign.geo"
ln -sf "$scratch/precious" "$R/mesh.msh.log"
make_foreign
check "gmsh's log is not written through a link" grep -qx precious "$scratch/precious"
echo precious >"$scratch/precious"
ln -sf "$scratch/precious" "$R/cases/one.log"
ln -sf "$scratch/by-surface" "$R/.surface"
surface_of fem/studies/foreign.geo
check "a load path's log is not written through a link" grep -qx precious "$scratch/precious"
check "the lock of a surface is not made through a link" absent "$scratch/by-surface"
check "the surface is made despite planted links" exist "$R/surface-foreign.geo-0.005-0.001.msh"
mkdir -p "$work/results/tiny/cases"
ln -sf "$scratch/by-count" "$work/results/tiny/cases/.counted"
run make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "a load path is solved despite a planted counter" exited 0
check "the counter of load paths is not made through a link" absent "$scratch/by-count"

# ---- VTK files: scripts/vtk_surface converts them, and all other programs refuse them
tissuectl surface fem/organ.vtp
check "surface refuses a .vtp: one line names the converting program" one_line '^tissuectl: fem/organ.vtp: is a VTK surface; convert it first: scripts/vtk_surface fem/organ.vtp fem/organ.obj$'
tissuectl new foreign2 --shape fem/organ.VTK --unit mm --held part_7
check "new refuses a VTK file: one line names the converting program" one_line '^tissuectl: fem/organ.VTK: is a VTK surface; convert it first: scripts/vtk_surface fem/organ.VTK fem/organ.obj$'
tissuectl new foreign2 --shape "$scratch/cube.stl" --unit mm --held 'within 0.003 of spine.vtp'
check "new refuses a fixed part near a VTK file" one_line '^tissuectl: spine.vtp: is a VTK surface; convert it first'
sed 's/foreign.geo/organ.vtu/' "$work/$study" >"$shapes/grid.toml"
tissuectl plan --study fem/studies/grid.toml --out "$scratch/plan.mk"
check "a study with a .vtu: one line states the cause and the remedy" one_line "grid.toml:[0-9]*: key 'geometry.shape': fem/studies/organ.vtu: is an unstructured grid: .* scripts/vtk_surface fem/studies/organ.vtp fem/studies/organ.obj; or give its tetrahedra as a .msh"

run "$PYTHON" -S scripts/vtk_surface "$study" organ.stl
check "vtk_surface writes only .obj: one line states the cause" one_line '^vtk_surface: organ.stl: the output is an .obj file'
readers=$PYTHON
[ -z "${TISSUE_READERS-}" ] || readers=$TISSUE_READERS  # a Python that is named must have VTK
"$readers" -c 'import vtkmodules' 2>/dev/null || readers=$root/build/venv/bin/python
if [ -n "${TISSUE_READERS-}" ] || "$readers" -c 'import vtkmodules' 2>/dev/null; then
    check "VTK writes a box" "$readers" "$root/tests/pipeline/vtk_boxes.py" "$work/fem"
    converts() { run "$readers" scripts/vtk_surface "$@"; }
    for box in box.vtp box.vtk; do
        rm -f "$work/fem/box.obj"
        converts fem/$box fem/box.obj --groups part
        check "$box is converted: exit 0" exited 0
        check "$box: its size and groups are printed" says '^fem/box.obj: 12 triangles, 8 points; groups: part_7, part_-1$'
        check "$box: coordinates are converted in double precision" grep -qx 'v 0.1 0.2 0.30000000000000004' "$work/fem/box.obj"
        tissuectl surface fem/box.obj --unit mm
        check "$box: the converted surface is closed" says '^fem/box.obj: 12 triangles, 8 points, 80 x 60 x 50 mm, 240 ml$'
        rm -f "$shapes/box.toml"
        tissuectl new box --shape fem/box.obj --unit mm --held part_7
        check "$box: new fixes one of its groups" says '^fem/box.obj: in space, 80 x 60 x 50 mm; fixed: part_7$'
    done
    converts fem/box.vtp fem/box.obj --groups label
    check "texts become groups, with names that make accepts" says '; groups: bed, all_the_rest$'
    converts fem/triangles.vtp fem/box.obj --groups part
    check "triangles and strips get the group of their cell" sh -c \
        'grep -q "; groups: part_7, part_-1, part_5$" "$1" && [ "$(sed -n "/^g part_5/,\$p" "$2" | grep -c ^f)$(sed -n "/^g part_7/,/^g part_-/p" "$2" | grep -c ^f)" = 22 ]' - "$said" "$work/fem/box.obj"
    rm -f "$work/fem/box.obj" "$ran"
    echo "$script" >"$work/fem/script.vtk"
    while IFS='|' read -r file options words; do
        # shellcheck disable=SC2086  # options are words
        converts "fem/$file" fem/box.obj $options
        check "$file $options: one line states the cause" one_line "^vtk_surface: fem/$file: $words"
    done <<'REFUSALS'
points.vtp||has no polygons: save the surface itself
grid.vtp||is an unstructured grid, not a surface: save its surface as .vtp (ParaView: Extract Surface)
grid.vtk||is an unstructured grid, not a surface
grid.vtu||is an unstructured grid, not a surface
cut.vtp||is truncated or damaged, save it again; VTK: Error reading
cut.vtk||is truncated or damaged, save it again; VTK: Error reading
huge.vtp||VTK failed while it read the file
beyond.vtk||cell 4 names a point that the file does not have; it has 9 points; save it again
again.vtk||cell 0 repeats a corner: remove that cell
words.vtk||is truncated or damaged, save it again; VTK: an error whose text is not UTF-8
nan.vtp||point 7 of cell [0-9]* has a coordinate that is not a finite number
box.vtp|--groups pat|has no cell data 'pat'; --groups takes one of: part, label, share$
box.vtp|--groups share|cell data 'share' is not an integer or a text of every cell
script.vtk||is not a VTK file of PolyData
REFUSALS
    check "refused VTK files write no .obj and run no script" sh -c '[ ! -e "$1" ] && [ ! -e "$2" ]' - "$work/fem/box.obj" "$ran"
    ln -s "$scratch/precious" "$work/fem/linked.obj"
    echo precious >"$scratch/precious"
    converts fem/box.vtp fem/linked.obj
    check "vtk_surface does not write through a link" grep -qx precious "$scratch/precious"
    run "$PYTHON" -S scripts/vtk_surface fem/box.vtp fem/box.obj
    check "vtk_surface without VTK: one line names the package" one_line 'has no VTK, which reads the file: apt-get install python3-vtk9, or scripts/venv (PyPI: vtk)$'
else
    skip "VTK surfaces are converted" "python3-vtk9 is not installed, nor has scripts/venv installed vtk"
fi

# ---- variables of the environment do not replace those of the plan
run env SHAPE=fem/organ.geo SOLID=none PATHS=none FIGURES=none make PYTHON="$PYTHON" STUDY=tiny mesh
check "with SHAPE and SOLID in the environment the block is meshed" exist "$work/results/tiny/mesh.msh"
finish
