"""Tissue in space: a vertical section through the contacts of the test set with the median and the largest displacement
error, finite elements over the model; displacement of the surface along it; and displacement error against force error
at every contact of the test set."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from results import COLOURS, learned_label
from shape_error import force_and_shape, percent, which_of

MM = 1e3


def draw(results):
    contacts = {c["name"]: c for c in results.evaluation["drawn"].get("held_out", [])}
    shapes = results.evaluation.get("drawn_shapes", [])
    figure = plt.figure(figsize=(16, 8.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1, 1, 0.85], height_ratios=[1.1, 1])
    for column, shape in enumerate(shapes):
        c, path = contacts[shape["name"]], results.paths[shape["name"]]
        section, profile = figure.add_subplot(grid[0, column]), figure.add_subplot(grid[1, column])
        cut = surface_cut(results, path)
        fe, model = path.displacement[-1], np.array(shape["displacement_m"])
        draw_section(section, results, path, cut, fe, model)
        section.set_title(f"{which_of(shape, contacts)}, {percent(c['shape']['learned'])} (force {percent(c['error']['learned'])}):\n"
                          f"{MM * c['depth_m']:.1f} mm of tool displacement, {round(c['angle_deg'])} degrees from the normal", fontsize=10)
        draw_profile(profile, results, cut, fe, model)
    if shapes:
        figure.set_layout_engine("constrained", rect=(0, 0.05, 1, 0.95))  # space for the legend
        figure.legend(*section.get_legend_handles_labels(), loc="lower left", bbox_to_anchor=(0.15, 0), ncols=4, frameon=False)
    force_and_shape(figure.add_subplot(grid[:, 2]), results, contacts, shapes)
    figure.suptitle("Deformed tissue in equilibrium with the displaced tool: finite elements and model")
    return figure


class Cut:
    """A vertical section along an axis: its points, each between two nodes, the lines between them, and the points of
    the top in order."""

    def __init__(self, along, place, first, second, part, lines, top):
        self.along, self.place, self.first, self.second, self.part, self.lines, self.top = along, place, first, second, part, lines, top

    def at(self, values):
        """Values at the nodes (N x 3), interpolated to the points."""
        part = self.part[:, None]
        return (1 - part) * values[self.first] + part * values[self.second]


def surface_cut(results, path):
    """The section through the contact along the axis of the displacement's tilt: where the plane cuts the edges of the
    surface's triangles."""
    along = int(np.argmax(np.abs(path.direction[:2])))
    place = path.contact[1 - along]
    above = results.nodes[:, 1 - along] > place
    met = [f for f in results.facets if 0 < above[f].sum() < 3]
    first, second, top = [], [], []
    for a, b, c in met:
        up = np.cross(results.nodes[b] - results.nodes[a], results.nodes[c] - results.nodes[a])[2] > 0
        for i, j in ((a, b), (b, c), (c, a)):
            if above[i] != above[j]:
                if up and results.nodes[[i, j], 2].max() > results.nodes[:, 2].min():
                    top.append(len(first))
                first.append(min(i, j))
                second.append(max(i, j))
    first, second = np.array(first), np.array(second)
    part = (place - results.nodes[first, 1 - along]) / (results.nodes[second, 1 - along] - results.nodes[first, 1 - along])
    cut = Cut(along, place, first, second, part, np.arange(len(first)).reshape(-1, 2), np.array(top))
    where = cut.at(results.nodes)[cut.top, along]
    cut.top = cut.top[np.unique(where, return_index=True)[1]]
    return cut


def draw_section(axis, results, path, cut, fe, model):
    along = cut.along
    for u, colour, style, width, label in ((0 * fe, "0.75", ":", 0.8, "at rest"), (fe, COLOURS["fe"], "-", 1.4, "finite elements"),
                                           (model, COLOURS["learned"], "--", 1.2, learned_label(results))):
        now = MM * cut.at(results.nodes + u)[:, [along, 2]]
        axis.add_collection(LineCollection(now[cut.lines], colors=colour, linewidths=width, linestyles=style, label=label))
    start = MM * path.contact[[along, 2]]
    axis.annotate("", start + MM * path.direction[[along, 2]] * path.magnitude[-1], start, zorder=3, annotation_clip=False,
                  arrowprops={"arrowstyle": "-|>", "color": "#009E73", "linewidth": 2})
    axis.plot([], [], color="#009E73", label="tool displacement")
    axis.autoscale_view()
    axis.margins(0.04)
    axis.set_aspect("equal")
    axis.set_xlabel(f"{'xy'[along]} (mm), in the plane {'yx'[along]} = {MM * cut.place:.0f} mm "
                    f"(contact: {MM * path.contact[1 - along]:.1f})")
    axis.set_ylabel("z (mm)")


def draw_profile(axis, results, cut, fe, model):
    along = cut.along
    place = MM * cut.at(results.nodes)[cut.top, along]
    for component, colour, label in ((2, "#D55E00", "upwards"), (along, "#009E73", f"along {'xy'[along]}")):
        axis.plot(place, MM * cut.at(fe)[cut.top, component], color=colour, linewidth=1.8, label=f"{label}: finite elements")
        axis.plot(place, MM * cut.at(model)[cut.top, component], "o--", color=colour, markersize=3.5, markerfacecolor="white", linewidth=1,
                  label=f"{label}: {learned_label(results)}")
    axis.axhline(0, color="0.7", linewidth=0.8)
    axis.set_xlabel(f"{'xy'[along]} at rest (mm), on the surface in that plane")
    axis.set_ylabel("displacement (mm)")
    axis.grid(color="0.9")
    axis.legend(frameon=False, fontsize=8)
