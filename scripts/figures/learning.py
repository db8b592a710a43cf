"""Fig. 4 of the paper: learning curves of every spring set, one panel for each optimiser."""
import matplotlib.pyplot as plt
import numpy as np

from results import COLOURS, LABELS


def draw(results):
    models = results.trained_by_model
    figure, axes = plt.subplots(1, len(models), figsize=(5.2 * len(models), 4), sharey=True, squeeze=False,
                                layout="constrained")
    for axis, (model, trained) in zip(axes.flat, models.items()):
        scale = (trained.loss / trained.rel_loss)[:, None]
        curves = trained.curve / scale
        for row in curves:  # sets record at different iterations; the last recorded value holds until the next
            known = ~np.isnan(row)
            row[:] = row[known][np.cumsum(known) - 1]
        colour = COLOURS.get(model, "#0072B2")
        iteration = np.maximum(trained.iteration, 0.7)  # a logarithmic axis has no 0
        middle = np.median(curves, axis=0)
        for row in curves:
            axis.plot(iteration, row, color=colour, alpha=0.3, linewidth=0.9)
        axis.plot(iteration, middle, color="black", linewidth=2, label="median of the sets")
        for mark in (1000, 5000):
            axis.axvline(mark, color="0.6", linewidth=0.8, linestyle=":")
            if mark <= trained.iteration[-1]:
                value = np.interp(mark, trained.iteration, middle)
                axis.annotate(f"{value:.2f} at {mark:,}", (mark, value), textcoords="offset points",
                              xytext=(8, 60 if mark == 1000 else 40), ha="left", fontsize=8,
                              arrowprops={"arrowstyle": "-", "color": "0.5", "linewidth": 0.6})
        axis.set_xscale("log")
        axis.set_title(f"{LABELS.get(model, model)}: {len(curves)} sets")
        axis.set_xlabel("iteration")
        axis.legend(frameon=False)
    axes[0, 0].set_ylabel("nodal-force error: loss (9) over the weighted FE force (1)")
    axes[0, 0].set_ylim(bottom=0)
    return figure
