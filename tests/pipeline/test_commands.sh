#!/bin/sh
# Runs every command in the documents, in a copy with small studies, unless it is marked as not run with a reason
# (doc_commands.py). Needs both programs, FreeFEM and gmsh.
. "$(dirname "$0")/common"
make_copy
cp -p "$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")" "$work/build/release/tissue-haptic"
pages=$(cd "$root" && find ./*.md cli fem lib scripts results/*.md results/reference -name '*.md' ! -name 'README.md' -o -path '*/README.md' ! -path ./README.md | sort)
# shellcheck disable=SC2086  # names without blanks
commands() { "$PYTHON" -B "$root/tests/pipeline/doc_commands.py" "$@"; }
count() { # prints the last output and counts its failed checks
    cat "$said"
    failures=$((failures + $(grep -c '^not ok' "$said")))
}

# studies with the names that documents use: paper on a 4 x 4 lattice, measured on a synthetic tissue; files of the
# reader
sed -i -e 's/^cells = .*/cells = [4, 4]/' -e 's/^check_refine = [0-9]*/check_refine = 0/' -e 's/^magnitudes_m = .*/magnitudes_m = [0.005, 0.010]/' \
    -e 's/^record_step_m = [0-9.]*/record_step_m = 0.005/' -e 's/^iterations = .*/iterations = 300/' "$work/fem/studies/paper.toml"
poked_tissue
mv "$work/fem/studies/tiny.toml" "$work/fem/studies/measured.toml"
mkdir -p "$work/given" "$work/results/surface-quick" "$work/results/paper-grid8"
cp "$model" "$work/results/surface-quick/model.h5"
cp "$model" "$work/given/MODEL.h5"
cp "$data" "$work/given/DATA.csv"
cp "$pokes" "$work/given/POKES.csv"
"$TISSUECTL" adapt "$model" --data "$pokes" --out "$work/given/OTHER.h5" >"$scratch/log" 2>&1 || cat "$scratch/log"

commands "$root" "$work" README.md >"$said" 2>&1
count
cp "$work/results/paper/cases.h5" "$work/results/paper/model.h5" "$work/given"
mv "$work/given/model.h5" "$work/results/paper-grid8/model.h5"
# shellcheck disable=SC2086
commands "$root" "$work" $pages >"$said" 2>&1
count
check "more commands of the documents are run than are marked as not run" sh -c 'set -- $(sed -n "s/^# of [0-9]* commands \([0-9]*\) were run, \([0-9]*\) .*/\1 \2/p" "$1"); [ "$1" -gt "$2" ]' - "$said"

# ---- tests of doc_commands.py, on pages with one fault each
page() { # SENTENCE WORDS TEXT: a page with this text is refused with these words
    printf '%b' "$3" >"$scratch/page.md"
    run "$PYTHON" -B "$root/tests/pipeline/doc_commands.py" "$scratch" "$work" page.md
    check "$1: refused" failed
    check "$1: a line names it" says "$2"
}
cp "$root/Makefile" "$scratch/Makefile"
page "a command that fails" 'not ok - page.md:3: false' 'Do:\n\n    false\n'
page "a formula without a mark" 'not ok - page.md:3: W(u)' 'So:\n\n    W(u) = 1\n'
page "a failing command after a marked one" 'not ok - page.md:6: false' 'Do:\n\n<!-- not run [make]: long -->\n\n    make test\n    false\n'
page "a mark without a reason" 'page.md:3: a mark of code' 'Do:\n\n<!-- not run: -->\n\n    false\n'
page "a mark without a matching command" 'no command begins so' 'Do:\n\n<!-- not run [make]: long -->\n\n    true\n'
page "a mark that does not directly precede its block" 'not ok - page.md:5: false' '<!-- not run: long -->\n\nDo:\n\n    false\n'
page "a fenced command that fails" 'not ok - page.md:2: false' '```sh\nfalse\n```\n'
page "a study that is refused" "key 'geometry.width'" '<!-- a study -->\n\n    based_on = "organ-mini"\n    [geometry]\n    width = 3\n'
page "a block that is not continued, after a study" 'not ok - page.md:7: test -e fem/studies/later.toml' \
    'Do:\n\n    tissuectl new later --shape fem/organ.geo --trust-geo --unit mm --held bed\n\nand\n\n    test -e fem/studies/later.toml\n'
printf '%b' 'Do:\n\n    tissuectl new later --shape fem/organ.geo --trust-geo --unit mm --held bed\n\n<!-- continued -->\n\n    test -e fem/studies/later.toml\n' >"$scratch/page.md"
run "$PYTHON" -B "$root/tests/pipeline/doc_commands.py" "$scratch" "$work" page.md
rm "$work/fem/studies/later.toml"
check "a continued block has the study of the block before it" exited 0
page "an unknown option" 'tissuectl export has no option --format' 'Run `tissuectl export --format sofa`.\n'
page "an unknown target" 'make has no target cake' 'Run `make cake`.\n'
page "an unknown command" 'tissuectl has no command bake' 'Run `tissuectl bake --hot`.\n'
finish
