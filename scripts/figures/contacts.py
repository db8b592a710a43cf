"""Draws what of a solid shape is held and where its contacts are, before any finite element is solved: contacts.py RESULTS OUT.png.

Reads RESULTS/mesh.msh and RESULTS/plan.mk, which `make mesh` leaves there. Says how many load paths there are, of which kind, and how much is held.
"""
import re
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from save import save  # noqa: E402

MM = 1e3
HELD = 1  # label of facets
VIEWS = [(-0.45, -1.0, 0.62), (0.45, 1.0, -0.62)]  # towards the eye: from the front and above, from behind and below
KINDS = {"validation": ("validation", "#009E73", "s"), "held-out": ("test", "#D55E00", "^"), "check": (None, None, None)}
TRAINING = ("training", "#0072B2", "o")


def read_surface(file):
    """Nodes (N x 3, in mm), facets (F x 3) and which of them are held (F)."""
    text = Path(file).read_text()
    nodes = np.array([line.split()[1:] for line in text.split("$Nodes\n")[1].split("$EndNodes")[0].splitlines()[1:]], float)
    rows = [line.split() for line in text.split("$Elements\n")[1].split("$EndElements")[0].splitlines()[1:]]
    facets = np.array([row[-3:] for row in rows if row[1] == "2"], int) - 1
    return MM * nodes, facets, np.array([int(row[3]) == HELD for row in rows if row[1] == "2"])


def read_contacts(file):
    """Of each load path but the checks: kind and place [mm]."""
    number = r"-contact_{} (\S+)"
    contacts = []
    for name, arguments in re.findall(r"^\$\(R\)/cases/(\S+)\.csv: PATH_ARGUMENTS = (.*)$", Path(file).read_text(), re.M):
        kind = next((KINDS[k] for k in KINDS if name.startswith(k)), TRAINING)
        if kind[0]:
            contacts.append((kind, MM * np.array([float(re.search(number.format(axis), arguments)[1]) for axis in "xyz"])))
    return contacts


def draw_view(axis, towards, surface, contacts):
    nodes, facets, held = surface
    eye = np.array(towards) / np.linalg.norm(towards)
    right = np.cross([0, 0, 1], eye)
    right /= np.linalg.norm(right)
    flat = np.stack([nodes @ right, nodes @ np.cross(eye, right)], axis=1)
    corners = nodes[facets]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    seen = np.flatnonzero(normal @ eye > 0)
    seen = seen[np.argsort((corners[seen] @ eye).mean(axis=1))]
    light = 0.55 + 0.45 * (normal[seen] @ eye)
    colour = np.where(held[seen, None], [0.80, 0.25, 0.20], [0.88, 0.88, 0.86]) * light[:, None]
    axis.add_collection(PolyCollection(flat[facets[seen]], facecolors=colour, edgecolors=0.8 * colour, linewidths=0.3))
    middles = corners.mean(axis=1)
    for (_, tint, marker), place in contacts:
        facing = normal[np.argmin(np.linalg.norm(middles - place, axis=1))] @ eye
        if facing > 0:
            axis.plot(place @ right, place @ np.cross(eye, right), marker, color=tint, markersize=6, markeredgecolor="white", markeredgewidth=0.7)
    axis.set_xlim(flat[:, 0].min() - 3, flat[:, 0].max() + 3)
    axis.set_ylim(flat[:, 1].min() - 3, flat[:, 1].max() + 3)
    axis.set_aspect("equal")
    axis.set_axis_off()


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder, out = Path(sys.argv[1]), sys.argv[2]
    try:
        surface = read_surface(folder / "mesh.msh")
        contacts = read_contacts(folder / "plan.mk")
    except OSError as error:
        sys.exit(f"contacts.py: {error}; make mesh makes it, of a study whose geometry.shape is in space")
    except (IndexError, TypeError):  # no elements, or no -contact_z
        sys.exit(f"contacts.py: {folder}: is of no study whose geometry.shape is in space")
    corners = surface[0][surface[1]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    kinds = [TRAINING, KINDS["validation"], KINDS["held-out"]]
    counts = {kind: sum(k == kind for k, _ in contacts) for kind in kinds}
    words = f"{len(contacts)} load paths ({', '.join(f'{counts[kind]} {kind[0]}' for kind in kinds)}); {100 * area[surface[2]].sum() / area.sum():.0f} % of the surface is held"
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.6))
    figure.set_layout_engine("constrained", rect=(0, 0.07, 1, 0.93))  # room for the legend below
    for axis, view, title in zip(axes, VIEWS, ("from the front and above", "from behind and below")):
        draw_view(axis, view, surface, contacts)
        axis.set_title(title, fontsize=10)
    handles = [plt.Line2D([], [], color=tint, marker=marker, linestyle="", label=f"{label} ({counts[label, tint, marker]})") for label, tint, marker in kinds]
    handles.append(plt.Rectangle((0, 0), 1, 1, color=(0.80, 0.25, 0.20), label="held"))
    figure.legend(handles=handles, loc="lower center", ncols=4, frameon=False)
    size = np.ptp(surface[0], axis=0)
    figure.suptitle(f"{folder.name}, {size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} mm: {words}", fontsize=11)
    save(figure, out)
    print(f"{out}: {words}")


if __name__ == "__main__":
    main()
