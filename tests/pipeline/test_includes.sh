#!/bin/sh
# Arrows run one way: a folder of lib/ includes its own headers, those of folders before it, io and the headers of lib/
# itself; io, at the bottom, includes no other folder. Needs no built program. SOURCES: another lib/ to look at.
. "$(dirname "$0")/common"
order="mesh surface_file springs study cases train adapt haptic eval export api"
SOURCES=${SOURCES:-$root/lib}

# arrows FOLDER: every include of another folder as "FROM TO FILE", once
arrows() {
    (cd "$1" && grep -rHo --include='*.h' --include='*.cpp' '^ *# *include *"[^"]*/' .) |
        sed 's|^\./\(\([^/:]*\)[^:]*\):.*"\([^/"]*\)/.*|\2 \3 \1|' | sort -u
}
# runs_back_up FOLDER: those that do, one a line; nothing when all is well
runs_back_up() {
    arrows "$1" | awk -v order="$order" '
        BEGIN { count = split(order, name); for (i = 1; i <= count; i++) place[name[i]] = i
                place["io"] = 0 }
        !($1 in place) || !($2 in place) { print $3 ": includes " $2 "/, which has no place in the order"; next }
        place[$2] > place[$1] { print $3 ": includes " $2 "/, which comes after " $1 "/" }'
}
none_of() { [ -z "$1" ] || { echo "$1"; return 1; }; }

check "every folder of lib has its place in the order" \
    none_of "$(for folder in "$SOURCES"/*/; do case " $order io " in *" $(basename "$folder") "*) ;; *) echo "$folder" ;; esac; done)"
check "no include of lib runs back up" none_of "$(runs_back_up "$SOURCES")"
check "the realtime core needs nothing of study, cases, train or eval" \
    none_of "$(arrows "$SOURCES" | grep -E '^haptic (study|cases|train|eval) ')"
check "nothing but io includes HDF5" none_of "$(grep -rl 'include *<\(hdf5\|H5\)' "$SOURCES" | grep -v /io/)"

# the walk itself, on a house with one arrow of each wrong kind
mkdir -p "$scratch/lib/io" "$scratch/lib/mesh" "$scratch/lib/train"
echo '#include "mesh/shape.h"' >"$scratch/lib/io/store.h"
echo '#include "train/spsa.h"' >"$scratch/lib/mesh/shape.h"
echo '#include "mesh/shape.h"' >"$scratch/lib/train/spsa.cpp"
check "an arrow that runs back up is seen, one that runs down is not" \
    sh -c '[ "$(echo "$0" | cut -d: -f1 | tr "\n" " ")" = "io/store.h mesh/shape.h " ]' "$(runs_back_up "$scratch/lib")"
finish
