#!/bin/bash
# Alone: its ticks keep real time. kill -9 of learning and recording, TISSUE_KILLS times each (4): `tissuectl adapt` of
# a file and of a stream, and `tissuectl serve` and `tissue-haptic` with a recording, learning and a journal. Earlier
# files are kept, no incomplete file has its final name, and the next run gives the result of an undisturbed one.
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
found=0
for _ in 1 2 3 4 5 6 7 8 9 10; do strike 0 sleep 5 && found=$((found + 1)); done
check "strike with 0 ms kills a running group, 10 times of 10" test $found = 10
make_copy
poked_tissue
count=${TISSUE_KILLS:-4}
out=$scratch/out
mkdir "$out"

adapt() { "$TISSUECTL" adapt "$@" >"$scratch/said_by_adapt" 2>&1 || { cat "$scratch/said_by_adapt"; return 1; }; }
remember() { "$@" || fallen=1; } >>"$scratch/seen_after_kills" 2>&1
all_held() { [ $fallen = 0 ] || { cat "$scratch/seen_after_kills"; return 1; }; }
fallen=0

# ---- adapt of a file: the earlier model or the new one is there
check "adapt of a file succeeds without kills" adapt "$model" --data "$pokes" --out "$scratch/whole.h5"
adapt "$model" --data "$pokes" --first 20 --out "$scratch/half.h5"
length=$(milliseconds adapt "$model" --data "$pokes" --out "$scratch/again.h5")
stands_or_done() { cmp -s "$out/model.h5" "$scratch/half.h5" || same_learned "$out/model.h5" "$scratch/whole.h5"; }
put_back() { cp "$scratch/half.h5" "$out/model.h5"; }
for moment in $(moments "$count" "$length"); do
    put_back
    strike_running "$moment" put_back "$TISSUECTL" adapt "$model" --data "$pokes" --out "$out/model.h5"
    remember stands_or_done
    remember whole_files "$out"
done
check "adapt of a file: after every kill the earlier model or the complete new one is there" all_held
check "adapt of a file: the next run succeeds" adapt "$model" --data "$pokes" --out "$out/model.h5"
check "adapt of a file: the next run gives the same model" same_learned "$out/model.h5" "$scratch/whole.h5"
check "adapt of a file: no incomplete file is left" no_half_files "$out"

# ---- adapt of a stream: the model after some measurement is there, and learning continues with the next
length=$(milliseconds sh -c '"$1" adapt "$2" --data - --stream --out "$3" <"$4" >/dev/null 2>&1' - "$TISSUECTL" "$model" "$scratch/stream.h5" "$pokes")
check "adapt of a stream without kills gives the same model as the file" same_learned "$scratch/stream.h5" "$scratch/whole.h5"
taken() { # number of rows that the model has processed
    "$PYTHON" -c 'import h5py, sys
print(sum(int(h5py.File(sys.argv[1])["adaptation"].attrs[k]) for k in ("learned", "gated", "refused")))' "$1"
}
goes_on() { # continues after the last processed row, or from the beginning
    from=$model rows=0
    if [ -e "$out/model.h5" ]; then from=$out/model.h5 rows=$(taken "$out/model.h5"); fi
    { head -n 1 "$pokes"; tail -n +$((rows + 2)) "$pokes"; } >"$scratch/rest.csv"
    [ "$(wc -l <"$scratch/rest.csv")" -gt 1 ] || return 0
    "$TISSUECTL" adapt "$from" --data - --stream --out "$out/model.h5" <"$scratch/rest.csv" >"$scratch/said_by_adapt" 2>&1 || { cat "$scratch/said_by_adapt"; return 1; }
}
nothing() { rm -f "$out"/*; }
feed=$pokes
for moment in $(moments "$count" "$length"); do
    nothing
    strike_running "$moment" nothing "$TISSUECTL" adapt "$model" --data - --stream --out "$out/model.h5"
    remember whole_files "$out"
    remember goes_on
    remember same_learned "$out/model.h5" "$scratch/whole.h5"
done
feed=/dev/null
check "adapt of a stream: after every kill it continues after the last row in the file, to the same model" all_held
check "adapt of a stream: no incomplete file is left" no_half_files "$out"

# ---- sessions: recording and model of the earlier session are kept; the journal has all learned measurements but
# possibly the last
rows_whole() { # FILE: every line has as many fields as the first, and the last line is complete
    [ ! -s "$1" ] || awk -F, 'NR == 1 { n = NF } NF != n { exit 1 }' "$1" && [ -z "$(tail -c 1 "$1" 2>/dev/null)" ]
}
teaches() { # FILE: adapt learns from the journal of a killed session
    [ ! -e "$1" ] || [ "$(wc -l <"$1")" -le 1 ] || adapt "$model" --data "$1" --live --out "$scratch/taught.h5"
}
as_before() { cmp "$out/record.h5" "$scratch/record.h5" && cmp "$out/learned.h5" "$scratch/learned.h5"; }
none() { :; }
has_row() { [ "$(wc -l 2>/dev/null <"$scratch/journal.csv")" -ge 2 ]; } 2>/dev/null
session() { # NAME LENGTH COMMAND...: a session is killed several times; then one runs for a second
    name=$1 length=$2
    shift 2
    nothing
    run "$@" --record "$out/record.h5" --learn "$out/learned.h5" --seconds 2
    check "$name: a session without kills succeeds" exited 0
    cp "$out/record.h5" "$out/learned.h5" "$scratch"
    rows=0 fallen=0
    : >"$scratch/seen_after_kills"
    for moment in $(moments "$count" "$length") row; do
        rm -f "$scratch/journal.csv"
        strike_when=
        if [ $moment = row ]; then strike_when=has_row moment=0; fi  # on a slow machine no row may come before the drawn times
        strike_running "$moment" none "$@" --record "$out/record.h5" --learn "$out/learned.h5" --journal "$scratch/journal.csv" --seconds 600
        remember as_before
        remember whole_files "$out"
        remember rows_whole "$scratch/journal.csv"
        remember teaches "$scratch/journal.csv"
        told=$(grep -c '^tissue-haptic [0-9.]* s: ' "$said")
        seen=$(wc -l <"$scratch/journal.csv" 2>/dev/null || echo 1)
        remember test $((seen - 1)) -ge $((told - 1))
        rows=$((rows + seen - 1))
    done
    check "$name: after every kill the earlier session's files are kept, and adapt learns from the journal" all_held
    check "$name: the journals of killed sessions have rows" test "$rows" -gt 0
    run "$@" --record "$out/record.h5" --learn "$out/learned.h5" --seconds 1
    check "$name: the next session succeeds" exited 0
    check "$name: the next session writes a new recording and a model" sh -c '"$1" info "$2/record.h5" && "$1" info "$2/learned.h5" && ! cmp -s "$2/record.h5" "$3/record.h5"' - "$TISSUECTL" "$out" \
        "$scratch"
    check "$name: no incomplete file is left" no_half_files "$out"
}
session "tissuectl serve" 9000 "$TISSUECTL" serve "$model" --port 0 --hidden "$scratch/whole.h5"
session "tissue-haptic" 6000 "$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --hidden "$scratch/whole.h5"
finish_kills "adapt of a file and of a stream, serve and tissue-haptic that record and learn"
