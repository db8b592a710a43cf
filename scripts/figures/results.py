"""A study's results as arrays, for the figures. Reads cases.h5, model.h5 and eval.json without computing anything."""
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from one_line import NUMBER_OR_NULL, read_json
from stored import stored

# Okabe and Ito's palette, which is distinguishable with every common type of colour vision
COLOURS = {
    "fe": "#000000",
    "learned": "#0072B2",
    "learned_spsa_2008": "#56B4E9",
    "optimum": "#009E73",
    "heuristic_a": "#D55E00",
    "heuristic_b": "#E69F00",
    "uniform": "#CC79A7",
    "untrained": "#56B4E9",
    "force_table": "#000000",
}
MARKERS = {"learned": "o", "learned_spsa_2008": "s", "optimum": "*", "heuristic_a": "^", "heuristic_b": "v",
           "uniform": "D"}
LABELS = {
    "fe": "finite elements",
    "learned": "trained (spsa)",
    "learned_spsa_2008": "trained (spsa-2008)",
    "optimum": "certified optimum",
    "heuristic_a": "Van Gelder, E2 = E t",
    "heuristic_b": "Van Gelder, E2 = (C1 + C2) t",
    "uniform": "springs of one stiffness",
    "one_set": "one trained set for all cases",
}

# form of eval.json (results/FORMATS.md), as far as figures and page use it
STATISTICS = {"median": NUMBER_OR_NULL, "p95": NUMBER_OR_NULL, "max": NUMBER_OR_NULL, "n": int, "of": int, "missing": int, "no_reference": int}
ERRORS = {"*": NUMBER_OR_NULL}
SERIES = {"magnitude_m": [float], "fe_N": [float], "models_N": {"*": [NUMBER_OR_NULL]}}
TRAINING = {"optimizer": str, "terms": {"*": float}, "seconds": float, "paths": int}
EVALUATION = {
    "study": str, "version": str, "seed": int, "training": TRAINING, "training_also": [TRAINING], "truth_check": STATISTICS,
    "open_loop": {"*": {"rel_loss": STATISTICS}}, "closed_loop": {"*": {"*": {**STATISTICS, "shape": (STATISTICS, type(None))}}},
    "drawn": {"*": [{"name": str, "contact_m": [float, ...], "direction": [float, ...], "arc_m": float, "depth_m": float, "angle_deg": float, "error": ERRORS, "shape": ERRORS}]},
    "drawn_curves": [{"name": str, **SERIES}], "curves": [{"path": str, "serving_set": [str], **SERIES}],
    "drawn_shapes": [{"name": str, "which": str, "displacement_m": [[float]]}], "cases": [{"name": str, "models": {"*": ERRORS}}, ...],
    "springs": {"*": {}}, "ridge_front": [{"distance_E2": float, "rel_loss": float}],
    "histories": {"groups": {"*": {"learned": {"rms": STATISTICS}}}, "each": [{
        "name": str, "group": str, "time_s": [float, ...], "fe_N": [float], "best_factor_N": [float], "learned_N": [NUMBER_OR_NULL], "error": {"learned": {"rms": NUMBER_OR_NULL}}}]},
    "map": {"depth_m": float, "places": [{"contact_m": [float, ...], "fe_N": float, "learned_N": NUMBER_OR_NULL}], "contrast": {"fe": float, "learned": NUMBER_OR_NULL}},
}


def truth_label(results):
    """Label of the reference: measured forces or finite elements."""
    return "measured" if results.evaluation.get("measurement") else LABELS["fe"]


def model_name(results, optimizer):
    """An optimiser's column in eval.json: "learned" for the study's own, "learned_NAME" for the others."""
    own = optimizer == next(iter(results.trained))
    return "learned" if own else "learned_" + optimizer.replace("-", "_").replace(":", "_")


class Results(SimpleNamespace):
    def _surface(self):
        """Nodes of the free surface, counter-clockwise from the end of the fixed edge, and their arc lengths."""
        loop, fixed = list(self.boundary), set(self.fixed)
        start = next(i for i in range(len(loop)) if loop[i] in fixed and loop[(i + 1) % len(loop)] not in fixed)
        nodes = [loop[start]]
        while len(nodes) == 1 or nodes[-1] not in fixed:
            nodes.append(loop[(start + len(nodes)) % len(loop)])
        points = self.nodes[nodes]
        return points, np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])

    def point_at(self, arc):
        points, arcs = self._surface()
        return np.array([np.interp(arc, arcs, points[:, axis]) for axis in (0, 1)])

    def normal_at(self, arc):
        along = self.point_at(arc + 1e-6) - self.point_at(arc - 1e-6)
        return np.array([-along[1], along[0]]) / np.linalg.norm(along)

    def corner_arcs(self):
        points, arcs = self._surface()
        step = np.diff(points, axis=0)
        step /= np.linalg.norm(step, axis=1)[:, None]
        # threshold as in mesh/outline; a smaller turn is a curve
        return arcs[1:-1][(step[:-1] * step[1:]).sum(axis=1) < np.sqrt(0.5)]


def how_often(evaluation, role, model):
    """Errors of a model at the contacts drawn for a role, in ascending order; for each the fraction of the contacts
    with a reference whose error is at or below it, where a missing answer counts as infinite; and "n of N"
    (results/FORMATS.md)."""
    models = evaluation["closed_loop"].get(role, {})
    name = model if model in models else f"{model}_patch"  # springs alone, with the contact of the model
    if name not in models:
        return [], [], ""
    found = models[name]
    errors = np.sort([c["error"][name] for c in evaluation["drawn"].get(role, []) if c["error"][name] is not None])
    return errors, np.arange(1, len(errors) + 1) / max(found["n"] + found["missing"], 1), f"{found['n']} of {found['of']}"


def nothing(words):
    """A figure with a text in place of one that cannot be drawn."""
    import matplotlib.pyplot as plt  # after the caller has chosen the backend
    figure = plt.figure(figsize=(8, 2))
    figure.text(0.5, 0.5, words, ha="center")
    return figure


def learned_label(results):
    """Legend label of the trained model: an energy model, or spring sets of which the nearest is used."""
    return "trained model" if "terms" in results.evaluation["training"] else "trained, nearest spring set"


def load(folder):
    folder = Path(folder)
    results = Results(evaluation=read_json(folder / "eval.json", EVALUATION), paths={}, trained={})
    results.evaluation.setdefault("drawn", {})  # missing where no drawn contact has an FE reference
    with stored(folder / "cases.h5") as f:
        results.is_block = "shape" not in f
        for name in f["path_names"].asstr():
            group = f["paths"][name]
            results.paths[name] = SimpleNamespace(**{key: group[key][()] for key in group})
    with stored(folder / "model.h5") as f:
        results.nodes = f["mesh/nodes"][()]
        results.springs = f["mesh/springs"][()]
        results.solid = results.nodes.shape[1] == 3
        if results.solid:
            results.tetrahedra = f["mesh/tetrahedra"][()]
            results.facets = f["mesh/facets"][()]
            results.ground = f["law/ground"][()] if "law/ground" in f else None
        else:
            results.triangles = f["mesh/triangles"][()]
            results.boundary = f["mesh/boundary"][()]
        results.fixed = f["mesh/fixed"][()]
        if "mesh/lattice" in f:  # the solid's own nodes come first
            results.nodes = results.nodes[: len(f["mesh/lattice/corner"])]
        results.modulus = float(f.attrs["modulus_N_m"])
        results.case_names = list(f["cases/names"].asstr())
        results.magnitude = f["cases/magnitude"][()]
        results.contact = f["cases/contact"][()]
        results.direction = f["cases/direction"][()]
        results.heuristic_a = f["heuristic_a"][()]
        results.trained_by_model = {}
        for optimizer in f["optimizers"].asstr() if "optimizers" in f else []:  # an energy model has none
            group = f["trained"][optimizer]
            results.trained[optimizer] = SimpleNamespace(
                theta=group["theta"][()], rel_loss=group["rel_loss"][()], loss=group["loss"][()],
                iteration=group["curve_iteration"][()], curve=group["curve_loss"][()])
            results.trained_by_model[model_name(results, optimizer)] = results.trained[optimizer]
    return results


def title_of_case(results, case):
    """"left-10mm" as "left, 10 mm"."""
    return f"{path_of_case(results, case).replace('-', ' ')}, {1e3 * results.magnitude[case]:g} mm"


def path_of_case(results, case):
    return results.case_names[case].rsplit("-", 1)[0]


def record_of_case(results, case):
    """Index of the path's record at the case's magnitude."""
    path = results.paths[path_of_case(results, case)]
    return int(np.argmin(np.abs(path.magnitude - results.magnitude[case])))


def shown_cases(results):
    """The two cases of the paper's Fig. 2, or a study's first and last."""
    wanted = ["left-10mm", "top-right-diagonal-15mm"]
    names = results.case_names
    if all(w in names for w in wanted):
        return [names.index(w) for w in wanted]
    return [0, len(names) - 1]
