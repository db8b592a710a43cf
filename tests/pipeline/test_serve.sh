#!/bin/sh
# Alone: its ticks keep real time. tissuectl serve seen by clients: access, content, refusals and its end.
. "$(dirname "$0")/common"
make_copy
make_tiny train -j2
check "make trains the study" exited 0
PYTHONDONTWRITEBYTECODE=1 "$PYTHON" "$root/tests/serve/check_server.py" "$work/build/release/tissuectl" "$R/model.h5" "$scratch" \
    || failures=$((failures + 1))
"$work/build/release/tissuectl" serve "$R/model.h5" --port 0 --seconds 1 --no-realtime --record "$scratch/unread.h5" 2>&1 >/dev/null | true
check "a session whose standard error is a closed pipe writes its recording" test -s "$scratch/unread.h5"
finish
