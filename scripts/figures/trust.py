"""Limits of the FE reference: trust.py TRUST.csv OUT.png, from scripts/trust_study.py.

Above: force of a 10 mm patch at the middle of the left wall against its displacement, on meshes of different element
size. Below: the displacement at which each mesh reaches a state that is folded or self-intersecting, or has no
equilibrium.
"""
import csv
import sys
from collections import defaultdict

import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from one_line import reading  # noqa: E402
from save import save  # noqa: E402

MESHES = {"5": "#0072B2", "2.5": "#009E73", "1.25": "#E69F00", "0.625": "#D55E00"}
SHOWN = {-30: ":", 0: "-", 30: "--"}


def read(file):
    paths = defaultdict(list)
    with open(file, newline="") as f:
        for row in csv.DictReader(f):
            key = row["formulation"], float(row["angle_deg"]), f"{float(row['end_size_mm']):g}"
            paths[key].append((float(row["push_mm"]), float(row["force_x_mN"]), float(row["force_y_mN"]), row["ended"]))
    return paths


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: trust.py TRUST.csv OUT.png")
    with reading(sys.argv[1]):
        paths = read(sys.argv[1])
    figure, axes = plt.subplots(2, 2, figsize=(11, 8), layout="constrained", sharey="row")
    for column, formulation in enumerate(["plane-stress", "plane-strain"]):
        force, reach = axes[0, column], axes[1, column]
        for mesh, colour in MESHES.items():
            ends = []
            for (kind, angle, size), rows in sorted(paths.items()):
                if kind != formulation or size != mesh:
                    continue
                push = np.array([r[0] for r in rows])
                direction = np.radians(angle)
                along = [r[1] * np.cos(direction) + r[2] * np.sin(direction) for r in rows]
                ends.append((angle, push[-1], bool(rows[-1][3])))
                if angle in SHOWN:
                    force.plot(push, along, SHOWN[angle], color=colour, linewidth=1.4)
                    if rows[-1][3]:
                        force.plot(push[-1], along[-1], "x", color=colour, markersize=7)
            reach.plot([e[0] for e in ends], [e[1] for e in ends], "-o", color=colour, label=f"{mesh} mm",
                       markersize=4)
        reach.axhline(15, color="0.6", linestyle=":", linewidth=1)
        reach.text(44, 15.2, "largest tool displacement of the studies", ha="right", fontsize=8, color="0.4")
        force.set_title(formulation.replace("-", " "))
        force.set_xlabel("tool displacement (mm)")
        reach.set_xlabel("angle from the inward normal (degrees;\nnegative: towards the fixed edge)")
        reach.set_ylim(0, 21)
    for angle, style in SHOWN.items():
        axes[0, 0].plot([], [], style, color="0.3", label=f"{angle:+d} degrees" if angle else "normal")
    axes[0, 0].plot([], [], "x", color="0.3", label="the path ends")
    axes[0, 0].legend(frameon=False)
    axes[0, 0].set_ylabel("force along the displacement, t = 1 mm (mN)")
    axes[1, 0].set_ylabel("largest displacement with a solution,\nof 20 mm (mm)")
    axes[1, 1].legend(title="element size at the ends of the patch", frameon=False, loc="lower right")
    figure.suptitle("The finer the mesh, the smaller the displacement at which the surface folds at the ends of the patch; the force converges")
    save(figure, sys.argv[2])


if __name__ == "__main__":
    main()
