#!/usr/bin/env python3
"""felupe on the lattice of a solid block: the peer of an indentation in scripts/peers_study.py.

Equations: neo-Hookean with the same shear modulus and a bulk modulus a thousand times as large; three fields:
           displacement, pressure and volume ratio. Each box is one hexahedron of eight nodes with constant pressure.
           The bottom is fixed.
Contact:   the nodes within the disc's radius of the contact, or the nearest one, have the tool's displacement; the
           force is the sum over them.
Method:    felupe's own Newton iteration and default solver, four load steps.

Reads what peer_mujoco.py reads, and "shear_Pa"; prints {"version", "press_us": [...], "force_N": [[x, y, z], ...]} as one line of JSON.
Sample run: scripts/peers_study.py calls it.
"""
import json
import os
import sys
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import felupe as fem  # noqa: E402
import numpy as np  # noqa: E402


def main():
    asked = json.load(sys.stdin)
    mesh = fem.Cube(b=tuple(asked["size_m"]), n=tuple(asked["counts"]))
    times, forces = [], []
    for contact, push in asked["pushes"]:
        begin = time.perf_counter()
        field = fem.FieldsMixed(fem.RegionHexahedron(mesh), n=3)
        solid = fem.SolidBody(fem.ThreeFieldVariation(fem.NeoHooke(mu=asked["shear_Pa"], bulk=1000 * asked["shear_Pa"])), field)
        distance = np.linalg.norm(mesh.points - contact, axis=1)
        disc = (distance <= asked["radius_m"] + 1e-9) | (distance <= distance.min() + 1e-9)
        fixed = np.abs(mesh.points[:, 2]) < 1e-9
        held = np.flatnonzero(np.repeat(disc | fixed, 3))
        free = np.setdiff1d(np.arange(sum(f.values.size for f in field.fields)), held)
        for step in (0.25, 0.5, 0.75, 1):
            move = np.where(disc[:, None], step * np.array(push), 0)
            fem.newtonraphson(items=[solid], x0=field, dof0=held, dof1=free, ext0=move.ravel()[held], tol=1e-8, verbose=False)
        force = solid.assemble.vector(field).toarray()[:mesh.points.size].reshape(-1, 3)
        times.append(1e6 * (time.perf_counter() - begin))
        forces.append(force[disc].sum(axis=0).tolist())
    print(json.dumps({"version": fem.__version__, "press_us": times, "force_N": forces}))


if __name__ == "__main__":
    main()
