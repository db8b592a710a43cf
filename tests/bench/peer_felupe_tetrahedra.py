#!/usr/bin/env python3
"""felupe on an organ's own tetrahedra: the peer of an indentation in scripts/peers_organ.py.

Equations: neo-Hookean on linear tetrahedra with the study's Young's modulus and Poisson's ratio 0.45, because linear
           tetrahedra lock nearer to 1/2. Fixed nodes do not move.
Contact:   surface nodes within the disc's radius of the contact, or the nearest one, are displaced by phi d, phi = 1 -
           (r / R)^2 / 2, as under our disc; the force is sum phi f, conjugate to d.
Method:    felupe's own Newton iteration and default solver, four load steps.

Reads {"nodes", "tetrahedra", "held" (fixed nodes), "surface", "normals" (outward, of its nodes), "modulus_Pa",
"radius_m", "pushes": [[contact], [displacement]], "outward" (unit normal of each)} from standard input; prints
{"version", "press_us": [...], "force_N": [[x, y, z], ...], "displacement_m": [[[x, y, z], ...], ...]} as one line of
JSON, with null for an indentation without an answer.
Sample run: scripts/peers_organ.py calls it.
"""
import json
import os
import sys
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import felupe as fem  # noqa: E402
import numpy as np  # noqa: E402

POISSON = 0.45


def press(mesh, asked, contact, push, outward):
    """Force [N] and displacement of all nodes [m]. felupe raises if Newton does not converge."""
    field = fem.FieldContainer([fem.Field(fem.RegionTetra(mesh), dim=3)])
    shear = asked["modulus_Pa"] / (2 * (1 + POISSON))
    solid = fem.SolidBody(fem.NeoHookeCompressible(mu=shear, lmbda=2 * shear * POISSON / (1 - 2 * POISSON)), field)
    surface = np.array(asked["surface"])
    away = np.linalg.norm(mesh.points[surface] - contact, axis=1)
    away[np.array(asked["normals"]) @ outward <= 0] = np.inf  # excludes the other side of thin tissue
    near = (away <= asked["radius_m"]) | (away <= away.min())
    phi = np.zeros(len(mesh.points))
    phi[surface[near]] = 1 - np.minimum(1, away[near] / asked["radius_m"]) ** 2 / 2
    fixed = phi > 0
    fixed[asked["held"]] = True
    held = np.flatnonzero(np.repeat(fixed, 3))
    free = np.setdiff1d(np.arange(mesh.points.size), held)
    for step in (0.25, 0.5, 0.75, 1):
        move = step * phi[:, None] * np.array(push)
        fem.newtonraphson(items=[solid], x0=field, dof0=held, dof1=free, ext0=move.ravel()[held], tol=1e-8, verbose=False)
    return phi @ solid.assemble.vector(field).toarray().reshape(-1, 3), field[0].values


def main():
    asked = json.load(sys.stdin)
    mesh = fem.Mesh(np.array(asked["nodes"]), np.array(asked["tetrahedra"]), "tetra")
    times, forces, displacements = [], [], []
    for (contact, push), outward in zip(asked["pushes"], asked["outward"]):
        begin = time.perf_counter()
        try:
            force, displacement = press(mesh, asked, np.array(contact), push, np.array(outward))
            forces.append(force.tolist())
            displacements.append(displacement.tolist())
        except Exception as error:  # felupe raises several types
            print(f"felupe: no answer at {contact}: {error}", file=sys.stderr)
            forces.append(None)
            displacements.append(None)
        times.append(1e6 * (time.perf_counter() - begin))
    print(json.dumps({"version": fem.__version__, "press_us": times, "force_N": forces, "displacement_m": displacements}))


if __name__ == "__main__":
    main()
