#!/usr/bin/env python3
"""The same continuum in an independent program: indentation by a patch in plane strain, felupe against solve_path.edp.

Equations: div P = 0, P = 2 C1 F + 2 C2 (I1 F - F C) + (p + p0) J F^-T in three dimensions with F33 = 1, and J = 1;
           for the first contact also Ogden's P = F sum_i l_i^-2 sum_k mu_k l_i^alpha_k N_i (x) N_i + (p + p0) J F^-T,
           by the eigenvectors N_i of C in 3-D, where our formulation uses a Chebyshev function of T and J.
           The nodes are those of the mesh file that FreeFEM reads, with two discretisations: FreeFEM's triangles
           (P2/P1) and quadrilaterals (Q2 displacement, Q1 pressure). Assembly, kinematics and linear solver are
           felupe's. The stress is a formula of tensors in 3-D, where ours is in T and J.
           Displacement histories of tissue that relaxes; the last one is of tissue with mass (a generalised-alpha step
           implemented here, on felupe's mass matrix): P = F ((1 - sum g) S0 + sum Q_k) + p J F^-T, S0 = F^-1 P at p = 0
           of the above, Q_k' + Q_k / tau_k = g_k S0', with all nine entries, where ours has the three of the plane.
Boundary:  u = 0 at y = 0; u = d on the boundary nodes within the patch's half-width of the contact.

Prints one line per comparison, "ok - sentence" or "not ok - sentence: measured vs wanted"; exits 1 if any failed.
Needs felupe (pip), gmsh and FreeFem++-nw. FF_LOADPATH must be set if FreeFEM's preferences do not name its plugins.

Sample run: python3 tests/fem/felupe_patch.py
            python3 tests/fem/felupe_patch.py --end-size-m 0.0025 --depth-m 0.01 --steps 20
"""
import argparse
import os
import subprocess
import sys
import tempfile
import time
from types import SimpleNamespace

import felupe as fem
import numpy as np
from felupe.math import cdya_ik, cdya_il, det, dot, dya, identity, inv, trace, transpose
from scipy.sparse import csr_matrix

WIDTH = HEIGHT = 0.1      # [m]
THICKNESS = 0.001         # [m]
C1, C2 = 263.0, 491.0     # [Pa]
MU, ALPHA = [600.0, 20.0], [2.5, 9.0]  # [Pa], 1: Ogden
HALF_WIDTH = 0.005        # [m]
FORCE_TOLERANCE = 0.01    # relative error of the contact force
HISTORY_TOLERANCE = 1e-7  # both programs solve the same discrete problem to 1e-9 or better
FEM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "fem")

# name, contact [m], direction of the tool displacement (unit vector). The third contact lies between nodes of the 1 cm
# lattice. Quadrilaterals are another discrete problem. Their difference from ours is discretisation error and is
# printed without a verdict.
PUSHES = [
    ("left midpoint", (0.0, 0.05), (1.0, 0.0)),
    ("top midpoint", (0.05, 0.1), (0.0, -1.0)),
    ("left, between nodes, 10 degrees up from the normal", (0.0, 0.067), (np.cos(np.pi / 18), np.sin(np.pi / 18))),
]


class IncompressibleMooneyRivlin:
    """Stress and tangent of W(F) + (p + p0) (J - 1) for felupe: F (3, 3, q, c), p (1, q, c)."""

    def __init__(self):
        self.x = [np.eye(3), np.zeros(1), np.zeros(0)]
        self.p0 = -2 * (C1 + 2 * C2)  # stress vanishes at rest

    def gradient(self, x):
        F, p, state = x[0], x[1], x[-1]
        C = dot(transpose(F), F)
        J = det(F)
        P = 2 * C1 * F + 2 * C2 * (trace(C) * F - dot(F, C)) + (p + self.p0) * J * transpose(inv(F))
        return [P, J - 1 + 0 * p, state]

    def hessian(self, x):
        F, p = x[0], x[1]
        one = identity(F)
        C, b = dot(transpose(F), F), dot(F, transpose(F))
        J = det(F)
        iFT = transpose(inv(F))
        eye4 = cdya_ik(one, one)  # dF/dF
        d_FF = 2 * C1 * eye4 + 2 * C2 * (
            trace(C) * eye4 + 2 * dya(F, F)
            - cdya_ik(one, C) - cdya_ik(b, one) - cdya_il(F, F)
        ) + (p + self.p0) * J * (dya(iFT, iFT) - cdya_il(iFT, iFT))
        return [d_FF, J * iFT, None]


class IncompressibleOgden:
    """The same for Ogden's solid, with the tangent by central differences of the stress."""

    def __init__(self):
        self.x = [np.eye(3), np.zeros(1), np.zeros(0)]
        self.p0 = -sum(MU)

    def stress(self, F):
        rows = np.moveaxis(dot(transpose(F), F), (0, 1), (-2, -1))
        square, N = np.linalg.eigh(rows)
        factor = sum(mu * square ** (alpha / 2 - 1) for mu, alpha in zip(MU, ALPHA))
        S = np.moveaxis(np.einsum("...ij,...j,...kj->...ik", N, factor, N), (-2, -1), (0, 1))
        return dot(F, S)

    def gradient(self, x):
        F, p, state = x[0], x[1], x[-1]
        J = det(F)
        return [self.stress(F) + (p + self.p0) * J * transpose(inv(F)), J - 1 + 0 * p, state]

    def hessian(self, x):
        F, p = x[0], x[1]
        J, iFT, h = det(F), transpose(inv(F)), 1e-6
        d_FF = np.zeros((3, 3) + F.shape)
        for k in range(3):
            for l in range(3):
                step = np.zeros((3, 3, 1, 1))
                step[k, l] = h
                d_FF[:, :, k, l] = (self.stress(F + step) - self.stress(F - step)) / (2 * h)
        d_FF += (p + self.p0) * J * (dya(iFT, iFT) - cdya_il(iFT, iFT))
        return [d_FF, J * iFT, None]


class Relaxing(IncompressibleMooneyRivlin):
    """The same with Maxwell branches: (relative modulus, relaxation time [s]) of each. Call remember() at a step's
    end."""

    def __init__(self, branches=((0.45, 0.5), (0.365, 50.0))):
        super().__init__()
        self.branches = branches
        self.past = None  # S0 at the step's beginning and Q of each branch
        self.begin(0.0)

    def begin(self, dt):
        self.decay = [np.exp(-dt / tau) for _, tau in self.branches]
        self.mean = [(1 - e) * tau / dt if dt > 0 else 1.0 for e, (_, tau) in zip(self.decay, self.branches)]
        self.share = 1 - sum(g * (1 - c) for (g, _), c in zip(self.branches, self.mean))
        if self.past:
            before, Q = self.past
            self.H = sum(e * q - g * c * before for e, c, q, (g, _) in zip(self.decay, self.mean, Q, self.branches))

    def elastic(self, F):
        return super().gradient([F, np.zeros((1,) + F.shape[2:]), None])[0]

    def remember(self, F):
        S0 = dot(inv(F), self.elastic(F))
        before, Q = self.past or (np.zeros_like(S0), [np.zeros_like(S0) for _ in self.branches])
        self.past = S0, [e * q + g * c * (S0 - before) for e, c, q, (g, _) in zip(self.decay, self.mean, Q, self.branches)]

    def gradient(self, x):
        F, p, state = x[0], x[1], x[-1]
        J = det(F)
        H = self.H if self.past else np.zeros_like(F)
        return [self.share * self.elastic(F) + dot(F, H) + p * J * transpose(inv(F)), J - 1 + 0 * p, state]

    def hessian(self, x):
        F, p = x[0], x[1]
        J, iFT, one = det(F), transpose(inv(F)), identity(F)
        H = self.H if self.past else np.zeros_like(F)
        d_FF = (self.share * super().hessian([F, 0 * p])[0] + cdya_ik(np.broadcast_to(one, F.shape), H)
                + p * J * (dya(iFT, iFT) - cdya_il(iFT, iFT)))
        return [d_FF, J * iFT, None]


class Inertia:
    """M ((1 - m) a + m a_before) as an item of felupe's Newton method, m = (r - 1) / (r + 1)."""

    def __init__(self, field, mass, lasting=0.8):
        self.field, self.mass, self.shift = field, mass, (lasting - 1) / (lasting + 1)
        self.beta, self.gamma = (1 - self.shift) ** 2 / 4, 0.5 - self.shift
        self.u, self.v, self.a = np.zeros(mass.shape[0]), np.zeros(mass.shape[0]), np.zeros(mass.shape[0])
        self.assemble = SimpleNamespace(vector=self.vector, matrix=self.matrix, multiplier=None)
        self.results = SimpleNamespace(update_statevars=lambda: None)

    def begin(self, dt):
        self.dt, self.u = dt, self.field[0].values.ravel().copy()

    def acceleration(self):
        moved = self.field[0].values.ravel() - self.u - self.dt * self.v
        return moved / (self.beta * self.dt ** 2) - (0.5 / self.beta - 1) * self.a

    def vector(self, field=None, **kwargs):
        return csr_matrix((self.mass @ ((1 - self.shift) * self.acceleration() + self.shift * self.a)).reshape(-1, 1))

    def matrix(self, field=None, **kwargs):
        return self.mass * ((1 - self.shift) / (self.beta * self.dt ** 2))

    def end(self):
        a = self.acceleration()
        self.v, self.a = self.v + self.dt * ((1 - self.gamma) * self.a + self.gamma * a), a


def histories():
    """Yields name, contact [m], rows of time [s] and displacement [m] (T x 3) from rest, and density [kg/m3]: a ramp
    with a hold; an indentation with a varying direction that returns to zero; a quick indentation with a hold, of
    tissue with mass."""
    t = np.r_[0, np.linspace(0.02, 0.1, 5), 0.1 + np.geomspace(0.05, 10, 8)]
    yield "ramp and hold", (0.05, 0.1), np.c_[t, 0 * t, -0.01 * np.minimum(t / 0.1, 1)], 0
    t = np.linspace(0, 1.5, 25)
    depth = 0.009 * np.sin(np.pi * t / 1.5) ** 2 * (1 + 0.3 * np.sin(9 * t))
    tilt = 0.5 * np.sin(4 * t)
    yield "indentation with a varying direction", (0.043, 0.1), np.c_[t, depth * np.sin(tilt), -depth * np.cos(tilt)], 0
    t = np.linspace(0, 0.15, 31)
    s = np.minimum(t / 0.1, 1)
    depth = 0.008 * s ** 3 * (10 - 15 * s + 6 * s ** 2)
    yield "quick indentation of tissue with mass", (0.043, 0.1), np.c_[t, 0.3 * depth, -depth], 1040


LAWS = {  # felupe's material, arguments of FreeFEM
    "Mooney-Rivlin": (IncompressibleMooneyRivlin, {"C1": C1, "C2": C2}),
    "Ogden": (IncompressibleOgden, {"law": "ogden", "terms": len(MU), **{f"mu{k + 1}": m for k, m in enumerate(MU)},
                                    **{f"alpha{k + 1}": a for k, a in enumerate(ALPHA)}}),
}


def read_msh(path):
    """Nodes (n x 2) and triangles (t x 3) of an MSH 2.2 file."""
    lines = open(path).read().split("\n")
    start = lines.index("$Nodes")
    count = int(lines[start + 1])
    points = np.array([[float(w) for w in line.split()[1:3]] for line in lines[start + 2:start + 2 + count]])
    numbers = {int(line.split()[0]): i for i, line in enumerate(lines[start + 2:start + 2 + count])}
    start = lines.index("$Elements")
    triangles = []
    for line in lines[start + 2:start + 2 + int(lines[start + 1])]:
        w = [int(v) for v in line.split()]
        if w[1] == 2:
            triangles.append([numbers[v] for v in w[-3:]])
    triangles = np.array(triangles)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return points, triangles


def quadratic(points, triangles):
    """The same mesh with midside nodes: nodes (m x 2), cells (t x 6), corners first, midsides 01, 12, 20."""
    middles, cells, more = {}, [], list(points)
    for t in triangles:
        cell = list(t)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            key = (min(t[i], t[j]), max(t[i], t[j]))
            if key not in middles:
                middles[key] = len(more)
                more.append(0.5 * (points[t[i]] + points[t[j]]))
            cell.append(middles[key])
        cells.append(cell)
    return np.array(more), np.array(cells)


def outline_position(x):
    """Arc length along the outline, anticlockwise from the lower left corner [m]; nan off it."""
    tol = 1e-8
    a = np.full(len(x), np.nan)
    a[np.abs(x[:, 0]) < tol] = (2 * (WIDTH + HEIGHT) - x[:, 1])[np.abs(x[:, 0]) < tol]
    a[np.abs(x[:, 1] - HEIGHT) < tol] = (2 * WIDTH + HEIGHT - x[:, 0])[np.abs(x[:, 1] - HEIGHT) < tol]
    a[np.abs(x[:, 0] - WIDTH) < tol] = (WIDTH + x[:, 1])[np.abs(x[:, 0] - WIDTH) < tol]
    return a


class QuadraticTriangle(fem.QuadraticTriangle):
    """felupe 11.3.0's element has a wrong entry in its gradient (last node: t1 - t2 instead of t1 - t3), so even a
    linear field has a wrong gradient. This class has the derivatives of the element's shape functions."""

    def gradient(self, rs):
        r, s = rs
        t = 1 - r - s
        return np.array([[1 - 4 * t, 1 - 4 * t], [4 * r - 1, 0], [0, 4 * s - 1],
                         [4 * (t - r), -4 * r], [4 * s, 4 * r], [-4 * s, 4 * (t - s)]])


def check_gradient(element, at=(0.2, 0.3), h=1e-6):
    """Raises an error unless an element's gradient is the derivative of its shape functions."""
    at = np.array(at)
    difference = np.stack([(element.function(at + h * e) - element.function(at - h * e)) / (2 * h) for e in np.eye(len(at))], 1)
    worst = np.abs(difference - element.gradient(at)).max()
    if worst > 1e-8:
        raise RuntimeError(f"felupe's {type(element).__name__} has a gradient that is off by {worst:.2g}")


def fields_on_triangles(points, triangles):
    """Fields of P2 displacement and P1 pressure, and the P2 nodes (m x 2)."""
    nodes, cells = quadratic(points, triangles)
    quadrature, element = fem.TriangleQuadrature(order=5), QuadraticTriangle()
    check_gradient(element)
    u = fem.FieldPlaneStrain(fem.Region(fem.Mesh(nodes, cells, "triangle6"), element, quadrature), dim=2)
    p = fem.Field(fem.RegionTriangle(fem.Mesh(points, triangles, "triangle"), quadrature=quadrature, grad=False), dim=1)
    return u, p, nodes


def fields_on_quads(points, triangles):
    """Fields of Q2 displacement and Q1 pressure on the rectangles that the triangles halve, and the nodes (m x 2): the
    same nodes as P2, since the middle of a diagonal is the rectangle's centre."""
    nodes, cells = quadratic(points, triangles)
    at = {}
    for cell in cells:
        for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
            if np.all(np.abs(nodes[cell[i]] - nodes[cell[j]]) > 1e-9):
                at.setdefault(cell[3 + k], []).append(cell)
    quads = []
    for centre, pair in at.items():
        own = np.unique(np.concatenate(pair))
        x = nodes[own]
        low, high = x.min(axis=0), x.max(axis=0)
        # felupe's order: corners, middles of the sides, centre
        places = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0)]
        quads.append([own[np.argmin(np.abs(x - 0.5 * (low + high) - 0.5 * np.array(q) * (high - low)).sum(axis=1))]
                      for q in places])
    quads = np.array(quads)
    quadrature = fem.GaussLegendre(order=2, dim=2)
    check_gradient(fem.element.BiQuadraticQuad())
    u = fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(fem.Mesh(nodes, quads, "quad9"), quadrature=quadrature), dim=2)
    p = fem.Field(fem.RegionQuad(fem.Mesh(points, quads[:, :4], "quad"), quadrature=quadrature, grad=False), dim=1)
    return u, p, nodes


def felupe_history(fields, msh, contact, rows, density):
    """Contact force [N] (T x 2) over a displacement history."""
    u, p, nodes = fields(*read_msh(msh))
    field, law = fem.FieldContainer([u, p]), Relaxing()
    solid = fem.SolidBody(law, field)
    place = outline_position(nodes)
    held = np.nan_to_num(np.abs(place - outline_position(np.array([contact]))[0]), nan=np.inf) <= HALF_WIDTH + 1e-8
    fixed = np.abs(nodes[:, 1]) < 1e-8
    items = [solid]
    if density:
        items.append(Inertia(field, csr_matrix(solid.assemble.mass(density))))
    law.remember(field.extract()[0])
    forces = [np.zeros(2)]
    for before, row in zip(rows, rows[1:]):
        law.begin(row[0] - before[0])
        for motion in items[1:]:
            motion.begin(row[0] - before[0])
        bounds = {
            "fixed": fem.Boundary(u, mask=fixed),
            "x": fem.Boundary(u, mask=held, skip=(0, 1), value=row[1]),
            "y": fem.Boundary(u, mask=held, skip=(1, 0), value=row[2]),
        }
        dof0, dof1 = fem.dof.partition(field, bounds)
        dof1 = np.setdiff1d(np.arange(sum(f.values.size for f in field.fields)), dof0)
        ext0 = fem.dof.apply(field, bounds, dof0)
        fem.newtonraphson(items=items, x0=field, dof0=dof0, dof1=dof1, ext0=ext0, tol=1e-9, maxiter=25, verbose=False)
        force = sum(item.assemble.vector(field).toarray()[:nodes.size] for item in items)
        forces.append(THICKNESS * force.reshape(-1, 2)[held].sum(axis=0))
        for motion in items[1:]:
            motion.end()
        law.remember(field.extract()[0])
    return np.array(forces)


def freefem_history(msh, contact, rows, density, work):
    """Contact force [N] (T x 2) over a displacement history."""
    history = os.path.join(work, "history.txt")
    np.savetxt(history, np.c_[rows, np.zeros(len(rows))], fmt="%.17g")
    more = {"history": history, "branches": len(Relaxing().branches), **({"density": density} if density else {})}
    for k, (g, tau) in enumerate(Relaxing().branches):
        more |= {f"g{k + 1}": g, f"tau{k + 1}": tau}
    return np.array([[float(w) for w in row[6:8]] for row in freefem_steps("Mooney-Rivlin", msh, contact, (0.0, -1.0), 0.01, 1, work, more)])


def felupe_force(law, fields, msh, contact, direction, depth, steps):
    """Contact force [N], (2), at the last displacement."""
    u, p, nodes = fields(*read_msh(msh))
    field = fem.FieldContainer([u, p])
    solid = fem.SolidBody(LAWS[law][0](), field)

    place = outline_position(nodes)
    middle = outline_position(np.array([contact]))[0]
    held = np.nan_to_num(np.abs(place - middle), nan=np.inf) <= HALF_WIDTH + 1e-8
    fixed = np.abs(nodes[:, 1]) < 1e-8
    for step in range(1, steps + 1):
        move = depth * step / steps * np.array(direction)
        bounds = {
            "fixed": fem.Boundary(u, mask=fixed),
            "x": fem.Boundary(u, mask=held, skip=(0, 1), value=move[0]),
            "y": fem.Boundary(u, mask=held, skip=(1, 0), value=move[1]),
        }
        dof0, dof1 = fem.dof.partition(field, bounds)
        dof1 = np.setdiff1d(np.arange(sum(f.values.size for f in field.fields)), dof0)
        ext0 = fem.dof.apply(field, bounds, dof0)
        fem.newtonraphson(items=[solid], x0=field, dof0=dof0, dof1=dof1, ext0=ext0, tol=1e-9, maxiter=25, verbose=False)
    force = solid.assemble.vector(field).toarray()[:nodes.size].reshape(-1, 2)
    return THICKNESS * force[held].sum(axis=0)


def freefem_force(law, msh, contact, direction, depth, steps, work):
    """Contact force [N], (2), at the last displacement."""
    return np.array([float(w) for w in freefem_steps(law, msh, contact, direction, depth, steps, work)[-1][4:6]])


def freefem_steps(law, msh, contact, direction, depth, steps, work, more=()):
    """Fields of every `step` row of the path's file."""
    out = os.path.join(work, "path.csv")
    arguments = {
        "mesh": msh, "out": out, "width": WIDTH, "height": HEIGHT, "thickness": THICKNESS, **LAWS[law][1],
        "cells_x": 10, "cells_y": 10, "contact_x": contact[0], "contact_y": contact[1],
        "direction_x": repr(float(direction[0])), "direction_y": repr(float(direction[1])), "depth": depth,
        "records": steps, "tolerance": 1e-10, "max_newton": 12, "formulation": "plane-strain", "indenter": "patch",
        "patch_half_width": HALF_WIDTH, **dict(more),
    }
    command = ["FreeFem++-nw", "-nw", "-v", "0", os.path.join(FEM, "solve_path.edp")]
    for key, value in arguments.items():
        command += ["-" + key, str(value)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(run.stderr.strip() or run.stdout.strip()[-300:])
    return [line.split(",") for line in open(out) if line.startswith("step,")]


def mesh_of_patch(contact, options, work):
    """Meshes the block for a patch; returns the name of the mesh file."""
    msh = os.path.join(work, "patch.msh")
    command = ["gmsh", "-v", "1", "-2", "-format", "msh22", os.path.join(FEM, "block_graded.geo"), "-o", msh]
    for key, value in {"contact_x": contact[0], "contact_y": contact[1], "patch_half_width": HALF_WIDTH,
                       "end_size": options.end_size_m, "surface_size": options.surface_size_m}.items():
        command += ["-setnumber", key, str(value)]
    subprocess.run(command, check=True, capture_output=True)
    return msh


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--depth-m", type=float, default=0.01)
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--end-size-m", type=float, default=0.0025, help="element size at the patch's ends")
    parser.add_argument("--surface-size-m", type=float, default=0.005, help="element size at the free surface")
    options = parser.parse_args()
    failed = 0
    for law, (name, contact, direction) in [("Mooney-Rivlin", push) for push in PUSHES] + [("Ogden", PUSHES[0])]:
        name = f"{law}, {name}"
        with tempfile.TemporaryDirectory() as work:
            msh = mesh_of_patch(contact, options, work)
            try:
                t0 = time.perf_counter()
                ours = freefem_force(law, msh, contact, direction, options.depth_m, options.steps, work)
                t1 = time.perf_counter()
                for element, fields in (("Q2/Q1", fields_on_quads), ("P2/P1", fields_on_triangles)):
                    t2 = time.perf_counter()
                    theirs = felupe_force(law, fields, msh, contact, direction, options.depth_m, options.steps)
                    t3 = time.perf_counter()
                    difference = np.linalg.norm(ours - theirs) / np.linalg.norm(theirs)
                    sentence = f"{name}, {1e3 * options.depth_m:g} mm: felupe {element} has the same contact force"
                    forces = (f"FreeFEM ({1e3 * ours[0]:.4f}, {1e3 * ours[1]:.4f}) mN in {t1 - t0:.2f} s, felupe "
                              f"({1e3 * theirs[0]:.4f}, {1e3 * theirs[1]:.4f}) mN in {t3 - t2:.2f} s")
                    if fields is fields_on_quads:
                        print(f"# {name}: felupe {element} differs by {difference:.1e}: {forces}")
                    elif difference <= FORCE_TOLERANCE:
                        print(f"ok - {sentence}, relative difference {difference:.1e}: {forces}")
                    else:
                        print(f"not ok - {sentence}: {difference:.1e} vs {FORCE_TOLERANCE}: {forces}")
                        failed += 1
            except Exception as error:  # either program may fail on a mesh: report it and continue
                print(f"not ok - {name}: {error} vs two forces")
                failed += 1
    for name, contact, rows, density in histories():
        with tempfile.TemporaryDirectory() as work:
            try:
                msh = mesh_of_patch(contact, options, work)
                ours = freefem_history(msh, contact, rows, density, work)
                theirs = felupe_history(fields_on_triangles, msh, contact, rows, density)
                largest = np.linalg.norm(theirs, axis=1).max()
                difference = np.linalg.norm(ours - theirs, axis=1).max() / largest
                sentence = f"relaxing, {name}, {len(rows) - 1} steps: felupe P2/P1 has the same contact force at each step"
                if difference <= HISTORY_TOLERANCE:
                    print(f"ok - {sentence}, largest difference {difference:.1e} of {1e3 * largest:.4f} mN; it ends at "
                          f"{1e3 * np.linalg.norm(ours[-1]):.4f} and {1e3 * np.linalg.norm(theirs[-1]):.4f} mN")
                else:
                    print(f"not ok - {sentence}: {difference:.1e} vs {HISTORY_TOLERANCE}")
                    failed += 1
            except Exception as error:
                print(f"not ok - relaxing, {name}: {error} vs two histories")
                failed += 1
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
