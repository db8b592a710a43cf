#!/bin/sh
# Alone: its ticks keep real time. tissuectl serve from outside: what it serves, to whom, what it refuses, and how it ends.
. "$(dirname "$0")/common"
make_copy
make_tiny train -j2
check "the study is trained to begin with" exited 0
PYTHONDONTWRITEBYTECODE=1 "$PYTHON" "$root/tests/serve/check_server.py" "$work/build/release/tissuectl" "$R/model.h5" "$scratch" \
    || failures=$((failures + 1))
"$work/build/release/tissuectl" serve "$R/model.h5" --port 0 --seconds 1 --no-realtime --record "$scratch/unread.h5" 2>&1 >/dev/null | true
check "a session whose lines nobody reads writes its recording" test -s "$scratch/unread.h5"
finish
