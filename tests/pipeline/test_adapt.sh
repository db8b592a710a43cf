#!/bin/sh
# A model that learns from pokes: files, streams, bad lines, resumption, and a hand that teaches while it plays.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
make_copy
poked_tissue

adapt() { "$TISSUECTL" adapt "$@" >"$scratch/out" 2>"$scratch/log"; }

# ---- a file
check "a file of pokes is learned from" adapt "$model" --data "$pokes" --held-out "$pokes" --next 2 --json --out "$scratch/whole.h5"
check "held-out errors before and after stand there, and fall" "$PYTHON" -c 'import json, re, sys
log, out = open(sys.argv[1]).read(), [json.loads(line) for line in open(sys.argv[2])]
before = float(re.search("before the first measurement: test ([0-9.]+)", log).group(1))
learned = [r for r in out if r.get("status") == "learned"]
after = 100 * learned[-1]["held_out"]["median"]
assert len(learned) > 40 and after < 0.5 * before, (before, after, len(learned))
assert [r["next"] for r in out if "next" in r] == [1, 2]' "$scratch/log" "$scratch/out"
"$PYTHON" - "$pokes" "$scratch/not_of_it.csv" <<'PY'
import csv, sys

rows = [row for row in csv.reader(open(sys.argv[1])) if row and not row[0].startswith("#")]
head, first = rows[0], rows[1]
far = ["5" if name.startswith("contact_") else value for name, value in zip(head, first)]
dead = ["0" if name.startswith("force_") else value for name, value in zip(head, first)]
csv.writer(open(sys.argv[2], "w")).writerows([head, first, far, dead])
PY
check "a held-out poke that is none of the tissue is no reference, and no error of the model" sh -c "
    '$TISSUECTL' adapt '$model' --data '$pokes' --first 1 --held-out '$scratch/not_of_it.csv' --out '$scratch/one.h5' 2>&1 | grep -q '1 of 3 measurements, 2 without a reference'"
check "the model plays" "$TISSUE_HAPTIC" "$scratch/whole.h5" --seconds 0.2 --no-realtime
check "info names what was learned" sh -c "'$TISSUECTL' info '$scratch/whole.h5' | grep -q adaptation/covariance"

awk -F, -v OFS=, 'NR > 1 { for (k = 5; k <= NF; ++k) $k *= 1000 } 1' "$pokes" >"$scratch/millinewtons.csv"
check "measurements in another unit are gated" adapt "$model" --data "$scratch/millinewtons.csv" --out "$scratch/unit.h5"
check "and a line asks for the unit" grep -q 'gated measurements are .* times the predicted force: is a unit in the header wrong' "$scratch/log"

# ---- going on: by the options that the file was begun with
for option in "--noise 0.5" "--model-error 0.5" "--place-error 0.01" "--unknowns scale" "--no-rival"; do
    check "of a file that has learned, $option is refused" sh -c "! '$TISSUECTL' adapt '$scratch/whole.h5' --data '$pokes' --first 1 $option --out '$scratch/on.h5' 2>'$scratch/log'"
    check "$option: one line says with what it has learned" grep -q "^tissuectl: .*/whole.h5: has learned with ${option%% *} .*, not .*: leave the option out, or begin again with --forget" "$scratch/log"
done
check "nothing is written then" absent "$scratch/on.h5"
check "its own value is no other" adapt "$scratch/whole.h5" --data "$pokes" --first 1 --noise 0.02 --unknowns field --out "$scratch/on.h5"
check "with --forget another one applies" adapt "$scratch/whole.h5" --data "$pokes" --first 1 --noise 0.5 --unknowns scale --forget --out "$scratch/anew.h5"
check "and it learns as from the trained model" adapt "$model" --data "$pokes" --first 1 --noise 0.5 --unknowns scale --out "$scratch/fresh.h5"
check "to the last bit" same_learned "$scratch/anew.h5" "$scratch/fresh.h5"
check "how readings were taken is asked of tissue that relaxes alone" sh -c "! '$TISSUECTL' adapt '$model' --data '$pokes' --readings instantaneous --out '$scratch/none.h5' 2>'$scratch/log'"
check "in one line" grep -q '^tissuectl: .*/model.h5: does not relax; --readings is of tissue that does' "$scratch/log"

check "what was learned is drawn" "$PYTHON" "$root/scripts/figures/learned.py" "$scratch/map.png" "$scratch/whole.h5" --truth 20 60 10
check "into a picture" exist "$scratch/map.png"
check "a model that has learned nothing is refused in one line" sh -c "! '$PYTHON' '$root/scripts/figures/learned.py' '$scratch/map.png' '$model' 2>'$scratch/log' && grep -q 'has learned no field' '$scratch/log'"

"$PYTHON" -B "$root/tests/serve/test_page_learned.py" "$TISSUECTL" "$scratch/whole.h5" "$model" || failures=$((failures + 1))

# ---- a stream, with bad lines in it
sed '6a a robot says hello' "$pokes" >"$scratch/with_bad.csv"
check "a stream goes on after a bad line, and tells" adapt "$model" --data - --stream --json --out "$scratch/stream.h5" <"$scratch/with_bad.csv"
check "with the line's place and cause" grep -q '"line":7,"status":"refused","why":"standard input:7: has 1 fields' "$scratch/out"
sed 's/refused/x/' "$scratch/log" >/dev/null
check "what it learned is the file's to the last bit" same_learned "$scratch/whole.h5" "$scratch/stream.h5"
check "a file with a bad line is refused" sh -c "! '$TISSUECTL' adapt '$model' --data '$scratch/with_bad.csv' --out '$scratch/none.h5' 2>'$scratch/log'"
check "in one line with file, line and cause" grep -q "with_bad.csv:7: has 1 fields, the header 6 columns" "$scratch/log"
check "and nothing is written" absent "$scratch/none.h5"

# ---- pipes, which give what is in them once
mkfifo "$scratch/pokes"
cat "$pokes" >"$scratch/pokes" &
check "pokes out of a pipe are learned from" timeout 600 "$TISSUECTL" adapt "$model" --data "$scratch/pokes" --out "$scratch/piped.h5"
kill $! 2>/dev/null  # it waits for ever where adapt never opened the pipe
wait $!
check "to the last bit as out of a file" same_learned "$scratch/whole.h5" "$scratch/piped.h5"
check "and so are those of standard input that is no stream" sh -c "'$TISSUECTL' adapt '$model' --data - --out '$scratch/piped.h5' <'$pokes'"
check "to the last bit, too" same_learned "$scratch/whole.h5" "$scratch/piped.h5"
check "one that brings nothing is refused" sh -c "! '$TISSUECTL' adapt '$model' --data - --out '$scratch/none.h5' </dev/null 2>'$scratch/log'"
check "in one line" grep -q '^tissuectl: standard input: has no rows' "$scratch/log"

# ---- half by half, back, and forgotten
adapt "$model" --data "$pokes" --first 20 --out "$scratch/half.h5"
{ head -n 1 "$pokes"; tail -n +22 "$pokes"; } >"$scratch/rest.csv"
check "learning goes on from a model's file" adapt "$scratch/half.h5" --data "$scratch/rest.csv" --out "$scratch/then.h5"
check "to the last bit as if it had gone all the way at once" same_learned "$scratch/whole.h5" "$scratch/then.h5"
check "--forget begins with the law as it was trained" adapt "$scratch/whole.h5" --forget --data "$pokes" --first 20 --out "$scratch/again.h5"
check "and comes to the same" same_learned "$scratch/half.h5" "$scratch/again.h5"
sed 's/displacement_x \[mm\]/displacement_x [m]/' "$pokes" >"$scratch/metres.csv"
check "displacements in another unit than they say are refused one by one" adapt "$model" --data "$scratch/metres.csv" --out "$scratch/metres.h5"
check "and learned nothing from" grep -q 'adapt: 0 learned' "$scratch/log"

# ---- while it plays
check "a hand that probes a hidden tissue teaches the law" sh -c "'$TISSUE_HAPTIC' '$model' --motion probe --depth 0.004 --seconds 6 --no-clock --json \
    --hidden '$scratch/whole.h5' --learn '$scratch/live.h5' --journal '$scratch/live.csv' --record '$scratch/live-record.h5' >'$scratch/out' 2>'$scratch/log'"
check "it says what it read and learned" grep -q '[1-9][0-9]* measurements, [1-9][0-9]* learned' "$scratch/log"
check "without a clock it takes every tick, records each, and says so" "$PYTHON" -c 'import h5py, json, numpy, sys
said = json.load(open(sys.argv[1]))
assert said["ticks"] == 6000 and said["misses"] == 0 and said["details"]["clock"] is False and said["details"]["lost_s"] == 0, said
with h5py.File(sys.argv[2]) as file:
    time = file["time"][:]
    assert len(time) == 6000 and abs(time - 1e-3 * numpy.arange(6000)).max() < 1e-9 and file.attrs["dropped_samples"] == 0' "$scratch/out" "$scratch/live-record.h5"
"$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 6 --no-clock --hidden "$scratch/whole.h5" --learn "$scratch/live-again.h5" --journal "$scratch/live-again.csv" >"$scratch/out" 2>"$scratch/log"
check "and the same session again learns the same to the last bit" same_learned "$scratch/live.h5" "$scratch/live-again.h5"
check "from the same readings" cmp "$scratch/live.csv" "$scratch/live-again.csv"
check "a device that a hand holds has a clock" sh -c "! '$TISSUE_HAPTIC' '$model' --device remote --no-clock 2>'$scratch/log' && grep -q -e '--no-clock: device remote moves by the clock' '$scratch/log'"
check "the journal is pokes" adapt "$model" --data "$scratch/live.csv" --live --out "$scratch/replayed.h5"
check "that make the same model" "$PYTHON" -c 'import h5py, sys
a, b = (h5py.File(f) for f in sys.argv[1:])
assert (a["adaptation/x"][:] == b["adaptation/x"][:]).all() and (a["law/constants"][:] == b["law/constants"][:]).all()' "$scratch/live.h5" "$scratch/replayed.h5"
cp "$scratch/live.csv" "$scratch/live-before.csv"
check "a journal with readings is not begun anew" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/live.csv' 2>'$scratch/log'"
check "in one line" grep -q '^tissue-haptic: .*/live.csv: has readings of an earlier session' "$scratch/log"
check "and stands as it was" cmp "$scratch/live.csv" "$scratch/live-before.csv"
for text in 'my notes, in one line' 'my notes\n' 'contact_x [m],contact_y [m],displacement_x [m],displacement_y [m],force_x [N],force_y [N]'; do
    printf "$text" >"$scratch/notes.txt"
    cp "$scratch/notes.txt" "$scratch/notes-before.txt"
    check "nor is a file that is none: $text" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/notes.txt' 2>'$scratch/log'"
    check "in one line that says so" grep -q '^tissue-haptic: .*/notes.txt: is there already, and is no journal: name another file' "$scratch/log"
    check "and it stands as it was" cmp "$scratch/notes.txt" "$scratch/notes-before.txt"
done
head -n 1 "$scratch/live.csv" >"$scratch/begun.csv"
journal() { timeout 600 "$TISSUE_HAPTIC" "$model" --seconds 0.1 --no-realtime --learn "$scratch/none.h5" --journal "$1" 2>"$scratch/log"; }
head -n 1 "$scratch/live.csv" >"$scratch/header"
begins() { head -n 1 "$1" | cmp - "$scratch/header"; }
journal /dev/stdout >"$scratch/out"
check "standard output takes a journal" grep -qxFf "$scratch/header" "$scratch/out"
journal /dev/stdout | cat >"$scratch/out"
check "and so does a pipe there" grep -qxFf "$scratch/header" "$scratch/out"
ln -s linked.csv "$scratch/own-link.csv"
journal "$scratch/own-link.csv" >"$scratch/out"
check "a link of one's own leads to a journal" begins "$scratch/linked.csv"
: >"$scratch/precious"
ln "$scratch/precious" "$scratch/hard.csv"
check "a hard link is not written through" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/hard.csv' 2>'$scratch/log'"
check "in one line" grep -q '^tissue-haptic: .*/hard.csv: is a link to a file that has other names' "$scratch/log"
ln -s precious "$scratch/planted.csv"
if chown -h 65534 "$scratch/planted.csv" 2>/dev/null; then
    check "nor is a link of another user" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/planted.csv' 2>'$scratch/log'"
    check "in one line, too" grep -q "^tissue-haptic: .*/planted.csv: cannot write: 'planted.csv' is a link of another user" "$scratch/log"
else
    skip "a link of another user" "only root can make one"
fi
mkdir "$scratch/folder"
for name in folder folder/ new/; do
    check "nor is a folder's name, $name" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --no-clock --learn '$scratch/none.h5' --journal '$scratch/$name' 2>'$scratch/log'"
    check "in one line, and nothing is made: $name" sh -c "grep -q '^tissue-haptic: .*/$name: is a folder.s name, wanted a file.s' '$scratch/log' && [ ! -e '$scratch/new' ]"
done
check "and what they lead to stays empty" test ! -s "$scratch/precious"
check "one without readings is begun anew" "$TISSUE_HAPTIC" "$model" --seconds 0.1 --learn "$scratch/begun.h5" --journal "$scratch/begun.csv" >"$scratch/out" 2>"$scratch/log"
: >"$scratch/held.csv"
check "nor is one that another session writes" sh -c "! flock '$scratch/held.csv' '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/held.csv' 2>'$scratch/log'"
check "in one line, too" grep -q '^tissue-haptic: .*/held.csv: another session writes it' "$scratch/log"
# a disk that has no locks, played by a library that stands before the system's
cat >"$scratch/no_locks.c" <<'C'
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

int flock(int descriptor, int operation) {
    struct stat a, b;
    const char *unlocked = getenv("UNLOCKED");
    if (unlocked && fstat(descriptor, &a) == 0 && stat(unlocked, &b) == 0 && a.st_ino == b.st_ino) return errno = ENOLCK, -1;
    return (int)syscall(SYS_flock, descriptor, operation);
}
C
gcc -shared -fPIC "$scratch/no_locks.c" -o "$scratch/no_locks.so" || exit 1
check "nor is one that the disk does not lock" sh -c "! UNLOCKED='$scratch/held.csv' LD_PRELOAD='$scratch/no_locks.so' '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/held.csv' 2>'$scratch/log'"
check "whose own cause is told" grep -q '^tissue-haptic: .*/held.csv: cannot be locked: No locks available' "$scratch/log"

# a tissue stiffer than a session may learn, and one that has learned to be stiffer
awk -F, -v OFS=, 'NR > 1 { for (k = 5; k <= NF; ++k) $k *= 9 } 1' "$pokes" >"$scratch/stiff.csv"
adapt "$model" --data "$scratch/stiff.csv" --out "$scratch/stiff.h5"
session() { # MODEL NAME: from that model, on the stiff one
    "$TISSUE_HAPTIC" "$1" --motion probe --depth 0.004 --seconds 6 --no-clock --hidden "$scratch/stiff.h5" --learn "$scratch/$2.h5" --journal "$scratch/$2.csv" >"$scratch/out" 2>"$scratch/log"
}
largest() { "$PYTHON" -c 'import h5py, numpy, sys
file = h5py.File(sys.argv[1])
x = max(abs(file["adaptation/x"][:]).max(), abs(file["adaptation"].attrs["scale"]))
assert float(sys.argv[2]) <= x <= float(sys.argv[3]), x' "$@"; }
check "a patient nine times as stiff" largest "$scratch/stiff.h5" 1.9 2.5
check "a session on it" session "$model" bounded
check "learns 4.5 times at the most" largest "$scratch/bounded.h5" 1.45 1.5000001
check "and its journal makes the same model" adapt "$model" --data "$scratch/bounded.csv" --live --out "$scratch/replayed.h5"
check "to the last bit" same_learned "$scratch/bounded.h5" "$scratch/replayed.h5"
check "a session that begins with the patient" session "$scratch/stiff.h5" stays
check "takes nothing back" largest "$scratch/stays.h5" 1.9 2.5
check "and its journal teaches the same" adapt "$scratch/stiff.h5" --data "$scratch/stays.csv" --live --out "$scratch/replayed.h5"
check "bit by bit" same_learned "$scratch/stays.h5" "$scratch/replayed.h5"
check "--live is one way to learn, not a part of another" sh -c "! '$TISSUECTL' adapt '$model' --data '$scratch/live.csv' --live --noise 0.03 --out '$scratch/none.h5' 2>/dev/null"

# sessions that something happens to: they go on until it has, and then are told to end
told() { [ "$(grep -c '^tissue-haptic [0-9.]* s: ' "$scratch/log")" -ge "$1" ]; }  # so many readings, or more
ended_early() { ! kill -0 $session 2>/dev/null; }
told_or_ended() { told "$1" || ended_early; }
mkdir "$scratch/gone"
: >"$scratch/log"
"$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 0 --no-clock --hidden "$scratch/whole.h5" --record "$scratch/gone/r.h5" --learn "$scratch/kept.h5" \
    >"$scratch/out" 2>"$scratch/log" &
session=$!
wait_for told_or_ended 1
rm -rf "$scratch/gone"
kill -TERM $session
wait $session
ended=$?
check "a recording that cannot be kept ends in an error" test $ended = 1
check "which takes neither model nor statistics along" sh -c "'$TISSUECTL' info '$scratch/kept.h5' | grep -q adaptation/x && grep -q ticks '$scratch/out'"
"$PYTHON" -c 'import os, resource, signal, subprocess, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
journal = sys.argv[-1]
session = subprocess.Popen(sys.argv[1:], restore_signals=False, stderr=subprocess.PIPE, text=True)  # the log would be full, too
def readings(more):  # waits for so many
    for line in session.stderr:
        sys.stderr.write(line)
        more -= line.startswith("tissue-haptic ") and " s: " in line
        if more == 0: break
readings(2)  # the first of which is in the journal
full = os.path.getsize(journal) + 20  # less than one more
resource.prlimit(session.pid, resource.RLIMIT_FSIZE, (full, full))
readings(3)
session.terminate()
sys.stderr.write(session.communicate()[1])
sys.exit(session.returncode)' "$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 0 --no-clock --hidden "$scratch/whole.h5" --learn "$scratch/full.h5" --journal "$scratch/full.csv" \
    >"$scratch/out" 2>"$scratch/log"
ended=$?
check "a disk that is full during a session ends it in an error" test $ended = 1
check "of each file that it took" sh -c "grep -q '/full.h5: .*cannot write' '$scratch/log' && grep -q '/full.csv: could not be written to its end' '$scratch/log'"
check "the journal has whole rows" "$PYTHON" -c 'import sys
lines = open(sys.argv[1]).read().split("\n")
assert len(lines) > 2 and lines[-1] == "" and all(len(l.split(",")) == 6 for l in lines[:-1]), lines' "$scratch/full.csv"
check "where the model cannot be written no session begins" sh -c "! '$TISSUE_HAPTIC' '$model' --motion probe --seconds 60 --learn '$scratch/no/where.h5' 2>'$scratch/log'"
check "in one line" grep -q '^tissue-haptic: .*no/where.h5' "$scratch/log"
mkfifo "$scratch/pipe"
head -n 1 "$scratch/pipe" >/dev/null &  # takes the header and no reading
head=$!
: >"$scratch/log"
(trap '' PIPE; exec "$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 0 --no-clock --hidden "$scratch/whole.h5" --learn "$scratch/broken.h5" --journal "$scratch/pipe" \
    >"$scratch/out" 2>"$scratch/log") &
session=$!
wait $head
wait_for told_or_ended $(($(grep -c '^tissue-haptic [0-9.]* s: ' "$scratch/log") + 3))
kill -TERM $session
wait $session
ended=$?
check "a journal that breaks off ends the session with an error" test $ended = 1
check "in one line" grep -q '^tissue-haptic: .*/pipe: could not be written to its end' "$scratch/log"
check "after the model that was learned" exist "$scratch/broken.h5"
check "where the journal cannot be written no session begins" sh -c "! '$TISSUE_HAPTIC' '$model' --learn '$scratch/none.h5' --journal /dev/full 2>'$scratch/log' &&
    grep -q '^tissue-haptic: /dev/full: cannot be written' '$scratch/log'"
check "a journal without --learn is refused" sh -c "! '$TISSUE_HAPTIC' '$model' --journal x.csv --seconds 0.1 2>/dev/null"
finish
