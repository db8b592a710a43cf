"""A solid cut open through the test contact with the median displacement error: displacement in finite elements, in the
model, and their difference."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm

from results import learned_label, nothing
from shape_error import percent, which_of

MM = 1e3
VIEW = np.array([-0.45, -1.0, 0.62])  # towards the eye


def draw(results):
    if not results.evaluation.get("drawn_shapes"):
        return nothing("The model has no answer at any contact of the test set, or none has an FE reference")
    shape = results.evaluation["drawn_shapes"][0]
    contacts = {c["name"]: c for c in results.evaluation["drawn"]["held_out"]}
    contact = contacts[shape["name"]]
    path = results.paths[shape["name"]]
    fe, model = MM * path.displacement[-1], MM * np.array(shape["displacement_m"])
    facets, cut_mm = cut_open(results, path.contact)
    away = np.linalg.norm(model - fe, axis=1)
    figure, axes = plt.subplots(1, 3, figsize=(17, 5.8))
    figure.set_layout_engine("constrained", rect=(0, 0.03, 1, 0.87))  # space for two lines above, descenders below
    shown = np.unique(facets)
    most = max(np.linalg.norm(u[shown], axis=1).max() for u in (fe, model))
    same = levels(most)
    for axis, u, value, bounds, cmap, title, label in (
            (axes[0], fe, np.linalg.norm(fe, axis=1), same, "viridis", "Finite elements", "displacement |u| (mm)"),
            (axes[1], model, np.linalg.norm(model, axis=1), same, "viridis", learned_label(results).capitalize(), "displacement |u| (mm)"),
            (axes[2], model, away, levels(away[shown].max()), "magma_r", "Difference of the displacements", "|u - u_fe| (mm)")):
        block(axis, results, facets, u, value, bounds, cmap)
        start, end = project(MM * np.stack([path.contact, path.contact + path.magnitude[-1] * path.direction]))[0]
        tail = start - 2.2 * (end - start)
        axis.annotate("", end, tail, zorder=9, arrowprops={"arrowstyle": "-|>", "color": "#D55E00", "linewidth": 2.5})
        axis.set_title(title, fontsize=11)
        axis.set_aspect("equal")
        axis.set_axis_off()
        figure.colorbar(ScalarMappable(BoundaryNorm(bounds, 256), cmap), ax=axis, label=label, location="bottom", shrink=0.8, pad=0.02)
    size = MM * np.ptp(results.nodes, axis=0)
    x, y, _ = MM * path.contact
    figure.suptitle(f"Contact of the test set with the {which_of(shape, contacts).lower()}, {percent(contact['shape']['learned'])} "
                    f"(force {percent(contact['error']['learned'])}): {MM * contact['depth_m']:.1f} mm of tool displacement, {round(contact['angle_deg'])} degrees "
                    f"from the normal, at x = {x:.0f} mm, y = {y:.0f} mm\n"
                    f"{'Block' if results.is_block else 'Shape'} of {size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} mm cut at y = {cut_mm:.0f} mm; displacements to scale; "
                    f"the arrow has the direction of the tool displacement", fontsize=11)
    return figure


def levels(most):
    """About ten round steps from 0 to the value."""
    step = 10 ** np.floor(np.log10(most / 10))
    step *= next(f for f in (1, 2, 5, 10) if most / (f * step) <= 12)
    return np.arange(0, np.ceil(most / step) + 1) * step


def cut_open(results, contact):
    """Facets, with outward normals, of the part behind the plane y = const of nodes nearest to a contact; and its y
    [mm]."""
    y = results.nodes[:, 1]
    cut = y[np.argmin(np.abs(y - contact[1]))]
    kept = results.tetrahedra[y[results.tetrahedra].mean(axis=1) > cut]
    sides = np.concatenate([kept[:, [1, 2, 3]], kept[:, [0, 3, 2]], kept[:, [0, 1, 3]], kept[:, [0, 2, 1]]])
    _, first, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    return sides[first[count == 1]], MM * cut


def project(points):
    """Points (... x 3) projected to the picture (... x 2), and their distance towards the eye (...)."""
    eye = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0, 0, 1], eye)
    right /= np.linalg.norm(right)
    return np.stack([points @ right, points @ np.cross(eye, right)], axis=-1), points @ eye


def block(axis, results, facets, u, value, bounds, cmap):
    place = MM * results.nodes + u
    corners = place[facets]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = facets[normal @ VIEW > 0]
    flat = project(place)[0]
    axis.tricontourf(*flat.T, seen, value, levels=bounds, norm=BoundaryNorm(bounds, 256), cmap=cmap, zorder=1)
    axis.tricontour(*flat.T, seen, value, levels=bounds, colors="black", linewidths=0.3, alpha=0.5, zorder=1.5)
    # edges of visible triangles, of a block without their diagonals; and the outline of the block at rest
    pairs = np.unique(np.sort(np.concatenate([seen[:, [0, 1]], seen[:, [1, 2]], seen[:, [2, 0]]]), axis=1), axis=0)
    if results.is_block:
        pairs = pairs[((results.nodes[pairs[:, 0]] - results.nodes[pairs[:, 1]]) != 0).sum(axis=1) == 1]
    axis.add_collection(LineCollection(flat[pairs], colors="0.7", linewidths=0.4, alpha=0.7, zorder=2))
    if results.is_block:
        low, high = MM * results.nodes[np.unique(facets)].min(axis=0), MM * results.nodes[np.unique(facets)].max(axis=0)
        box = np.array([[[high[d] if k >> d & 1 else low[d] for d in range(3)] for k in (a, a | 1 << e)]
                        for e in range(3) for a in range(8) if not a >> e & 1])
        axis.add_collection(LineCollection(project(box)[0], colors="0.45", linewidths=0.8, linestyles=":", zorder=3))
    low, high = flat[np.unique(facets)].min(axis=0), flat[np.unique(facets)].max(axis=0)
    room = 0.03 * (high - low).max()
    axis.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
