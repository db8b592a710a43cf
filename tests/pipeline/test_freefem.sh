#!/bin/sh
# gmsh or FreeFEM missing, crashing, killed or without an answer: one clear line, no output, earlier results untouched.
. "$(dirname "$0")/common"
make_copy
make_tiny eval -j2
check "the study is solved to begin with" exited 0
real_path=$PATH

fake() { # SCRIPT: what FreeFem++-nw does from now on
    mkdir -p "$scratch/fake"
    printf '#!/bin/sh\n%s\n' "$1" >"$scratch/fake/FreeFem++-nw"
    chmod +x "$scratch/fake/FreeFem++-nw"
    PATH=$scratch/fake:$real_path
}

fails() { # SENTENCE LINE-PATTERN: the left path must be solved again and cannot be
    edit 'push = \[1, [^]]*\]' "push = [1, -0.$(date +%N)]"
    snapshot "$R" >"$scratch/before"
    make_tiny eval
    check "$1: make fails" failed
    check "$1: one line says so" one_line "$2"
    check "$1: earlier results are untouched" only_changed "$scratch/before" "$R" "${3-cases/left.log }plan.mk plan/path-left"
    check "$1: no half-written file" no_half_files "$R"
    rm -f "$R/cases/left.csv"
    make_tiny cases
    check "$1: where there was no load path, there is none" absent "$R/cases/left.csv" "$R/cases/left.csv.tmp"
    PATH=$real_path
    make_tiny eval
    check "$1: once FreeFEM works again, make goes on" exited 0
}

# writes half a path before it ends as told
half='while [ "$1" != -out ]; do shift; done; printf "tissuectl load path,1\nstep,0,0,0" >"$2"'
fake "$half; kill -KILL \$\$"
fails "FreeFEM killed" "load path 'left': FreeFEM was killed by signal 9; see results/tiny/cases/left.log"
fake "$half; kill -SEGV \$\$"
fails "FreeFEM crashing" "load path 'left': FreeFEM was killed by signal 11"
fake "$half; exit 3"
fails "FreeFEM failing" "load path 'left': FreeFEM failed with status 3"
fake "$half; exit 0"
fails "FreeFEM ending well with half a path" "load path 'left': FreeFEM's output is cut off"
fake "exit 0"
fails "FreeFEM ending well without a path" "load path 'left': FreeFEM's output is cut off"

# missing: all that the system has, but not FreeFEM
mkdir "$scratch/bin"
for folder in $(echo "$real_path" | tr : ' '); do ln -s "$folder"/* "$scratch/bin/" 2>/dev/null; done
rm -f "$scratch"/bin/FreeFem*
PATH=$scratch/bin
fails "FreeFEM missing" "FreeFem++-nw is not installed; run make deps" ""

# gmsh: writes half a mesh before it is killed
mkdir -p "$scratch/fake_gmsh"
printf '#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done; echo half >"$2"; kill -KILL $$\n' >"$scratch/fake_gmsh/gmsh"
chmod +x "$scratch/fake_gmsh/gmsh"
snapshot "$R" >"$scratch/before"
PATH=$scratch/fake_gmsh:$real_path
make_tiny -W fem/block.geo mesh
check "gmsh killed: make fails" failed
check "gmsh killed: one line says so" says "^fem/block.geo: gmsh cannot read or mesh it; see results/tiny/mesh.*log"
check "gmsh killed: the earlier mesh is untouched" only_changed "$scratch/before" "$R" "mesh.msh.log"
PATH=$real_path

# no equilibrium that is physical: a push right through the tissue, onto the ground that holds it
edit '^magnitudes_m = .*' 'magnitudes_m = [0.095]'
edit '^record_step_m = .*' 'record_step_m = 0.095'
rm -f "$R"/cases/*.csv
make_tiny results/tiny/cases/top.csv
check "a push that FE cannot follow: make fails" failed
check "a push that FE cannot follow: one line gives path, push and log" \
    one_line "load path 'top': .* mm .*see results/tiny/cases/top.log"
check "a push that FE cannot follow: there is no load path" absent "$R/cases/top.csv" "$R/cases/top.csv.tmp"
check "a push that FE cannot follow: the log has every step's residuals" grep -q "step from .* relative residuals" \
    "$R/cases/top.log"
finish
