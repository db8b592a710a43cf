"""Tables of README.md and results/RESULTS.md: rows of Markdown, from evaluations (eval.json or a record's part of it)
and from patient.md.

A record has fewer values than eval.json. A cell whose value is missing is UNKNOWN.
"""
import re

UNKNOWN = "?"
LABELS = {
    "learned": "learned (`spsa`)",
    "learned_spsa_2008": "learned (`spsa-2008`, the paper's)",
    "optimum": "certified optimum",
    "heuristic_a": "heuristic, E2 = E t",
    "heuristic_b": "heuristic, E2 = (C1 + C2) t",
    "uniform": "one stiffness",
    "one_set": "one learned set for all cases",
}
DRAWN = {  # studies evaluated at drawn contacts, and their models' names in RESULTS.md
    "surface": "**energy model**, plane strain (`surface`)",
    "surface-quick": "energy model, trained in half a minute (`surface-quick`)",
    "surface-sets": "spring sets, the nearest one is used (`surface-sets`)",
    "surface-stress": "energy model, plane stress (`surface-stress`)",
    "organ": "energy model, section of an organ (`organ`)",
    "organ-lump": "energy model, with an inclusion five times as stiff (`organ-lump`)",
}
SPACE = {  # models of solids, and their names in RESULTS.md
    ("block3", "learned"): "**energy model**, {numbers} parameters, {paths} FE paths (`block3`)",
    ("block3-quick", "learned"): "energy model, {numbers} parameters, {paths} FE paths (`block3-quick`, its own contacts)",
    ("nodule3", "learned"): "energy model, {numbers} parameters, {paths} FE paths, block with an inclusion (`nodule3`, its own contacts)",
    ("organ3", "learned"): "energy model, {numbers} parameters, {paths} FE paths, a solid of any shape (`organ3`, its own contacts)",
    ("block3", "untrained"): "`block3`'s model before training",
    ("block3", "force_table"): "FE force table",
    ("block3", "heuristic_a_patch"): "heuristic, E2 = E, without cells, under the contact of the untrained model",
    ("block3", "uniform_patch"): "one stiffness, the same contact",
}
RELAXING = {  # studies evaluated along displacement histories, and their names in RESULTS.md
    "relax": "the block (`relax`)",
    "nodule-relax": "an inclusion that relaxes a quarter as much (`nodule-relax`)",
    "block3-relax": "in space (`block3-relax`)",
}
SPACE_ROLES = ["held_out", "held_out_near", "held_out_sideways"]
VAN_GELDER = "Van Gelder"
SUMMARY = [  # README's rows: model, study, role, baseline
    ("spring sets of the paper", "paper", "trained", "heuristic_a", VAN_GELDER),
    ("energy model, block in the plane", "surface", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("energy model, section of an organ", "organ", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("energy model, block in space", "block3", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("the same under discs of 4, 6 and 8.5 mm, trained at 3, 5, 7 and 10", "block3-tools", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("block with a stiff inclusion", "nodule3", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("organ in space", "organ3", "held_out", "heuristic_a_patch", VAN_GELDER),
    ("trained on noisy synthetic forces, in place of measured ones", "measured", "held_out", "repeat", "a second measurement"),
]
PATIENT = {"lump": "adapted to a synthetic target tissue with an inclusion"}  # rows of patient.md in README
PATIENT_POKES = 20
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


def n_of(statistics):
    """"n of N" of a statistic (results/FORMATS.md)."""
    of = statistics.get("of", UNKNOWN)  # a record of an earlier program
    lost = statistics.get("no_reference", 0)
    return f"{statistics['n']} of {of}" + (f", {lost} without a reference" if lost else "")


def counted(text, statistics):
    return f"{text} ({n_of(statistics)})"


def quantiles(statistics):
    """median / p95 / max. An infinite quantile is "none": it falls on missing answers."""
    return " / ".join(percent(statistics[key]) for key in ("median", "p95", "max")) if statistics["n"] else "none"


def three(statistics):
    return counted(quantiles(statistics), statistics)


def shape(entry):
    """Displacement error of an entry of closed_loop, at the same contacts as the force error."""
    return quantiles(entry["shape"]) if entry["shape"] else "none"


def seconds(value):
    if value is None:
        return UNKNOWN
    return f"{value:.2g} s" if value < 99.5 else f"{value:.0f} s"


def results_table(evaluation):
    rows = ["| model | rel_loss (9) | resolved force | indentation error of force | of displacement |", "|---|---|---|---|---|"]
    for model, errors in evaluation["open_loop"].items():
        rows.append(f"| {LABELS.get(model, model)} | {three(errors['rel_loss'])} | "
                    f"{three(errors['resolved_force_error'])} | {three(evaluation['closed_loop']['trained'][model])} | "
                    f"{shape(evaluation['closed_loop']['trained'][model])} |")
    return rows


def studies_table(evaluations):
    rows = ["| spring mesh | heuristic rel_loss | certified optimum | gap of `spsa`, max | gap of `spsa-2008`, median | "
            "indentation error of force, trained | of displacement | of force, best baseline | of displacement |",
            "|---|---|---|---|---|---|---|---|---|"]
    for study, e in evaluations.items():
        closed = e["closed_loop"]["trained"]
        baselines = {m: closed[m]["median"] for m in ("heuristic_a", "heuristic_b", "uniform") if closed[m]["median"] is not None}
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
    """The models of study surface, and the spring sets trained at the same contacts."""
    names = {"learned": "**energy model**", "untrained": "the same before training", "force_table": "FE force table",
             "heuristic_a_patch": "heuristic, E2 = E t, without cells, under the contact of the model",
             "uniform_patch": "one stiffness, the same contact",
             "heuristic_a": "heuristic, E2 = E t, two-node contact", "uniform": "one stiffness, two-node contact"}
    rows = ["| model | held_out: force | held_out: displacement | held_out_full: force | held_out_full: displacement |",
            "|---|---|---|---|---|"]
    for model, name in names.items():
        rows.append(f"| {name} | {roles_of(e, model)} |")
        if model == "untrained":
            rows.append(f"| spring sets, the nearest one is used (`surface-sets`) | {roles_of(sets, 'learned')} |")
    rows.append("| the reference, finer mesh | " + three(e["truth_check"]) + " | | | |")
    return rows


def drawn_table(evaluations):
    rows = ["| model | parameters | FE paths | training | held_out: force | held_out: displacement | held_out_full: force | "
            "held_out_full: displacement |", "|---|---|---|---|---|---|---|---|"]
    for study, name in DRAWN.items():
        e = evaluations[study]
        t = e["training"]
        numbers = len(t["terms"]) if "terms" in t else f"{t['sets']} sets"
        paths = t.get("paths", evaluations["surface"]["training"]["paths"])  # spring sets use the paths of surface
        rows.append(f"| {name} | {numbers} | {paths} | {seconds(t.get('seconds'))} | {roles_of(e, 'learned')} |")
    return rows


def space_table(evaluations):
    rows = ["| model | training | " + " | ".join(f"{role}: force | displacement" for role in SPACE_ROLES) + " |",
            "|---|---|" + "---|---|" * len(SPACE_ROLES)]
    for (study, model), name in SPACE.items():
        e = evaluations[study]
        training = e["training"]
        drawn = e["closed_loop"]
        cells = [f"{three(drawn[role][model])} | {shape(drawn[role][model])}" if role in drawn else " | " for role in SPACE_ROLES]
        rows.append(f"| {name.format(numbers=len(training['terms']), paths=training['paths'])} | "
                    + (seconds(training.get('seconds')) if model == "learned" else "") + " | " + " | ".join(cells) + " |")
    rows.append("| the reference, finer mesh | | " + three(evaluations["block3"]["truth_check"]) + " | " * 6 + "|")
    return rows


def tools_table(e):
    """Study block3-tools: errors of the energy model by disc radius. No test contact has a trained radius."""
    of_disc = {role: {entry["radius_m"]: entry for entry in e["by_radius"][role]} for role in SPACE_ROLES}
    rows = ["| disc | " + " | ".join(f"{role}: force | displacement" for role in SPACE_ROLES) + " |", "|---|" + "---|---|" * len(SPACE_ROLES)]

    def row(name, models, model):
        return f"| {name} | " + " | ".join(f"{three(m[model])} | {shape(m[model])}" if m else " | " for m in models) + " |"

    for radius_m in sorted(set().union(*of_disc.values())):
        rows.append(row(f"{1e3 * radius_m:g} mm", [of_disc[role].get(radius_m) for role in SPACE_ROLES], "learned"))
    every = [e["closed_loop"][role] for role in SPACE_ROLES]
    return rows + [row(name, every, model) for name, model in
                   (("all of them", "learned"), ("all, before training", "untrained"), ("all, heuristic, E2 = E, under the contact of the untrained model", "heuristic_a_patch"))]


def nodule_table(e):
    """The force map of study nodule3: above the nodule, far away, and their ratio."""
    contrast = e["map"]["contrast"]
    force = {tuple(p["contact_m"]): p for p in e["map"].get("places", [])}

    def row(name, places):
        if not force:  # evaluation of a record
            return f"| {name} | {UNKNOWN} | {UNKNOWN} |"
        return f"| {name} | " + " | ".join(mean([force[tuple(p)][model] for p in places]) for model in ("fe_N", "learned_N")) + " |"

    def mean(forces_N):
        return "none" if None in forces_N else f"{1e3 * sum(forces_N) / len(forces_N):.1f} mN"

    learned = contrast["learned"]

    return [f"| straight in, {1e3 * e['map']['depth_m']:g} mm | finite elements | energy model |", "|---|---|---|",
            row("above the middle of the inclusion", [contrast["over_m"]]), row("far from it", contrast["far_m"]),
            f"| contrast | {contrast['fe']:.3f} | {'none' if learned is None else format(learned, '.3f')} |"]


def beside(statistics, learned):
    """"n of N" where it differs from that of the row."""
    return "" if n_of(statistics) == n_of(learned) else f" ({n_of(statistics)})"


def relaxing_table(evaluations):
    """Median errors of the model and of baselines, for each group of histories of the studies that relax."""
    others = {"long_term": "long-term", "instantaneous": "instantaneous", "best_factor": "best factor", "kelvin_voigt": "Kelvin-Voigt",
              "one_branch": "one branch", "prony": "FE force without relaxation, through the Prony series"}
    rows = ["| histories | n of N | model, rms | largest error | without relaxation in both, rms | " + " | ".join(others.values()) + " |",
            "|---|---|---|---|---|" + "---|" * len(others)]

    for study, name in RELAXING.items():
        for group, models in evaluations[study]["histories"]["groups"].items():
            if group == "all":
                continue
            medians = [percent(models[m]["rms"]["median"]) + beside(models[m]["rms"], models["learned"]["rms"]) for m in others]
            rows.append(f"| {name}: {group} | {n_of(models['learned']['rms'])} | {quantiles(models['learned']['rms'])} | "
                        f"{quantiles(models['learned']['peak'])} | {quantiles(models['elastic'])}{beside(models['elastic'], models['learned']['rms'])} | "
                        + " | ".join(medians) + " |")
    return rows


def ablation_table(variants, roles):
    rows = ["| parameters | FE paths | training | " + " | ".join(f"{role}: force | {role}: displacement" for role in roles) + " |",
            "|---|---|---|" + "---|---|" * len(roles)]
    for v in sorted(variants, key=lambda v: (v["fe_paths"], v["numbers"])):
        cells = [f"{three(v[role]['learned'])} | {shape(v[role]['learned'])}" for role in roles]
        rows.append(f"| {v['numbers']} | {v['fe_paths']} | {seconds(v['seconds'])} | " + " | ".join(cells) + " |")
    return rows


def measured_table(e):
    names = {"learned": "energy model", "force_table": "force table, interpolated", "heuristic_a": "heuristic, E2 = E t",
             "heuristic_b": "heuristic, E2 = (C1 + C2) t", "uniform": "one stiffness", "repeat": "a repeat of the measurement"}
    rows = ["| model | rows of the test set |", "|---|---|"]
    return rows + [f"| {name} | {three(e['closed_loop']['held_out'][model])} |" for model, name in names.items()]


def measured_histories_table(e):
    models = {"learned": "energy model", "long_term": "long-term", "instantaneous": "instantaneous", "best_factor": "elastic, best factor",
              "kelvin_voigt": "Kelvin-Voigt", "one_branch": "one branch"}
    rows = ["| histories | " + " | ".join(models.values()) + " |", "|---|" + "---|" * len(models)]

    for group, errors in e["histories"]["groups"].items():
        rows.append(f"| {group} | " + " | ".join(three(errors[m]["rms"]) for m in models) + " |")
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
            f"| certified optimum | {ratio('optimum', 'rel_loss'):.1f} times | "
            f"{ratio('optimum', 'resolved_force_error'):.1f} times |"]


def two(statistics):
    if not statistics:
        return ""
    return f"{percent(statistics['median'])} / {percent(statistics['p95'])}" if statistics["n"] else "none"


def patient_rows(text, way="field, chosen places"):
    """Rows of patient.md: target tissue -> (description, errors by number of measurements as written there, "n of N" of
    the fewest answers)."""
    rows = {}
    for section in text.split("\n## ")[1:]:
        head, *lines = section.splitlines()
        table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
        found = [row for row in table if row[0] == way]
        if found:
            patient, _, what = head.partition(": ")
            answered = next(re.match(r"Answered at (\d+ of \d+) ", line)[1] for line in lines if line.startswith("Answered at "))
            rows[patient] = what, dict(zip(map(int, table[0][1:]), found[0][1:])), answered
    return rows


def patient_table(patients):
    shown = (0, 1, 5, 10, 20, 40)
    rows = ["| target tissue (synthetic) | " + " | ".join("before" if n == 0 else f"{n} measurement{'s' * (n > 1)}" for n in shown) + " | answered |",
            "|---|" + "---|" * (len(shown) + 1)]
    return rows + [f"| {what} | " + " | ".join(errors[n] for n in shown) + f" | {answered} |" for what, errors, answered in patients.values()]


def summary_table(evaluations, patients):
    """README's table: errors of force and displacement of each model, and of its baseline; median / p95 (n of N,
    eval/statistics.h)."""
    def of_truth(statistics):
        return counted(two(statistics), statistics) if statistics else ""

    rows = ["| model (study) | error of force | of displacement | baseline, its error of force | reference |", "|---|---|---|---|---|"]
    for name, study, role, other, called in SUMMARY:
        e = evaluations[study]
        models = e["closed_loop"][role]
        rows.append(f"| {name} (`{study}`) | {counted(two(models['learned']), models['learned'])} | {two(models['learned'].get('shape'))} | "
                    f"{called} {two(models[other])}{beside(models[other], models['learned'])} | {of_truth(e.get('truth_check'))} |")
    models = evaluations["relax"]["histories"]["groups"]["all"]
    rows.append(f"| tissue that relaxes, over time (`relax`) | {counted(two(models['learned']['rms']), models['learned']['rms'])} |  | "
                f"elastic, best factor {two(models['best_factor']['rms'])}{beside(models['best_factor']['rms'], models['learned']['rms'])} |  |")

    def errors(text):
        return " / ".join(part.strip() if part.strip() == "none" else f"{part.strip()} %" for part in text.split("/"))

    for patient, name in PATIENT.items():
        _, pokes, answered = patients[patient]
        rows.append(f"| {name}, after {PATIENT_POKES} measurements | {errors(pokes[PATIENT_POKES])} ({answered}) |  | before adaptation {errors(pokes[0])} |  |")
    return rows


def tables(evaluations):
    """(marker, rows) of RESULTS.md's tables, for those whose studies are all present."""
    def of(*studies):
        return all(study in evaluations for study in studies)

    e = evaluations
    if of("paper"):
        yield "results", results_table(e["paper"])
        yield "claim", claim(e["paper"])
    if of(*STUDIES):
        yield "studies", studies_table({study: e[study] for study in STUDIES})
    if of("surface", "surface-sets"):
        yield "surface", surface_table(e["surface"], e["surface-sets"])
    if of(*DRAWN):
        yield "drawn", drawn_table(e)
    if of("block3", "block3-quick", "nodule3", "organ3"):
        yield "space", space_table(e)
    if of("block3-tools"):
        yield "tools", tools_table(e["block3-tools"])
    if of("nodule3"):
        yield "nodule", nodule_table(e["nodule3"])
    if of(*RELAXING):
        yield "relaxing", relaxing_table(e)
    if of("measured"):
        yield "measured", measured_table(e["measured"])
    if of("measured-relax"):
        yield "measured-relax", measured_histories_table(e["measured-relax"])
