#!/usr/bin/python3
"""Writes the committed part of the studies' results: reference.py [--check | STUDY...]

results/reference/STUDY.json   reference record for the regression (reference_record.py)
results/reference/*.png        figures of README and results/RESULTS.md
results/RESULTS.md             tables between its markers, from the evaluations, and from `make ablation STUDY=surface`
                               and `STUDY=block3`
README.md                      its table, from the records in results/reference/ and from patient.md of `make patient`

With only some studies of RESULTS.md it writes their tables and figures; without a study, only README's table.
--check writes nothing. It prints each table that differs from the records, and exits with 1 if there is one. It does
not compare what no record has: wall times, places of a map, ablations.
"""
import re
import shutil
import sys
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parent / "figures"))
import reference_record
from one_line import read_json
from save import written
from reference_tables import SPACE_ROLES, UNKNOWN, ablation_table, patient_rows, patient_table, summary_table, tables

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = reference_record.FOLDER
README = ROOT / "README.md"
RESULTS = ROOT / "results" / "RESULTS.md"
NOT_RECORDED = ["ablation", "space-ablation"]  # tables that no record has
FIGURES = ["contours", "force", "learning", "springs", "errors", "character"]
SHOWN = [("surface", "shape", "shape"), ("surface", "held_out", "held_out"), ("surface", "ablation", "ablation"),
         ("organ", "shape", "organ"), ("block3", "solid", "block3-solid"),
         ("block3", "held_out", "block3-held_out"), ("relax", "histories", "relax"), ("nodule3", "map", "nodule3-map"), ("organ3", "solid", "organ3-solid"),
         *(("paper", figure, figure) for figure in FIGURES)]  # study, figure, its name in results/reference


def between(page, marker):
    return re.compile(rf"(<!-- begin {marker} -->\n)(.*?)(<!-- end {marker} -->)", re.S), f"reference.py: {page}: there is no marker '{marker}'"


def fill(page, marker, rows):
    """Replaces the rows between the page's markers."""
    pattern, missing = between(page, marker)
    text = page.read_text()
    if not pattern.search(text):
        sys.exit(missing)
    with written(page) as beside:
        Path(beside).write_text(pattern.sub(lambda m: m.group(1) + "\n".join(rows) + "\n" + m.group(3), text))


def moved(page, marker, rows):
    """Messages on the rows of a page's table that differ from `rows`. A cell UNKNOWN matches anything."""
    pattern, missing = between(page, marker)
    found = pattern.search(page.read_text())
    if not found:
        return [missing]
    there = found.group(2).splitlines()
    lines = [] if len(there) == len(rows) else [f"{page.name}: table '{marker}' has {len(there)} rows, of the records {len(rows)}"]
    for is_there, row in zip(there, rows):
        cells = is_there.split("|"), row.split("|")
        if len(cells[0]) != len(cells[1]) or any(b.strip() != UNKNOWN and a != b for a, b in zip(*cells)):
            lines.append(f"{page.name}: table '{marker}' says\n  {is_there}\nand of the records it is\n  {row}")
    return lines


def recorded():
    """The evaluation in each committed record."""
    # soak.json is of scripts/soak
    return {path.stem: reference_record.read(path)["evaluation"] for path in sorted(REFERENCE.glob("*.json")) if path.stem != "soak"}


def patients(path=REFERENCE / "patient.md"):
    return patient_rows(path.read_text())


def check():
    """Messages on tables that differ from the records."""
    records = recorded()
    try:
        lines = moved(README, "summary", summary_table(records, patients()))
    except KeyError as missing:
        lines = [f"reference.py: README.md: table 'summary': no record has {missing}"]
    of_records = dict(tables(records), patient=patient_table(patients()), peers=peers_table())
    for marker, rows in of_records.items():
        lines += moved(RESULTS, marker, rows)
    shown = re.findall(r"<!-- begin (.*) -->", RESULTS.read_text())
    return lines + [f"reference.py: RESULTS.md: table '{marker}': a study of it has no record" for marker in shown
                    if marker not in of_records and marker not in NOT_RECORDED]


def peers_table(path=REFERENCE / "peers.md"):
    """The rows of a page of `make peers`."""
    return [line for line in path.read_text().splitlines() if line.startswith("|")]


def write_peers(path):
    fill(RESULTS, "peers", peers_table(path))


def write_patients(path):
    """Writes the tables from patient.md of `make patient` into both pages."""
    fill(RESULTS, "patient", patient_table(patients(path)))
    fill(README, "summary", summary_table(recorded(), patients(path)))


def main():
    if sys.argv[1:] == ["--check"]:
        lines = check()
        print("\n".join(lines), end="\n" if lines else "", file=sys.stderr)
        sys.exit(1 if lines else 0)
    if any(word.startswith("-") for word in sys.argv[1:]):
        print(__doc__.strip(), file=sys.stdout if sys.argv[1] in ("-h", "--help") else sys.stderr)
        sys.exit(0 if sys.argv[1] in ("-h", "--help") else 2)
    evaluations = {}
    for study in sys.argv[1:]:
        results = ROOT / "results" / study
        evaluations[study] = read_json(results / "eval.json", reference_record.EVALUATION)
        reference_record.write(REFERENCE / f"{study}.json", reference_record.of(results, f"make all STUDY={study}"))
    for study, figure, name in SHOWN:
        if study in evaluations:
            with written(REFERENCE / f"{name}.png") as beside:
                shutil.copyfile(ROOT / "results" / study / "figures" / f"{figure}.png", beside)
    for marker, rows in tables(evaluations):
        fill(RESULTS, marker, rows)
    for study, marker, roles in (("surface", "ablation", ("held_out", "held_out_full")), ("block3", "space-ablation", SPACE_ROLES)):
        if study in evaluations:
            variants = read_json(ROOT / "results" / study / "ablation.json", {"variants": [{}, ...]})["variants"]
            fill(RESULTS, marker, ablation_table(variants, roles))
    fill(README, "summary", summary_table(recorded(), patients()))


if __name__ == "__main__":
    main()
