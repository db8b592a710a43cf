#!/usr/bin/env python3
"""The same tetrahedra in an independent program: indentation by the disc, felupe against solve_solid.edp.

Equations: div P = 0, P = 2 C1 F + 2 C2 (I1 F - F C) + (p + p0) J F^-T, and J = 1, P2 displacement and P1 pressure, on
           the mesh file that FreeFEM reads. Assembly, kinematics, quadrature (14 points; ours has 8), Newton's method
           and the linear solver are felupe's.
Boundary:  u = 0 at z = 0; u = phi d on the top's nodes within the disc, phi = 1 - (r/R)^2 / 2; the force is sum of phi f.

Prints one line per comparison, "ok - sentence" or "not ok - sentence: measured vs wanted"; exits 1 if any failed. The
last line is the ratio of CPU times of the same load paths. Ours includes the start-up of FreeFEM, felupe's does not
include that of Python.
Needs felupe (pip), gmsh and FreeFem++-nw. FF_LOADPATH must be set if FreeFEM's preferences do not name its plugins.

Sample run: python3 tests/fem/felupe_solid.py
            python3 tests/fem/felupe_solid.py --size-near-m 0.005 --size-far-m 0.02
"""
import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "SCOTCH_PTHREAD_NUMBER"):  # compare CPU times on one core
    os.environ[name] = "1"

import felupe as fem  # noqa: E402
import numpy as np  # noqa: E402
from felupe_patch import C1, C2, FEM, FORCE_TOLERANCE, IncompressibleMooneyRivlin, check_gradient  # noqa: E402

SIZE = (0.1, 0.1, 0.05)  # [m] width, length, height
RADIUS = 0.007           # [m] radius of the disc
# name, contact [m], direction (unit vector)
PUSHES = [
    ("middle, normal", (0.05, 0.05), (0.0, 0.0, -1.0)),
    ("between nodes, 30 degrees along x", (0.043, 0.056), (0.5, 0.0, -np.sqrt(0.75))),
    ("20 mm from two walls, 20 degrees", (0.02, 0.08), tuple(np.array([0.6, -0.8, 0]) * np.sin(np.pi / 9) - np.array([0, 0, np.cos(np.pi / 9)]))),
]


def read_msh(path):
    """Nodes (n x 3) and tetrahedra (t x 4) of an MSH 2.2 file."""
    lines = open(path).read().split("\n")
    start = lines.index("$Nodes")
    rows = [line.split() for line in lines[start + 2:start + 2 + int(lines[start + 1])]]
    numbers = {int(row[0]): i for i, row in enumerate(rows)}
    points = np.array([[float(w) for w in row[1:]] for row in rows])
    start = lines.index("$Elements")
    rows = [line.split() for line in lines[start + 2:start + 2 + int(lines[start + 1])]]
    return points, np.array([[numbers[int(w)] for w in row[-4:]] for row in rows if row[1] == "4"])


def quadratic(points, tetrahedra):
    """The same mesh with midside nodes in felupe's order, 01, 12, 20, 03, 13, 23: nodes (m x 3), cells (t x 10)."""
    pairs = np.sort(np.concatenate([tetrahedra[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))]), axis=1)
    edges, place = np.unique(pairs, axis=0, return_inverse=True)
    middles = place.reshape(6, -1).T + len(points)
    return np.vstack([points, points[edges].mean(axis=1)]), np.hstack([tetrahedra, middles])


def felupe_force(msh, contact, direction, depth, steps):
    """Conjugate contact force [N], (3), at the last displacement, and CPU seconds."""
    start = time.process_time()
    points, tetrahedra = read_msh(msh)
    nodes, cells = quadratic(points, tetrahedra)
    quadrature = fem.TetrahedronQuadrature(order=5)
    u = fem.Field(fem.RegionQuadraticTetra(fem.Mesh(nodes, cells, "tetra10"), quadrature=quadrature), dim=3)
    p = fem.Field(fem.RegionTetra(fem.Mesh(points, tetrahedra, "tetra"), quadrature=quadrature, grad=False), dim=1)
    field = fem.FieldContainer([u, p])
    solid = fem.SolidBody(IncompressibleMooneyRivlin(), field)

    r2 = ((nodes[:, :2] - np.array(contact)) ** 2).sum(axis=1)
    disc = (np.abs(nodes[:, 2] - SIZE[2]) < 1e-8) & (r2 <= (RADIUS + 1e-8) ** 2)
    fixed = np.abs(nodes[:, 2]) < 1e-8
    phi = np.where(disc, 1 - 0.5 * r2 / RADIUS**2, 0)
    held = np.flatnonzero(np.repeat(disc | fixed, 3))
    free = np.setdiff1d(np.arange(nodes.size + len(points)), held)
    for step in range(1, steps + 1):
        move = phi[:, None] * (depth * step / steps) * np.array(direction)
        fem.newtonraphson(items=[solid], x0=field, dof0=held, dof1=free, ext0=move.ravel()[held], tol=1e-9, maxiter=25, verbose=False)
    force = solid.assemble.vector(field).toarray()[:nodes.size].reshape(-1, 3)
    return phi @ force, time.process_time() - start


def freefem_force(msh, contact, direction, depth, steps, work):
    """The same by solve_solid.edp."""
    out = os.path.join(work, "path.csv")
    arguments = {
        "mesh": msh, "out": out, **dict(zip(("width", "length", "height"), SIZE)), "C1": C1, "C2": C2,
        "cells_x": 10, "cells_y": 10, "cells_z": 5, "contact_x": contact[0], "contact_y": contact[1], "contact_z": SIZE[2],
        **{"direction_" + axis: repr(float(d)) for axis, d in zip("xyz", direction)}, "disc_radius": RADIUS,
        "depth": depth, "records": steps, "tolerance": 1e-10, "max_newton": 12,
    }
    command = ["FreeFem++-nw", "-nw", "-v", "0", os.path.join(FEM, "solve_solid.edp")]
    for key, value in arguments.items():
        command += ["-" + key, str(value)]

    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    before = spent()
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(run.stderr.strip() or run.stdout.strip()[-300:])
    last = [line.split(",") for line in open(out) if line.startswith("step,")][-1]
    return np.array([float(w) for w in last[4:7]]), spent() - before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--depth-m", type=float, default=0.01)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--size-near-m", type=float, default=0.0035)
    parser.add_argument("--size-far-m", type=float, default=0.015)
    options = parser.parse_args()
    check_gradient(fem.QuadraticTetra(), at=(0.2, 0.3, 0.1))
    failed, ours_spent, theirs_spent = 0, 0, 0
    for name, contact, direction in PUSHES:
        with tempfile.TemporaryDirectory() as work:
            msh = os.path.join(work, "path.msh")
            command = ["gmsh", "-v", "1", "-3", "-format", "msh22", os.path.join(FEM, "block3.geo"), "-o", msh]
            for key, value in {"contact_x": contact[0], "contact_y": contact[1], "disc_radius": RADIUS,
                               "size_near": options.size_near_m, "size_far": options.size_far_m}.items():
                command += ["-setnumber", key, str(value)]
            subprocess.run(command, check=True, capture_output=True)
            try:
                ours, a = freefem_force(msh, contact, direction, options.depth_m, options.steps, work)
                theirs, b = felupe_force(msh, contact, direction, options.depth_m, options.steps)
                ours_spent, theirs_spent = ours_spent + a, theirs_spent + b
                difference = np.linalg.norm(ours - theirs) / np.linalg.norm(theirs)
                sentence = f"disc, {name}, {1e3 * options.depth_m:g} mm: felupe P2/P1 has the same contact force"
                words = ", ".join(f"({', '.join(f'{1e3 * w:.3f}' for w in f)}) mN in {t:.1f} s" for f, t in ((ours, a), (theirs, b)))
                if difference <= FORCE_TOLERANCE:
                    print(f"ok - {sentence}, relative difference {difference:.1e}: FreeFEM, felupe {words}", flush=True)
                else:
                    print(f"not ok - {sentence}: {difference:.1e} vs {FORCE_TOLERANCE}: FreeFEM, felupe {words}", flush=True)
                    failed += 1
            except Exception as error:  # either program may fail on a mesh: report it and continue
                print(f"not ok - disc, {name}: {error} vs two forces", flush=True)
                failed += 1
    if theirs_spent > 0:
        print(f"# disc: CPU time of the same paths, ours over felupe's: {ours_spent:.1f} s / {theirs_spent:.1f} s = {ours_spent / theirs_spent:.2f}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
