"""Writes what is committed of the studies' results: reference.py STUDY...

results/reference/STUDY.json   what a regression compares with (reference_record.py)
results/reference/*.png        the figures that README shows
README.md                      the tables between its markers, from the evaluations; what it says of plane stress, when
                               results/surface-stress is there
"""
import json
import re
import shutil
import sys
from pathlib import Path

import reference_record

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = reference_record.FOLDER
FIGURES = ["contours", "force", "learning", "springs", "errors", "character"]
LABELS = {
    "learned": "learned (`spsa`)",
    "learned_spsa_2008": "learned (`spsa-2008`, the paper's)",
    "optimum": "certified optimum",
    "heuristic_a": "heuristic, E2 = E t",
    "heuristic_b": "heuristic, E2 = (C1 + C2) t",
    "uniform": "one stiffness",
    "one_set": "one learned set for all cases",
}
SWEPT = {"surface": ("held_out", "held_out"), "organ": ("contours", "organ")}  # the figure README shows, and its name there
STUDIES = {
    "paper": "4-connected, `isotropic` (`paper`)",
    "paper-axial": "4-connected, `axial` (`paper-axial`)",
    "paper-grid8": "8-connected, `axial` (`paper-grid8`)",
    "paper-grid8-turning": "8-connected, `geometric` (`paper-grid8-turning`)",
}


def percent(value):
    if value is None:
        return "none"
    return "< 0.01 %" if value < 1e-4 else f"{100 * value:.3g} %"


def counted(text, statistics):
    return f"{text} ({statistics['n']})" if statistics["n"] else "none"


def three(statistics):
    return counted(" / ".join(percent(statistics[key]) for key in ("median", "p95", "max")), statistics)


def shape(entry):
    """Shape error of an entry of closed_loop; its contacts are the force's."""
    return three(entry["shape"]).rpartition(" (")[0] if entry["shape"] and entry["shape"]["n"] else "none"


def results_table(evaluation):
    rows = ["| model | rel_loss (9) | resolved force | closed loop | its shape |", "|---|---|---|---|---|"]
    for model, errors in evaluation["open_loop"].items():
        rows.append(f"| {LABELS.get(model, model)} | {three(errors['rel_loss'])} | "
                    f"{three(errors['resolved_force_error'])} | {three(evaluation['closed_loop']['trained'][model])} | "
                    f"{shape(evaluation['closed_loop']['trained'][model])} |")
    return rows


def studies_table(evaluations):
    rows = ["| spring mesh | heuristic rel_loss | certified optimum | gap of `spsa`, max | gap of `spsa-2008`, median | "
            "closed loop, learned | its shape | closed loop, best baseline | its shape |",
            "|---|---|---|---|---|---|---|---|---|"]
    for study, e in evaluations.items():
        closed = e["closed_loop"]["trained"]
        baselines = {m: closed[m]["median"] for m in ("heuristic_a", "heuristic_b", "uniform") if closed[m]["n"]}
        best = min(baselines, key=baselines.get, default=None)
        learned = closed["learned"]
        rows.append(
            f"| {STUDIES.get(study, study)} | {percent(e['open_loop']['heuristic_a']['rel_loss']['median'])} | "
            f"{percent(e['open_loop']['optimum']['rel_loss']['median'])} | {percent(e['training']['gap']['max'])} | "
            f"{percent(e['training_also'][0]['gap']['median'])} | {counted(percent(learned['median']), learned)} | "
            f"{percent(learned['shape']['median'])} | "
            + (f"{LABELS[best]}: {counted(percent(baselines[best]), closed[best])} | "
               f"{percent(closed[best]['shape']['median'])} |" if best else "none | none |"))
    return rows


def surface_table(e):
    names = {"learned": "**learned law**", "untrained": "the same law untrained", "force_table": "FE force table",
             "heuristic_a_patch": "heuristic, E2 = E t, springs alone under the law's contact",
             "heuristic_b_patch": "heuristic, E2 = (C1 + C2) t, likewise",
             "uniform_patch": "one stiffness, likewise"}
    roles = [e["closed_loop"][role] for role in ("held_out", "held_out_full")]
    rows = ["| model | held_out: force | held_out: shape | held_out_full: force | held_out_full: shape |",
            "|---|---|---|---|---|"]
    for model in roles[0]:
        label = names.get(model, LABELS.get(model, f"`{model}`"))
        rows.append(f"| {label} | " + " | ".join(f"{three(role[model])} | {shape(role[model])}" for role in roles) + " |")
    counts = {role: (e["closed_loop"][role]["learned"]["n"], len(e["lost"][role]))
              for role in ("held_out", "held_out_full")}
    rows.append("| contacts (and lost by FE) | " + " | | ".join(f"{n} ({lost})" for n, lost in counts.values()) + " | |")
    rows.append("| the truth's own error, finer mesh | " + three(e["truth_check"]) + " | | | |")
    return rows


def stress_words(e):
    learned = {role: e["closed_loop"][role]["learned"] for role in ("held_out", "held_out_full")}
    return ["In plane stress (`make all STUDY=surface-stress`) the learned springs reach",
            f"{three(learned['held_out'])} on `held_out` and", f"{three(learned['held_out_full'])} on `held_out_full`."]


def claim(e):
    def ratio(model, measure):
        open_loop = e["open_loop"]
        return open_loop["heuristic_a"][measure]["median"] / open_loop[model][measure]["median"]

    restarted = e["training_also"][0]["restarted_sets"]
    sets = e["training"]["sets"]
    return ["| reading | L | resolved force |", "|---|---|---|",
            f"| `spsa-2008`, the paper's optimiser ({restarted} of {sets} sets restarted; the paper: 3 of 18) | "
            f"{ratio('learned_spsa_2008', 'rel_loss'):.1f} times | "
            f"{ratio('learned_spsa_2008', 'resolved_force_error'):.1f} times |",
            f"| `spsa`, ours | {ratio('learned', 'rel_loss'):.1f} times | "
            f"{ratio('learned', 'resolved_force_error'):.1f} times |",
            f"| the best there is, certified | {ratio('optimum', 'rel_loss'):.1f} times | "
            f"{ratio('optimum', 'resolved_force_error'):.1f} times |"]


def fill(text, marker, rows):
    pattern = re.compile(rf"(<!-- begin {marker} -->\n).*?(<!-- end {marker} -->)", re.S)
    if not pattern.search(text):
        sys.exit(f"reference.py: README.md: there is no marker '{marker}'")
    return pattern.sub(lambda m: m.group(1) + "\n".join(rows) + "\n" + m.group(2), text)


def main():
    evaluations = {}
    for study in sys.argv[1:]:
        results = ROOT / "results" / study
        evaluations[study] = json.loads((results / "eval.json").read_text())
        reference_record.write(REFERENCE / f"{study}.json", reference_record.of(results, "make reference"))
    swept = {study: evaluations.pop(study) for study in SWEPT if study in evaluations}
    for study in swept:
        figure, name = SWEPT[study]
        shutil.copyfile(ROOT / "results" / study / "figures" / f"{figure}.png", REFERENCE / f"{name}.png")
    for figure in FIGURES:
        shutil.copyfile(ROOT / "results" / "paper" / "figures" / f"{figure}.png", REFERENCE / f"{figure}.png")
    readme = ROOT / "README.md"
    text = readme.read_text()
    text = fill(text, "results", results_table(evaluations["paper"]))
    text = fill(text, "claim", claim(evaluations["paper"]))
    text = fill(text, "studies", studies_table(evaluations))
    for study, evaluation in swept.items():
        text = fill(text, study, surface_table(evaluation))
    stress = ROOT / "results" / "surface-stress" / "eval.json"
    if stress.exists():
        text = fill(text, "stress", stress_words(json.loads(stress.read_text())))
    readme.write_text(text)


if __name__ == "__main__":
    main()
