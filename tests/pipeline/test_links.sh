#!/bin/sh
# Links in a results folder: links of the same user are followed, links of another user are refused, and no log is
# written through a symbolic or hard link. Also names that begin with -, and files that scripts cannot read.
. "$(dirname "$0")/common"
make_copy
other=65534
mine() { echo precious >"$scratch/precious"; }
still_mine() { [ "$(cat "$scratch/precious")" = precious ]; }
may_plant() { # succeeds if a link of another user can be made
    ln -s nowhere "$scratch/of_another" && chown -h $other "$scratch/of_another" 2>/dev/null
}

# ---- logs and locks
make_tiny results/tiny/cases/left.csv
check "a load path is solved" exited 0
for link in -s ""; do
    mine
    rm -f "$R/cases/left.log" "$R/cases/.counted" "$R/mesh.msh.log" "$R/cases/left.csv" "$R/mesh.msh"
    # shellcheck disable=SC2086
    for log in cases/left.log cases/.counted mesh.msh.log; do ln $link "$scratch/precious" "$R/$log"; done
    make_tiny results/tiny/cases/left.csv
    check "logs that are links${link:+ ($link)}: mesh and load path are made" exited 0
    check "logs that are links${link:+ ($link)}: nothing is written through them" still_mine
    check "logs that are links${link:+ ($link)}: they are replaced by regular files" sh -c 'cd "$1" && for log in cases/left.log cases/.counted mesh.msh.log; do
        [ "$(stat -c "%F %h" "$log" | sed "s/empty //")" = "regular file 1" ] || { stat "$log"; exit 1; }; done' - "$R"
done
rm -f "$R/cases/left.log" "$R/cases/left.csv"
mkfifo "$R/cases/left.log"
run timeout 600 make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "a log that is a pipe does not block the load path" exited 0
# links planted while a load path is solved
mkdir "$scratch/bin"
cat >"$scratch/bin/FreeFem++-nw" <<SH
#!/bin/sh
for log in left.log .counted; do ln -sfT "$scratch/precious" "$R/cases/\$log"; done
exec "$(command -v FreeFem++-nw)" "\$@"
SH
chmod +x "$scratch/bin/FreeFem++-nw"
mine
rm -f "$R/cases/left.log" "$R/cases/left.csv"
run env PATH="$scratch/bin:$PATH" make PYTHON="$PYTHON" STUDY=tiny results/tiny/cases/left.csv
check "logs that become links during a solution: the load path is solved" exited 0
check "logs that become links during a solution: nothing is written through them" still_mine
umask 022
rm "$R/cases/left.log" && ln -s nowhere "$R/cases/left.log"
(cd "$work" && scripts/own_file results/tiny/cases/left.log)
check "the umask sets the permissions of a log" test "$(stat -c %a "$R/cases/left.log")" = 644
echo kept >>"$R/cases/left.log"
(cd "$work" && scripts/own_file results/tiny/cases/left.log)
check "a log that is a regular file is kept" test "$(cat "$R/cases/left.log")" = kept

# ---- results
mkdir "$scratch/elsewhere"
echo precious >"$scratch/elsewhere/mesh.msh.raw"
rm -f "$R/mesh.msh"
ln -s "$scratch/elsewhere" "$R/mesh.msh"
run env -C "$work" TISSUECTL="$TISSUECTL" scripts/mesh results/tiny/mesh.msh fem/block.geo -2 -setnumber cells_x 4 -setnumber cells_y 4
check "a mesh replaces a link to a folder at its name" test -f "$R/mesh.msh" -a ! -h "$R/mesh.msh"
mkdir -p "$R/mesh.msh.tissue-abcdef.tmp/precious" "$R/mesh.msh.tissue-fedcba.tmp"
: >"$R/mesh.msh.tissue-fedcba.tmp/mesh.msh.tissue-fedcba.tmp"
: >"$R/mesh.msh.tissue-fedcba.tmp/half"
run env -C "$work" TISSUECTL="$TISSUECTL" scripts/mesh results/tiny/mesh.msh fem/block.geo -2 -setnumber cells_x 4 -setnumber cells_y 4
check "a folder with foreign content and the name of a leftover is kept" exist "$R/mesh.msh.tissue-abcdef.tmp/precious"
check "a leftover temporary folder is removed" absent "$R/mesh.msh.tissue-fedcba.tmp"
rm -r "$R/mesh.msh.tissue-abcdef.tmp"
check "files in the linked folder are unchanged" test "$(cat "$scratch/elsewhere"/*)" = precious
rm "$scratch/elsewhere"/*

# ---- folders
rm -rf "$R/cases" "$R/first"
ln -s "$scratch/elsewhere" "$R/cases"
make_tiny results/tiny/cases/left.csv
check "a folder of load paths that is a link of the same user: exit 0" exited 0
check "a folder of load paths that is a link of the same user is followed" exist "$scratch/elsewhere/left.csv"
if may_plant; then
    refused_link() { # SENTENCE NAME
        check "$1: fails" failed
        check "$1: one line names the link" one_line "'$2' is a link of another user, which is not followed: give the path of its target"
    }
    rm -rf "$scratch/elsewhere" && mkdir "$scratch/elsewhere"
    chown -h $other "$R/cases"
    make_tiny results/tiny/cases/left.csv
    refused_link "a folder of load paths that is a link of another user" cases
    rm "$R/cases"
    rm -rf "$R/plan"
    for name in plan first figures; do
        ln -s "$scratch/elsewhere" "$R/$name"
        chown -h $other "$R/$name"
    done
    tissuectl plan --study fem/studies/tiny.toml --out results/tiny/plan.mk
    refused_link "a folder of plans that is a link of another user" plan
    run scripts/folder results/tiny/first
    refused_link "a folder of first models that is a link of another user" first
    run scripts/folder results/tiny/first/below
    refused_link "a folder below a link of another user" first
    mkdir "$R/shared" && ln -s "$scratch/elsewhere" "$R/shared/theirs" && chown -h $other "$R/shared/theirs" && ln -s shared/theirs "$R/mine"
    run scripts/folder results/tiny/mine/below
    refused_link "a link of the same user that leads to a link of another user" theirs
    rm -r "$R/mine" "$R/shared"
    run "$PYTHON" -c 'import sys
sys.path.insert(0, "scripts/figures")
import save
class Figure:
    def savefig(self, *_, **__): raise AssertionError("drawn")
save.save(Figure(), "results/tiny/figures/force.png")'
    refused_link "a folder of figures that is a link of another user" figures
    check "nothing is written through links of another user" test -z "$(ls -A "$scratch/elsewhere")"
    rm "$R/plan" "$R/first" "$R/figures"
else
    skip "links of another user" "only root can make one"
fi
run scripts/folder results/tiny/a "results/tiny/it's a folder/b"
check "scripts/folder makes a folder with quote and blanks in its name" test -d "$R/it's a folder/b"
ln -s "$R/not there yet" "$R/own" && run scripts/folder results/tiny/own/c
check "scripts/folder makes a folder where a link of the same user leads" test -d "$R/not there yet/c"
run "$PYTHON" -B -c 'import sys
sys.path.insert(0, "scripts/figures")
import save
with save.written("/dev/null") as name: raise AssertionError(name)'
check "a file written by Python does not replace a device" says 'is a device or a pipe'
run scripts/folder -n results/tiny/none
check "scripts/folder -n makes no folder" absent "$R/none"

for file in "$scratch/not there/organ.obj" /dev/full; do
    run "$PYTHON" -B scripts/make_organ.py "$file"
    check "make_organ.py to $file: exit 2" exited 2
    check "make_organ.py to $file: one line names it" sh -c '[ "$(wc -l <"$1")" = 1 ] && grep -q "^make_organ.py: $2: " "$1"' - "$said" "$file"
done

# ---- names that begin with -
run make STUDY=tiny R=-x eval
check "a results folder that begins with -: one line states the cause" one_line '^Makefile:[0-9]*: \*\*\* R=.*does not begin with -'
run scripts/mesh -x.msh fem/block.geo -2 -setnumber width 0.1 -setnumber height 0.1 -setnumber cells_x 2 -setnumber cells_y 2
check "a mesh whose name begins with - is made" exited 0
check "a mesh whose name begins with - has its name" exist "$work/-x.msh"
tissuectl info -x.msh
check "an input whose name begins with -: exit 2" exited 2
tissuectl info ./-x.msh
check "an input with ./ before - is read" one_line 'tissuectl: ./-x.msh: is not an HDF5 file'

# ---- numbers that are passed to gmsh and not to FreeFEM
for word in abc 1,5 0x1 1e "1
2" '0.01;touch pwned'; do
    run scripts/solve_path results/tiny number -geo fem/block3.geo -size_near "$word"
    check "'$(echo "$word" | tr '\n' ' ')' as a size: one line names the argument" one_line "load path 'number': argument -size_near must be a number, got"
done
run scripts/solve_path results/tiny number -geo fem/block3.geo -nodule_raduis 0.008
check "a misspelt argument that gmsh would accept: one line names it" one_line "load path 'number': argument -nodule_raduis is not known"
run scripts/solve_path results/tiny number -geo fem/block3.geo -contact_x 0 -contact_y -.5e-2 -size_near abc
check "0 and a number with a power of ten are accepted" one_line "argument -size_near must be a number, got 'abc'"

# ---- files that scripts cannot read: one line, exit status 2
echo '{"variants": 3' >"$scratch/cut.json"
echo '[1, 2]' >"$scratch/list.json"
printf '\377\376' >"$scratch/bytes"
: >"$scratch/empty"
mkdir "$scratch/folder"
names_it() { [ "$(wc -l <"$said")" = 1 ] && says "$1"; }
unread() { # SCRIPT ARGUMENT...: the script refuses $file, which is one of the arguments
    script=$1
    shift
    run "$PYTHON" -B "scripts/$script" "$@"
    check "$script of ${file##*/}: exit 2" exited 2
    check "$script of ${file##*/}: one line names it" names_it "^${script##*/}: .*${file##*/}: "
}
for file in "$scratch/none" "$scratch/cut.json" "$scratch/list.json" "$scratch/bytes" "$scratch/empty" "$scratch/folder"; do
    unread figures/ablation.py "$file" "$scratch/out.png"
    unread figures/motion.py "$file" "$scratch/out.png"
    unread figures/learned.py "$scratch/out.png" "$file"
    unread make_measured.py "$file" "$scratch/out.csv"
    unread make_histories.py "$file" "$scratch/out.csv"
    unread make_pokes.py "$file" held_out "$scratch/out.csv"
done
printf 'push_mm,angle_deg\n1,2\n' >"$scratch/short.csv"
for file in "$scratch/none" "$scratch/bytes" "$scratch/short.csv"; do unread figures/trust.py "$file" "$scratch/out.png"; done
mkdir "$scratch/results"
for name in eval.json cases.h5 model.h5; do
    file=$scratch/results/$name
    unread figures/draw.py force "$scratch/results" "$scratch/out.png"
    case $name in eval.json) echo '{}' >"$file" ;; *) "$PYTHON" -c 'import h5py, numpy, sys; h5py.File(sys.argv[1], "w")["path_names"] = numpy.array([], "S1")' "$file" ;; esac
done
cat >"$scratch/ablation.json" <<'JSON'
{"variants": [{"fe_paths": 20, "numbers": 12, "area_cap_E2": 1, "shape_scale": 1, "magnitudes_m": [0.01], "arcs_m": [0.1], "angles_deg": [0],
  "held_out": {"learned": {"median": 0.01, "p95": 0.02, "max": 0.03, "n": 40, "of": 40, "shape": {"median": 0.01, "p95": 0.02, "max": null}}}}]}
JSON
cat >"$scratch/motion.json" <<'JSON'
{"study": "tiny", "presses": [{"static_error": 0.01, "force_N": [1, 2], "static_N": [1, 2], "curve": {"time_s": [0], "force_N": [0], "depth_m": [0]}}],
 "switches": [{"from": 0, "to": 1, "innovation": 1, "force_jump_N": 0.1, "curve": {"time_s": [0], "force_N": [0]}}]}
JSON
for name in ablation motion; do
    check "$name.py with wrong content in well-formed JSON: success, or one line" "$PYTHON" -B "$root/tests/pipeline/wrong_content.py" $name "$scratch/$name.json"
done
check "scripts that refuse a file write no output" absent "$scratch/out.png" "$scratch/out.csv"
run "$PYTHON" -B -c 'import sys
sys.path.insert(0, "scripts/figures")
from one_line import reading
with reading("a file"):
    numbers = [1]
numbers[1]'
check "an exception outside of reading a file prints a traceback" says '^Traceback'
finish
