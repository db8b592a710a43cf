#!/bin/sh
# gmsh or FreeFEM is missing, crashes, is killed or finds no equilibrium: one line, no output, earlier results
# unchanged.
. "$(dirname "$0")/common"
make_copy
make_tiny eval -j2
check "make eval solves the study" exited 0
real_path=$PATH

fake() { # SCRIPT: replaces FreeFem++-nw by this script
    mkdir -p "$scratch/fake"
    printf '#!/bin/sh\n%s\n' "$1" >"$scratch/fake/FreeFem++-nw"
    chmod +x "$scratch/fake/FreeFem++-nw"
    PATH=$scratch/fake:$real_path
}

fails() { # SENTENCE LINE-PATTERN [CHANGED]: load path `left` must be solved again and cannot be
    edit 'push = \[1, [^]]*\]' "push = [1, -0.$(date +%N)]"
    snapshot "$R" >"$scratch/before"
    make_tiny eval
    check "$1: make fails" failed
    check "$1: one line states the cause" one_line "$2"
    check "$1: earlier results are unchanged" only_changed "$scratch/before" "$R" "${3-cases/left.log }plan.mk plan/path-left"
    check "$1: no incomplete file is left" no_half_files "$R"
    rm -f "$R/cases/left.csv"
    make_tiny cases
    check "$1: a missing load path stays missing" absent "$R/cases/left.csv" "$R/cases/left.csv.tmp"
    PATH=$real_path
    make_tiny eval
    check "$1: make eval succeeds after FreeFEM works again" exited 0
}

# writes half of a load path's file and then ends
half='while [ "$1" != -out ]; do shift; done; printf "tissuectl load path,1\nstep,0,0,0" >"$2"'
fake "$half; kill -KILL \$\$"
fails "FreeFEM killed" "load path 'left': FreeFEM was killed by signal 9; see results/tiny/cases/left.log"
fake "$half; kill -SEGV \$\$"
fails "FreeFEM crashing" "load path 'left': FreeFEM was killed by signal 11"
fake "$half; exit 3"
fails "FreeFEM failing" "load path 'left': FreeFEM failed with status 3"
fake "$half; exit 0"
fails "FreeFEM succeeding with half of a load path" "load path 'left': FreeFEM's output is truncated"
fake "exit 0"
fails "FreeFEM succeeding without a load path" "load path 'left': FreeFEM's output is truncated"

# missing: all programs of the system but FreeFEM
mkdir "$scratch/bin"
for folder in $(echo "$real_path" | tr : ' '); do ln -s "$folder"/* "$scratch/bin/" 2>/dev/null; done
rm -f "$scratch"/bin/FreeFem*
PATH=$scratch/bin
fails "FreeFEM missing" "FreeFem++-nw is not installed; run make deps" ""

# gmsh writes half of a mesh before it is killed
mkdir -p "$scratch/fake_gmsh"
printf '#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done; echo half >"$2"; kill -KILL $$\n' >"$scratch/fake_gmsh/gmsh"
chmod +x "$scratch/fake_gmsh/gmsh"
snapshot "$R" >"$scratch/before"
PATH=$scratch/fake_gmsh:$real_path
make_tiny -W fem/block.geo mesh
check "gmsh killed: make fails" failed
check "gmsh killed: a line names the shape and the log" says "^fem/block.geo: gmsh cannot read or mesh it; see results/tiny/mesh.*log"
check "gmsh killed: the earlier mesh is unchanged" only_changed "$scratch/before" "$R" "mesh.msh.log"
PATH=$real_path

# no physical equilibrium: a tool displacement of 95 mm in a tissue of 100 mm
edit '^magnitudes_m = .*' 'magnitudes_m = [0.095]'
edit '^record_step_m = .*' 'record_step_m = 0.095'
rm -f "$R"/cases/*.csv
make_tiny results/tiny/cases/top.csv
check "a displacement without FE equilibrium: make fails" failed
check "a displacement without FE equilibrium: one line names load path, displacement and log" \
    one_line "load path 'top': .* mm .*see results/tiny/cases/top.log"
check "a displacement without FE equilibrium: no load path is written" absent "$R/cases/top.csv" "$R/cases/top.csv.tmp"
check "a displacement without FE equilibrium: the log contains residuals of load steps" grep -q "step from .* relative residuals" \
    "$R/cases/top.log"
finish
