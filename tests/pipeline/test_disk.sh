#!/bin/sh
# A read-only results folder and a full disk: one line, a non-zero exit status, and no file that looks finished.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
make_copy
make_tiny figures -j2
check "make figures solves the study" exited 0
cp -pR "$R" "$scratch/whole"

# stage FILE: runs the program or script that writes FILE
stage() {
    case $1 in
        plan.mk) set -- build/release/tissuectl plan --study fem/studies/tiny.toml --out results/tiny/plan.mk ;;
        mesh.msh) set -- make PYTHON="$PYTHON" STUDY=tiny results/tiny/mesh.msh ;;
        cases/left.csv) set -- make PYTHON="$PYTHON" STUDY=tiny -o results/tiny/mesh.msh results/tiny/cases/left.csv ;;
        cases.h5) set -- build/release/tissuectl collect --study fem/studies/tiny.toml --paths results/tiny/cases \
            --out results/tiny/cases.h5 ;;
        model.h5) set -- build/release/tissuectl train --study fem/studies/tiny.toml \
            --cases results/tiny/cases.h5 --out results/tiny/model.h5 ;;
        eval.json) set -- build/release/tissuectl eval --study fem/studies/tiny.toml --model results/tiny/model.h5 \
            --cases results/tiny/cases.h5 --out results/tiny/eval.json --report results/tiny/report.md ;;
        figures/force.png) set -- "$PYTHON" scripts/figures/draw.py force results/tiny results/tiny/figures/force.png ;;
    esac
    run $as_someone "$@"
}
failed_well() { [ "$status" = 1 ] || [ "$status" = 2 ] || { echo "exit status $status"; cat "$said"; return 1; }; }
files="plan.mk mesh.msh cases/left.csv cases.h5 model.h5 eval.json figures/force.png"

# ---- loss of power: content is forced to the disk before a file gets its name
mkdir "$scratch/bin"
cat >"$scratch/bin/sync" <<'SH'
#!/bin/sh
# notes each file that is forced to the disk before it has its name
for file; do
    made=${file%.tmp}
    made=${made%.raw}
    [ -s "$file" ] && [ ! -e "$made" ] && echo "${made##*/}" >>"$FORCED"
done
[ -z "${DISK_FAILS-}" ]
SH
chmod +x "$scratch/bin/sync"
export FORCED="$scratch/forced"
forced() { printf '%s\n' "$@" | cmp - "$FORCED"; }
rm "$R/mesh.msh" "$R/cases/left.csv"
run env PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "make solves mesh and load path again" exited 0
check "files of gmsh and FreeFEM are forced to the disk before they get their names" forced mesh.msh left.csv
rm "$R/cases/left.csv"
run env DISK_FAILS=1 PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "a load path whose sync fails gets no name" absent "$R/cases/left.csv"
check "a load path whose sync fails: one line names it" one_line "left.csv"
check "a file written by Python is forced to the disk before it gets its name" "$PYTHON" -c "import os, sys
sys.path.insert(0, 'scripts/figures')
import save
seen = []
os.fsync = lambda descriptor: seen.append((os.fstat(descriptor).st_size, os.path.exists(sys.argv[1])))
with save.written(sys.argv[1]) as beside:
    open(beside, 'w').write('whole')
assert seen == [(5, False)], seen" "$scratch/drawn"
check "Python follows no planted link, removes leftovers of its own, and keeps other files beside its output" "$PYTHON" -c "import os, sys
sys.path.insert(0, 'scripts/figures')
import save
folder = sys.argv[1]
os.mkdir(folder)
own, out = folder + '/own', folder + '/a.png'
open(own, 'w').write('precious')
for name in ('.tmp', '.tissue-0123abcd.tmp'):
    os.symlink(own, out + name)
open(out + '.tissue-89abcdef.tmp', 'w').write('of a killed one')
open(out + '.20251125.tmp', 'w').write('of the user, with a date')
os.umask(0o002)
with save.written(out) as first:
    with save.written(out) as second:
        open(second, 'w').write('second')
    open(first, 'w').write('first')
assert open(own).read() == 'precious' and open(out).read() == 'first'
assert sorted(os.listdir(folder)) == ['a.png', 'a.png.20251125.tmp', 'a.png.tissue-0123abcd.tmp', 'a.png.tmp', 'own'], os.listdir(folder)
assert os.stat(out).st_mode & 0o777 == 0o664, oct(os.stat(out).st_mode)" "$scratch/planted"
check "an error of the system names the requested file, and no temporary file is left" "$PYTHON" -c "import os, sys
sys.path.insert(0, 'scripts/figures')
import save
out = sys.argv[1] + '/a.png'
os.makedirs(out + '/not empty')
try:
    with save.replaced(out) as beside:
        open(beside, 'w').write('drawn')
except OSError as error:
    assert error.filename == out and os.listdir(sys.argv[1]) == ['a.png'], (error, os.listdir(sys.argv[1]))
else:
    sys.exit('a folder was replaced')" "$scratch/in_place"
check "a link that replaces Python's temporary file is refused, and nothing is written through it" "$PYTHON" -c "import os, sys
sys.path.insert(0, 'scripts/figures')
import save
folder = sys.argv[1]
os.mkdir(folder)
own, out = folder + '/own', folder + '/a.png'
open(own, 'w').write('precious')
try:
    with save.replaced(out) as beside:
        name, = (entry.path for entry in os.scandir(folder) if entry.name.startswith('a.png.tissue-'))
        os.unlink(name)
        os.symlink(own, name)
        open(beside, 'w').write('drawn')
except OSError as error:
    assert 'taken the file away' in error.strerror, error
else:
    sys.exit('it was taken for whole')
assert open(own).read() == 'precious' and os.listdir(folder) == ['own'], os.listdir(folder)" "$scratch/swapped"
cp -p "$scratch/whole/cases/left.csv" "$R/cases"

# ---- read-only results: root may write anywhere, so root runs the stages as user nobody
as_someone=
if [ "$(id -u)" = 0 ]; then
    export HOME=/
    as_someone="setpriv --reuid=65534 --regid=65534 --clear-groups"
    chmod 755 "$scratch"
else
    chmod -R a-w "$R"
fi
if $as_someone true 2>/dev/null; then
    touch "$work/fem/block.geo" "$work/scripts/solve_path"  # mesh and load paths must be made again
    snapshot "$R" >"$scratch/before"
    for target in $files; do
        stage "$target"
        check "read-only results: making $target fails with exit status 1, or 2 of make" failed_well
        check "read-only results: one line names $target or its folder" one_line "$target\|results/tiny"
    done
    check "read-only results are unchanged" only_changed "$scratch/before" "$R" ""
else
    skip "read-only results" "neither root nor able to drop privileges"
fi
as_someone=
[ "$(id -u)" = 0 ] || chmod -R u+w "$R"

# ---- a full disk: a small file system of its own for the results
rm -rf "$R"
mkdir "$R"
if [ "$(id -u)" = 0 ] && mount -t tmpfs -o size=8m tissue_test "$R" 2>/dev/null; then
    clean_up() { umount "$R" 2>/dev/null; rm -rf "$scratch"; }
    for target in $files; do
        rm -rf "$R"/*
        cp -pR "$scratch/whole/." "$R"
        rm -f "$R/$target" "$R/plan/path-top"
        [ "$target" = eval.json ] && rm -f "$R/report.md"
        [ "$target" = cases/left.csv ] && rm -f "$R/cases/left.log"
        cat /dev/zero >"$R/filler" 2>/dev/null  # until the disk is full
        stage "$target"
        check "full disk: making $target fails with exit status 1, or 2 of make" failed_well
        check "full disk: one line names $target or its folder" one_line "$target\|results/tiny"
        check "full disk: $target is not written" absent "$R/$target"
        check "full disk: making $target leaves no incomplete file" no_half_files "$R"
        rm "$R/filler"
        if [ "$target" = eval.json ]; then check "full disk: no report is written" absent "$R/report.md"; fi
    done
    rm -rf "$R"/*
    cp -pR "$scratch/whole/." "$R"
    cat /dev/zero >"$R/filler" 2>/dev/null
    truncate -s -100K "$R/filler"  # space for the beginning of the recording
    run "$TISSUE_HAPTIC" results/tiny/model.h5 --seconds 2 --record results/tiny/r.h5
    check "full disk: a recording ends with exit status 1" exited 1
    check "full disk: one line names the recording, and fewer than 40 lines are printed" sh -c '[ "$(grep -c "r.h5: " "$1")" = 1 ] && [ "$(wc -l <"$1")" -lt 40 ]' - "$said"
    check "full disk: no incomplete recording is left" no_half_files "$R"
    rm "$R/filler"
    rm -rf "$R"/*
    make_tiny eval -j2
    check "with space again, make eval succeeds from an empty folder" exited 0
    check "with space again, the results are the same" same_contents "$R" "$scratch/whole"
    umount "$R"
else
    skip "full disk" "mounting a small file system needs root"
fi
finish
