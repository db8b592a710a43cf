#!/bin/sh
# A model that adapts to measurements: files, streams, bad lines, resumption, and a session that learns from a probing
# motion.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
make_copy
poked_tissue

adapt() { "$TISSUECTL" adapt "$@" >"$scratch/out" 2>"$scratch/log"; }

# ---- a file
check "a model learns from a file of measurements" adapt "$model" --data "$pokes" --held-out "$pokes" --next 2 --json --out "$scratch/whole.h5"
check "the test error after learning is less than half of that before, and --next prints 2 places" "$PYTHON" -c 'import json, re, sys
log, out = open(sys.argv[1]).read(), [json.loads(line) for line in open(sys.argv[2])]
before = float(re.search("before the first measurement: test error ([0-9.]+)", log).group(1))
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
check "test measurements off the surface or without force count as missing references" sh -c "
    '$TISSUECTL' adapt '$model' --data '$pokes' --first 1 --held-out '$scratch/not_of_it.csv' --out '$scratch/one.h5' 2>&1 | grep -q '1 of 3 measurements, 2 without a reference'"
check "tissue-haptic plays the adapted model" "$TISSUE_HAPTIC" "$scratch/whole.h5" --seconds 0.2 --no-realtime
check "info lists the covariance of the adaptation" sh -c "'$TISSUECTL' info '$scratch/whole.h5' | grep -q adaptation/covariance"

awk -F, -v OFS=, 'NR > 1 { for (k = 5; k <= NF; ++k) $k *= 1000 } 1' "$pokes" >"$scratch/millinewtons.csv"
check "adapt accepts a file with forces in a wrong unit" adapt "$model" --data "$scratch/millinewtons.csv" --out "$scratch/unit.h5"
check "one line reports gated measurements and asks about the unit" grep -q 'gated measurements are .* times the predicted force: is a unit in the header wrong' "$scratch/log"

# ---- continuation: options must equal those of the first run
for option in "--noise 0.5" "--model-error 0.5" "--place-error 0.01" "--unknowns scale" "--no-rival"; do
    check "$option is refused for a model that has learned with another value" sh -c "! '$TISSUECTL' adapt '$scratch/whole.h5' --data '$pokes' --first 1 $option --out '$scratch/on.h5' 2>'$scratch/log'"
    check "$option: one line states the value that it has learned with" grep -q "^tissuectl: .*/whole.h5: was adapted with ${option%% *} .*, not .*: leave the option out, or start again with --forget" "$scratch/log"
done
check "refused options write no model" absent "$scratch/on.h5"
check "options with the same values are accepted" adapt "$scratch/whole.h5" --data "$pokes" --first 1 --noise 0.02 --unknowns field --out "$scratch/on.h5"
check "with --forget other values are accepted" adapt "$scratch/whole.h5" --data "$pokes" --first 1 --noise 0.5 --unknowns scale --forget --out "$scratch/anew.h5"
check "the trained model learns with the same options" adapt "$model" --data "$pokes" --first 1 --noise 0.5 --unknowns scale --out "$scratch/fresh.h5"
check "--forget with other options gives the same model as the trained model with them" same_learned "$scratch/anew.h5" "$scratch/fresh.h5"
check "--readings is refused for tissue that does not relax" sh -c "! '$TISSUECTL' adapt '$model' --data '$pokes' --readings instantaneous --out '$scratch/none.h5' 2>'$scratch/log'"
check "--readings: one line states the cause" grep -q '^tissuectl: .*/model.h5: the model does not relax; --readings needs a model that relaxes' "$scratch/log"

check "learned.py draws the learned field" "$PYTHON" "$root/scripts/figures/learned.py" "$scratch/map.png" "$scratch/whole.h5" --truth 20 60 10
check "learned.py writes a picture" exist "$scratch/map.png"
check "learned.py draws the scale and its standard deviation where one scale is in use" "$PYTHON" -B - "$root/scripts/figures" "$scratch/whole.h5" "$scratch/drawn.h5" <<'PY'
import shutil, sys
sys.path.insert(0, sys.argv[1])
import h5py
import numpy as np
from learned import learned
shutil.copy(sys.argv[2], sys.argv[3])
for evidence in (1.0, -1.0):
    with h5py.File(sys.argv[3], "r+") as model:
        model["adaptation"].attrs.update(evidence=evidence, scale=0.3, scale_variance=0.04)
        x, sd = model["adaptation/x"][:], np.sqrt(np.diag(model["adaptation/covariance"][:]))
    _, _, factor, drawn_sd, _ = learned(sys.argv[3])
    assert np.allclose(factor, np.exp(x if evidence > 0 else 0.3)) and np.allclose(drawn_sd, sd if evidence > 0 else 0.2), (evidence, factor, drawn_sd)
PY
check "learned.py refuses a model that has learned nothing, in one line" sh -c "! '$PYTHON' '$root/scripts/figures/learned.py' '$scratch/map.png' '$model' 2>'$scratch/log' && grep -q 'has learned no field' '$scratch/log'"

"$PYTHON" -B "$root/tests/serve/test_page_learned.py" "$TISSUECTL" "$scratch/whole.h5" "$model" || failures=$((failures + 1))

# ---- a stream, with bad lines in it
sed '6a a robot says hello' "$pokes" >"$scratch/with_bad.csv"
check "a stream continues after a bad line" adapt "$model" --data - --stream --json --out "$scratch/stream.h5" <"$scratch/with_bad.csv"
check "a bad line of a stream is reported with its number and cause" grep -q '"line":7,"status":"refused","why":"standard input:7: has 1 fields' "$scratch/out"
sed 's/refused/x/' "$scratch/log" >/dev/null
check "a stream with a bad line gives the same model as the file without it" same_learned "$scratch/whole.h5" "$scratch/stream.h5"
check "a file with a bad line is refused" sh -c "! '$TISSUECTL' adapt '$model' --data '$scratch/with_bad.csv' --out '$scratch/none.h5' 2>'$scratch/log'"
check "a file with a bad line: one line names file, line and cause" grep -q "with_bad.csv:7: has 1 fields, the header 6 columns" "$scratch/log"
check "a file with a bad line writes no model" absent "$scratch/none.h5"

# ---- pipes, which can be read once
mkfifo "$scratch/pokes"
cat "$pokes" >"$scratch/pokes" &
check "a model learns from measurements in a pipe" timeout 600 "$TISSUECTL" adapt "$model" --data "$scratch/pokes" --out "$scratch/piped.h5"
kill $! 2>/dev/null  # it blocks if adapt never opened the pipe
wait $!
check "measurements in a pipe give the same model as the file" same_learned "$scratch/whole.h5" "$scratch/piped.h5"
check "a model learns from measurements of standard input without --stream" sh -c "'$TISSUECTL' adapt '$model' --data - --out '$scratch/piped.h5' <'$pokes'"
check "measurements of standard input give the same model as the file" same_learned "$scratch/whole.h5" "$scratch/piped.h5"
check "empty standard input is refused" sh -c "! '$TISSUECTL' adapt '$model' --data - --out '$scratch/none.h5' </dev/null 2>'$scratch/log'"
check "empty standard input: one line states the cause" grep -q '^tissuectl: standard input: has no rows' "$scratch/log"

# ---- learning in two parts, and --forget
adapt "$model" --data "$pokes" --first 20 --out "$scratch/half.h5"
{ head -n 1 "$pokes"; tail -n +22 "$pokes"; } >"$scratch/rest.csv"
check "learning continues from the file of an adapted model" adapt "$scratch/half.h5" --data "$scratch/rest.csv" --out "$scratch/then.h5"
check "learning in two parts gives the same model as at once" same_learned "$scratch/whole.h5" "$scratch/then.h5"
check "--forget begins with the trained model" adapt "$scratch/whole.h5" --forget --data "$pokes" --first 20 --out "$scratch/again.h5"
check "--forget with half of the file gives the same model as the trained model with it" same_learned "$scratch/half.h5" "$scratch/again.h5"
sed 's/displacement_x \[mm\]/displacement_x [m]/' "$pokes" >"$scratch/metres.csv"
check "adapt accepts a file with displacements in a wrong unit" adapt "$model" --data "$scratch/metres.csv" --out "$scratch/metres.h5"
check "no measurement with a displacement in a wrong unit is learned" grep -q 'adapt: 0 learned' "$scratch/log"

# ---- during a session
check "a session that probes a target tissue learns" sh -c "'$TISSUE_HAPTIC' '$model' --motion probe --depth 0.004 --seconds 6 --no-clock --json \
    --hidden '$scratch/whole.h5' --learn '$scratch/live.h5' --journal '$scratch/live.csv' --record '$scratch/live-record.h5' >'$scratch/out' 2>'$scratch/log'"
check "a session prints its numbers of measurements and learned ones" grep -q '[1-9][0-9]* measurements, [1-9][0-9]* learned' "$scratch/log"
check "a session without a clock runs and records all 6000 ticks, without overruns" "$PYTHON" -c 'import h5py, json, numpy, sys
said = json.load(open(sys.argv[1]))
assert said["ticks"] == 6000 and said["misses"] == 0 and said["details"]["clock"] is False and said["details"]["lost_s"] == 0, said
with h5py.File(sys.argv[2]) as file:
    time = file["time"][:]
    assert len(time) == 6000 and abs(time - 1e-3 * numpy.arange(6000)).max() < 1e-9 and file.attrs["dropped_samples"] == 0' "$scratch/out" "$scratch/live-record.h5"
"$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 6 --no-clock --hidden "$scratch/whole.h5" --learn "$scratch/live-again.h5" --journal "$scratch/live-again.csv" >"$scratch/out" 2>"$scratch/log"
check "the same session without a clock learns the same model again" same_learned "$scratch/live.h5" "$scratch/live-again.h5"
check "the same session without a clock writes the same journal again" cmp "$scratch/live.csv" "$scratch/live-again.csv"
check "--no-clock is refused for device remote" sh -c "! '$TISSUE_HAPTIC' '$model' --device remote --no-clock 2>'$scratch/log' && grep -q -e '--no-clock: device remote needs the clock' '$scratch/log'"
check "adapt reads the journal of a session as measurements" adapt "$model" --data "$scratch/live.csv" --live --out "$scratch/replayed.h5"
check "the journal gives the same unknowns and constants as the session" "$PYTHON" -c 'import h5py, sys
a, b = (h5py.File(f) for f in sys.argv[1:])
assert (a["adaptation/x"][:] == b["adaptation/x"][:]).all() and (a["law/constants"][:] == b["law/constants"][:]).all()' "$scratch/live.h5" "$scratch/replayed.h5"
cp "$scratch/live.csv" "$scratch/live-before.csv"
check "a journal with measurements is not overwritten" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/live.csv' 2>'$scratch/log'"
check "a journal with measurements: one line states the cause" grep -q '^tissue-haptic: .*/live.csv: has measurements of an earlier session' "$scratch/log"
check "a journal with measurements is unchanged" cmp "$scratch/live.csv" "$scratch/live-before.csv"
for text in 'my notes, in one line' 'my notes\n' 'contact_x [m],contact_y [m],displacement_x [m],displacement_y [m],force_x [N],force_y [N]'; do
    printf "$text" >"$scratch/notes.txt"
    cp "$scratch/notes.txt" "$scratch/notes-before.txt"
    check "a file that is not a journal is refused: $text" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/notes.txt' 2>'$scratch/log'"
    check "a file that is not a journal: one line states the cause: $text" grep -q '^tissue-haptic: .*/notes.txt: exists and is not a journal: name another file' "$scratch/log"
    check "a file that is not a journal is unchanged: $text" cmp "$scratch/notes.txt" "$scratch/notes-before.txt"
done
head -n 1 "$scratch/live.csv" >"$scratch/begun.csv"
journal() { timeout 600 "$TISSUE_HAPTIC" "$model" --seconds 0.1 --no-realtime --learn "$scratch/none.h5" --journal "$1" 2>"$scratch/log"; }
head -n 1 "$scratch/live.csv" >"$scratch/header"
begins() { head -n 1 "$1" | cmp - "$scratch/header"; }
journal /dev/stdout >"$scratch/out"
check "a journal is written to standard output" grep -qxFf "$scratch/header" "$scratch/out"
journal /dev/stdout | cat >"$scratch/out"
check "a journal is written to a pipe on standard output" grep -qxFf "$scratch/header" "$scratch/out"
ln -s linked.csv "$scratch/own-link.csv"
journal "$scratch/own-link.csv" >"$scratch/out"
check "a journal is written through a link of the same user" begins "$scratch/linked.csv"
: >"$scratch/precious"
ln "$scratch/precious" "$scratch/hard.csv"
check "a journal that is a hard link is refused" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/hard.csv' 2>'$scratch/log'"
check "a journal that is a hard link: one line states the cause" grep -q '^tissue-haptic: .*/hard.csv: is a file with several hard links' "$scratch/log"
ln -s precious "$scratch/planted.csv"
if chown -h 65534 "$scratch/planted.csv" 2>/dev/null; then
    check "a journal that is a link of another user is refused" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/planted.csv' 2>'$scratch/log'"
    check "a journal that is a link of another user: one line states the cause" grep -q "^tissue-haptic: .*/planted.csv: cannot write: 'planted.csv' is a link of another user" "$scratch/log"
else
    skip "a journal that is a link of another user is refused" "only root can make one"
fi
mkdir "$scratch/folder"
for name in folder folder/ new/; do
    check "a journal with a folder's name is refused: $name" sh -c "! '$TISSUE_HAPTIC' '$model' --seconds 0.1 --no-clock --learn '$scratch/none.h5' --journal '$scratch/$name' 2>'$scratch/log'"
    check "a journal with a folder's name: one line states the cause, and no folder is made: $name" sh -c "grep -q '^tissue-haptic: .*/$name: is the name of a folder; give that of a file' '$scratch/log' && [ ! -e '$scratch/new' ]"
done
check "nothing is written through the links" test ! -s "$scratch/precious"
check "a journal without measurements is used" "$TISSUE_HAPTIC" "$model" --seconds 0.1 --learn "$scratch/begun.h5" --journal "$scratch/begun.csv" >"$scratch/out" 2>"$scratch/log"
: >"$scratch/held.csv"
check "a journal that another session writes is refused" sh -c "! flock '$scratch/held.csv' '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/held.csv' 2>'$scratch/log'"
check "a journal that another session writes: one line states the cause" grep -q '^tissue-haptic: .*/held.csv: another session is writing it' "$scratch/log"
# a preloaded library simulates a disk without locks
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
check "a journal on a disk without locks is refused" sh -c "! UNLOCKED='$scratch/held.csv' LD_PRELOAD='$scratch/no_locks.so' '$TISSUE_HAPTIC' '$model' --seconds 0.1 --learn '$scratch/none.h5' --journal '$scratch/held.csv' 2>'$scratch/log'"
check "a journal on a disk without locks: one line states the system's cause" grep -q '^tissue-haptic: .*/held.csv: cannot be locked: No locks available' "$scratch/log"

# a target tissue that is stiffer than a session may learn, and a model that has learned to be that stiff
awk -F, -v OFS=, 'NR > 1 { for (k = 5; k <= NF; ++k) $k *= 9 } 1' "$pokes" >"$scratch/stiff.csv"
adapt "$model" --data "$scratch/stiff.csv" --out "$scratch/stiff.h5"
session() { # MODEL NAME: a session from that model on the stiff target tissue
    "$TISSUE_HAPTIC" "$1" --motion probe --depth 0.004 --seconds 6 --no-clock --hidden "$scratch/stiff.h5" --learn "$scratch/$2.h5" --journal "$scratch/$2.csv" >"$scratch/out" 2>"$scratch/log"
}
largest() { "$PYTHON" -c 'import h5py, numpy, sys
file = h5py.File(sys.argv[1])
x = max(abs(file["adaptation/x"][:]).max(), abs(file["adaptation"].attrs["scale"]))
assert float(sys.argv[2]) <= x <= float(sys.argv[3]), x' "$@"; }
check "a model that learns from nine-fold forces has a largest log factor of 1.9 to 2.5" largest "$scratch/stiff.h5" 1.9 2.5
check "a session on the stiff target tissue succeeds" session "$model" bounded
check "the log factor that a session learns is limited to 1.5 (4.5 times)" largest "$scratch/bounded.h5" 1.45 1.5000001
check "adapt learns from the journal of the bounded session" adapt "$model" --data "$scratch/bounded.csv" --live --out "$scratch/replayed.h5"
check "the journal of the bounded session gives the same model" same_learned "$scratch/bounded.h5" "$scratch/replayed.h5"
check "a session from the stiff model succeeds" session "$scratch/stiff.h5" stays
check "a session from the stiff model keeps its factor" largest "$scratch/stays.h5" 1.9 2.5
check "adapt learns from the journal of the session with the stiff model" adapt "$scratch/stiff.h5" --data "$scratch/stays.csv" --live --out "$scratch/replayed.h5"
check "the journal of the session with the stiff model gives the same model" same_learned "$scratch/stays.h5" "$scratch/replayed.h5"
check "--live is refused together with --noise" sh -c "! '$TISSUECTL' adapt '$model' --data '$scratch/live.csv' --live --noise 0.03 --out '$scratch/none.h5' 2>/dev/null"

# sessions with a disturbance: they run until it has happened and are then terminated
told() { [ "$(grep -c '^tissue-haptic [0-9.]* s: ' "$scratch/log")" -ge "$1" ]; }  # at least that many measurements
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
check "a session whose recording cannot be kept ends with exit status 1" test $ended = 1
check "a session whose recording cannot be kept writes its model and statistics" sh -c "'$TISSUECTL' info '$scratch/kept.h5' | grep -q adaptation/x && grep -q ticks '$scratch/out'"
"$PYTHON" -c 'import os, resource, signal, subprocess, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
journal = sys.argv[-1]
session = subprocess.Popen(sys.argv[1:], restore_signals=False, stderr=subprocess.PIPE, text=True)  # the limit would apply to the log too
def readings(more):  # waits for that many measurements
    for line in session.stderr:
        sys.stderr.write(line)
        more -= line.startswith("tissue-haptic ") and " s: " in line
        if more == 0: break
readings(2)  # the first one is in the journal by then
full = os.path.getsize(journal) + 20  # less than one row more
resource.prlimit(session.pid, resource.RLIMIT_FSIZE, (full, full))
readings(3)
session.terminate()
sys.stderr.write(session.communicate()[1])
sys.exit(session.returncode)' "$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --seconds 0 --no-clock --hidden "$scratch/whole.h5" --learn "$scratch/full.h5" --journal "$scratch/full.csv" \
    >"$scratch/out" 2>"$scratch/log"
ended=$?
check "a session on a full disk ends with exit status 1" test $ended = 1
check "a session on a full disk: one line for each incomplete file" sh -c "grep -q '/full.h5: .*cannot write' '$scratch/log' && grep -q '/full.csv: could not be written completely' '$scratch/log'"
check "the journal of a session on a full disk has complete rows" "$PYTHON" -c 'import sys
lines = open(sys.argv[1]).read().split("\n")
assert len(lines) > 2 and lines[-1] == "" and all(len(l.split(",")) == 6 for l in lines[:-1]), lines' "$scratch/full.csv"
check "no session begins if the model cannot be written" sh -c "! '$TISSUE_HAPTIC' '$model' --motion probe --seconds 60 --learn '$scratch/no/where.h5' 2>'$scratch/log'"
check "a model that cannot be written: one line names it" grep -q '^tissue-haptic: .*no/where.h5' "$scratch/log"
mkfifo "$scratch/pipe"
head -n 1 "$scratch/pipe" >/dev/null &  # reads the header and no measurement
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
check "a session whose journal pipe is closed ends with exit status 1" test $ended = 1
check "a closed journal pipe: one line states the cause" grep -q '^tissue-haptic: .*/pipe: could not be written completely' "$scratch/log"
check "a session whose journal pipe is closed writes its model" exist "$scratch/broken.h5"
check "no session begins if the journal cannot be written" sh -c "! '$TISSUE_HAPTIC' '$model' --learn '$scratch/none.h5' --journal /dev/full 2>'$scratch/log' &&
    grep -q '^tissue-haptic: /dev/full: cannot be written' '$scratch/log'"
check "a journal without --learn is refused" sh -c "! '$TISSUE_HAPTIC' '$model' --journal x.csv --seconds 0.1 2>/dev/null"
finish
