"""Shape of the tissue at the held-out contacts with the median and the largest shape error, finite elements over the
learned springs; and shape error against force error at every held-out contact."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from results import COLOURS, learned_label

MM = 1e3
WHICH = ["Median shape error", "Largest shape error"]  # of eval.json's drawn_shapes, in order
SHOWN = {"uniform": ("one stiffness", 8), "heuristic_a": ("heuristic, E2 = E t", 8), "learned": (None, 16)}


def draw(results):
    contacts = {c["name"]: c for c in results.evaluation["drawn"].get("held_out", [])}
    figure, axes = plt.subplots(1, 3, figsize=(15, 5.2), layout="constrained", gridspec_kw={"width_ratios": [1, 1, 0.9]})
    shapes = results.evaluation.get("drawn_shapes", [])
    for axis, shape, which in zip(axes, shapes, WHICH):
        c = contacts[shape["name"]]
        outlines(axis, results, results.paths[shape["name"]], np.array(shape["displacement_m"]))
        axis.set_title(f"{which}, {percent(c['shape']['learned'])} (force {percent(c['error']['learned'])}):\n"
                       f"{1e3 * c['depth_m']:.1f} mm deep, {c['angle_deg']:.0f} degrees off the normal", fontsize=10)
    for axis in axes[len(shapes):2]:
        axis.set_visible(False)
    if shapes:
        figure.set_layout_engine("constrained", rect=(0, 0.05, 1, 0.95))  # room for the legend
        figure.legend(*axes[0].get_legend_handles_labels(), loc="lower left", bbox_to_anchor=(0.1, 0), ncols=4, frameon=False)

    errors = axes[2]
    for model, (label, size) in SHOWN.items():
        label = label or learned_label(results)
        both = np.array([(c["error"][model], c["shape"][model]) for c in contacts.values()
                         if c["shape"].get(model) is not None])
        if len(both):
            errors.scatter(*both.T, s=size, color=COLOURS[model], alpha=0.8, linewidths=0, label=f"{label} (n = {len(both)})")
    shown = [contacts[shape["name"]] for shape in shapes]
    errors.scatter([c["error"]["learned"] for c in shown], [c["shape"]["learned"] for c in shown], s=70,
                   facecolors="none", edgecolors="black", label="the two on the left")
    errors.set_xscale("log")
    errors.set_yscale("log")
    for axis in (errors.xaxis, errors.yaxis):
        axis.set_major_formatter(lambda v, _: f"{100 * v:g} %")
        axis.set_minor_formatter(lambda v, _: f"{100 * v:g} %" if f"{v:.0e}"[0] in "25" else "")
    errors.tick_params(axis="both", which="minor", labelsize=7)
    errors.set_xlabel("force error")
    errors.set_ylabel("shape error: rms of u - u_fe over rms of u_fe")
    errors.grid(color="0.9")
    errors.legend(frameon=False, fontsize=8)
    errors.set_title("Every held-out contact, in closed loop", fontsize=10)
    figure.suptitle("What an eye sees: the tissue's shape while the contact is held, finite elements and springs")
    return figure


def outlines(axis, results, path, displacement):
    """Where finite elements and the model have the outline, and every node's way from the one to the other."""
    rest = results.nodes * MM
    fe = rest + path.displacement[-1] * MM
    model = rest + displacement * MM
    loop = np.append(results.boundary, results.boundary[0])
    axis.plot(*rest[loop].T, color="0.7", linewidth=1, linestyle=":", label="at rest")
    axis.plot(*fe[loop].T, color=COLOURS["fe"], linewidth=2, label="finite elements")
    axis.plot(*model[loop].T, color=COLOURS["learned"], linewidth=1.5, linestyle="--", label=learned_label(results))
    axis.add_collection(LineCollection(np.stack([fe, model], axis=1), colors=COLOURS["heuristic_a"], linewidths=1,
                                       label="from the one to the other, at every node"))
    axis.plot(*fe.T, ".", color=COLOURS["fe"], markersize=2)
    start = path.contact * MM
    axis.annotate("", start + path.direction * path.magnitude[-1] * MM, start, zorder=3, annotation_clip=False,
                  arrowprops={"arrowstyle": "-|>", "color": "#009E73", "linewidth": 2})
    axis.set_aspect("equal")
    axis.set_xlabel("x (mm)")
    axis.set_ylabel("y (mm)")


def percent(value):
    return f"{100 * value:.1f} %"
