#!/bin/bash
# Alone: its ticks keep real time. kill -9 of what learns and records, TISSUE_KILLS times each (4): `tissuectl adapt` of a file and of a stream, `tissuectl serve` and `tissue-haptic` that
# record, learn and keep a journal. What stood before stands, nothing half-written does, and the next run comes to what one that nobody killed came to.
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
found=0
for _ in 1 2 3 4 5 6 7 8 9 10; do strike 0 sleep 5 && found=$((found + 1)); done
check "a kill that comes as soon as a command begins finds its group" test $found = 10
make_copy
poked_tissue
count=${TISSUE_KILLS:-4}
out=$scratch/out
mkdir "$out"

adapt() { "$TISSUECTL" adapt "$@" >"$scratch/said_by_adapt" 2>&1 || { cat "$scratch/said_by_adapt"; return 1; }; }
remember() { "$@" || fallen=1; } >>"$scratch/seen_after_kills" 2>&1
all_held() { [ $fallen = 0 ] || { cat "$scratch/seen_after_kills"; return 1; }; }
fallen=0

# ---- adapt, a file: what stood there stands, or the new one does
check "a file is learned from when nobody kills" adapt "$model" --data "$pokes" --out "$scratch/whole.h5"
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
check "adapt of a file: after every kill the earlier model stands, or the whole new one" all_held
check "adapt of a file: the next run succeeds" adapt "$model" --data "$pokes" --out "$out/model.h5"
check "adapt of a file: with the same model to the last bit" same_learned "$out/model.h5" "$scratch/whole.h5"
check "adapt of a file: nothing half-written is left" no_half_files "$out"

# ---- adapt, a stream: the model after some poke stands there, and goes on with the next
length=$(milliseconds sh -c '"$1" adapt "$2" --data - --stream --out "$3" <"$4" >/dev/null 2>&1' - "$TISSUECTL" "$model" "$scratch/stream.h5" "$pokes")
check "a stream comes to the same model when nobody kills" same_learned "$scratch/stream.h5" "$scratch/whole.h5"
taken() { # how many rows the model has seen
    "$PYTHON" -c 'import h5py, sys
print(sum(int(h5py.File(sys.argv[1])["adaptation"].attrs[k]) for k in ("learned", "gated", "refused")))' "$1"
}
goes_on() { # from where it stands, or from the beginning
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
check "adapt of a stream: after every kill it goes on with the poke after the last that is in the file, to the same model" all_held
check "adapt of a stream: nothing half-written is left" no_half_files "$out"

# ---- sessions: the recording and the model of the session before stand; the journal has all that was learned, but for the last
rows_whole() { # FILE: every line has as many fields as the first, and the last has ended
    [ ! -s "$1" ] || awk -F, 'NR == 1 { n = NF } NF != n { exit 1 }' "$1" && [ -z "$(tail -c 1 "$1" 2>/dev/null)" ]
}
teaches() { # FILE: of a session that was killed
    [ ! -e "$1" ] || [ "$(wc -l <"$1")" -le 1 ] || adapt "$model" --data "$1" --live --out "$scratch/taught.h5"
}
as_before() { cmp "$out/record.h5" "$scratch/record.h5" && cmp "$out/learned.h5" "$scratch/learned.h5"; }
none() { :; }
has_row() { [ "$(wc -l 2>/dev/null <"$scratch/journal.csv")" -ge 2 ]; } 2>/dev/null
session() { # NAME LENGTH COMMAND...: killed, and then one that lasts a second
    name=$1 length=$2
    shift 2
    nothing
    run "$@" --record "$out/record.h5" --learn "$out/learned.h5" --seconds 2
    check "$name: a session that nobody kills ends well" exited 0
    cp "$out/record.h5" "$out/learned.h5" "$scratch"
    rows=0 fallen=0
    : >"$scratch/seen_after_kills"
    for moment in $(moments "$count" "$length") row; do
        rm -f "$scratch/journal.csv"
        strike_when=
        if [ $moment = row ]; then strike_when=has_row moment=0; fi  # on a slow machine none comes before the moments drawn
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
    check "$name: after every kill the session before stands, and the journal can be learned from" all_held
    check "$name: the journals of killed sessions have rows" test "$rows" -gt 0
    run "$@" --record "$out/record.h5" --learn "$out/learned.h5" --seconds 1
    check "$name: the next session ends well" exited 0
    check "$name: and has a recording and a model of its own" sh -c '"$1" info "$2/record.h5" && "$1" info "$2/learned.h5" && ! cmp -s "$2/record.h5" "$3/record.h5"' - "$TISSUECTL" "$out" \
        "$scratch"
    check "$name: nothing half-written is left" no_half_files "$out"
}
session "tissuectl serve" 9000 "$TISSUECTL" serve "$model" --port 0 --hidden "$scratch/whole.h5"
session "tissue-haptic" 6000 "$TISSUE_HAPTIC" "$model" --motion probe --depth 0.004 --hidden "$scratch/whole.h5"
finish_kills "adapt of a file and of a stream, serve and tissue-haptic that record and learn"
