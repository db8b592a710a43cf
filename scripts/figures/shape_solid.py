"""Of tissue in space: a vertical section through the held-out contacts with the median and the largest shape error, finite
elements over the law; the surface's displacement along it; and shape error against force error at every held-out contact."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from results import COLOURS, learned_label
from shape_error import force_and_shape, percent

MM = 1e3
WHICH = ["Median shape error", "Largest shape error"]  # of eval.json's drawn_shapes, in order


def draw(results):
    contacts = {c["name"]: c for c in results.evaluation["drawn"].get("held_out", [])}
    shapes = results.evaluation.get("drawn_shapes", [])
    figure = plt.figure(figsize=(16, 8.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1, 1, 0.85], height_ratios=[1.1, 1])
    for column, (shape, which) in enumerate(zip(shapes, WHICH)):
        c, path = contacts[shape["name"]], results.paths[shape["name"]]
        section, profile = figure.add_subplot(grid[0, column]), figure.add_subplot(grid[1, column])
        along, nodes = plane_of(results, path)
        fe, model = path.displacement[-1], np.array(shape["displacement_m"])
        draw_section(section, results, path, along, nodes, fe, model)
        section.set_title(f"{which}, {percent(c['shape']['learned'])} (force {percent(c['error']['learned'])}):\n"
                          f"{MM * c['depth_m']:.1f} mm deep, {c['angle_deg']:.0f} degrees off straight in", fontsize=10)
        draw_profile(profile, results, along, nodes, fe, model)
    if shapes:
        figure.set_layout_engine("constrained", rect=(0, 0.05, 1, 0.95))  # room for the legend
        figure.legend(*section.get_legend_handles_labels(), loc="lower left", bbox_to_anchor=(0.15, 0), ncols=4, frameon=False)
    force_and_shape(figure.add_subplot(grid[:, 2]), results, contacts, shapes)
    figure.suptitle("What an eye sees: the tissue's shape while the contact is held, finite elements and springs")
    return figure


def plane_of(results, path):
    """The axis along which the section runs, as the push leans, and the nodes in the lattice's plane nearest to the contact."""
    along = int(np.argmax(np.abs(path.direction[:2])))
    across = results.nodes[:, 1 - along]
    nearest = across[np.argmin(np.abs(across - path.contact[1 - along]))]
    return along, np.flatnonzero(np.abs(across - nearest) < 1e-9)


def draw_section(axis, results, path, along, nodes, fe, model):
    rest = MM * results.nodes[:, [along, 2]]
    inside = np.zeros(len(rest), bool)
    inside[nodes] = True
    i, j = results.springs[inside[results.springs].all(axis=1)].T
    edges = np.flatnonzero(((results.nodes[i] - results.nodes[j]) != 0).sum(axis=1) == 1)  # no diagonals
    for u, colour, style, width, label in ((0 * fe, "0.75", ":", 0.8, "at rest"), (fe, COLOURS["fe"], "-", 1.4, "finite elements"),
                                           (model, COLOURS["learned"], "--", 1.2, learned_label(results))):
        now = rest + MM * u[:, [along, 2]]
        axis.add_collection(LineCollection(np.stack([now[i[edges]], now[j[edges]]], axis=1), colors=colour, linewidths=width,
                                           linestyles=style, label=label))
    start = MM * path.contact[[along, 2]]
    axis.annotate("", start + MM * path.direction[[along, 2]] * path.magnitude[-1], start, zorder=3, annotation_clip=False,
                  arrowprops={"arrowstyle": "-|>", "color": "#009E73", "linewidth": 2})
    axis.plot([], [], color="#009E73", label="the push")
    axis.autoscale_view()
    axis.margins(0.04)
    axis.set_aspect("equal")
    axis.set_xlabel(f"{'xy'[along]} (mm), in the plane {'yx'[along]} = {MM * results.nodes[nodes[0], 1 - along]:.0f} mm "
                    f"(contact: {MM * path.contact[1 - along]:.1f})")
    axis.set_ylabel("z (mm)")


def draw_profile(axis, results, along, nodes, fe, model):
    top = nodes[results.nodes[nodes, 2] > results.nodes[:, 2].max() - 1e-9]
    top = top[np.argsort(results.nodes[top, along])]
    place = MM * results.nodes[top, along]
    for component, colour, label in ((2, "#D55E00", "up"), (along, "#009E73", f"along {'xy'[along]}")):
        axis.plot(place, MM * fe[top, component], color=colour, linewidth=1.8, label=f"{label}: finite elements")
        axis.plot(place, MM * model[top, component], "o--", color=colour, markersize=3.5, markerfacecolor="white", linewidth=1,
                  label=f"{label}: {learned_label(results)}")
    axis.axhline(0, color="0.7", linewidth=0.8)
    axis.set_xlabel(f"{'xy'[along]} at rest (mm), on the surface in that plane")
    axis.set_ylabel("displacement (mm)")
    axis.grid(color="0.9")
    axis.legend(frameon=False, fontsize=8)
