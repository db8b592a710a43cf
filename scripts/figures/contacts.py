"""Draws the fixed part and the contacts of a solid shape before any path is solved: contacts.py RESULTS OUT.png.

Reads RESULTS/mesh.msh, plan.mk and plan/collect, which `make mesh` writes. Prints the number of places and load paths
of each role, and the fixed part of the surface. A contact behind the tissue is not drawn in that view.
"""
import re
import sys
from pathlib import Path

import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from one_line import say  # noqa: E402
from save import save  # noqa: E402

MM = 1e3
FREE_LABEL, TRIANGLE, TETRAHEDRON = 2, "2", "4"
HELD_COLOUR, FREE_COLOUR = [0.80, 0.25, 0.20], [0.88, 0.88, 0.86]
VIEWS = {"from the front and above": (-0.45, -1.0, 0.62), "from behind and below": (0.45, 1.0, -0.62)}  # towards the eye
STYLES = {"train": ("#0072B2", "o"), "validation": ("#009E73", "s"), "held_out": ("#D55E00", "^"), "history": ("#CC79A7", "D")}


class Refusal(Exception):
    """A file that cannot be used, and the cause: one line of output."""


def section(text, name):
    """Lines of one section of a mesh file, without their count."""
    return text.split(f"${name}\n")[1].split(f"$End{name}")[0].splitlines()[1:]


def read_surface(file):
    """Corners of the facets (F x 3 x 3, in mm), outward by the right-hand rule, and which facets are fixed (F)."""
    try:
        text = Path(file).read_text()
        nodes = np.array([line.split()[1:] for line in section(text, "Nodes")], float)
        rows = [line.split() for line in section(text, "Elements")]
        facets = np.array([row[-3:] for row in rows if row[1] == TRIANGLE], int) - 1
        held = np.array([int(row[3]) != FREE_LABEL for row in rows if row[1] == TRIANGLE])
        corners = MM * nodes[facets]
        whole = "$EndElements" in text and nodes.shape[1] == 3
    except (ValueError, IndexError):  # ValueError also for text in another encoding
        whole = False
    if not whole:
        raise Refusal(file, "is no whole mesh of a solid shape")
    if not any(row[1] == TETRAHEDRON for row in rows):
        raise Refusal(file, "is a mesh in the plane; contacts are drawn of a study with a solid shape")
    return corners, held


def read_contacts(folder):
    """Contact positions [mm] of each role's load paths; those of histories under "history". held_out_WORD counts as
    held_out."""
    arguments = dict(re.findall(r"^\$\(R\)/cases/(\S+)\.csv: PATH_ARGUMENTS = (.*)$", (folder / "plan.mk").read_text(), re.M))
    contacts = {role: [] for role in STYLES}
    for line in (folder / "plan" / "collect").read_text().splitlines():
        first, *rest = line.split() or [""]
        role = "held_out" if first.startswith("held_out") else first
        if role in STYLES and rest and rest[-1] in arguments:
            found = [re.search(rf"-contact_{axis} (\S+)", arguments[rest[-1]]) for axis in "xyz"]
            if all(found):
                contacts[role].append([MM * float(word[1]) for word in found])
    if not any(contacts.values()):
        raise Refusal(folder, "its plan has no contacts on a solid shape")
    return {role: np.array(places) for role, places in contacts.items() if places}


def hidden(place, eye, corners):
    """Whether a facet lies between a place on the surface and the eye."""
    sides = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], np.broadcast_to(-eye, corners[:, 0].shape)], axis=2)
    met = np.abs(np.linalg.det(sides)) > 1e-9
    v, w, away = np.linalg.solve(sides[met], (place - corners[met, 0])[:, :, None])[:, :, 0].T
    own_facet_mm = 0.1
    return bool(np.any((v >= 0) & (w >= 0) & (v + w <= 1) & (away > own_facet_mm)))


def draw_view(axis, towards, corners, held, contacts):
    """Draws one view of the shape with its contacts."""
    eye = np.array(towards) / np.linalg.norm(towards)
    right = np.cross([0, 0, 1], eye)
    right /= np.linalg.norm(right)
    flat = np.stack([right, np.cross(eye, right)], axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    seen = np.flatnonzero(normal @ eye > 0)
    seen = seen[np.argsort((corners[seen] @ eye).mean(axis=1))]
    colour = np.where(held[seen, None], HELD_COLOUR, FREE_COLOUR) * (0.55 + 0.45 * (normal[seen] @ eye))[:, None]
    axis.add_collection(PolyCollection(corners[seen] @ flat, facecolors=colour, edgecolors=0.8 * colour, linewidths=0.3))
    for role, places in contacts.items():
        tint, marker = STYLES[role]
        for place in np.unique(places, axis=0):
            if not hidden(place, eye, corners):
                axis.plot(*(place @ flat), marker, color=tint, markersize=6, markeredgecolor="white", markeredgewidth=0.7)
    low, high = (corners @ flat).min(axis=(0, 1)) - 3, (corners @ flat).max(axis=(0, 1)) + 3
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    axis.set_aspect("equal")
    axis.set_axis_off()


def draw(folder, out):
    try:
        corners, held = read_surface(folder / "mesh.msh")
        contacts = read_contacts(folder)
    except OSError as error:
        say(error.filename, f"{error.strerror}; contacts are drawn of a study with a solid shape, once make mesh has meshed it")
    except Refusal as refusal:
        say(*refusal.args)
    except ValueError as error:  # text in another encoding, or text that is not a number
        say(folder, error)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    counts = {role: f"{role} {len(np.unique(places, axis=0))} places, {len(places)} load paths" for role, places in contacts.items()}
    share = f"{100 * area[held].sum() / area.sum():.0f} % of the surface is fixed"
    figure, axes = plt.subplots(1, len(VIEWS), figsize=(12, 5.6))
    figure.set_layout_engine("constrained", rect=(0, 0.07, 1, 0.93))  # space for the legend below
    for axis, (title, towards) in zip(axes, VIEWS.items()):
        draw_view(axis, towards, corners, held, contacts)
        axis.set_title(title, fontsize=10)
    handles = [plt.Line2D([], [], color=STYLES[role][0], marker=STYLES[role][1], linestyle="", label=label) for role, label in counts.items()]
    handles.append(plt.Rectangle((0, 0), 1, 1, color=HELD_COLOUR, label="fixed"))
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), frameon=False, fontsize=9)
    size = np.ptp(corners, axis=(0, 1))
    figure.suptitle(f"{folder.name}: {size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} mm, {share}", fontsize=11)
    save(figure, out)
    print(f"{out}: {'; '.join(counts.values())}; {share}")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    draw(Path(sys.argv[1]), sys.argv[2])


if __name__ == "__main__":
    main()
