"""Indentation error of contact force on the test set: around the outline, its distribution, and against angle and
depth."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import held_out_solid
from results import COLOURS, LABELS, how_often, learned_label

ROLES = {"held_out": "core range", "held_out_full": "full range"}


def draw(results):
    if results.solid:
        return held_out_solid.draw(results)
    evaluation = results.evaluation
    drawn = {role: [c for c in evaluation["drawn"].get(role, []) if c["error"]["learned"] is not None]
             for role in ROLES}
    contacts = [c for role in ROLES for c in drawn[role]]
    error = np.array([c["error"]["learned"] for c in contacts])
    figure, axes = plt.subplots(2, 3, figsize=(14, 8.4), layout="constrained",
                                gridspec_kw={"width_ratios": [1.25, 1, 1]})

    around = axes[0, 0]
    loop = np.append(results.boundary, results.boundary[0])
    around.plot(*(results.nodes[loop] * 1e3).T, color="0.5", linewidth=1)
    points = np.array([results.point_at(c["arc_m"]) for c in contacts]).reshape(-1, 2) * 1e3  # also for no contact
    inward = np.array([results.normal_at(c["arc_m"]) for c in contacts]).reshape(-1, 2)
    depth = np.array([c["depth_m"] for c in contacts]) * 1e3
    where = points + inward * depth[:, None]  # inside the tissue, at the depth of the indentation
    shade = around.scatter(*where.T, c=np.maximum(error, 1e-3), norm=LogNorm(1e-3, 0.3), cmap="viridis", s=16)
    figure.colorbar(shade, ax=around, label="indentation error of force", format=lambda v, _: f"{100 * v:g} %")
    around.set_aspect("equal")
    around.set_title("Contacts: each dot is below its contact\nby the length of the tool displacement", fontsize=10)
    around.set_xlabel("x (mm)")
    around.set_ylabel("y (mm)")

    often = axes[1, 0]
    bins = np.geomspace(1e-4, 2, 45)
    table = "force table" if "measurement" in evaluation else "FE force table"
    shown = {"learned": learned_label(results), "force_table": table, "uniform": "springs of one stiffness",
             "heuristic_a": LABELS["heuristic_a"], "untrained": "untrained model"}
    for model, label in shown.items():
        values, part, count = how_often(evaluation, "held_out", model)
        if len(values):
            often.plot(np.maximum(values, bins[0]), part, color=COLOURS[model], label=f"{label} ({count})")
    often.set_xscale("log")
    often.set_ylim(0, 1.02)
    often.set_xlabel("indentation error of force, core range")
    often.set_ylabel("part of the contacts with a smaller error (1)")
    often.xaxis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
    often.grid(color="0.9")
    often.legend(frameon=False, fontsize=8)

    counts = axes[0, 1]
    counts.hist([np.maximum([c["error"]["learned"] for c in drawn[role]], bins[0]) for role in ROLES],
               bins=bins, stacked=True, color=["#0072B2", "#56B4E9"], label=[f"{label} ({how_often(evaluation, role, 'learned')[2]})".replace(" ()", "") for role, label in ROLES.items()])
    counts.set_xscale("log")
    counts.xaxis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
    counts.set_xlabel("indentation error of force, trained model")
    counts.set_ylabel("number of contacts")
    counts.legend(frameon=False)

    for axis, key, scale, label in ((axes[0, 2], "angle_deg", 1, "angle between tool displacement and inward normal (degrees)"),
                                    (axes[1, 1], "depth_m", 1e3, "tool displacement (mm)"),
                                    (axes[1, 2], "arc_m", 1e3, "place along the surface, arc length (mm)")):
        for role, colour in zip(ROLES, ("#0072B2", "#56B4E9")):
            axis.plot([c[key] * scale for c in drawn[role]],
                      [max(c["error"]["learned"], bins[0]) for c in drawn[role]], ".", color=colour, markersize=5,
                      label=ROLES[role])
        axis.set_yscale("log")
        axis.yaxis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
        axis.set_xlabel(label)
        axis.set_ylabel("indentation error of force")
        axis.grid(color="0.9")
    for corner in results.corner_arcs():
        axes[1, 2].axvline(corner * 1e3, color="0.6", linestyle=":", linewidth=1)
    axes[1, 2].legend(framealpha=0.9)  # nearly opaque: the legend's markers are not data
    figure.suptitle("Indentation error of contact force at the contacts of the test set")
    return figure
