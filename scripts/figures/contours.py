"""Fig. 2 of the paper: displacement of two load cases on the deformed tissue, with undeformed outline and lattice."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from results import path_of_case, record_of_case, shown_cases, title_of_case

MM = 1e3


def draw(results):
    cases = shown_cases(results)
    fields = []
    for case in cases:
        path = results.paths[path_of_case(results, case)]
        fields.append(path.displacement[record_of_case(results, case)])
    levels = np.linspace(0, max(np.linalg.norm(u, axis=1).max() for u in fields) * MM, 16)
    figure, axes = plt.subplots(1, len(cases), figsize=(10.5, 4.9), sharex=True, sharey=True, layout="constrained")
    for axis, case, u in zip(axes, cases, fields):
        rest, now = results.nodes * MM, (results.nodes + u) * MM
        shade = axis.tricontourf(now[:, 0], now[:, 1], results.triangles, np.linalg.norm(u, axis=1) * MM,
                                 levels=levels, cmap="viridis")
        axis.add_collection(LineCollection(rest[results.springs], colors="0.55", linewidths=0.4, zorder=1.5))
        axis.add_collection(LineCollection(now[results.springs], colors="white", linewidths=0.4, zorder=2))
        loop = np.append(results.boundary, results.boundary[0])
        axis.plot(*rest[loop].T, color="0.3", linewidth=1, linestyle="--", label="undeformed")
        axis.plot(*now[loop].T, color="black", linewidth=1, label="deformed")
        contact, push = results.contact[case] * MM, results.direction[case] * results.magnitude[case] * MM
        axis.annotate("", contact + push, contact, zorder=3, annotation_clip=False,
                      arrowprops={"arrowstyle": "-|>", "color": "#D55E00", "linewidth": 2})
        axis.set_aspect("equal")
        axis.use_sticky_edges = False
        axis.margins(0.05)
        axis.set_title(title_of_case(results, case))
        axis.set_xlabel("x (mm)")
    axes[0].set_ylabel("y (mm)")
    axes[0].legend(loc="lower left", framealpha=0.9)
    figure.colorbar(shade, ax=axes, label="displacement |u| (mm)", shrink=0.9)
    figure.suptitle("Finite elements: displacement in two load cases; the arrow is the tool displacement")
    return figure
