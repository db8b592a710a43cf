"""Errors of every case: loss (9), resolved force, and indentation error, for learned springs and baselines."""
import matplotlib.pyplot as plt

from results import COLOURS, LABELS, MARKERS
from shape_error import percent_axis

MEASURES = {
    "rel_loss": "nodal-force error, rel_loss (9)",
    "resolved_force_error": "force at the loaded node, all nodes\nat their FE displacement",
    "closed_loop_error": "indentation error of contact force",
}


def draw(results):
    cases = results.evaluation["cases"]
    answered = {model: f"{statistics['n']} of {statistics['of']}" for model, statistics in results.evaluation["closed_loop"]["trained"].items()}
    figure, axes = plt.subplots(1, len(MEASURES), figsize=(13, 0.3 * len(cases) + 1.6), sharey=True,
                                layout="constrained")
    for axis, (measure, title) in zip(axes, MEASURES.items()):
        answers = 0
        for model in cases[0]["models"]:
            errors = [case["models"][model][measure] for case in cases]
            rows = [i for i, e in enumerate(errors) if e is not None]
            answers += len(rows)
            axis.plot([max(errors[i], 1e-3) for i in rows], rows, MARKERS.get(model, "o"),
                      color=COLOURS.get(model, "0.4"), markersize=6, alpha=0.85,
                      label=f"{LABELS.get(model, model)} ({answered[model]})")
        if answers == 0:
            axis.text(0.5, 0.5, "no model has an answer: see the report", ha="center", transform=axis.transAxes)
        else:
            axis.set_xscale("log")
            axis.axvline(1, color="0.6", linewidth=0.8)
            low, high = axis.get_xlim()
            percent_axis(axis.xaxis, between=high < 100 * low)
            axis.tick_params(axis="x", which="minor", labelsize=7)
        axis.set_title(title, fontsize=10)
        axis.grid(axis="both", color="0.9")
        axis.set_axisbelow(True)
    axes[0].set_yticks(range(len(cases)), [case["name"].replace("-", " ") for case in cases], fontsize=8)
    axes[0].invert_yaxis()
    handles, labels = axes[0].get_legend_handles_labels()
    figure.set_layout_engine("constrained", rect=(0, 0.08, 1, 0.92))  # space for the legend
    figure.legend(handles, labels, loc="lower center", ncols=-(-len(labels) // 2), frameon=False)
    figure.suptitle("Relative errors of force by load case; in brackets: number of cases with an equilibrium")
    return figure
