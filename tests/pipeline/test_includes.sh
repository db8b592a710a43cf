#!/bin/sh
# Includes have one direction: a folder of lib/ includes its own headers, those of earlier folders, io and the headers
# of lib/ itself; io includes no other folder. Needs no built program. SOURCES: another lib/ to check.
. "$(dirname "$0")/common"
order="mesh surface_file springs study cases train adapt haptic eval export api"
SOURCES=${SOURCES:-$root/lib}

# arrows FOLDER: prints every include with a folder as "FROM TO FILE", once
arrows() {
    (cd "$1" && grep -rHo --include='*.h' --include='*.cpp' '^ *# *include *"[^"]*/' .) |
        sed 's|^\./\(\([^/:]*\)[^:]*\):.*"\([^/"]*\)/.*|\2 \3 \1|' | sort -u
}
# runs_back_up FOLDER: prints includes of a later folder, one per line; nothing if there are none
runs_back_up() {
    arrows "$1" | awk -v order="$order" '
        BEGIN { count = split(order, name); for (i = 1; i <= count; i++) place[name[i]] = i
                place["io"] = 0 }
        !($1 in place) || !($2 in place) { print $3 ": includes " $2 "/, which has no place in the order"; next }
        place[$2] > place[$1] { print $3 ": includes " $2 "/, which comes after " $1 "/" }'
}
none_of() { [ -z "$1" ] || { echo "$1"; return 1; }; }

check "every folder of lib is in the order" \
    none_of "$(for folder in "$SOURCES"/*/; do case " $order io " in *" $(basename "$folder") "*) ;; *) echo "$folder" ;; esac; done)"
check "no file of lib includes a later folder" none_of "$(runs_back_up "$SOURCES")"
check "haptic includes no header of study, cases, train or eval" \
    none_of "$(arrows "$SOURCES" | grep -E '^haptic (study|cases|train|eval) ')"
check "only io includes HDF5" none_of "$(grep -rl 'include *<\(hdf5\|H5\)' "$SOURCES" | grep -v /io/)"

# test of the check, on a lib/ with wrong includes
mkdir -p "$scratch/lib/io" "$scratch/lib/mesh" "$scratch/lib/train"
echo '#include "mesh/shape.h"' >"$scratch/lib/io/store.h"
echo '#include "train/spsa.h"' >"$scratch/lib/mesh/shape.h"
echo '#include "mesh/shape.h"' >"$scratch/lib/train/spsa.cpp"
check "the check reports an include of a later folder, and not one of an earlier folder" \
    sh -c '[ "$(echo "$0" | cut -d: -f1 | tr "\n" " ")" = "io/store.h mesh/shape.h " ]' "$(runs_back_up "$scratch/lib")"
finish
