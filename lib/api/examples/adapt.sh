#!/bin/sh
# Adapts a model to force measurements of another tissue: adapt.sh MODEL.h5 MEASURED.csv TEST.csv ADAPTED.h5
# Learns from MEASURED.csv, and prints the error of force on TEST.csv in % before and after. Then three places to measure
# next, with contact and tool displacement in mm. The format of both files is that of measured contacts
# (results/FORMATS.md); their headers have the units. `tissuectl` must be in PATH.
set -eu
[ $# = 4 ] || { echo "usage: adapt.sh MODEL.h5 MEASURED.csv TEST.csv ADAPTED.h5" >&2; exit 2; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT

tissuectl adapt "$1" --data "$2" --held-out "$3" --next 3 --out "$4" 2>"$log" || { tail -n 1 "$log" >&2; exit 1; }

sed -n '/^adapt: before the first/p' "$log"
sed -n 's/^adapt \([0-9]*\): .*; test error /adapt: after line \1 of the file: test error /p' "$log" | tail -n 1
sed -n -e '/^adapt next/p' -e '$p' "$log"
