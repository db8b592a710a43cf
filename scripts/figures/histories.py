"""Force over time for the displacement history with the median error of each group: finite elements, the trained model,
elastic springs."""
import math

import matplotlib.pyplot as plt
import numpy as np

from results import COLOURS, nothing, truth_label


def draw(results):
    histories = results.evaluation["histories"]
    if "each" not in histories:
        return nothing("No displacement history of the test set has an FE reference")
    groups = list(dict.fromkeys(h["group"] for h in histories["each"]))  # groups with an FE reference
    columns = min(2, len(groups))
    rows = -(-len(groups) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(5.6 * columns, 2.7 * rows), squeeze=False, layout="constrained")
    for axis, group in zip(axes.flat, groups):
        history = middle([h for h in histories["each"] if h["group"] == group])
        t = np.array(history["time_s"])
        axis.plot(t, history["fe_N"], color=COLOURS["fe"], linewidth=2.4, label=truth_label(results))
        axis.plot(t, history["best_factor_N"], ":", color=COLOURS["uniform"], linewidth=1.8, label="elastic model, best factor")
        axis.plot(t, history["learned_N"], color=COLOURS["learned"], linewidth=1.2, label="trained model")
        axis.axhline(0, color="0.8", linewidth=0.8, zorder=0)
        off, found = history["error"]["learned"]["rms"], histories["groups"][group]["learned"]["rms"]
        axis.set_title(f"{group} ({found['n']} of {found['of']}): {history['name']}, " + ("no answer" if off is None else f"rms error {100 * off:.1f} %"), fontsize=9)
        axis.set_xlim(0, t[-1])
        axis.set_xlabel("time (s)")
        axis.set_ylabel("force along the displacement (N)")
    for axis in axes.flat[len(groups):]:
        axis.set_visible(False)
    axes[0, 0].legend(frameon=False, fontsize=8)
    alone = "at contacts without a history of the training set" if results.evaluation.get("measurement") else "of the test set"
    figure.suptitle(f"Force over displacement histories {alone}; of each group the history with the median error")
    return figure


def middle(histories):
    """The history with the median error; of an even number the better of the middle two."""
    ordered = sorted(histories, key=lambda h: math.inf if h["error"]["learned"]["rms"] is None else h["error"]["learned"]["rms"])
    return ordered[(len(ordered) - 1) // 2]
