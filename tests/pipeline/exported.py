"""exported.py WHAT EXPORT FILE [NAME]: exits 0 if an export equals the HDF5 file that it was made from; otherwise
prints the first difference.

WHAT   cases-vtu (a .pvd and its .vtu, read by one VTK reader that steps through them; with NAME by pyvista and meshio),
       model-vtu (read by VTK), sofa (NAME: the set), cases-csv, model-csv, numpy; for an energy model law-csv and
       law-numpy (NAME: the folder of its CSV), whose energy is computed again from the export, law-vtu and law-vtp
       (NAME likewise). law-vtp is of tissue in space; all others but model-vtu, sofa and model-csv may be.
"""
import csv
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import numpy as np


def same(name, seen, wanted, tolerance=0.0):
    seen, wanted = np.asarray(seen), np.asarray(wanted)
    if seen.shape != wanted.shape:
        sys.exit(f"{name}: shape {seen.shape}, wanted {wanted.shape}")
    if wanted.dtype.kind in "US":
        equal = (seen == wanted).all()
    else:
        equal = np.abs(seen - wanted).max(initial=0) <= tolerance * np.abs(wanted).max(initial=0)
    if not equal:
        sys.exit(f"{name}: differs from the HDF5 file")


class Grid:
    """A .vtu read by VTK. With `reader`, the reader of another file is moved to this one, as ParaView does between
    steps."""

    def __init__(self, file, reader=None):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        reader = reader or vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(file))
        reader.UpdateInformation()
        if reader.GetNumberOfTimeSteps():
            sys.exit(f"{file}: has time steps of its own, which readers confuse with the collection's")
        reader.Update()
        grid = reader.GetOutput()
        if reader.GetErrorCode() or not grid.GetNumberOfPoints():
            sys.exit(f"{file}: VTK cannot read it")
        arrays = lambda data: {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
        self.points, self.cells, self.field = (arrays(d) for d in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()))
        self.places = vtk_to_numpy(grid.GetPoints().GetData())
        self.types = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
        self.nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        self.grid, self.reader = grid, reader

    def hexahedra(self):
        """Volumes and smallest scaled Jacobians in VTK's numbering of corners; both are negative where the numbering is
        reversed."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

        def quality(measure):
            verdict = vtkMeshQuality()
            verdict.SetInputData(self.grid)
            getattr(verdict, f"SetHexQualityMeasureTo{measure}")()
            verdict.Update()
            every = vtk_to_numpy(verdict.GetOutput().GetCellData().GetArray("Quality"))
            return every[[self.grid.GetCellType(i) == 12 for i in range(self.grid.GetNumberOfCells())]]

        return quality("Volume"), quality("ScaledJacobian")


def in_space(field):
    return np.pad(field, ((0, 0), (0, 3 - field.shape[1])))


def axes(before, after, dimension):
    return [f"{before}{axis}{after}" for axis in "xyz"[:dimension]]


def steps_of(collection):
    """Time and file of each step of a .pvd."""
    root = ElementTree.parse(collection).getroot()
    same(f"{collection}: type", root.get("type"), "Collection")
    return [(float(step.get("timestep")), collection.parent / step.get("file")) for step in root.iter("DataSet")]


def cases_vtu(export, h5, others=None):
    names, reader = sorted(name for name in h5["paths"] if len(h5["paths"][name]["magnitude"])), None  # a path may have no record
    same("files", sorted(file.stem for file in export.glob("*.pvd")), names)
    for name in names:
        path = h5["paths"][name]
        steps = steps_of(export / f"{name}.pvd")
        same(f"{name}: times", [time for time, _ in steps], path["magnitude"][:])
        rest, u, force = in_space(h5["nodes"][:]), np.array([in_space(x) for x in path["displacement"]]), np.array([in_space(x) for x in path["force"]])
        if others:
            other_readers(export / f"{name}.pvd", steps, rest, u, force)
            continue
        for step in [*range(len(steps)), 0]:  # and the first again
            grid = Grid(steps[step][1], reader)
            reader = grid.reader
            same(f"{name}: cells", sorted(grid.types), [10 if "shape/tetrahedra" in h5 else 9 if h5["nodes"].shape[1] == 2 else 12])
            if 12 in grid.types:
                volume, jacobian = grid.hexahedra()
                if min(volume.min(), jacobian.min()) <= 0:
                    sys.exit(f"{name}: a cell is inverted")
                if step == 0:
                    same(f"{name}: volume", volume.sum(), np.ptp(h5["nodes"][:], axis=0).prod(), 1e-9)
            same(f"{name}: magnitude", grid.field["magnitude_m"], path["magnitude"][step:step + 1])
            same(f"{name}: energy", grid.field["energy_J"], path["energy"][step:step + 1])
            same(f"{name}: rest", grid.points["rest_m"], rest)
            same(f"{name}: displacement", grid.points["displacement_m"], u[step])
            same(f"{name}: force", grid.points["force_N"], force[step])
            same(f"{name}: places", grid.places, rest + u[step])


def other_readers(collection, steps, rest, u, force):
    """Compares pyvista's reader of collections, moved through the steps and back, and meshio's reader of each file."""
    import meshio
    import pyvista

    reader = pyvista.get_reader(str(collection))
    same(f"{collection}: pyvista's times", reader.time_values, [time for time, _ in steps])
    for step in [*range(len(steps)), 0]:
        reader.set_active_time_value(steps[step][0])
        grid, mesh = reader.read()[0], meshio.read(steps[step][1])
        for by, points, place in (("pyvista", grid.point_data, grid.points), ("meshio", mesh.point_data, mesh.points)):
            same(f"{collection}: displacement by {by}", points["displacement_m"], u[step])
            same(f"{collection}: force by {by}", points["force_N"], force[step])
            same(f"{collection}: places by {by}", place, rest + u[step])


def names_of(h5):
    return [name.decode() for name in h5["cases/names"]]


def model_vtu(export, h5):
    optimizer = h5["optimizers"][0].decode()
    nodes = h5["mesh/nodes"][:]
    same("files", sorted(file.stem for file in export.glob("*.vtu")), sorted(names_of(h5)))
    for row, name in enumerate(names_of(h5)):
        grid = Grid(export / f"{name}.vtu")
        same(f"{name}: cells", sorted(grid.types), [3])
        same(f"{name}: springs", grid.nodes.reshape(-1, 2), h5["mesh/springs"][:])
        same(f"{name}: stiffness", grid.cells["stiffness_N_m"], h5[f"trained/{optimizer}/theta"][row])
        same(f"{name}: mass", grid.points["mass_kg"], h5["node_mass"][:])
        same(f"{name}: fixed", np.flatnonzero(grid.points["fixed"]), h5["mesh/fixed"][:])
        # The contact has the prescribed displacement, and K u vanishes at all other free nodes.
        u = grid.points["displacement_m"][:, :2]
        same(f"{name}: places", grid.places, in_space(nodes + u))
        contact = int(np.argmin(np.linalg.norm(nodes - h5["cases/contact"][row], axis=1)))
        same(f"{name}: contact", u[contact], h5["cases/magnitude"][row] * h5["cases/direction"][row], 1e-12)
        i, j = h5["mesh/springs"][:].T
        pull = h5[f"trained/{optimizer}/theta"][row][:, None] * (u[i] - u[j])  # the spring law is isotropic
        force = np.zeros_like(u)
        np.add.at(force, i, pull)
        np.add.at(force, j, -pull)
        same(f"{name}: force", grid.points["force_N"], in_space(force), 1e-12)
        free = np.setdiff1d(np.arange(len(nodes)), np.append(h5["mesh/fixed"][:], contact))
        if np.abs(force[free]).max() > 1e-9 * np.abs(force).max():
            sys.exit(f"{name}: is not in equilibrium")


def sofa(export, h5, name):
    scene = ElementTree.parse(export).getroot()
    tissue = scene.find("Node")
    numbers = lambda element, key: np.array(tissue.find(element).get(key).split(), float)
    row = names_of(h5).index(name)
    theta = h5["trained"][h5["optimizers"][0].decode()]["theta"][row]
    same("positions", numbers("MeshTopology", "position").reshape(-1, 3), in_space(h5["mesh/nodes"][:]))
    same("masses", numbers("DiagonalMass", "vertexMass"), h5["node_mass"][:])
    same("fixed nodes", numbers("FixedProjectiveConstraint", "indices"), h5["mesh/fixed"][:])
    springs = numbers("SpringForceField", "spring").reshape(-1, 5)
    same("springs", springs[:, :2], h5["mesh/springs"][:])
    same("stiffness", springs[:, 2], theta)
    same("damping and length", springs[:, 3:], np.zeros((len(theta), 2)))  # isotropic: springs of zero length
    plugins = {plugin.get("name") for plugin in scene.iter("RequiredPlugin")}
    if "Sofa.Component.SolidMechanics.Spring" not in plugins:
        sys.exit("the plugin of SpringForceField is not required")


def table(file):
    with open(file, newline="") as rows:
        return list(csv.DictReader(rows))


def column(rows, *names):
    return np.array([[float(row[name]) for name in names] for row in rows])


def cases_csv(export, h5):
    records, fields = table(export / "records.csv"), table(export / "fields.csv")
    D = h5["nodes"].shape[1]
    same("nodes", column(table(export / "nodes.csv"), *axes("", "_m", D)), h5["nodes"][:])
    for name in h5["paths"]:
        path = h5["paths"][name]
        mine = [row for row in records if row["path"] == name]
        same(f"{name}: magnitude", column(mine, "magnitude_m")[:, 0], path["magnitude"][:])
        same(f"{name}: contact force", column(mine, *axes("contact_", "_N", D)), path["contact_force"][:])
        mine = [row for row in fields if row["path"] == name]
        same(f"{name}: displacement", column(mine, *axes("u_", "_m", D)), path["displacement"][:].reshape(-1, D))
        same(f"{name}: force", column(mine, *axes("f_", "_N", D)), path["force"][:].reshape(-1, D))


def model_csv(export, h5):
    nodes, springs, sets = (table(export / f"{name}.csv") for name in ("nodes", "springs", "sets"))
    same("nodes", column(nodes, "x_m", "y_m"), h5["mesh/nodes"][:])
    same("mass", column(nodes, "mass_kg")[:, 0], h5["node_mass"][:])
    same("fixed", np.flatnonzero(column(nodes, "fixed")), h5["mesh/fixed"][:])
    same("springs", column(springs, "node_i", "node_j"), h5["mesh/springs"][:])
    same("heuristic_a", column(springs, "heuristic_a_N_m")[:, 0], h5["heuristic_a"][:])
    same("triangles", column(table(export / "triangles.csv"), "node_i", "node_j", "node_k"), h5["mesh/triangles"][:])
    same("sets", [row["set"] for row in sets], names_of(h5))
    same("magnitude", column(sets, "magnitude_m")[:, 0], h5["cases/magnitude"][:])
    theta = h5["trained"][h5["optimizers"][0].decode()]["theta"][:]
    same("stiffness", column(table(export / "stiffness.csv"), *names_of(h5)), theta.T)


def stored(length, rest, curve, dimension):
    """Energy of springs per unit of stiffness (results/FORMATS.md). curve: C2's share and the two stretches beyond
    which the force is linear; None for Hooke's springs."""
    if curve is None:
        return (length - rest)**2 / 2
    q, low, high = curve
    D, s = dimension, length / rest
    a, b = (1 - q) / (D + 2), q / 2
    w = lambda s: a * (s**2 / 2 + s**-D / D - 1 / 2 - 1 / D) + b * (s**-(D + 2) / (D + 2) - s**-D / D + 1 / D - 1 / (D + 2))
    pull = lambda t: a * (t - t**-(D + 1)) + b * (t**-(D + 1) - t**-(D + 3))
    slope = lambda t: a * (1 + (D + 1) * t**-(D + 2)) + b * (-(D + 1) * t**-(D + 2) + (D + 3) * t**-(D + 4))
    straight = lambda t: w(t) + (s - t) * (pull(t) + slope(t) * (s - t) / 2)
    return rest**2 * np.where(s.real < low, straight(low), np.where(s.real > high, straight(high), w(s)))


def curve_names(h5):
    return ["law/spring_curve"] if "c2_share" in h5["law"].attrs else []


def curve_of(h5, file):
    """The exported curve, compared with the HDF5 file; None for Hooke's springs, which have no curve file."""
    if "c2_share" not in h5["law"].attrs:
        if file.exists():
            sys.exit(f"{file}: the springs are Hooke's")
        return None
    if file.suffix == ".npy":
        share, *straight = np.load(file)
    else:
        share, *straight = column(table(file), "c2_share", "straight_below", "straight_above")[0]
    same("share of C2", share, h5["law"].attrs["c2_share"])
    return share, *straight


class Law:
    """Energy of an energy model in the plane (results/FORMATS.md), computed from exported arrays alone."""

    def __init__(self, curve, nodes, springs, theta, edges, rest_area, stiffness, patch_log, surface_node, surface_arc, log_scale):
        self.nodes, self.springs, self.theta, self.edges = nodes, springs.astype(int), theta, edges.astype(int)
        self.curve, self.rest_area, self.stiffness, self.patch_log = curve, rest_area, stiffness, patch_log
        ends = lambda a: np.concatenate(([2 * a[0] - a[1]], a, [2 * a[-1] - a[-2]]))
        node = surface_node.astype(int)
        self.line, self.arc, self.place = np.concatenate((node[:1], node, node[-1:])), ends(surface_arc), ends(nodes[node])
        self.log_scale = np.concatenate((log_scale[:1], log_scale, log_scale[-1:]))
        same("areas at rest", self.areas(nodes), rest_area, 1e-12)

    def areas(self, x):
        area, i, j = self.edges.T
        out = np.zeros(len(self.rest_area), x.dtype)
        np.add.at(out, area, (x[i, 0] * x[j, 1] - x[i, 1] * x[j, 0]) / 2)
        return out

    def energy(self, u):
        i, j = self.springs.T
        length = lambda x: np.sqrt(((x[i] - x[j]) ** 2).sum(axis=1))  # no abs: u may be complex
        springs = self.theta * stored(length(self.nodes + u), length(self.nodes), self.curve, 2)
        swelling = self.areas(self.nodes + u) / self.rest_area - 1
        return springs.sum() + (self.stiffness * self.rest_area * swelling**2).sum() / 2

    def contact(self, s, d, u):
        """Energy between the tissue and a tool at arc length s with the tool displacement d."""
        def spline(f):
            g = 1 - f
            return (np.array([g**3, 4 - 6 * f**2 + 3 * f**3, 4 - 6 * g**2 + 3 * g**3, f**3]) / 6,
                    np.array([-g * g / 2, -2 * f + 1.5 * f * f, 2 * g - 1.5 * g * g, f * f / 2]))

        last = len(self.line) - 4
        k = next((k for k in range(last) if spline(1)[0] @ self.arc[k:k + 4] > s), last)
        low, high = 0.0, 1.0
        for _ in range(60):
            f = (low + high) / 2
            low, high = (f, high) if spline(f)[0] @ self.arc[k:k + 4] < s else (low, f)
        w, slope = spline(f)
        along, spacing, place = slope @ self.place[k:k + 4], slope @ self.arc[k:k + 4], k + f
        tangent = along / np.linalg.norm(along)
        normal = np.array([-tangent[1], tangent[0]])
        corner = max(0, 1 - np.linalg.norm(along) / spacing) / (1 - np.sqrt(0.5))
        factors = np.array([1, np.cos(2 * np.pi * place), corner, np.exp(-min(place, last + 1 - place))])
        stiffness = np.exp(self.patch_log @ factors + w @ self.log_scale[k:k + 4])
        gap, turn = d - w @ u[self.line[k:k + 4]], slope @ u[self.line[k:k + 4]]
        return (stiffness * np.array([normal @ gap, tangent @ gap, normal @ turn, tangent @ turn])**2).sum() / 2

    @staticmethod
    def slope(function, x, h=1e-30):
        """Derivative by complex steps, without cancellation."""
        out = np.zeros(x.shape)
        for at in np.ndindex(x.shape):
            moved = x.astype(complex)
            moved[at] += 1j * h
            out[at] = function(moved).imag / h
        return out

    def check(self, fixed, name, s, d, u, tissue_force, hand_force):
        """Compares the forces of tissue and tool with derivatives of the energy, and checks equilibrium of free
        nodes."""
        force, size = self.slope(self.energy, u), np.linalg.norm(hand_force)
        same(f"{name}: force of the tissue", force, tissue_force, 1e-9)
        same(f"{name}: force of the tool", self.slope(lambda push: self.contact(s, push, u), d), hand_force, 1e-9)
        left = force + self.slope(lambda v: self.contact(s, d, v), u)
        if np.abs(np.delete(left, fixed, axis=0)).max() > 1e-9 * size:
            sys.exit(f"{name}: is not in equilibrium")


class SolidLaw:
    """Energy of an energy model in space, element by element, so that complex steps evaluate few elements."""

    def __init__(self, curve, nodes, springs, theta, cells, at, volume, stiffness, contacts, held):
        """contacts: k (R), push (R x 3), row (Q), node (Q), pull (Q x 3) and hardening of each case. held: stiffness k
        (M) of each support, and the lattice nodes that move its node (M x 8) with their weights."""
        self.curve, self.nodes, self.springs, self.theta = curve, nodes, springs.astype(int), theta
        self.cells, self.volume, self.stiffness, self.contacts, self.held = cells.astype(int), volume, stiffness, contacts, held
        self.side = np.ones((len(at), 8, 3))  # weight of each corner in the mean edge along each axis
        for corner in range(8):
            for axis in range(3):
                for other in range(3):
                    far = corner >> other & 1
                    self.side[:, corner, axis] *= (1 if far else -1) if other == axis else at[:, other] if far else 1 - at[:, other]

    def volumes(self, x):
        """Volumes of cells with corners x (C x 8 x 3): the determinant of their mean edges."""
        a, b, c = np.einsum("cki,ckj->jci", x, self.side)
        return (np.cross(a, b) * c).sum(axis=1)

    def force(self, u):
        """dW/du (N x 3)."""
        def scatter(nodes, energy):
            x = (self.nodes + u)[nodes]
            for corner in range(nodes.shape[1]):
                for axis in range(3):
                    moved = x.astype(complex)
                    moved[:, corner, axis] += 1e-30j
                    np.add.at(total, (nodes[:, corner], axis), energy(moved).imag / 1e-30)

        total = np.zeros(u.shape)
        length = lambda x: np.sqrt(((x[:, 0] - x[:, 1]) ** 2).sum(axis=1))  # no abs: x may be complex
        rest = length(self.nodes[self.springs])
        scatter(self.springs, lambda x: self.theta * stored(length(x), rest, self.curve, 3))
        rest_volume = self.volumes(self.nodes[self.cells])
        scatter(self.cells, lambda x: self.stiffness * self.volume * (self.volumes(x) / rest_volume - 1) ** 2 / 2)
        k, corner, weight = self.held
        moved = np.einsum("mk,mki->mi", weight, u[corner])
        np.add.at(total, corner, (k[:, None] * weight)[:, :, None] * moved[:, None, :])
        return total

    def contact(self, name, d, u):
        """Energy between the tissue and the disc at the case's contact, with the tool displacement d."""
        k, push, row, node, pull, hardening = self.contacts[name]
        e = push @ d - np.bincount(row, (pull * u[node].real).sum(axis=1), len(k)) \
            - 1j * np.bincount(row, (pull * u[node].imag).sum(axis=1), len(k))
        harder, saturation, coupling, in_compression = hardening
        s = (k * e**2)[:3].sum() / 2 if not in_compression else (k * e**2)[0] / 2 if e[0].real > 0 else 0
        return (k * e**2).sum() / 2 + harder * s**2 / (2 * (1 + saturation * s)) + coupling * (e[0] / (1 - 2 * coupling / k[1] * e[0]) if in_compression and e[0].real < 0 else e[0]) * (e[1]**2 + e[2]**2) / 2

    def check(self, fixed, name, _, d, u, tissue_force, hand_force):
        force, size = self.force(u), np.linalg.norm(hand_force)
        same(f"{name}: force of the tissue", force, tissue_force, 1e-9)
        same(f"{name}: force of the tool", Law.slope(lambda push: self.contact(name, push, u), d), hand_force, 1e-9)
        left = force + Law.slope(lambda v: self.contact(name, d, v), u)
        if np.abs(np.delete(left, fixed, axis=0)).max() > 1e-9 * size:
            sys.exit(f"{name}: is not in equilibrium")


def presses_of(folder):
    pressed = table(folder / "pressed.csv")
    D = 3 if "u_z_m" in pressed[0] else 2
    for press in table(folder / "presses.csv"):
        if press["reason"]:
            sys.exit(f"{press['case']}: {press['reason']}")
        mine = [row for row in pressed if row["case"] == press["case"]]
        yield (press["case"], float(press["arc_m"]) if D == 2 else None, column([press], *axes("push_", "_m", D))[0],
               column(mine, *axes("u_", "_m", D)), column(mine, *axes("f_", "_N", D)), column([press], *axes("force_", "_N", D))[0])


def solid_law_csv(export, h5):
    read = {name: table(export / f"{name}.csv") for name in
            ("nodes", "springs", "tetrahedra", "facets", "cells", "terms", "contact", "contact_rows", "contact_pull", "contact_hardening")}
    constants, S, names = h5["law/constants"][:], len(h5["mesh/springs"]), names_of(h5)
    corners = [f"node_{k >> 0 & 1}{k >> 1 & 1}{k >> 2 & 1}" for k in range(8)]
    cells = column(read["cells"], *corners)
    supports, inside = table(export / "supports.csv"), table(export / "embedding.csv")
    fixed = column(supports, "node")[:, 0].astype(int)
    corner, weight = column(inside, *corners).astype(int), column(inside, *(name.replace("node", "weight") for name in corners))
    same("fixed nodes", fixed, h5["mesh/fixed"][:])
    same("tissue in cells", column(read["cells"], "rest_volume_m3")[:, 0], h5["mesh/lattice/fraction"][:] * h5["mesh/lattice"].attrs["spacing_m"]**3, 1e-12)
    same("supports", column(supports, "stiffness_N_m")[:, 0], constants[S + len(cells):])
    for press in presses_of(export):
        same("displacement of the solid's nodes", np.einsum("nk,nki->ni", weight, press[3][corner]), press[3][:len(corner)], 1e-12)
    same("nodes", column(read["nodes"], "x_m", "y_m", "z_m"), h5["mesh/nodes"][:])
    same("springs", column(read["springs"], "node_i", "node_j"), h5["mesh/springs"][:])
    same("tetrahedra", column(read["tetrahedra"], "node_i", "node_j", "node_k", "node_l"), h5["mesh/tetrahedra"][:])
    same("facets", column(read["facets"], "node_i", "node_j", "node_k"), h5["mesh/facets"][:])
    same("stiffness of springs", column(read["springs"], "stiffness_N_m")[:, 0], constants[:S])
    same("stiffness of cells", column(read["cells"], "stiffness_Pa")[:, 0], constants[S:S + len(cells)])
    same("terms", [row["term"] for row in read["terms"]], [name.decode() for name in h5["law/terms"]])
    same("coefficients", column(read["terms"], "coefficient")[:, 0], h5["law/coefficients"][:])
    same("range of curved", [float(row["curved"]) for row in read["contact"][7:]], h5["law/curved_range"][:])
    correction, corrections = h5["law/lattice_correction"][:], table(export / "correction.csv")
    own = column(corrections, "radius_m")[:, 0] == h5["law"].attrs["disc_radius_m"]
    corrections = [row for row, mine in zip(corrections, own) if mine]
    same("correction", column(corrections, "log_scale")[:, 0], correction.reshape(-1))
    same("facets of the correction", column(corrections, "facet")[:, 0], np.repeat(np.arange(len(correction)), correction.shape[1]))
    same("weights of the correction", column(corrections, "weight_i", "weight_j", "weight_k").sum(axis=1), np.ones(correction.size), 1e-12)
    del read["contact"][7:]
    same("rows", [row["row"] for row in read["contact"]], ["normal", "tangent", "imprint_normal", "imprint_tangent", "hardening", "saturation", "coupling"])
    same("contact", column(read["contact"], "log_k_N_m", "curved", "ground", "edge"), h5["law/patch_log"][:])
    hardening = {row["case"]: [float(row[c]) for c in ("hardening_1_J", "saturation_1_J", "coupling_N_m2", "in_compression")] for row in read["contact_hardening"]}
    case = np.array([names.index(row["case"]) for row in read["contact_rows"]])
    law = SolidLaw(curve_of(h5, export / "spring_curve.csv"), column(read["nodes"], "x_m", "y_m", "z_m"), column(read["springs"], "node_i", "node_j"),
                   column(read["springs"], "stiffness_N_m")[:, 0], cells, column(read["cells"], "at_x", "at_y", "at_z"),
                   column(read["cells"], "rest_volume_m3")[:, 0], column(read["cells"], "stiffness_Pa")[:, 0],
                   contacts_of(names, case, column(read["contact_rows"], "k_N_m")[:, 0], column(read["contact_rows"], "push_x", "push_y", "push_z"),
                               column(read["contact_pull"], "row")[:, 0].astype(int), column(read["contact_pull"], "node")[:, 0].astype(int),
                               column(read["contact_pull"], "pull_x", "pull_y", "pull_z"), [hardening[name] for name in names]),
                   (constants[S + len(cells):], corner[fixed], weight[fixed]))
    presses = list(presses_of(export))
    same("cases", [press[0] for press in presses], names)
    for press in presses:
        law.check(h5["mesh/fixed"][:], *press)


def contacts_of(names, case, k, push, pull_row, pull_node, pull, hardening):
    """The contact rows of each case, by its name."""
    contacts = {}
    for c, name in enumerate(names):
        rows = np.flatnonzero(case == c)
        mine = np.isin(pull_row, rows)
        contacts[name] = (k[rows], push[rows], np.searchsorted(rows, pull_row[mine]), pull_node[mine], pull[mine], hardening[c])
    return contacts


def law_csv(export, h5):
    if "mesh/tetrahedra" in h5:
        return solid_law_csv(export, h5)
    read = {name: table(export / f"{name}.csv") for name in ("nodes", "springs", "areas", "area_edges", "terms", "contact", "surface")}
    constants, S = h5["law/constants"][:], len(h5["mesh/springs"])
    same("nodes", column(read["nodes"], "x_m", "y_m"), h5["mesh/nodes"][:])
    same("springs", column(read["springs"], "node_i", "node_j"), h5["mesh/springs"][:])
    same("stiffness of springs", column(read["springs"], "stiffness_N_m")[:, 0], constants[:S])
    same("stiffness of areas", column(read["areas"], "stiffness_N_m")[:, 0], constants[S:])
    same("kinds", sorted({row["kind"] for row in read["areas"]}), ["cell", "region"])
    same("terms", [row["term"] for row in read["terms"]], [name.decode() for name in h5["law/terms"]])
    same("coefficients", column(read["terms"], "coefficient")[:, 0], h5["law/coefficients"][:])
    same("rows", [row["row"] for row in read["contact"]], ["normal", "tangent", "rotation", "stretch"])
    same("contact", column(read["contact"], "log_k_N_m", "phase", "corner", "edge"), h5["law/patch_log"][:])
    law = Law(curve_of(h5, export / "spring_curve.csv"), column(read["nodes"], "x_m", "y_m"), column(read["springs"], "node_i", "node_j"),
              column(read["springs"], "stiffness_N_m")[:, 0], column(read["area_edges"], "area", "node_i", "node_j"),
              column(read["areas"], "rest_area_m2")[:, 0], column(read["areas"], "stiffness_N_m")[:, 0],
              column(read["contact"], "log_k_N_m", "phase", "corner", "edge"),
              column(read["surface"], "node")[:, 0], column(read["surface"], "arc_m")[:, 0], column(read["surface"], "contact_log_scale")[:, 0])
    presses = list(presses_of(export))
    same("cases", [press[0] for press in presses], names_of(h5))
    for press in presses:
        law.check(h5["mesh/fixed"][:], *press)


def solid_law_numpy(export, h5, csv_export):
    parts = ["case", "k", "push", "pull_row", "pull_node", "pull", "hardening"]
    numpy_files(export, h5, [*curve_names(h5), "law/cells", "law/cell_at", "law/cell_rest", "law/contact_kind", *(f"law/contact_{part}" for part in parts)])
    load = lambda name: np.load(export / f"{name}.npy")
    springs, constants = load("mesh/springs"), load("law/constants")
    S, cells = len(springs), load("law/cells")
    fixed = load("mesh/fixed")
    held = constants[S + len(cells):], load("mesh/lattice/corner")[fixed], load("mesh/lattice/weight")[fixed]
    law = SolidLaw(curve_of(h5, export / "law/spring_curve.npy"), load("mesh/nodes"), springs, constants[:S], cells, load("law/cell_at"), load("law/cell_rest"),
                   constants[S:S + len(cells)], contacts_of(names_of(h5), *(load(f"law/contact_{part}") for part in parts)), held)
    for press in presses_of(Path(csv_export)):
        law.check(load("mesh/fixed"), *press)


def law_numpy(export, h5, csv_export):
    if "mesh/tetrahedra" in h5:
        return solid_law_numpy(export, h5, csv_export)
    numpy_files(export, h5, [*curve_names(h5), "law/area_edges", "law/area_kind", "law/area_rest", "law/surface_arc", "law/surface_node"])
    load = lambda name: np.load(export / f"{name}.npy")
    springs, constants = load("mesh/springs"), load("law/constants")
    learned = load("law/contact_log_scale")[load("law/surface_node")] if "law/contact_log_scale" in h5 else np.zeros(len(load("law/surface_node")))
    law = Law(curve_of(h5, export / "law/spring_curve.npy"), load("mesh/nodes"), springs, constants[:len(springs)], load("law/area_edges"), load("law/area_rest"),
              constants[len(springs):], load("law/patch_log"), load("law/surface_node"), load("law/surface_arc"), learned)
    for press in presses_of(Path(csv_export)):
        law.check(load("mesh/fixed"), *press)


def law_vtu(export, h5, csv_export):
    nodes = h5["mesh/nodes"][:]
    same("files", sorted(file.stem for file in export.glob("*.vtu")), sorted(names_of(h5)))
    for name, _, _, u, force, _ in presses_of(Path(csv_export)):
        grid = Grid(export / f"{name}.vtu")
        S = len(h5["mesh/springs"])
        same(f"{name}: springs", grid.nodes[:2 * S].reshape(-1, 2), h5["mesh/springs"][:])
        same(f"{name}: stiffness", grid.cells["stiffness_N_m"][:S], h5["law/constants"][:S])
        if "mesh/tetrahedra" in h5:
            volume, jacobian = grid.hexahedra()
            cells = len(h5["mesh/lattice/cubes"])
            same(f"{name}: stiffness of cells", grid.cells["stiffness_Pa"][S:], h5["law/constants"][S:S + cells])
            same(f"{name}: number of cells", len(volume), cells)
            same(f"{name}: corners of cells", grid.nodes[2 * S:].reshape(-1, 8), h5["mesh/lattice/cubes"][:][:, [0, 1, 3, 2, 4, 5, 7, 6]])
            if min(volume.min(), jacobian.min()) <= 0:
                sys.exit(f"{name}: a cell is inverted")
        same(f"{name}: displacement", grid.points["displacement_m"], in_space(u))
        same(f"{name}: force", grid.points["force_N"], in_space(force))
        same(f"{name}: places", grid.places, in_space(nodes + u))


def law_vtp(export, h5, csv_export):
    """The displayed surface: phi(r) times the tool displacement under the disc, the lattice's displacement beyond 2.5
    radii (springs/skin.h)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    nodes, facets, radius = h5["mesh/nodes"][:], h5["mesh/facets"][:], h5["law"].attrs["disc_radius_m"]
    shown = np.unique(facets)
    same("files", sorted(file.stem for file in export.glob("*.vtp")), sorted(names_of(h5)))
    for (name, _, push, u, _, force), contact in zip(presses_of(Path(csv_export)), h5["cases/contact"][:]):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(export / f"{name}.vtp"))
        reader.Update()
        surface = reader.GetOutput()
        at = {key: vtk_to_numpy(surface.GetPointData().GetArray(key)) for key in ("rest_m", "displacement_m")}
        whole = {key: vtk_to_numpy(surface.GetFieldData().GetArray(key))[0] for key in ("contact_m", "push_m", "force_N")}
        same(f"{name}: rest", at["rest_m"], nodes[shown])
        same(f"{name}: facets", shown[vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)], facets)
        same(f"{name}: places", vtk_to_numpy(surface.GetPoints().GetData()), at["rest_m"] + at["displacement_m"], 1e-12)
        for key, wanted in (("contact_m", contact), ("push_m", push), ("force_N", force)):
            same(f"{name}: {key}", whole[key], wanted)
        r = np.linalg.norm(nodes[shown] - contact, axis=1) / radius
        same(f"{name}: beyond the disc", at["displacement_m"][r > 2.6], u[shown][r > 2.6], 1e-9)
        near = r < 0.9
        if not near.any() or not (r > 2.6).any():
            sys.exit(f"{name}: no node under the disc, or none beyond it")
        same(f"{name}: under the disc", at["displacement_m"][near], (1 - r[near, None]**2 / 2) * push, 1e-9)


def numpy_files(export, h5, more=()):
    datasets = {}
    h5.visititems(lambda name, item: datasets.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    same("files", sorted(str(file.relative_to(export))[:-4] for file in export.rglob("*.npy")), sorted([*datasets, *more]))
    for name, wanted in datasets.items():
        seen = np.load(export / f"{name}.npy")
        if wanted.dtype.kind == "S":
            wanted = np.char.decode(wanted, "utf-8")
        elif seen.dtype != wanted.dtype:
            sys.exit(f"{name}: {seen.dtype}, wanted {wanted.dtype}")
        if wanted.dtype.kind == "f" and seen.tobytes() == wanted.tobytes():
            continue  # also for NaN
        same(name, seen, wanted)


what, export, file, *rest = sys.argv[1:]
with h5py.File(file) as h5:
    {"cases-vtu": cases_vtu, "model-vtu": model_vtu, "sofa": sofa, "cases-csv": cases_csv, "model-csv": model_csv,
     "numpy": numpy_files, "law-csv": law_csv, "law-numpy": law_numpy, "law-vtu": law_vtu, "law-vtp": law_vtp}[what](Path(export), h5, *rest)
