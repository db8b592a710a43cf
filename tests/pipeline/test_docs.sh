#!/bin/sh
# What is written for people: README is one sitting, links and pictures lead to files that there are, and tables say what the records in
# results/reference say.
. "$(dirname "$0")/common"
pages="README.md results/RESULTS.md results/FORMATS.md cli/README.md lib/README.md fem/README.md fem/organs/README.md lib/api/ENGINES.md lib/api/OPTIONS.md cli/view/PROTOCOL.md"
sitting() { [ "$(wc -l <"$1")" -le 150 ] || { echo "$1: $(wc -l <"$1") lines"; return 1; }; }
# shellcheck disable=SC2086  # names without blanks
links() { "$PYTHON" "$root/tests/pipeline/docs_links.py" "$1" ${2:-$pages}; }
# shellcheck disable=SC2086
words() { "$PYTHON" "$root/tests/pipeline/docs_words.py" "$1" ${2:-$pages SECURITY.md}; }
tables() { "$PYTHON" "$1/scripts/reference.py" --check; }

check "README has at most 150 lines" sitting "$root/README.md"
check "every relative link and picture leads to a file, or to a heading of one" links "$root"
check "documents have the words of lib/GLOSSARY.md" words "$root"
check "README's table and those of results/RESULTS.md are what the records say" tables "$root"

# the checks themselves, on a copy with one thing wrong at a time
mkdir -p "$work/results"
cp -pR "$root/README.md" "$root/scripts" "$work"
cp -pR "$root/results/reference" "$root/results/RESULTS.md" "$work/results"
wrong() { # SENTENCE WORDS COMMAND...: the copy is refused, in these words, and then put right again
    sentence=$1 words=$2
    shift 2
    "$@" >"$said" 2>&1
    status=$?
    check "$sentence: refused" failed
    check "$sentence: the line says which" says "$words"
    cp -p "$root/README.md" "$work"
    cp -p "$root/results/RESULTS.md" "$work/results"
    cp -p "$root/results/reference"/surface*.json "$work/results/reference"
}
change() { # FILE: the first number in the row of study surface
    sed -i '/(`surface`)/s/| [0-9.]* %/| 0.1 %/' "$work/$1"
}
check "the copy's tables are what the records say" tables "$work"
change README.md
wrong "a number of README's table changed by hand" "README.md: table 'summary' says" tables "$work"
change results/RESULTS.md
wrong "a number of results/RESULTS.md changed by hand" "RESULTS.md: table 'drawn' says" tables "$work"
sed -i '/| a lump |/s/[0-9.]* |$/9.9 |/' "$work/results/RESULTS.md"
wrong "a number of the patients changed by hand" "RESULTS.md: table 'patient' says" tables "$work"
sed -i '/(`block3`)/d' "$work/README.md"
wrong "a row of README's table gone" "README.md: table 'summary' has" tables "$work"
sed -i '/<!-- begin summary -->/d' "$work/README.md"
wrong "README's table without its marker" "README.md: there is no marker 'summary'" tables "$work"
sed -i '/"median"/s/"median": 0\.[0-9]*/"median": 0.5/' "$work/results/reference/surface.json"
wrong "a record that moved" "README.md: table 'summary' says" tables "$work"
rm "$work/results/reference/surface-sets.json"
wrong "a record gone" "RESULTS.md: table 'surface': a study of it has no record" tables "$work"
awk 'BEGIN { for (i = 0; i < 100; i++) print "one more line" }' >>"$work/README.md"
wrong "a long README" "README.md: [0-9]* lines" sitting "$work/README.md"
echo "[gone](lib/gone.h), ![gone](results/reference/gone.png)" >"$work/page.md"
wrong "a link to a file that is not there" "page.md: link to lib/gone.h" links "$work" page.md
wrong "a picture that is not there" "page.md: link to results/reference/gone.png" links "$work" page.md
echo "[gone](README.md#no-such-heading)" >"$work/page.md"
wrong "a link to a heading that is not there" "page.md: link to README.md#no-such-heading" links "$work" page.md
echo "The truth stands beside the law." >"$work/page.md"
wrong "an older word" "page.md:1: 'truth': write FE reference" words "$work" page.md
finish
