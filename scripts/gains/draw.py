"""The figure of gains.md."""
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)

from gains.questions import BUDGET, FARS, LATTICES, MESHES, PATCH, STEPS  # noqa: E402
from gains.rules import at_step, gain_table, half_block, iterations_of, left_over, q_ratios, springs_of, step_points, step_rule, without  # noqa: E402

# Okabe and Ito's palette, as in scripts/figures/results.py
COLOURS = {6: "#E69F00", 11: "#0072B2", 21: "#009E73", 41: "#CC79A7"}


def draw(measured):
    figure, axes = plt.subplots(1, 4, figsize=(17, 4.4), layout="constrained")
    left = axes[0]
    for topology, marker in zip(MESHES, "os"):
        points = step_points(measured, topology)
        for n in LATTICES:
            own = points[points[:, 0] == n]
            S = springs_of(n, topology)
            left.plot([S] * len(own), own[:, 3], marker, color=COLOURS[n], markersize=5, alpha=0.6)
            predicted = iterations_of(step_rule(without(points, n)), n, np.median(own[:, 1]), topology)
            left.plot(S, predicted, "_", color="black", markersize=18, markeredgewidth=1.6,
                      label="predicted from the other lattices" if (n, topology) == (6, "grid4") else None)
        left.plot([], [], marker, color="0.4", label=f"{topology}, {MESHES[topology]}")
    left.axhline(20000, color="0.6", linewidth=0.8, linestyle=":")
    left.text(60, 22000, "20,000", fontsize=8, color="0.4")
    left.set(xscale="log", yscale="log", xlabel="number of springs", ylabel="iterations until the gap is <= 2 %")
    left.set_title("spsa: number of iterations", fontsize=10)
    left.legend(frameon=False, fontsize=8, loc="upper left")
    left.set_ylim(top=3e6)

    for axis, topology in zip(axes[1:3], MESHES):
        table = gain_table(measured, topology, "one")
        for n in LATTICES:
            curve = left_over(measured[f"gains-{topology}-{n}"])
            axis.plot(STEPS, curve, "-o", color=COLOURS[n], markersize=3.5, linewidth=1.4, label=f"{n} nodes a side")
            step = float(np.exp(np.mean(np.log(table[n][:, 1]))))
            axis.plot(step, at_step(curve, step), "X", color=COLOURS[n], markersize=10, markeredgecolor="black")
        axis.plot([], [], "X", color="0.7", markersize=9, markeredgecolor="black", label="predicted from the other lattices")
        axis.set(xscale="log", xlabel="first step (E2)", ylim=(0, 1))
        axis.set_title(f"spsa-2008, {topology}: after {BUDGET:,} iterations", fontsize=10)
    axes[1].set_ylabel("remaining part of the reducible loss (1)")
    axes[1].legend(frameon=False, fontsize=8)

    right = axes[3]
    for n in LATTICES:
        for block, style in ((PATCH, "-o"), (4, ":o")):
            ratio = [np.divide(*(v[0] for v in q_ratios(measured, "grid4", n, half_block(block, n), far))) for far in FARS]
            right.plot(FARS, ratio, style, color=COLOURS[n], markersize=3.5, linewidth=1.4)
    right.plot([], [], "-", color="0.4", label="full weight on the nodes that carry the patch")
    right.plot([], [], ":", color="0.4", label="full weight on 9 x 9 nodes")
    right.axhline(1, color="0.7", linewidth=0.8)
    right.set(xscale="log", xlabel="weight of all other nodes, over the paper's (1)", ylim=(0, None))
    right.invert_xaxis()
    right.set_ylabel("resolved force error, over that with the paper's Q (1)")
    right.set_title("Q, grid4: the certified optimum", fontsize=10)
    right.legend(frameon=False, fontsize=8)
    return figure
