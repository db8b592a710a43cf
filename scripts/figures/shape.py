"""Deformed tissue at the contacts of the test set with the median and the largest displacement error, finite elements
over the model; and displacement error against force error at every contact of the test set."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

import shape_solid
from results import COLOURS, learned_label
from shape_error import force_and_shape, percent, which_of

MM = 1e3


def draw(results):
    if results.solid:
        return shape_solid.draw(results)
    contacts = {c["name"]: c for c in results.evaluation["drawn"].get("held_out", [])}
    figure, axes = plt.subplots(1, 3, figsize=(15, 5.2), layout="constrained", gridspec_kw={"width_ratios": [1, 1, 0.9]})
    shapes = results.evaluation.get("drawn_shapes", [])
    for axis, shape in zip(axes, shapes):
        c = contacts[shape["name"]]
        outlines(axis, results, results.paths[shape["name"]], np.array(shape["displacement_m"]))
        axis.set_title(f"{which_of(shape, contacts)}, {percent(c['shape']['learned'])} (force {percent(c['error']['learned'])}):\n"
                       f"{1e3 * c['depth_m']:.1f} mm of tool displacement, {round(c['angle_deg'])} degrees from the normal", fontsize=10)
    for axis in axes[len(shapes):2]:
        axis.set_visible(False)
    if shapes:
        figure.set_layout_engine("constrained", rect=(0, 0.05, 1, 0.95))  # space for the legend
        figure.legend(*axes[0].get_legend_handles_labels(), loc="lower left", bbox_to_anchor=(0.1, 0), ncols=4, frameon=False)

    force_and_shape(axes[2], results, contacts, shapes)
    figure.suptitle("Deformed tissue in equilibrium with the displaced tool: finite elements and model")
    return figure


def outlines(axis, results, path, displacement):
    """The outline in finite elements and in the model, and the difference at every node."""
    rest = results.nodes * MM
    fe = rest + path.displacement[-1] * MM
    model = rest + displacement * MM
    loop = np.append(results.boundary, results.boundary[0])
    axis.plot(*rest[loop].T, color="0.7", linewidth=1, linestyle=":", label="at rest")
    axis.plot(*fe[loop].T, color=COLOURS["fe"], linewidth=2, label="finite elements")
    axis.plot(*model[loop].T, color=COLOURS["learned"], linewidth=1.5, linestyle="--", label=learned_label(results))
    axis.add_collection(LineCollection(np.stack([fe, model], axis=1), colors=COLOURS["heuristic_a"], linewidths=1,
                                       label="difference at each node"))
    axis.plot(*fe.T, ".", color=COLOURS["fe"], markersize=2)
    start = path.contact * MM
    axis.annotate("", start + path.direction * path.magnitude[-1] * MM, start, zorder=3, annotation_clip=False,
                  arrowprops={"arrowstyle": "-|>", "color": "#009E73", "linewidth": 2})
    axis.set_aspect("equal")
    axis.set_xlabel("x (mm)")
    axis.set_ylabel("y (mm)")
