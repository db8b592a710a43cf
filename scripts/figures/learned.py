"""The field that a model in the plane has adapted to measurements: stiffness over the trained one, and its posterior
standard deviation.

    scripts/figures/learned.py OUT.png MODEL.h5 [MODEL.h5 ...] [--truth X Y RADIUS]

One column for each model of `tissuectl adapt` (or `tissue-haptic --learn`) with unknowns `field`: above the factor,
below the posterior standard deviation of its logarithm. --truth: the outline of a known inclusion, a circle.
"""
import argparse

import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from one_line import say
from save import save
from stored import stored


def learned(file):
    """(nodes, triangles, factor at each node, standard deviation of its logarithm, number of measurements)"""
    with stored(file) as model:
        if "adaptation" not in model or model["adaptation"].attrs["unknowns"] not in ("field", b"field"):
            say(file, "has learned no field")
        if "mesh/triangles" not in model:
            say(file, "is no model in the plane")
        group = model["adaptation"]
        x, sd = group["x"][:], np.sqrt(np.diag(group["covariance"][:]))
        if group.attrs["rival"] and group.attrs["evidence"] < 0:  # one scale for all the tissue is likelier
            x, sd = np.full_like(x, group.attrs["scale"]), np.full_like(x, np.sqrt(group.attrs["scale_variance"]))
        return model["mesh/nodes"][:], model["mesh/triangles"][:], np.exp(x), sd, int(group.attrs["learned"])


def draw(files, truth=None):
    models = [learned(file) for file in files]
    figure, axes = plt.subplots(2, len(models), figsize=(2.9 * len(models) + 1, 5.4), squeeze=False, layout="constrained")
    most = max(1.5, *(max(m[2].max(), 1 / m[2].min()) for m in models))
    for column, (nodes, triangles, factor, sd, pokes) in enumerate(models):
        above, below = axes[:, column]
        stiffness = above.tripcolor(*(1e3 * nodes.T), triangles, factor, shading="gouraud", cmap="RdBu_r", norm=LogNorm(1 / most, most))
        unsure = below.tripcolor(*(1e3 * nodes.T), triangles, sd, shading="gouraud", cmap="Greys", vmin=0, vmax=0.6)
        above.set_title(f"after {pokes} measurements", fontsize=10)
        for axis in (above, below):
            axis.set_aspect("equal")
            axis.tick_params(labelsize=8)
            if truth:
                axis.add_patch(plt.Circle(truth[:2], truth[2], fill=False, linestyle="--", linewidth=1.2, color="0.15"))
        below.set_xlabel("x (mm)", fontsize=8)
    for axis in axes[:, 0]:
        axis.set_ylabel("y (mm)", fontsize=8)
    ticks = [t for t in (0.2, 0.33, 0.5, 0.7, 1, 1.4, 2, 3, 5) if 1 / most <= t <= most]
    bar = figure.colorbar(stiffness, ax=axes[0, :], label="stiffness over that of the trained model (1)")
    bar.set_ticks(ticks, labels=[f"{t:g}" for t in ticks])
    bar.minorticks_off()
    figure.colorbar(unsure, ax=axes[1, :], label="posterior standard deviation of its logarithm (1)")
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("out", metavar="OUT.png")
    parser.add_argument("models", nargs="+", metavar="MODEL.h5")
    parser.add_argument("--truth", nargs=3, type=float, metavar=("X", "Y", "RADIUS"), help="centre and radius of the inclusion, mm")
    options = parser.parse_args()
    save(draw(options.models, options.truth), options.out)


if __name__ == "__main__":
    main()
