#!/bin/sh
# report.html: one self-contained file, with the main number first, and tables that can be sorted in a browser.
. "$(dirname "$0")/common"
make_copy
make_tiny report -j2
check "make report succeeds from an empty folder" exited 0
page=$R/report.html
browse() { "$PYTHON" "$root/tests/pipeline/browse_report.py" "$@"; }
inside() { "$PYTHON" "$root/tests/pipeline/report_contents.py" "$1" "$R"; }

for what in self-contained figures number tables provenance; do
    check "report.html: $(inside "$what-sentence")" inside $what
done
cp -p "$page" "$scratch/first.html"
rm "$page"
make_tiny report
check "report.html is identical when made again from the same results" cmp "$page" "$scratch/first.html"
make_tiny all
make_tiny all -q
check "make all is up to date after make all with a report" exited 0

if ! "$PYTHON" -c "import selenium" 2>/dev/null || ! command -v chromedriver >/dev/null; then
    skip "report.html in a browser" "no python3-selenium or chromium-driver"
else
    browse "$page" "$scratch/browser" || failures=$((failures + 1))
fi

# ---- inputs without which there is no report
mv "$R/figures/force.png" "$scratch/force.png"
run "$PYTHON" scripts/report/page.py results/tiny results/tiny/report.html
check "a missing figure: exit 2" exited 2
check "a missing figure: one line names it" one_line 'figures/force.png: '
check "a missing figure: the earlier report is unchanged" cmp "$page" "$scratch/first.html"
mv "$scratch/force.png" "$R/figures/force.png"
cp "$R/eval.json" "$scratch/eval.json"
head -c 500 "$scratch/eval.json" >"$R/eval.json"
run "$PYTHON" scripts/report/page.py results/tiny results/tiny/report.html
check "a truncated evaluation: exit 2" exited 2
check "a truncated evaluation: one line names it" one_line '^page.py: results/tiny/eval.json: '
cp "$scratch/eval.json" "$R/eval.json"
for name in page force; do
    check "$name.py with wrong content in an evaluation: success, or one line" "$PYTHON" -B "$root/tests/pipeline/wrong_content.py" $name "$R"
done
check "HDF5 files with links, or with values in other files, are refused" "$PYTHON" -B -c "import subprocess, sys
import h5py, numpy
file, secret = sys.argv[1:]
sys.path.insert(0, 'scripts/figures')
with h5py.File(secret, 'w') as f:
    f['x'] = numpy.ones(3)
def linked(f): f['link'] = h5py.ExternalLink(secret, '/x')
def soft(f): f['link'] = h5py.SoftLink('/here')
def raw(f): f['group'].create_dataset('x', (3,), 'f8', external=[(secret, 0, 24)])
def virtual(f):
    layout = h5py.VirtualLayout((3,), 'f8')
    layout[:] = h5py.VirtualSource(secret, 'x', (3,))
    f.create_virtual_dataset('x', layout)
def within(f): f['group/again'] = f['group']
def twice(f): f['other'] = f['group']
for foreign, why in ((linked, 'is a link'), (soft, 'is a link'), (raw, 'values in another file'), (virtual, 'values in another file'), (within, 'second hard link'), (twice, 'second hard link'), (None, '')):
    with h5py.File(file, 'w') as f:
        f['here'] = numpy.zeros(3)
        f.create_group('group')
        if foreign: foreign(f)
    ended = subprocess.run([sys.executable, '-c', 'import sys; sys.path.insert(0, sys.argv[1]); from stored import stored\nwith stored(sys.argv[2]) as f: print(*f)', 'scripts/figures', file], capture_output=True, text=True)
    assert (ended.returncode, bool(ended.stdout)) == ((2, False) if foreign else (0, True)) and why in ended.stderr and ended.stderr.count('\\n') <= 1, (why, ended)" \
    "$scratch/foreign.h5" "$scratch/secret.h5"
check "no incomplete file is left" no_half_files "$R"
finish
