"""report_contents.py WHAT RESULTS: exits 0 if RESULTS/report.html passes the check WHAT.

WHAT-sentence prints the sentence of the check. The page is read as HTML, without a browser and without the code that
wrote it.
"""
import base64
import html.parser
import json
import re
import sys
from pathlib import Path

SENTENCES = {
    "self-contained": "it refers to no other file or address",
    "figures": "it contains every figure of report.md, byte for byte",
    "number": "its main number, before the first table, is the learned springs' median nodal-force error in eval.json",
    "tables": "every number of report.md's tables has its own cell",
    "provenance": "its footer contains command, version, seed and hashes of the inputs",
}
REFERENCES = {"src", "href", "srcset", "data", "action", "poster", "xlink:href"}


class Page(html.parser.HTMLParser):
    """References, images in order, and the text by class, tag or id of its elements."""

    def __init__(self, text):
        super().__init__()
        self.references, self.images, self.words, self.open = [], [], {}, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.references += [value for name, value in attributes if name in REFERENCES]
        if tag == "img":
            self.images.append(given["src"])
        if tag not in ("meta", "link", "img", "br"):
            self.open.append((tag, given.get("class"), given.get("id")))
            if tag == "td":
                self.words.setdefault("cells", []).append("")

    def handle_endtag(self, tag):
        if tag not in ("meta", "link", "img", "br"):
            assert self.open.pop()[0] == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        for names in self.open:
            for name in names:
                self.words[name] = self.words.get(name, "") + data
        if any(names[0] == "td" for names in self.open):
            self.words["cells"][-1] += data


def self_contained(page, text, results):
    outside = [r for r in page.references if not r.startswith(("data:", "#"))]
    assert not outside, outside
    assert not re.search(r"@import|url\(|https?://|\bfetch\(|XMLHttpRequest|<iframe", text), "a reference"
    assert not page.open, page.open


def figures(page, text, results):
    wanted = re.findall(r"!\[\w+\]\(([^)]+)\)", (results / "report.md").read_text())
    prefix = "data:image/png;base64,"
    assert len(wanted) >= 5, wanted
    assert [base64.b64decode(i[len(prefix):]) for i in page.images] == [(results / w).read_bytes() for w in wanted]


def number(page, text, results):
    median = json.loads((results / "eval.json").read_text())["open_loop"]["learned"]["rel_loss"]["median"]
    assert page.words["number"] == f"{100 * median:.1f} %", page.words["number"]
    assert text.index('class="number"') < text.index("<table"), "the number is not before the first table"


def tables(page, text, results):
    rows = [line for line in (results / "report.md").read_text().splitlines()
            if line.startswith("|") and not line.startswith("|---")]
    values = [part.strip() for row in rows for cell in row.strip("|").split("|") for part in cell.split(" / ")]
    cells = [cell.replace("\u00a0", " ") for cell in page.words["cells"]]
    for wanted in (v for v in values if re.match(r"^\d+\.\d+", v)):
        assert cells.count(wanted) >= values.count(wanted), f"{wanted}: {cells.count(wanted)} of {values.count(wanted)}"
    assert not [c for c in cells if " / " in c], "a cell contains several numbers"


def provenance(page, text, results):
    foot = page.words["provenance"]
    evaluation = json.loads((results / "eval.json").read_text())
    for wanted in ("make all STUDY=tiny", "tissuectl train", evaluation["version"], str(evaluation["seed"]), "XXH3 "):
        assert wanted in foot, f"no '{wanted}' in: {foot}"


what, folder = sys.argv[1], Path(sys.argv[2])
if what.endswith("-sentence"):
    sys.exit(print(SENTENCES[what[:-len("-sentence")]]))
source = (folder / "report.html").read_text()
try:
    globals()[what.replace("-", "_")](Page(source), source, folder)
except AssertionError as error:
    sys.exit(f"{what}: {error}")
