#!/bin/bash
# kill -9 of `make all`, the whole process group, at twenty seeded moments: it resumes, redoes no finished load path, and
# ends with the same contents of every dataset as a run that nobody killed.
. "$(dirname "$0")/common"
make_copy
legs=4 seed=2008

# FE that takes its time: three paths on a finer mesh, so that kills find it at work
edit '^record_step_m = .*' 'record_step_m = 0.001'
edit '^  { name = "top".*' '&\n  { name = "right", contact_m = [0.10, 0.05], push = [-1, -0.5] },'
edit '^refine = 1' 'refine = 4'

# ---- the run that nobody kills: its contents, and how long FE, and all of it, take
start=$(date +%s%N)
make_tiny cases -j2
check "make cases succeeds when nobody kills it" exited 0
fe=$((($(date +%s%N) - start) / 1000000))  # [ms]
make_tiny all -j2
check "make all succeeds when nobody kills it" exited 0
whole=$((($(date +%s%N) - start) / 1000000))
cp -R "$R" "$scratch/undisturbed"

# Five kills a leg, at ascending moments of the work, each drawn from its fifth of the run, or of its FE [ms].
moments=$(awk -v seed=$seed -v whole=$whole -v fe=$fe -v legs=$legs -v n=5 'BEGIN {
    srand(seed)
    for (leg = 0; leg < legs; ++leg)
        for (i = 0; i < n; ++i) print leg, i, int((leg % 2 ? whole : fe) * (i + rand()) / n) }')

# Load paths that are newer than the mesh and their arguments: work that must not be done again.
finished_paths() {
    for csv in "$R"/cases/*.csv; do
        name=$(basename "$csv" .csv)
        [ -e "$csv" ] && [ "$csv" -nt "$R/mesh.msh" ] && [ "$csv" -nt "$R/plan/path-$name" ] && stat -c '%i %.Y %n' "$csv"
    done
}
kept() { # the finished paths of $scratch/finished are the same files still
    while read -r inode time csv; do
        [ "$(stat -c '%i %.Y' "$csv")" = "$inode $time" ] || { echo "done again: $csv"; return 1; }
    done <"$scratch/finished"
}

landed=0 again=0 ran=0
while read -r leg number moment; do
    [ "$number" = 0 ] && { rm -rf "$R"; ran=0; }
    wait_ms=$((moment - ran)) ran=$moment  # the leg has worked `ran` already
    for _ in 1 2 3 4 5; do  # one that comes too late finds no group: the machine has become faster meanwhile
        finished_paths >"$scratch/finished"
        setsid make -C "$work" PYTHON="$PYTHON" STUDY=tiny all -j2 >"$said" 2>&1 </dev/null &
        group=$!
        sleep "$(printf '%d.%03d' $((wait_ms / 1000)) $((wait_ms % 1000)))"
        kill -9 -- -"$group" 2>/dev/null && landed=$((landed + 1)) && break
        wait "$group" 2>/dev/null
        wait_ms=$((wait_ms / 2))
        rm -rf "$R"
    done
    wait "$group" 2>/dev/null
    kept >>"$scratch/kept" || again=1
    if [ "$number" = 4 ]; then
        finished_paths >"$scratch/finished"
        make_tiny all -j2
        name="leg $((leg + 1)) of $legs, killed five times"
        check "$name: make all resumes to the end" exited 0
        check "$name: no finished load path was done again at the end" kept
        check "$name: the same contents of every dataset as without kills" same_contents "$R" "$scratch/undisturbed"
        check "$name: nothing is left to do" sh -c "cd '$work' && make -q PYTHON='$PYTHON' STUDY=tiny all"
    fi
done <<END
$moments
END
check "between two kills no finished load path was done again" test $again = 0
check "every one of the twenty kills struck a running make" test $landed = 20
finish
