#!/bin/sh
# report.html: one file that needs nothing else, with the number that matters first, and tables that sort in a browser.
. "$(dirname "$0")/common"
make_copy
make_tiny report -j2
check "make report succeeds from nothing" exited 0
page=$R/report.html
browse() { "$PYTHON" "$root/tests/pipeline/browse_report.py" "$@"; }
inside() { "$PYTHON" "$root/tests/pipeline/report_contents.py" "$1" "$R"; }

for what in self-contained figures number tables provenance; do
    check "report.html: $(inside "$what-sentence")" inside $what
done
cp -p "$page" "$scratch/first.html"
rm "$page"
make_tiny report
check "the same results give the same bytes" cmp "$page" "$scratch/first.html"
make_tiny all
make_tiny all -q
check "make all makes it, once" exited 0

if ! "$PYTHON" -c "import selenium" 2>/dev/null || ! command -v chromedriver >/dev/null; then
    skip "report.html in a browser" "no python3-selenium or chromium-driver"
else
    browse "$page" "$scratch/browser" || failures=$((failures + 1))
fi

# ---- what it cannot be made of
mv "$R/figures/force.png" "$scratch/force.png"
run "$PYTHON" scripts/report/page.py results/tiny results/tiny/report.html
check "a missing figure: exit 2" exited 2
check "a missing figure: one line names it" one_line 'figures/force.png: '
check "a missing figure: the earlier report is untouched" cmp "$page" "$scratch/first.html"
mv "$scratch/force.png" "$R/figures/force.png"
cp "$R/eval.json" "$scratch/eval.json"
head -c 500 "$scratch/eval.json" >"$R/eval.json"
run "$PYTHON" scripts/report/page.py results/tiny results/tiny/report.html
check "an evaluation that is cut off: exit 2" exited 2
check "an evaluation that is cut off: one line" one_line '^page.py: results/tiny/eval.json: '
cp "$scratch/eval.json" "$R/eval.json"
for name in page force; do
    check "an evaluation with wrong content, $name: one line" "$PYTHON" -B "$root/tests/pipeline/wrong_content.py" $name "$R"
done
check "nothing half-written is left" no_half_files "$R"
finish
