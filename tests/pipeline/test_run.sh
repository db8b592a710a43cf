#!/bin/sh
# Tests of tests/run: its counts for suites that pass, fail, skip, crash or check nothing, and for two suites with one
# name. Tests of tests/parts: every test runs once.
. "$(dirname "$0")/common"
mkdir -p "$work/tests/fem" "$work/tests/pipeline"
cp "$root/tests/run" "$work/tests"

# suite FOLDER/NAME LINE...: writes a suite of these lines
suite() {
    file=$work/tests/$1.sh
    shift
    printf '%s\n' '#!/bin/sh' "$@" >"$file"
    chmod +x "$file"
}
library() { printf '%s\n' '#!/bin/sh' "echo '$1'" "exit $2" >"$work/library" && chmod +x "$work/library"; }
counts() { [ "$(tail -n 1 "$said")" = "$1" ] || { cat "$said"; return 1; }; }

library 'All tests passed (12 assertions in 5 test cases)' 0
suite fem/test_solid 'echo "ok - a"' 'echo "ok - b"'
suite pipeline/test_solid 'echo "ok - c"' 'echo "ok - d # SKIP no such thing here"'
suite pipeline/test_alone '# Alone: it keeps real time.' 'echo "ok - e"'
for jobs in 1 4; do
    run "$work/tests/run" "$work/library" $jobs
    check "$jobs at a time: suites with one name in two folders are both counted" counts "9 passed, 0 failed, 1 skipped"
    check "$jobs at a time: exit status 0" exited 0
    check "$jobs at a time: skipped checks are printed" grep -q '^skipped d # SKIP no such thing' "$said"
done

suite fem/test_solid 'echo "ok - a"' 'echo "not ok - b"' 'echo "it was 3"' 'exit 1'
run "$work/tests/run" "$work/library" 4
check "a failed check is counted" counts "8 passed, 1 failed, 1 skipped"
check "a failed check: exit status 1" exited 1
check "the output of a failed check is printed" sh -c "grep -A 1 '^not ok - b' '$said' | grep -q '^it was 3'"
suite fem/test_solid 'echo "ok - a"' 'exit 3'
run "$work/tests/run" "$work/library" 4
check "a suite that fails after passed checks counts as one failure" counts "8 passed, 1 failed, 1 skipped"
suite fem/test_solid true
run "$work/tests/run" "$work/library" 4
check "a suite without checks counts as one failure" counts "7 passed, 1 failed, 1 skipped"
suite fem/test_solid 'echo "ok - a"'
library 'test cases: 5 | 3 passed | 2 failed' 2
run "$work/tests/run" "$work/library" 4
check "failures of the library's tests are counted" counts "6 passed, 2 failed, 1 skipped"
library '' 139
run "$work/tests/run" "$work/library" 4
check "a crash of the library's tests counts as one failure" counts "3 passed, 1 failed, 1 skipped"
library 'All tests passed (12 assertions in 5 test cases)' 0
suite pipeline/test_the_last '# Long: it takes minutes.' 'echo "ok - f"'
run "$work/tests/run" "$work/library" 1
check "a suite marked Long runs directly after the library's tests" sh -c "sed -n 2p '$said' | grep -q test_the_last"
check "a suite marked Long runs once" counts "9 passed, 0 failed, 1 skipped"

# ---- a substitute for a Catch2 program of seven tests: test BAD fails, test GONE ends the process
cat >"$work/seven" <<'SH'
#!/bin/sh
[ "$1" != --list-test-names-only ] || { seq 6; echo 7, at last; exit 7; }
for file; do :; done
n=$(grep -c . "$file")
cat "$file" >>"$SEEN"
! grep -qx "${GONE:-0}" "$file" || exit 139
if grep -qx "${BAD:-0}" "$file"; then
    printf '%s\n' "it was 3" "test cases: $n | $((n - 1)) passed | 1 failed"
    exit 1
fi
echo "All tests passed (99 assertions in $n test cases)"
SH
chmod +x "$work/seven"
export SEEN="$work/seen"
every_one_once() { [ "$(sort "$SEEN" | tr '\n' ' ')" = '1 2 3 4 5 6 7\, at last ' ]; }
for parts in 1 2 9; do
    rm -f "$SEEN"
    run "$root/tests/parts" "$work/seven" $parts
    check "in $parts parts: exit status 0" exited 0
    check "in $parts parts: each test runs once" every_one_once
done
export BAD=3
run "$root/tests/parts" "$work/seven" 2
check "in parts: a failed test gives exit status 1" exited 1
check "in parts: the output of a failed test is printed" grep -q '^it was 3' "$said"
export BAD=0 GONE=3
run "$root/tests/parts" "$work/seven" 2
check "in parts: a part that ends early gives exit status 1" exited 1
check "in parts: the number of tests that ran is printed" grep -q '^tests/parts: 3 of 7 tests ran' "$said"
finish
