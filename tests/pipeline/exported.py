"""exported.py WHAT EXPORT FILE [NAME]: exit 0 when an export holds what the HDF5 file it was made from does, else says where not.

WHAT   cases-vtu, model-vtu (read by VTK), sofa (NAME: its set), cases-csv, model-csv, numpy
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
        sys.exit(f"{name}: differs from the file")


class Grid:
    """A .vtu at one of its steps, as VTK reads it."""

    def __init__(self, file, step=None):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(file))
        reader.UpdateInformation()
        self.steps = reader.GetNumberOfTimeSteps()
        reader.Update() if step is None else reader.UpdateTimeStep(step)
        grid = reader.GetOutput()
        if reader.GetErrorCode() or not grid.GetNumberOfPoints():
            sys.exit(f"{file}: VTK cannot read it")
        arrays = lambda data: {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
        self.points, self.cells, self.field = (arrays(d) for d in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()))
        self.places = vtk_to_numpy(grid.GetPoints().GetData())
        self.types = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
        self.nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())


def in_space(field):
    return np.pad(field, ((0, 0), (0, 1)))


def cases_vtu(export, h5):
    names = sorted(h5["paths"])
    same("files", sorted(file.stem for file in export.glob("*.vtu")), names)
    for name in names:
        path = h5["paths"][name]
        for step in range(len(path["magnitude"])):
            grid = Grid(export / f"{name}.vtu", step)
            same(f"{name}: steps", grid.steps, len(path["magnitude"]))
            same(f"{name}: cells", sorted(grid.types), [9])
            same(f"{name}: magnitude", grid.field["magnitude_m"], path["magnitude"][:])
            same(f"{name}: energy", grid.field["energy_J"], path["energy"][:])
            same(f"{name}: rest", grid.points["rest_m"], in_space(h5["nodes"][:]))
            same(f"{name}: displacement", grid.points["displacement_m"], in_space(path["displacement"][step]))
            same(f"{name}: force", grid.points["force_N"], in_space(path["force"][step]))
            same(f"{name}: places", grid.places, in_space(h5["nodes"][:] + path["displacement"][step]))


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
        # the contact is where it was pushed; everything else that is free carries no force, which K u says again
        u = grid.points["displacement_m"][:, :2]
        same(f"{name}: places", grid.places, in_space(nodes + u))
        contact = int(np.argmin(np.linalg.norm(nodes - h5["cases/contact"][row], axis=1)))
        same(f"{name}: contact", u[contact], h5["cases/magnitude"][row] * h5["cases/direction"][row], 1e-12)
        i, j = h5["mesh/springs"][:].T
        pull = h5[f"trained/{optimizer}/theta"][row][:, None] * (u[i] - u[j])  # the law is isotropic
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
    same("damping and length", springs[:, 3:], np.zeros((len(theta), 2)))  # isotropic: springs of no length
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
    same("nodes", column(table(export / "nodes.csv"), "x_m", "y_m"), h5["nodes"][:])
    for name in h5["paths"]:
        path = h5["paths"][name]
        mine = [row for row in records if row["path"] == name]
        same(f"{name}: magnitude", column(mine, "magnitude_m")[:, 0], path["magnitude"][:])
        same(f"{name}: contact force", column(mine, "contact_x_N", "contact_y_N"), path["contact_force"][:])
        mine = [row for row in fields if row["path"] == name]
        same(f"{name}: displacement", column(mine, "u_x_m", "u_y_m"), path["displacement"][:].reshape(-1, 2))
        same(f"{name}: force", column(mine, "f_x_N", "f_y_N"), path["force"][:].reshape(-1, 2))


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


def numpy_files(export, h5):
    datasets = {}
    h5.visititems(lambda name, item: datasets.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    same("files", sorted(str(file.relative_to(export))[:-4] for file in export.rglob("*.npy")), sorted(datasets))
    for name, wanted in datasets.items():
        seen = np.load(export / f"{name}.npy")
        if wanted.dtype == object:
            wanted = np.array([text.decode() for text in wanted])
        elif seen.dtype != wanted.dtype:
            sys.exit(f"{name}: {seen.dtype}, wanted {wanted.dtype}")
        if wanted.dtype.kind == "f" and seen.tobytes() == wanted.tobytes():
            continue  # NaN too
        same(name, seen, wanted)


what, export, file, *rest = sys.argv[1:]
with h5py.File(file) as h5:
    {"cases-vtu": cases_vtu, "model-vtu": model_vtu, "sofa": sofa, "cases-csv": cases_csv, "model-csv": model_csv,
     "numpy": numpy_files}[what](Path(export), h5, *rest)
