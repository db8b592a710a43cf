"""Fig. 3 of the paper: resolved force at the loaded node against its displacement, along every load path."""
import matplotlib.pyplot as plt
import numpy as np

from results import COLOURS, LABELS


def draw(results):
    curves = results.evaluation["curves"][:9]
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(3.6 * columns, 2.9 * rows), sharex=True, squeeze=False,
                                layout="constrained")
    for axis, curve in zip(axes.flat, curves):
        x = np.array(curve["magnitude_m"]) * 1e3
        axis.plot(x, np.array(curve["fe_N"]) * 1e3, color=COLOURS["fe"], linewidth=2.2, label=LABELS["fe"])
        serving = np.array(curve["serving_set"])
        for model in ("learned", "heuristic_a", "heuristic_b"):
            y = np.array(curve["models_N"][model], dtype=float) * 1e3  # null: no answer
            # the learned model changes its spring set between magnitudes, where its curve has a jump
            for name in dict.fromkeys(serving) if model == "learned" else [None]:
                part = serving == name if name else np.full(len(x), True)
                axis.plot(x[part], y[part], color=COLOURS[model], linewidth=1.6,
                          linestyle="-" if model == "learned" else "--",
                          label=LABELS[model] if name in (None, serving[0]) else None)
        switch = np.flatnonzero(serving[1:] != serving[:-1])
        edges = [0, *(0.5 * (x[switch] + x[switch + 1])), x[-1]]
        for i, name in enumerate(dict.fromkeys(serving)):
            axis.axvspan(edges[i], edges[i + 1], color="0.93" if i % 2 else "1", zorder=0)
            axis.text(0.5 * (edges[i] + edges[i + 1]), 0.985, "set " + name.rsplit("-", 1)[1], fontsize=7, color="0.4",
                      ha="center", va="top", transform=axis.get_xaxis_transform())
        axis.set_title(curve["path"].replace("-", " "), fontsize=10)
        axis.set_xlim(0, x[-1])
        axis.set_ylim(bottom=min(0, axis.get_ylim()[0]), top=1.12 * axis.get_ylim()[1])
    for axis in axes.flat[len(curves):]:
        axis.set_visible(False)
    for axis in axes[-1]:
        axis.set_xlabel("tool displacement (mm)")
    for axis in axes[:, 0]:
        axis.set_ylabel("force along the displacement (mN)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.set_layout_engine("constrained", rect=(0, 0.045, 1, 0.955))  # space for the legend
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False)
    figure.suptitle("Force at the loaded node along the tool displacement; all nodes have their FE displacement.\n"
                    "Bands: the spring set in use, which is that of the nearest trained magnitude", fontsize=11)
    return figure
