"""Fig. 6 of the paper: the spring mesh of two load cases, coloured by trained stiffness in units of E2 = E t."""
import matplotlib.pyplot as plt
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm

from results import shown_cases, title_of_case


def draw(results):
    cases = shown_cases(results)
    theta = next(iter(results.trained.values())).theta / results.modulus
    norm = LogNorm(theta[cases].min(), theta[cases].max())
    figure, axes = plt.subplots(1, len(cases), figsize=(10.5, 5.6), sharey=True, layout="constrained")
    rest = results.nodes * 1e3
    for axis, case in zip(axes, cases):
        lines = LineCollection(rest[results.springs], array=theta[case], cmap="cividis", norm=norm, linewidths=3)
        axis.add_collection(lines)
        axis.plot(*rest.T, "o", color="black", markersize=2)
        contact, push = results.contact[case] * 1e3, results.direction[case]
        axis.annotate("", contact, contact - 12 * push, zorder=3,
                      arrowprops={"arrowstyle": "-|>", "color": "#D55E00", "linewidth": 2})
        axis.set_aspect("equal")
        axis.margins(0.14)
        axis.set_title(title_of_case(results, case))
        axis.set_xlabel("x (mm)")
    axes[0].set_ylabel("y (mm)")
    figure.colorbar(lines, ax=axes, label="stiffness theta / E2 (1)", shrink=0.9)
    figure.suptitle("Trained spring sets at rest; the arrow has the contact and the direction of the tool displacement")
    return figure
