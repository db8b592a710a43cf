#!/bin/sh
# The site of `make docs`: the documents build without warnings, formulas and references are in it, and it refuses a page
# that is not listed, links to nothing, and a formula that cannot be drawn.
. "$(dirname "$0")/common"
export TISSUE_MODULE="${TISSUECTL%/*}/python"
site() { # FOLDER: its documents to $scratch/site; the options are make's
    (cd "$1" && rm -rf "$scratch/site" && "$PYTHON" -B -m sphinx -q -W --keep-going -E -c scripts/docs -d "$scratch/cache" . "$scratch/site") >"$said" 2>&1
    status=$?
}
in_page() { grep -q -- "$2" "$scratch/site/$1" || { echo "$1 does not contain $2"; return 1; }; }

check "make builds the site with the options of this test" grep -q -- '-m sphinx -q -W --keep-going -E -c scripts/docs -d build/docs.cache . build/docs$' "$root/Makefile"
site "$root"
check "the documents build as one site" exited 0
check "the site builds without a warning" silent
check "the front page leads to the table of contents" in_page index.html 'url=scripts/docs/index.html'
check "the table of contents is there" exist "$scratch/site/scripts/docs/index.html"
check "every document of the project is a page" sh -c 'for page in $(cd "$1" && find ./*.md cli fem lib scripts results/*.md results/reference -name "*.md"); do [ -s "$2/${page%.md}.html" ] || { echo "no page of $page"; exit 1; }; done' - "$root" "$scratch/site"
check "formulas are drawn as MathML" in_page lib/springs/README.html '<mfrac>'
check "no page needs another server" sh -c '! grep -rlE "(src|href)=\"(https?:)?//[^\"]*\.(js|css|woff2?)\"" "$1"' - "$scratch/site"
check "the C reference has the calls of tissue.h" in_page scripts/docs/c.html tissue_tick_aged
check "the Python reference has the methods of the module" in_page scripts/docs/python.html 'id="tissue.Simulation.tick_tools"'
check "the search finds words of a tutorial and of a header" sh -c 'grep -q segment "$1" && grep -q tissue_tick_ag "$1"' - "$scratch/site/searchindex.js"

# a copy with one page of each fault
mkdir -p "$work/results"
cp -pR "$root"/*.md "$root/LICENSE" "$root/NOTICE" "$root/CITATION.cff" "$root/Makefile" "$root/cli" "$root/fem" "$root/lib" "$root/scripts" "$root/tests" "$work"
cp -pR "$root/results/reference" "$root"/results/*.md "$work/results"
echo "# Nowhere" >"$work/fem/NOWHERE.md"
printf '\n[gone](gone.h) and [heading](README.md#no-such-heading), ![picture](gone.png)\n\n$$\n\\nosuch{x}\n$$\n' >>"$work/SECURITY.md"
site "$work"
check "faults are refused" failed
check "a page that is not listed: a line names it" says "fem/NOWHERE.md: WARNING: document isn't included in any toctree"
check "a link to a missing file: a line names it" says "SECURITY.md:[0-9]*: WARNING: .*gone.h"
check "a link to a missing heading: a line names it" says "SECURITY.md:[0-9]*: WARNING: .*no-such-heading"
check "a missing picture: a line names it" says "SECURITY.md:[0-9]*: WARNING: image file not readable: gone.png"
check "a formula that cannot be drawn: a line names it" says 'SECURITY.md:[0-9]*: WARNING: formula .*nosuch{x}: Unknown LaTeX command'
check "nothing else is refused" sh -c '[ "$(grep -c WARNING "$1")" = 5 ] || cat "$1" && [ "$(grep -c WARNING "$1")" = 5 ]' - "$said"
finish
