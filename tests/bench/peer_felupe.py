#!/usr/bin/env python3
"""felupe on the load paths of solve_path.edp in plane stress: the peer of `make cases` in scripts/bench.py.

Equations: the same discrete problem: the same MSH file, quadratic triangles, 7 quadrature points, displacement only,
           F33 = 1/J, P = 2 W_T F + W_J cof F (fem/plane_stress.idp), point indenter, the same records. Criterion of
           convergence: largest force on a free node over the largest on a fixed one.
Method:    felupe's own Newton iteration with a new tangent in every iteration, its assembly and its default solver. A
           record is one load step; a step that fails is halved, as in solve_path.edp. Start-up counts once for all
           paths, and the only output is one line; both favour felupe.

Prints {"version", "forces": {path: [[s_m, fx_N, fy_N], ...]}} as one line of JSON.
Sample run: build/venv/bin/python tests/bench/peer_felupe.py --plan results/paper/plan.mk --results results/paper
"""
import argparse
import json
import multiprocessing
import os
import re
import sys

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):  # two processes already use two cores
    os.environ.setdefault(name, "1")

import felupe as fem
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fem"))
from felupe_patch import QuadraticTriangle, check_gradient, quadratic, read_msh  # noqa: E402


class PlaneStressMooneyRivlin:
    """Stress and tangent of W(T, J) for felupe: F (2, 2, q, c); T = F : F, J = det F."""

    def __init__(self, C1, C2):
        self.x = [np.eye(2), np.zeros(0)]
        self.C1, self.C2 = C1, C2

    def invariants(self, F):
        cof = np.stack([np.stack([F[1, 1], -F[1, 0]]), np.stack([-F[0, 1], F[0, 0]])])
        return cof, F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0], (F * F).sum(axis=(0, 1))

    def gradient(self, x):
        F, state = x[0], x[-1]
        cof, J, T = self.invariants(F)
        W_T = self.C1 + self.C2 / J**2
        W_J = -2 * self.C1 / J**3 + self.C2 * (2 * J - 2 * T / J**3)
        return [2 * W_T * F + W_J * cof, state]

    def hessian(self, x):
        F = x[0]
        cof, J, T = self.invariants(F)
        W_T = self.C1 + self.C2 / J**2
        W_J = -2 * self.C1 / J**3 + self.C2 * (2 * J - 2 * T / J**3)
        W_TJ = -2 * self.C2 / J**3
        W_JJ = 6 * self.C1 / J**4 + self.C2 * (2 + 6 * T / J**4)
        a = 2 * W_TJ * F + W_JJ * cof  # dW_J/dF
        A = np.einsum("ij...,kl...->ijkl...", cof, a)
        A += np.einsum("ij...,kl...->ijkl...", 2 * W_TJ * F, cof)
        for i in (0, 1):
            for j in (0, 1):
                A[i, j, i, j] += 2 * W_T
                A[i, j, 1 - i, 1 - j] += W_J if i == j else -W_J
        return [A]


def solve_path(task):
    """Solves one path. Returns its name and [s, fx, fy] at each record [m, N]."""
    name, mesh_file, a = task
    points, triangles = read_msh(mesh_file)
    nodes, cells = quadratic(points, triangles)
    element, quadrature = QuadraticTriangle(), fem.TriangleQuadrature(order=5)
    check_gradient(element)
    u = fem.Field(fem.Region(fem.Mesh(nodes, cells, "triangle6"), element, quadrature), dim=2)
    field = fem.FieldContainer([u])
    solid = fem.SolidBody(PlaneStressMooneyRivlin(a["C1"], a["C2"]), field)
    fixed = np.abs(nodes[:, 1]) < 1e-8
    held = np.hypot(nodes[:, 0] - a["contact_x"], nodes[:, 1] - a["contact_y"]) < 1e-8

    def check(dx, x, f, xtol, ftol, dof1=None, dof0=None, items=None, eps=None):
        residual = np.abs(f[dof1]).max() / np.abs(f[dof0]).max()
        return np.linalg.norm(dx), residual, residual <= ftol

    def step_to(s):
        bounds = {
            "fixed": fem.Boundary(u, mask=fixed),
            "x": fem.Boundary(u, mask=held, skip=(0, 1), value=s * a["direction_x"]),
            "y": fem.Boundary(u, mask=held, skip=(1, 0), value=s * a["direction_y"]),
        }
        dof0, dof1 = fem.dof.partition(field, bounds)
        ext0 = fem.dof.apply(field, bounds, dof0)
        before = u.values.copy()
        try:
            with np.errstate(all="ignore"):
                done = fem.newtonraphson(items=[solid], x0=field, dof0=dof0, dof1=dof1, ext0=ext0, tol=a["tolerance"],
                                         check=check, maxiter=int(a["max_newton"]), verbose=False)
        except ValueError:  # felupe's NewtonConvergenceError
            u.values[:] = before
            return None
        u.values[:] = done.x[0].values
        return done.fun

    depth, records = a["depth"], int(a["records"])
    forces, s = [[0.0, 0.0, 0.0]], 0.0
    for record in range(1, records + 1):
        target = depth * record / records
        step = target - s
        while s < target:
            goal = target if s + 1.001 * step >= target else s + step
            force = step_to(goal)
            if force is None:
                step /= 2
                if step < 1e-3 * depth:
                    raise RuntimeError(f"felupe finds no equilibrium on path {name} past {1e3 * s:g} mm")
                continue
            s = goal
        at = a["thickness"] * force.reshape(-1, 2)[held].sum(axis=0)
        forces.append([s, *at])
    return name, forces


def planned(plan, results):
    """Paths of plan.mk with the arguments that FreeFEM gets: (name, mesh file, numbers by name)."""
    tasks = []
    for name, line in re.findall(r"cases/([^/\s]+)\.csv: PATH_ARGUMENTS = (.*)", open(plan).read()):
        words = line.replace("$(R)", results).split()
        given = {key.lstrip("-"): value for key, value in zip(words[::2], words[1::2])}
        if given["formulation"] != "plane-stress" or given["indenter"] != "point":
            raise RuntimeError(f"path {name} is not plane stress under a point, which is all that this peer does")
        text = ("mesh", "formulation", "indenter")
        tasks.append((name, given["mesh"], {k: float(v) for k, v in given.items() if k not in text}))
    return tasks


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", required=True, help="plan.mk of the study")
    parser.add_argument("--results", required=True, help="what $(R) stands for in it")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", help="these paths alone, by name, with commas between")
    options = parser.parse_args()
    tasks = [t for t in planned(options.plan, options.results) if not options.only or t[0] in options.only.split(",")]
    with multiprocessing.Pool(options.processes) as pool:
        forces = dict(pool.imap_unordered(solve_path, tasks, chunksize=1))
    print(json.dumps({"version": fem.__version__, "forces": forces}))


if __name__ == "__main__":
    main()
