"""Writes what is committed of the studies' results: reference.py STUDY...

results/reference/STUDY.json   what a regression compares with (reference_record.py)
results/reference/*.png        the figures that README shows
README.md                      the tables between its markers, from the evaluations, and from `make ablation STUDY=surface`
                               and `STUDY=block3`

Of fewer studies than README is about it writes the tables and figures of those alone.
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
DRAWN = {  # studies judged on drawn contacts, and what README calls their models
    "surface": "**law**, plane strain (`surface`)",
    "surface-quick": "law, half a minute (`surface-quick`)",
    "surface-sets": "spring sets, the nearest serves (`surface-sets`)",
    "surface-stress": "law, plane stress (`surface-stress`)",
    "organ": "law, an organ's section (`organ`)",
    "organ-lump": "law, its lump five times as stiff (`organ-lump`)",
}
SHOWN = [("surface", "shape", "shape"), ("surface", "held_out", "held_out"), ("surface", "ablation", "ablation"),
         ("organ", "shape", "organ"), ("block3", "solid", "block3-solid"),
         ("block3", "held_out", "block3-held_out"), ("relax", "histories", "relax"), ("nodule3", "map", "nodule3-map"), ("organ3", "solid", "organ3-solid"),
         *(("paper", figure, figure) for figure in FIGURES)]  # study, figure, its name beside README
SPACE = {  # models of solids, and what README calls them
    ("block3", "learned"): "**learned law**, {numbers} numbers, {paths} FE paths (`block3`)",
    ("block3-quick", "learned"): "law, {numbers} numbers, {paths} FE paths (`block3-quick`, on the first of these contacts)",
    ("nodule3", "learned"): "law, {numbers} numbers, {paths} FE paths, a nodule in the block (`nodule3`, its own contacts)",
    ("organ3", "learned"): "law, {numbers} numbers, {paths} FE paths, a solid of any shape (`organ3`, its own contacts)",
    ("block3", "untrained"): "`block3`'s law, nothing learned",
    ("block3", "force_table"): "FE force table",
    ("block3", "heuristic_a_patch"): "heuristic, E2 = E, without cells, under the untrained law's contact",
    ("block3", "uniform_patch"): "one stiffness, likewise",
}
RELAXING = {  # studies judged on histories, and what README calls them
    "relax": "the block (`relax`)",
    "nodule-relax": "an inclusion that relaxes a quarter as much (`nodule-relax`)",
    "block3-relax": "in space (`block3-relax`)",
}
SPACE_ROLES = ["held_out", "held_out_near", "held_out_sideways"]
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


def seconds(value):
    return f"{value:.2g} s" if value < 99.5 else f"{value:.0f} s"


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


def roles_of(e, model):
    return " | ".join(f"{three(role[model])} | {shape(role[model])}" for role in
                      (e["closed_loop"]["held_out"], e["closed_loop"]["held_out_full"]))


def surface_table(e, sets):
    """The models of study surface, and what spring sets make of the same training contacts."""
    names = {"learned": "**learned law**", "untrained": "the same law, nothing learned", "force_table": "FE force table",
             "heuristic_a_patch": "heuristic, E2 = E t, without cells, under the law's contact",
             "uniform_patch": "one stiffness, likewise",
             "heuristic_a": "heuristic, E2 = E t, two-node contact", "uniform": "one stiffness, two-node contact"}
    rows = ["| model | held_out: force | held_out: shape | held_out_full: force | held_out_full: shape |",
            "|---|---|---|---|---|"]
    for model, name in names.items():
        rows.append(f"| {name} | {roles_of(e, model)} |")
        if model == "untrained":
            rows.append(f"| spring sets, the nearest serves (`surface-sets`) | {roles_of(sets, 'learned')} |")
    rows.append("| the truth's own error, finer mesh | " + three(e["truth_check"]) + " | | | |")
    return rows


def drawn_table(evaluations):
    rows = ["| model | numbers | FE paths | training | held_out: force | held_out: shape | held_out_full: force | "
            "held_out_full: shape |", "|---|---|---|---|---|---|---|---|"]
    for study, name in DRAWN.items():
        e = evaluations[study]
        t = e["training"]
        numbers = len(t["terms"]) if "terms" in t else f"{t['sets']} sets"
        paths = t.get("paths", evaluations["surface"]["training"]["paths"])  # sets have those of surface
        rows.append(f"| {name} | {numbers} | {paths} | {seconds(t['seconds'])} | {roles_of(e, 'learned')} |")
    return rows


def space_table(evaluations):
    rows = ["| model | training | " + " | ".join(f"{role}: force | shape" for role in SPACE_ROLES) + " |",
            "|---|---|" + "---|---|" * len(SPACE_ROLES)]
    for (study, model), name in SPACE.items():
        e = evaluations[study]
        training = e["training"]
        drawn = e["closed_loop"]
        cells = [f"{three(drawn[role][model])} | {shape(drawn[role][model])}" if role in drawn else " | " for role in SPACE_ROLES]
        rows.append(f"| {name.format(numbers=len(training['terms']), paths=training['paths'])} | "
                    + (seconds(training['seconds']) if model == "learned" else "") + " | " + " | ".join(cells) + " |")
    rows.append("| the truth's own error, finer mesh | | " + three(evaluations["block3"]["truth_check"]) + " | " * 6 + "|")
    return rows


def nodule_table(e):
    """What the map of study nodule3 says: over the nodule, far away, and their ratio."""
    contrast = e["map"]["contrast"]
    force = {tuple(p["contact_m"]): p for p in e["map"]["places"]}

    def row(name, places):
        values = [1e3 * sum(force[tuple(p)][model] for p in places) / len(places) for model in ("fe_N", "learned_N")]
        return f"| {name} | {values[0]:.1f} mN | {values[1]:.1f} mN |"

    return [f"| straight in, {1e3 * e['map']['depth_m']:g} mm | finite elements | learned law |", "|---|---|---|",
            row("over the nodule's middle", [contrast["over_m"]]), row("far from it", contrast["far_m"]),
            f"| contrast | {contrast['fe']:.3f} | {contrast['learned']:.3f} |"]


def relaxing_table(evaluations):
    """Each group of histories of the studies that relax: what the law is off, and what else there could be, in the median."""
    others = {"long_term": "long-term", "instantaneous": "instantaneous", "best_factor": "best factor", "kelvin_voigt": "Kelvin-Voigt",
              "one_branch": "one branch", "prony": "FE's elastic force through the branches"}
    rows = ["| histories | n | learned law, rms | largest error | its own, elastic beside elastic FE | " + " | ".join(others.values()) + " |",
            "|---|---|---|---|---|" + "---|" * len(others)]

    def cells(statistics):
        return " / ".join(percent(statistics[key]) for key in ("median", "p95", "max")) if statistics["n"] else ""

    for study, name in RELAXING.items():
        if study not in evaluations:
            continue
        for group, models in evaluations[study]["histories"]["groups"].items():
            if group == "all":
                continue
            medians = [percent(models[m]["rms"]["median"]) if models[m]["rms"]["n"] else "" for m in others]
            rows.append(f"| {name}: {group} | {models['learned']['rms']['n']} | {cells(models['learned']['rms'])} | "
                        f"{cells(models['learned']['peak'])} | {cells(models['elastic'])} | " + " | ".join(medians) + " |")
    return rows


def ablation_table(variants, roles=("held_out", "held_out_full")):
    rows = ["| numbers | FE paths | training | " + " | ".join(f"{role}: force | {role}: shape" for role in roles) + " |",
            "|---|---|---|" + "---|---|" * len(roles)]
    for v in sorted(variants, key=lambda v: (v["fe_paths"], v["numbers"])):
        cells = [f"{three(v[role]['learned'])} | {shape(v[role]['learned'])}" for role in roles]
        rows.append(f"| {v['numbers']} | {v['fe_paths']} | {seconds(v['seconds'])} | " + " | ".join(cells) + " |")
    return rows


def measured_table(e):
    names = {"learned": "learned law", "force_table": "force table, interpolated", "heuristic_a": "heuristic, E2 = E t",
             "heuristic_b": "heuristic, E2 = (C1 + C2) t", "uniform": "one stiffness", "repeat": "the same push measured again"}
    rows = ["| model | held-out rows |", "|---|---|"]
    return rows + [f"| {name} | {three(e['closed_loop']['held_out'][model])} |" for model, name in names.items()]


def measured_histories_table(e):
    models = {"learned": "learned law", "long_term": "long-term", "instantaneous": "instantaneous", "best_factor": "elastic, best factor",
              "kelvin_voigt": "Kelvin-Voigt", "one_branch": "one branch"}
    rows = ["| histories | " + " | ".join(models.values()) + " |", "|---|" + "---|" * len(models)]

    def three_of(s):
        return " / ".join(percent(s[key]) for key in ("median", "p95", "max")) + f" ({s['n']})"

    for group, errors in e["histories"]["groups"].items():
        rows.append(f"| {group} | " + " | ".join(three_of(errors[m]["rms"]) for m in models) + " |")
    return rows


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
    for study, figure, name in SHOWN:
        if study in evaluations:
            shutil.copyfile(ROOT / "results" / study / "figures" / f"{figure}.png", REFERENCE / f"{name}.png")
    readme = ROOT / "README.md"
    text = readme.read_text()

    def variants(study):
        return json.loads((ROOT / "results" / study / "ablation.json").read_text())["variants"]

    tables = [  # marker, studies it needs, its rows
        ("results", ["paper"], lambda: results_table(evaluations["paper"])),
        ("claim", ["paper"], lambda: claim(evaluations["paper"])),
        ("studies", STUDIES, lambda: studies_table({s: e for s, e in evaluations.items() if s in STUDIES})),
        ("surface", ["surface", "surface-sets"], lambda: surface_table(evaluations["surface"], evaluations["surface-sets"])),
        ("drawn", DRAWN, lambda: drawn_table(evaluations)),
        ("ablation", ["surface"], lambda: ablation_table(variants("surface"))),
        ("space", ["block3", "block3-quick", "nodule3", "organ3"], lambda: space_table(evaluations)),
        ("nodule", ["nodule3"], lambda: nodule_table(evaluations["nodule3"])),
        ("space-ablation", ["block3"], lambda: ablation_table(variants("block3"), SPACE_ROLES)),
        ("relaxing", ["relax", "nodule-relax"], lambda: relaxing_table(evaluations)),
        ("measured", ["measured"], lambda: measured_table(evaluations["measured"])),
        ("measured-relax", ["measured-relax"], lambda: measured_histories_table(evaluations["measured-relax"])),
    ]
    for marker, needs, rows in tables:
        if all(study in evaluations for study in needs):
            text = fill(text, marker, rows())
    readme.write_text(text)


if __name__ == "__main__":
    main()
