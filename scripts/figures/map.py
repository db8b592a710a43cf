"""Force map of straight indentations over a solid's top, from above: finite elements, the model, and their difference.
The dashed circle is the outline of the nodule below. A symmetric block is solved on one side; the other side is its
mirror image."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from results import learned_label, nothing

MM, MN = 1e3, 1e3


def draw(results):
    found = results.evaluation["map"]
    if "places" not in found:
        return nothing("No indentation of the map has an FE reference")
    at = np.array([p["contact_m"][:2] for p in found["places"]])
    x, y = np.unique(at[:, 0].round(9)), np.unique(at[:, 1].round(9))
    values = np.full((2, len(y), len(x)), np.nan)
    for p, (px, py) in zip(found["places"], at.round(9)):
        place = np.searchsorted(y, py), np.searchsorted(x, px)
        values[(0, *place)] = MN * p["fe_N"]
        values[(1, *place)] = np.nan if p["learned_N"] is None else MN * p["learned_N"]
    x, y, values = whole(x, y, values, results)
    fe, law = values
    off = 100 * (law / fe - 1)
    figure, axes = plt.subplots(1, 3, figsize=(15, 5.9), layout="constrained")
    force = {"cmap": "viridis", "vmin": np.nanmin(values), "vmax": np.nanmax(values)}
    most = np.nanmax(np.abs(off), initial=0.1)
    shade = shaded(axes[0], x, y, fe, **force)
    shaded(axes[1], x, y, law, **force)
    away = shaded(axes[2], x, y, off, cmap="RdBu_r", vmin=-most, vmax=most)
    for axis, title in zip(axes, ("Finite elements", learned_label(results).capitalize(), "Difference of the forces")):
        axis.plot(*MM * at.T, ".", color="black", markersize=3, zorder=3, clip_on=False)
        outline(axis, results.ground)
        axis.set(aspect="equal", title=title, xlabel="x (mm), the surface from above")
    axes[0].set_ylabel("y (mm)")
    figure.colorbar(shade, ax=axes[:2], label="force along the displacement (mN)", location="bottom", shrink=0.6, aspect=40)
    figure.colorbar(away, ax=axes[2], label="(model - FE) / FE", format=lambda v, _: f"{v:g} %", ticks=MaxNLocator(5), location="bottom", shrink=0.9)
    mirrored = " or at their mirror images" if values.shape[1] * values.shape[2] > len(at) else ""
    figure.suptitle(f"Indentations of {MM * found['depth_m']:g} mm straight down at the dots{mirrored}; none is in the training set" + contrast(found))
    return figure


def whole(x, y, values, results):
    """Mirrors places and values at the nodule's centre, along each axis where the nodule is at the middle of the block
    and all places are on one side."""
    if results.ground is None:
        return x, y, values
    nodule = results.ground[:, :3].mean(axis=0)
    middle = (results.nodes.min(axis=0) + results.nodes.max(axis=0)) / 2
    places = [y, x]
    for axis, d in ((0, 1), (1, 0)):
        side = places[axis] - middle[d]
        if abs(nodule[d] - middle[d]) > 1e-6 or not (np.all(side > -1e-6) or np.all(side < 1e-6)):
            continue
        order = np.argsort(np.abs(side))[::-1]  # from the far end to the middle
        other = order[np.abs(side[order]) > 1e-6]
        places[axis] = np.concatenate([middle[d] - np.abs(side[other]), middle[d] + np.abs(side[order[::-1]])])
        values = np.concatenate([np.take(values, other, axis + 1), np.take(values, order[::-1], axis + 1)], axis + 1)
    return places[1], places[0], values


def shaded(axis, x, y, value, **how):
    """The value over the places. Rectangles with a corner without an answer stay empty."""
    return axis.pcolormesh(MM * x, MM * y, np.ma.masked_invalid(value), shading="gouraud", zorder=1, **how)


def outline(axis, ground):
    """The nodule's outline. The mean square distance from a ball's centre is 3/5 of its squared radius."""
    if ground is None:
        return
    middle = ground[:, :3].mean(axis=0)
    radius = np.sqrt(5 / 3 * ((ground[:, :3] - middle) ** 2).sum(axis=1).mean())
    for colour, gaps in (("white", (0, (3.7, 1.6))), ("black", (2.65, (3.7, 1.6)))):
        axis.add_patch(plt.Circle(MM * middle[:2], MM * radius, fill=False, linestyle=gaps, color=colour, linewidth=1.5, zorder=4))


def contrast(found):
    if "contrast" not in found:
        return ""
    c = found["contrast"]
    learned = "no answer" if c["learned"] is None else f"{c['learned']:.3f}"
    return f"\nForce above the centre of the inclusion over the force far from it: finite elements {c['fe']:.3f}, model {learned}"
