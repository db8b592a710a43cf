"""Tissue in space: indentation error of force at the contacts of the test set: on the surface from above; its
distribution; against tilt, depth and distance from the nearest wall (of a shape: height)."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from results import COLOURS, how_often, learned_label

MM = 1e3
ROLES = {"held_out": ("core range", "o", "#0072B2"), "held_out_near": ("near a wall", "s", "#E69F00"),
         "held_out_sideways": ("sideways", "D", "#CC79A7")}
SHOWN = {"learned": None, "force_table": "FE force table", "untrained": "untrained model",
         "heuristic_a": "Van Gelder's springs alone", "uniform": "springs of one stiffness alone"}
LOWEST = 1e-3  # lower limit of the logarithmic axes


def draw(results):
    drawn = {role: [c for c in results.evaluation["drawn"].get(role, []) if c["error"]["learned"] is not None]
             for role in ROLES}
    figure = plt.figure(figsize=(18, 8.4), layout="constrained")
    grid = figure.add_gridspec(2, 4, width_ratios=[1.7, 1, 1, 1])
    from_above(figure, figure.add_subplot(grid[:, 0]), results, drawn)
    models = {}
    for column, role in enumerate(ROLES, 1):
        axis = figure.add_subplot(grid[0, column])
        if not drawn[role]:
            axis.set_visible(False)
            continue
        often(axis, results, role)
        models.update(zip(*reversed(axis.get_legend_handles_labels())))
    figure.legend(models.values(), models.keys(), loc="lower right", bbox_to_anchor=(0.97, 0.03), ncols=5, frameon=False,
                  title="distributions above:")
    low, high = results.nodes[:, :2].min(axis=0), results.nodes[:, :2].max(axis=0)
    to_wall = lambda c: MM * min(np.min(c["contact_m"][:2] - low), np.min(high - c["contact_m"][:2]))
    for column, (value, label) in enumerate(((lambda c: c["angle_deg"], "angle between tool displacement and inward normal (degrees)"),
                                             (lambda c: MM * c["depth_m"], "tool displacement (mm)"),
                                             (to_wall, "distance from the nearest wall (mm)") if results.is_block else
                                             (lambda c: MM * c["contact_m"][2], "height of the contact (mm)")), 1):
        against(figure.add_subplot(grid[1, column]), results, drawn, value, label)
    figure.suptitle("Indentation error of contact force at the contacts of the test set")
    return figure


def from_above(figure, axis, results, drawn):
    corners = results.nodes[results.facets]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0
    axis.triplot(*(MM * results.nodes[:, :2]).T, results.facets[up], color="0.85", linewidth=0.6, zorder=1)
    trained = np.array([path.contact for path in results.paths.values() if path.role[0] == b"train"])
    axis.plot(*(MM * trained[:, :2]).T, "x", color="black", markersize=7, markeredgewidth=1.5, zorder=4)
    shade = axis.scatter([], [], c=[], norm=LogNorm(LOWEST, 0.3), cmap="viridis")
    for role, (label, marker, _) in ROLES.items():
        if not drawn[role]:
            continue
        place = MM * np.array([c["contact_m"][:2] for c in drawn[role]])
        # a line with the length of the sideways part of the displacement
        tick = MM * np.array([c["depth_m"] * np.array(c["direction"][:2]) for c in drawn[role]])
        for start, way in zip(place, tick):
            axis.plot(*np.stack([start, start + way]).T, color="0.25", linewidth=1, zorder=2)
        error = np.array([c["error"]["learned"] for c in drawn[role]])
        axis.scatter(*place.T, c=np.maximum(error, LOWEST), norm=shade.norm, cmap="viridis", marker=marker,
                     s=44, edgecolors="black", linewidths=0.4, zorder=3)
    figure.colorbar(shade, ax=axis, label="indentation error of force, trained model", format=lambda v, _: f"{100 * v:g} %",
                    location="bottom", shrink=0.8, aspect=35)
    handles = [Line2D([], [], color="0.6", marker=marker, linestyle="", markeredgecolor="black", label=f"{label} ({how_often(results.evaluation, role, 'learned')[2]})")
               for role, (label, marker, _) in ROLES.items() if drawn[role]]
    handles += [Line2D([], [], color="black", marker="x", linestyle="", label="training contacts"),
                Line2D([], [], color="0.25", label="tangential part of the tool displacement"),
                Line2D([], [], color="0.85", label="edges of the surface")]
    axis.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize=9)
    axis.set_aspect("equal")
    axis.set_xlabel("x (mm), the surface from above")
    axis.set_ylabel("y (mm)")


def often(axis, results, role):
    counts = {}
    for model, name in SHOWN.items():
        values, part, counts[model] = how_often(results.evaluation, role, model)
        if len(values):
            axis.step(np.maximum(np.append(values[0], values), LOWEST), np.append(0, part),
                      where="post", color=COLOURS[model], label=name or learned_label(results))
    others = {count for count in counts.values() if count} - {counts["learned"]}
    count = counts["learned"] + ("; others " + ", ".join(sorted(others)) if others else "")
    axis.set_xscale("log")
    axis.set_xlim(LOWEST / 4, 2)
    axis.set_ylim(0, 1.02)
    axis.xaxis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
    axis.set_title(f"Distribution, {ROLES[role][0]} ({count})", fontsize=10)
    axis.set_xlabel("indentation error of force")
    axis.set_ylabel("part of the contacts with at most this error (1)")
    axis.grid(color="0.9")


def against(axis, results, drawn, value, label):
    if not any(drawn.values()):
        return axis.set_visible(False)
    for role, (name, marker, colour) in ROLES.items():
        if drawn[role]:
            axis.plot([value(c) for c in drawn[role]], [max(c["error"]["learned"], LOWEST) for c in drawn[role]], marker,
                      color=colour, markersize=5, linestyle="", label=f"{name} ({how_often(results.evaluation, role, 'learned')[2]})")
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
    axis.yaxis.set_minor_formatter(lambda v, _: f"{100 * v:g} %" if f"{v:.0e}"[0] in "25" else "")
    axis.tick_params(axis="y", which="minor", labelsize=7)
    axis.set_xlabel(label)
    axis.set_ylabel("indentation error of force, trained model")
    axis.grid(color="0.9")
    axis.legend(frameon=False, fontsize=8)
