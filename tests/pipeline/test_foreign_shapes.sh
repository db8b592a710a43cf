#!/bin/sh
# Files of strangers are never executed: a script called .msh, options files beside a mesh or in the home folder, a .geo that the
# study does not trust; and nothing is written through a planted link. Every one of them would leave a file `ran`.
. "$(dirname "$0")/common"
make_copy
ran=$scratch/ran
script="SystemCall \"touch '$ran'\";"
not_run() { [ ! -e "$ran" ] || { echo "it was run"; rm "$ran"; return 1; }; }
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
surface_of() { # SHAPE: as a path asks for it
    run env TISSUECTL=build/release/tissuectl scripts/solve_path results/foreign one -shape "$1" -unit_m 0.001 -fixed bed \
        -springs none.msh -size_near 0.005 -size_far 0.02 -contact_x 0.03 -contact_y 0.03 -contact_z 0.06 -disc_radius 0.007
}
R=$work/results/foreign

cp "$scratch/cube.msh" "$shapes/foreign.msh"
make_foreign
check "a mesh is taken" exited 0

(printf '$Comments\nby a scanner\n$EndComments\n' && cat "$scratch/cube.msh") >"$shapes/foreign.msh"
make_foreign
check "a mesh that begins with comments is taken" exited 0

refused_unrun() { # SENTENCE
    make_foreign
    check "$1: make fails" failed
    check "$1: one line says so" one_line "fem/studies/foreign.msh: is not a gmsh mesh"
    check "$1: nothing was run" not_run
    surface_of fem/studies/foreign.msh
    check "$1, before a path: it fails, with one line" one_line "fem/studies/foreign.msh: is not a gmsh mesh"
    check "$1, before a path: nothing was run" not_run
}
echo "$script" >"$shapes/foreign.msh"
refused_unrun "a script that is called .msh"
(echo " $script" && cat "$scratch/cube.msh") >"$shapes/foreign.msh"
refused_unrun "a script before a mesh"
(printf '\n' && cat "$scratch/cube.msh" && echo "$script") >"$shapes/foreign.msh"
refused_unrun "a mesh after an empty line, and a script behind it"
printf '$N\000OD\n%s\n' "$script" >"$shapes/foreign.msh"
refused_unrun "a script behind a beginning with a null byte"
printf '$MeshForma\n%s\n' "$script" >"$shapes/foreign.msh"
refused_unrun "a script behind a beginning that is nearly a mesh's"
(cat "$scratch/cube.msh" && echo "$script") >"$shapes/foreign.msh"
make_foreign
check "a script behind a whole mesh is not run" not_run
for first in MeshFormat Comments CommentsX 'Comments\nno mesh\n$EndComments'; do
    what="a script behind \$$(printf "$first" | tr '\n' ' ')"
    printf "\$$first\\n%s\\n" "$script" >"$shapes/foreign.msh"
    make_foreign
    check "$what: make fails" failed
    check "$what is not run" not_run
done

# ---- options files
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
    check "$option_file is not run before a path either" not_run
    rm "$shapes/$option_file" "$work/$option_file"
done
echo "$script" >"$work/fem/fill3.geo.opt"
surface_of fem/studies/foreign.msh
check "an options file beside one of our own .geo is refused" one_line "fem/fill3.geo: gmsh would run fem/fill3.geo.opt"
rm "$work/fem/fill3.geo.opt"

# ---- an .stl does not reach gmsh
sed -i 's/foreign.msh/foreign.stl/; s/"bed"/"surface-1"/' "$work/$study"
printf '\n[lattice]\nsize_m = 0.02\n' >>"$work/$study"
cp "$scratch/cube.stl" "$shapes/foreign.stl"
echo "$script" >"$shapes/foreign.stl.opt"
make_foreign
check "an .stl with options beside it: the mesh is made" exited 0
check "an .stl with options beside it: they are not run" not_run
rm "$shapes/foreign.stl.opt"
echo "$script" >"$shapes/foreign.stl"
make_foreign
check "a script that is called .stl: one line" one_line "fem/studies/foreign.stl: is no .stl"
check "a script that is called .stl is not run" not_run
printf 'solid \033]0;title\007\nfacet normal 0 0 1\n\033[31mouter\nendsolid\n' >"$shapes/foreign.stl"
make_foreign
check "control bytes of an .stl do not reach the terminal" sh -c '! LC_ALL=C grep -q "$(printf "[\033\007]")" "$0" && grep -q "foreign.stl:3: is not .outer loop" "$0"' "$said"

# ---- a .geo only where the study trusts it
cp "$scratch/cube.geo" "$shapes/foreign.geo"
echo "$script" >>"$shapes/foreign.geo"
sed -i 's/foreign.stl/foreign.geo/; s/"surface-1"/"bed"/' "$work/$study"
make_foreign
check "a .geo that the study does not trust: one line" one_line "foreign.toml:[0-9]*: key 'geometry.shape': fem/studies/foreign.geo is a program.*trust_geo = true"
check "a .geo that the study does not trust is not run, though the study below trusts its own" not_run
tissuectl shape --study $study --mesh "$scratch/cube.msh" --out "$scratch/out.msh"
check "nor does another command take that study" failed
sed -i 's/^shape = .*/&\ntrust_geo = true/' "$work/$study"
echo "$script" >"$shapes/foreign.geo.opt"
make_foreign
check "options beside a trusted .geo: one line" one_line "fem/studies/foreign.geo: gmsh would run fem/studies/foreign.geo.opt"
check "options beside a trusted .geo are not run" not_run
rm "$shapes/foreign.geo.opt"
make_foreign
check "a .geo that the study trusts is run: that is what trust means" sh -c '[ "$2" = 0 ] && [ -e "$1" ]' sh "$ran" "$status"
rm -f "$ran"

# ---- planted links
# Logs and locks are what has a name that is known before; the rest is made in drawn folders (io/beside.h). Through a link a log would empty
# `precious`, and a lock or a count would make the file that is not there.
echo precious >"$scratch/precious"
touch "$shapes/foreign.geo"
ln -sf "$scratch/precious" "$R/mesh.msh.log"
make_foreign
check "gmsh's log is not written through a link" grep -qx precious "$scratch/precious"
echo precious >"$scratch/precious"
ln -sf "$scratch/precious" "$R/cases/one.log"
ln -sf "$scratch/by-surface" "$R/.surface"
surface_of fem/studies/foreign.geo
check "a path's log is not written through a link" grep -qx precious "$scratch/precious"
check "nor is the lock of the surface made through one" absent "$scratch/by-surface"
check "though the surface is made" exist "$R/surface-foreign.geo-0.005-0.001.msh"
mkdir -p "$work/results/tiny/cases"
ln -sf "$scratch/by-count" "$work/results/tiny/cases/.counted"
run make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "a path is solved" exited 0
check "nor are paths counted through a link" absent "$scratch/by-count"

# ---- files of VTK: a program of their own converts them, and all else refuses them
tissuectl surface fem/organ.vtp
check "a .vtp: one line names the program that converts it" one_line '^tissuectl: fem/organ.vtp: VTK surfaces are converted first: scripts/vtk_surface fem/organ.vtp fem/organ.obj$'
tissuectl new foreign2 --shape fem/organ.VTK --unit mm --held part_7
check "nor is a study written of one" one_line '^tissuectl: fem/organ.VTK: VTK surfaces are converted first: scripts/vtk_surface fem/organ.VTK fem/organ.obj$'
tissuectl new foreign2 --shape "$scratch/cube.stl" --unit mm --held 'within 0.003 of spine.vtp'
check "nor is anything held near one" one_line '^tissuectl: spine.vtp: VTK surfaces are converted first'
sed 's/foreign.geo/organ.vtu/' "$work/$study" >"$shapes/grid.toml"
tissuectl plan --study fem/studies/grid.toml --out "$scratch/plan.mk"
check "a study that names a .vtu: one line says that it is a grid, and what to do" one_line "grid.toml:[0-9]*: key 'geometry.shape': fem/studies/organ.vtu: is an unstructured grid: .* scripts/vtk_surface fem/studies/organ.vtp fem/studies/organ.obj; or bring its tetrahedra as a .msh"

run "$PYTHON" -S scripts/vtk_surface "$study" organ.stl
check "what is converted is an .obj: one line" one_line '^vtk_surface: organ.stl: what is converted is written as .obj'
readers=$PYTHON
[ -z "${TISSUE_READERS-}" ] || readers=$TISSUE_READERS  # one that is named must have VTK
"$readers" -c 'import vtkmodules' 2>/dev/null || readers=$root/build/venv/bin/python
if [ -n "${TISSUE_READERS-}" ] || "$readers" -c 'import vtkmodules' 2>/dev/null; then
    check "VTK writes a box" "$readers" "$root/tests/pipeline/vtk_boxes.py" "$work/fem"
    converts() { run "$readers" scripts/vtk_surface "$@"; }
    for box in box.vtp box.vtk; do
        rm -f "$work/fem/box.obj"
        converts fem/$box fem/box.obj --groups part
        check "$box is converted: exit 0" exited 0
        check "$box: its size and groups are said" says '^fem/box.obj: 12 triangles, 8 points; groups: part_7, part_-1$'
        check "$box: coordinates are those of the file, in double precision" grep -qx 'v 0.1 0.2 0.30000000000000004' "$work/fem/box.obj"
        tissuectl surface fem/box.obj --unit mm
        check "$box: it is closed" says '^fem/box.obj: 12 triangles, 8 points, 80 x 60 x 50 mm, 240 ml$'
        rm -f "$shapes/box.toml"
        tissuectl new box --shape fem/box.obj --unit mm --held part_7
        check "$box: a study holds one of its groups" says '^fem/box.obj: in space, 80 x 60 x 50 mm; held: part_7$'
    done
    converts fem/box.vtp fem/box.obj --groups label
    check "texts are groups, with names that make can carry" says '; groups: bed, all_the_rest$'
    converts fem/triangles.vtp fem/box.obj --groups part
    check "triangles and a strip: each has its own cell's group" sh -c \
        'grep -q "; groups: part_7, part_-1, part_5$" "$1" && [ "$(sed -n "/^g part_5/,\$p" "$2" | grep -c ^f)$(sed -n "/^g part_7/,/^g part_-/p" "$2" | grep -c ^f)" = 22 ]' - "$said" "$work/fem/box.obj"
    rm -f "$work/fem/box.obj" "$ran"
    echo "$script" >"$work/fem/script.vtk"
    while IFS='|' read -r file options words; do
        # shellcheck disable=SC2086  # options are words
        converts "fem/$file" fem/box.obj $options
        check "$file $options: one line" one_line "^vtk_surface: fem/$file: $words"
    done <<'REFUSALS'
points.vtp||has no polygons: save the surface itself
grid.vtp||is an unstructured grid, not a surface: save its surface as .vtp (ParaView: Extract Surface)
grid.vtk||is an unstructured grid, not a surface
grid.vtu||is an unstructured grid, not a surface
cut.vtp||is cut off or damaged, save it again; VTK: Error reading
cut.vtk||is cut off or damaged, save it again; VTK: Error reading
huge.vtp||VTK failed while it read the file
beyond.vtk||cell 4 names a point that the file does not have: it has 9; save it again
again.vtk||cell 0 repeats a corner: remove that cell
words.vtk||is cut off or damaged, save it again; VTK: an error whose text is not UTF-8
nan.vtp||point 7 of cell [0-9]* has a coordinate that is no finite number
box.vtp|--groups pat|has no cell data 'pat'; --groups takes one of: part, label, share$
box.vtp|--groups share|cell data 'share' is not an integer or a text of every cell
script.vtk||is no VTK file of PolyData
REFUSALS
    check "nothing was written where it was refused, and nothing was run" sh -c '[ ! -e "$1" ] && [ ! -e "$2" ]' - "$work/fem/box.obj" "$ran"
    ln -s "$scratch/precious" "$work/fem/linked.obj"
    echo precious >"$scratch/precious"
    converts fem/box.vtp fem/linked.obj
    check "nor is anything written through a link" grep -qx precious "$scratch/precious"
    run "$PYTHON" -S scripts/vtk_surface fem/box.vtp fem/box.obj
    check "without VTK: one line names the package" one_line 'has no VTK, which reads the file: apt-get install python3-vtk9, or scripts/venv (PyPI: vtk)$'
else
    skip "surfaces of VTK are converted" "python3-vtk9 is not installed, nor has scripts/venv installed vtk"
fi

# ---- the environment's words are not the plan's
run env SHAPE=fem/organ.geo SOLID=none PATHS=none FIGURES=none make PYTHON="$PYTHON" STUDY=tiny mesh
check "SHAPE and SOLID in the environment: the block is meshed" exist "$work/results/tiny/mesh.msh"
finish
