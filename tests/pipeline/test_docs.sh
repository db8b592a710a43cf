#!/bin/sh
# Documents: README has at most 150 lines, links and pictures lead to existing files, documents use the glossary's
# words, and tables equal the records in results/reference.
. "$(dirname "$0")/common"
pages=$(cd "$root" && ls README.md SECURITY.md CONTRIBUTING.md VERSIONING.md results/*.md cli/*.md cli/view/*.md fem/*.md fem/organs/*.md lib/*.md lib/*/*.md scripts/docs/*.md scripts/slurm/*.md)
sitting() { [ "$(wc -l <"$1")" -le 150 ] || { echo "$1: $(wc -l <"$1") lines"; return 1; }; }
# shellcheck disable=SC2086  # names without blanks
links() { "$PYTHON" "$root/tests/pipeline/docs_links.py" "$1" ${2:-$pages}; }
# the glossary has the older words too
# shellcheck disable=SC2046,SC2086
words() { "$PYTHON" "$root/tests/pipeline/docs_words.py" "$1" ${2:-$(echo "$pages" | grep -vx lib/GLOSSARY.md)}; }
# every library whose headers are compiled in, and every file that the page takes from outside the project
noticed() { # ROOT
    for name in $(cd "$root" && grep -rhoE '#include <[A-Za-z0-9_+]+/' lib cli | sed 's/.*<//' | grep -vxE '(sys|arpa|netinet)/' | sort -u); do
        grep -qF "<$name>" "$1/NOTICE" || { echo "NOTICE: has no entry for headers <$name>"; return 1; }
    done
    for file in $(sed -n 's/^TAKE_IN(.*"\/\(.*\)").*/\1/p' "$root/cli/serve/page.cpp"); do
        grep -qF "${file##*/}" "$1/NOTICE" || { echo "NOTICE: has no entry for ${file##*/}, a file of the page"; return 1; }
    done
}
cited() { # ROOT: CITATION.cff has the version of lib/version.h
    version=$(sed -n 's/.* version = "\(.*\)";/\1/p' "$root/lib/version.h")
    grep -qx "version: $version" "$1/CITATION.cff" || { echo "CITATION.cff: the version is not $version, as in lib/version.h"; return 1; }
}
tables() { "$PYTHON" "$1/scripts/reference.py" --check; }

check "README has at most 150 lines" sitting "$root/README.md"
check "every relative link and picture leads to an existing file or heading" links "$root"
check "documents use the words of lib/GLOSSARY.md" words "$root"
check "NOTICE has every library and file that is built in" noticed "$root"
check "CITATION.cff has the version of the project" cited "$root"
check "the tables of README and results/RESULTS.md equal the records" tables "$root"

# tests of the checks, on a copy with one fault at a time
mkdir -p "$work/results"
cp -pR "$root/README.md" "$root/NOTICE" "$root/CITATION.cff" "$root/scripts" "$work"
cp -pR "$root/results/reference" "$root/results/RESULTS.md" "$work/results"
wrong() { # SENTENCE WORDS COMMAND...: the copy is refused with these words; then the copy is restored
    sentence=$1 words=$2
    shift 2
    "$@" >"$said" 2>&1
    status=$?
    check "$sentence: refused" failed
    check "$sentence: a line names it" says "$words"
    cp -p "$root/README.md" "$work"
    cp -p "$root/results/RESULTS.md" "$work/results"
    cp -p "$root/results/reference"/surface*.json "$work/results/reference"
}
change() { # FILE: changes the first number in the row of study surface
    sed -i '/(`surface`)/s/| [0-9.]* %/| 0.1 %/' "$work/$1"
}
check "the copy's tables equal the records" tables "$work"
change README.md
wrong "a number of README's table changed by hand" "README.md: table 'summary' says" tables "$work"
change results/RESULTS.md
wrong "a number of results/RESULTS.md changed by hand" "RESULTS.md: table 'drawn' says" tables "$work"
sed -i '/| an inclusion |/s/[0-9.]* |$/9.9 |/' "$work/results/RESULTS.md"
wrong "a number of the target tissues changed by hand" "RESULTS.md: table 'patient' says" tables "$work"
sed -i '/(`block3`)/d' "$work/README.md"
wrong "a row missing in README's table" "README.md: table 'summary' has" tables "$work"
sed -i '/<!-- begin summary -->/d' "$work/README.md"
wrong "README's table without its marker" "README.md: there is no marker 'summary'" tables "$work"
sed -i '/"median"/s/"median": 0\.[0-9]*/"median": 0.5/' "$work/results/reference/surface.json"
wrong "a changed record" "README.md: table 'summary' says" tables "$work"
rm "$work/results/reference/surface-sets.json"
wrong "a missing record" "RESULTS.md: table 'surface': a study of it has no record" tables "$work"
awk 'BEGIN { for (i = 0; i < 100; i++) print "one more line" }' >>"$work/README.md"
wrong "a long README" "README.md: [0-9]* lines" sitting "$work/README.md"
echo "[gone](lib/gone.h), ![gone](results/reference/gone.png)" >"$work/page.md"
wrong "a link to a missing file" "page.md: link to lib/gone.h" links "$work" page.md
wrong "a missing picture" "page.md: link to results/reference/gone.png" links "$work" page.md
echo "[gone](README.md#no-such-heading)" >"$work/page.md"
wrong "a link to a missing heading" "page.md: link to README.md#no-such-heading" links "$work" page.md
echo "The truth stands beside the law." >"$work/page.md"
wrong "an older word" "page.md:1: 'truth': write FE reference" words "$work" page.md
sed -i 's/<toml++\/>/toml++/' "$work/NOTICE"
wrong "a library without a notice" "NOTICE: has no entry for headers <toml++/>" noticed "$work"
sed 's/three.module.js/three.js/' "$root/NOTICE" >"$work/NOTICE"
wrong "a file of the page without a notice" "NOTICE: has no entry for three.module.js" noticed "$work"
sed -i 's/^version: .*/version: 0.0.9/' "$work/CITATION.cff"
wrong "a citation of another version" "CITATION.cff: the version is not" cited "$work"
finish
