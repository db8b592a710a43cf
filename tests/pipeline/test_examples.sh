#!/bin/sh
# Alone: ticks and clients keep real time. The examples of lib/api/examples, built and run as their head says: against
# the installed library and module, a real tissue-haptic over UDP, and a program that sends forged forces.
# shellcheck disable=SC2046,SC2086  # flags, and a client with its interpreter, are words of their own
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
examples=$root/lib/api/examples
prefix=$scratch/prefix
PREFIX=$prefix PACKAGES="$(sed -n 's/^PACKAGES := //p' "$root/Makefile")" PYTHON=$PYTHON "$root/scripts/install" "$(dirname "$TISSUECTL")" || exit 1
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig" LD_LIBRARY_PATH="$prefix/lib" PYTHONPATH="$(echo "$prefix"/lib/python3*/dist-packages)" PATH="$prefix/bin:$PATH"
export MPLCONFIGDIR="$scratch"
work=$scratch

# a model of measured contacts, $model, and measurements of a target tissue, $pokes
mkdir -p "$work/fem/studies" "$work/fem/data"
poked_tissue
measured=$model
# one of finite elements, with one contact to train on
work="$scratch/a copy"
make_copy
cat >"$work/fem/studies/tiny.toml" <<'TOML'
based_on = "surface-quick"

[lattice]
cells = [6, 6]

[loads.sweep]
arcs_m = [0.150]

[draws.validation]
count = 1

[draws.held_out]
count = 1

[draws.held_out_full]
count = 1
TOML
make_tiny results/tiny/model.h5 -j2
check "make trains an energy model" exited 0
model=$R/model.h5
work=$scratch
cd "$work" || exit 1

# ---- every example is run here or by test_gym.sh
check "every file of lib/api/examples is in a test" sh -c 'for file in "$1"/*; do grep -q "${file##*/}" "$2" "$3" || { echo "${file##*/}"; exit 1; }; done' - "$examples" "$root/tests/pipeline/test_examples.sh" "$root/tests/pipeline/test_gym.sh"
check "the table of lib/api/ENGINES.md has every program of lib/api/examples" sh -c 'for file in "$1"/*; do grep -q "](examples/${file##*/})" "$2" || { echo "${file##*/}"; exit 1; }; done' - "$examples" "$root/lib/api/ENGINES.md"

# numbers PATTERN: what the groups of the pattern (Python's re) match in the output, else nothing
numbers() { "$PYTHON" -c 'import re, sys
found = re.search(sys.argv[1], open(sys.argv[2]).read())
print(*found.groups() if found else "")' "$1" "$said"; }
# holds CONDITION NUMBER...: of awk, with $1, $2, ...
holds() {
    condition=$1
    shift
    echo "$@" | awk "{ exit !($condition) }" || { echo "$condition: $*"; cat "$said"; return 1; }
}

# ---- press, plot, film
run gcc -std=c99 -Wall -Wextra -Wpedantic -Werror "$examples/press.c" $(pkg-config --cflags --libs tissue-c) -o press
check "press.c builds" exited 0
printf '0.05 0.102 0\n0.05 0.1005 0\n0.05 0.099 0\n0.05 0.0975 0\n' >way
run sh -c './press "$1" <way' - "$model"
check "press.c: the tissue pushes the hand up, and the hand gives energy" sh -c 'grep -q "pressed with law: the tissue, [0-9.e-]* J from the hand" "$1" && tail -n 2 "$1" | grep -q "0x1"' - "$said"
run "$PYTHON" "$examples/press.py" "$model" press.png
check "press.py presses a tissue and writes a picture" exist press.png
check "press.py: the model's force at its training contacts is that of finite elements within 5 %" holds '$1 > 0 && $1 < 5' "$(numbers 'training contacts, median ([0-9.e-]*) %')"
run "$PYTHON" "$examples/film.py" "$model" film.gif 0.4
check "film.py films an indentation" exited 0
check "film.py writes as many different frames as it prints" "$PYTHON" - film.gif "$(numbers ': ([0-9]*) frames, ([0-9]*) ticks, largest force ([0-9.e-]*) N')" <<'PY'
import sys

from PIL import Image
frames, ticks, force = sys.argv[2].split()
film = Image.open(sys.argv[1])
assert film.n_frames == int(frames) == 10 and int(ticks) == 400 and float(force) > 0.1, (film.n_frames, sys.argv[2])
pictures = set()
for k in range(film.n_frames):
    film.seek(k)
    pictures.add(film.convert("RGB").tobytes())
assert len(pictures) == film.n_frames, len(pictures)
PY
run "$PYTHON" "$examples/film.py" "$model" film.avi
check "film.py refuses an unknown kind of film in one line" one_line '^film: film.avi: name a .gif or .webp, or install ffmpeg and name an .mp4'

# ---- two tools
run gcc -std=c99 -Wall -Wextra -Wpedantic -Werror "$examples/two_tools.c" $(pkg-config --cflags --libs tissue-c) -lm -o two_tools
check "two_tools.c builds" exited 0
run ./two_tools "$model" 0.035 0.1 0 0.065 0.1 0 0 -0.005 0
for tool in 1 2; do
    check "two_tools.c: tool $tool beside the other one has less force than alone" holds '$1 > 0.1 && $2 > 0.1 && $2 < 0.95 * $1' "$(numbers "tool $tool: ([0-9.]*) N alone, ([0-9.]*) N with")"
done
run ./two_tools "$model" 0.035 0.1 0 0.065 0.1 0 0 -5 0
check "two_tools.c ends with a refused position, in one line" one_line '^two_tools: the position was refused: not finite, too fast or too old$'
run ./two_tools "$model" 0.035 0.1 0 0.065 0.1 0 0 five 0
check "two_tools.c refuses a word for a number: exit 2" exited 2

# ---- adapt
head -n 25 "$pokes" >half.csv
{ head -n 1 "$pokes"; tail -n +26 "$pokes"; } >test.csv
run "$examples/adapt.sh" "$measured" half.csv test.csv adapted.h5
check "adapt.sh adapts a model" exited 0
check "adapt.sh: the test error afterwards is less than half of that before" holds '$2 > 0 && $2 < 0.5 * $1' \
    "$(numbers 'before the first measurement: test error ([0-9.]*) %')" "$(numbers 'of the file: test error ([0-9.]*) %')"
check "adapt.sh prints three places to measure next, with units" test "$(grep -c '^adapt next: at [0-9., ]* mm by [-0-9., ]* mm: ' "$said")" = 3
check "adapt.sh writes a model that plays" "$TISSUE_HAPTIC" adapted.h5 --seconds 0.1 --no-clock
run "$examples/adapt.sh" "$measured" way test.csv none.h5
check "adapt.sh: a file that is refused has one line with its name and the cause" one_line '^tissuectl: way:1: '
run "$examples/adapt.sh" "$measured" half.csv
check "adapt.sh with too few arguments: exit 2" exited 2
check "adapt.sh writes nothing where it fails" absent none.h5

# ---- the loops of CHAI3D, with its stand-in
run g++ -std=c++17 -O1 -Wall -Wextra -Wpedantic -Wshadow -Werror "$examples/chai3d_loop.cpp" -pthread $(pkg-config --cflags --libs tissue-c) -o chai3d_loop
check "chai3d_loop.cpp builds without CHAI3D" exited 0
run ./chai3d_loop "$model" 2 axes y,z offset "0.05 0.102"
check "chai3d_loop.cpp: the haptic thread ticks faster than the graphics, which see the tissue move" holds '$1 > 120 && $2 > 0.1 && $3 > 1 && $3 < 7' \
    "$(numbers '^([0-9]*) ticks, 120 frames, largest force ([0-9.]*) N, largest displacement ([0-9.]*) mm')"
run ./chai3d_loop "$model" 2 frction 0.3
check "chai3d_loop.cpp prints an error of the library in one line" one_line "^chai3d_loop: there is no option 'frction'"

# ---- clients over UDP, in C++ and C#
# played ARGUMENT...: plays the model to a client; what both print is in $said and $scratch/statistics. Where the machine
# stops a client for 50 ms as it enters the tissue, its position is stale, and there is no force until the tool has been
# outside again: then once more.
played() {
    for _ in 1 2 3; do
        play "$@"
        grep -q 'pushed with up to 0.0000 N' "$said" || break
    done
}
play() {
    port=$((40000 + ($$ + ${tries:=0}) % 20000))
    tries=$((tries + 7))
    "$TISSUE_HAPTIC" "$model" --device remote --port $port --seconds 0 --no-heuristic --json >"$scratch/statistics" 2>"$scratch/log" &
    program=$!
    wait_for sh -c "grep -q coupling '$scratch/log' || ! kill -0 $program"
    what=$1
    shift
    run $client "$what" $port "$@"
    kill -TERM $program
    wait $program || cat "$scratch/log"
}
statistics() { "$PYTHON" -c 'import json, sys
s = json.load(open(sys.argv[1]))
d = s["details"]["device"]
assert eval(sys.argv[2]), s' "$scratch/statistics" "$1"; }
forged() { run "$PYTHON" "$root/tests/pipeline/forged_forces.py" "$@" $client press PORT 0.05 0.1 0 0 -0.005 0 1 500; }
with_client() { # NAME: checks of one client, $client
    played press 0.05 0.1 0 0 -0.005 0 2
    force=$(numbers 'pushed with up to ([0-9.]*) N, pulled with up to ([0-9.]*) N, at the end ([0-9.]*) N')
    check "$1: the tissue pushes, and the force ends outside" holds '$1 > 0.1 && $3 == 0' "$force"
    check "$1 receives the largest force of the program" statistics "abs(s['force_max_N'] - ${force%% *}) < 0.02 * s['force_max_N']"
    check "$1 is the program's peer, and every datagram is one of its format" statistics "d['received'] > 500 and d['foreign'] == d['leaps'] == d['others'] == d['late'] == s['details']['jumps'] == 0"
    answers=$(numbers 'sent ([0-9]*), answers ([0-9]*), refused ([0-9]*)')
    check "$1 uses the program's forces and refuses none" holds '$2 > 500 && $3 == 0' "$answers"
    slow=${force%% *}
    played press 0.05 0.1 0 0 -0.005 0 2 90
    check "$1: at 90 positions a second the force is that at 1000 within 5 %" holds '$2 > 0.95 * $1 && $2 < 1.05 * $1' "$slow" "$(numbers 'pushed with up to ([0-9.]*) N')"
    played grasp 0.05 0.1 0 0 -0.005 0 2
    check "$1: a tool that grasps is pulled back by the tissue, and lets go" holds '$1 > 0.1 && $2 > 0.1 && $3 == 0' "$(numbers 'pushed with up to ([0-9.]*) N, pulled with up to ([0-9.]*) N, at the end ([0-9.]*) N')"
    forged 0.25 0 200
    check "$1 ignores forged and invalid forces, and forces of another socket" says 'pushed with up to 0.2500 N, pulled with up to 0.0000 N, at the end 0.0000 N'
    check "$1 counts what it refuses" holds '$2 > 10 && $2 <= 200 && $3 > 100' "$(numbers 'sent ([0-9]*), answers ([0-9]*), refused ([0-9]*)')"
    forged 1000 0 200
    check "$1 limits the force to 3.3 N" says 'pushed with up to 3.3000 N, pulled with up to 0.0000 N, at the end 0.0000 N'
    forged 1 50 200
    check "$1 has no force where the newest is 0.1 s old" says 'pushed with up to 0.0000 N, pulled with up to 0.0000 N, at the end 0.0000 N'
    check "$1 has received those forces" holds '$2 > 10' "$(numbers 'sent ([0-9]*), answers ([0-9]*), refused ([0-9]*)')"
    run $client press $port 0.05 0.1 0 0 -0.005 0 0.1
    check "$1 without a program: exit 1" exited 1
    run $client press $port 0.05 0.1 0 0 nan 0
    check "$1 refuses a displacement that is not a number: exit 2" exited 2
    check "$1 prints its arguments in one line" one_line '^usage: .* press|grasp PORT X Y Z DX DY DZ'
}
run g++ -std=c++17 -O1 -Wall -Wextra -Wpedantic -Wshadow -Werror "$examples/udp_press.cpp" -o udp_press
check "udp_press.cpp and udp_device.h build without tissuectl" exited 0
client=./udp_press
with_client "the client in C++"
if command -v mcs >/dev/null && command -v mono >/dev/null; then
    run mcs -warnaserror -warn:4 -out:UdpPress.exe "$examples/UdpPress.cs" "$examples/UdpDevice.cs"
    check "UdpPress.cs and UdpDevice.cs build" exited 0
    client="mono UdpPress.exe"
    with_client "the client in C#"
else
    skip "the client in C#" "no mcs and mono (Debian's mono-mcs and mono-runtime)"
fi
finish
