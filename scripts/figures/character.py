"""How the stiffnesses of spring sets differ (Sec. 3 of the paper): from the heuristic, near the contact and elsewhere;
between neighbouring sets; and the least loss against the distance from the heuristic."""
import matplotlib.pyplot as plt
import numpy as np

from results import COLOURS, LABELS, MARKERS

MEASURES = {
    "distance_near_E2": "set and heuristic,\nnear the contact",
    "distance_far_E2": "set and heuristic,\nelsewhere",
    "magnitude_step_E2": "sets of\nneighbouring\nmagnitudes",
    "angle_step_E2": "sets of\nneighbouring\nangles",
}


def draw(results):
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), layout="constrained")
    sets = {name: s for name, s in results.evaluation["springs"].items() if name.startswith(("learned", "optimum"))}
    for offset, (name, character) in zip(np.linspace(-0.2, 0.2, len(sets)), sets.items()):
        for place, measure in enumerate(MEASURES):
            s = character[measure]
            if s["n"] == 0:
                continue
            left.plot([place + offset] * 2, [s["median"], s["max"]], color=COLOURS.get(name, "0.4"), linewidth=1)
            left.plot(place + offset, s["median"], MARKERS.get(name, "o"), color=COLOURS.get(name, "0.4"), markersize=8,
                      label=LABELS.get(name, name) if place == 0 else None)
    left.set_xticks(range(len(MEASURES)), MEASURES.values())
    left.set_ylabel("rms difference of stiffness over the springs (E2):\nmedian (marker) and largest of the sets")
    left.set_ylim(bottom=0)
    left.legend(frameon=False)
    left.set_title("Differences of stiffness", fontsize=10)

    front = results.evaluation["ridge_front"]
    right.plot([p["distance_E2"] for p in front], [p["rel_loss"] for p in front], "-*", color=COLOURS["optimum"],
               markersize=9, label="least loss at that distance (ridge)")
    for name in sets:
        trained = results.trained_by_model[name] if name != "optimum" else None
        if trained is None:
            continue
        distance = np.sqrt(np.mean((trained.theta - results.heuristic_a) ** 2, axis=1)) / results.modulus
        right.plot(np.median(distance), np.median(trained.rel_loss), MARKERS.get(name, "o"),
                   color=COLOURS.get(name, "0.4"), markersize=8, label=LABELS.get(name, name))
    heuristic = results.evaluation["open_loop"]["heuristic_a"]["rel_loss"]["median"]
    right.plot(0, heuristic, MARKERS["heuristic_a"], color=COLOURS["heuristic_a"], markersize=8,
               label=LABELS["heuristic_a"])
    right.set_xlabel("rms difference of stiffness from the heuristic (E2)")
    right.set_ylabel("nodal-force error (9), median over the cases (1)")
    right.set_ylim(bottom=0)
    right.legend(frameon=False)
    right.set_title("Nodal-force error against the distance from the heuristic", fontsize=10)
    return figure
