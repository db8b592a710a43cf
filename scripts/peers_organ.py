"""Compares a study's model with other programs on the same solid, in one run: peers_organ.py STUDY OUT.md

Models: the energy model; on its lattice Van Gelder's springs and springs of one stiffness (as `tissuectl eval` has
them); on the tetrahedra that fill the study's shape neo-Hookean elements by felupe and Saint Venant-Kirchhoff elements
by MuJoCo. Forces of the tetrahedra are reported unscaled, and scaled by one factor that is fitted to the first
validation contacts. Needs results/STUDY with its evaluation, build/release/python and build/venv (scripts/venv). A
missing peer is left out, and the page names it. A study with an elastic bed, a nodule or regions is refused: the peers
get one material, and fixed nodes."""
import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "figures"), "build/release/python"]
import numpy as np  # noqa: E402
import tissue  # noqa: E402
from peers_study import SECONDS, ask, off, quantiles, spread, ticks_of  # noqa: E402
from one_line import read_json  # noqa: E402
from results import COLOURS, EVALUATION  # noqa: E402
from save import save, written  # noqa: E402
from stored import stored  # noqa: E402

FITTED = 6  # number of validation contacts that a peer's factor is fitted to


class Organ:
    """The solid for the peers: its own nodes, tetrahedra, facets, fixed nodes; and contacts with their FE reference."""

    def __init__(self, folder):
        for file in ("model.h5", "cases.h5", "eval.json", "plan.mk"):
            if not Path(folder, file).is_file():
                sys.exit(f"peers_organ.py: {folder} has no {file}: run make eval STUDY={Path(folder).name}")
        plan = Path(folder, "plan.mk").read_text()
        for argument, what in (("-beds", "an elastic bed"), ("-nodule_radius", "a nodule"), ("-regions", "regions")):
            if f" {argument} " in plan:
                sys.exit(f"peers_organ.py: {folder}: has {what}, and the other programs get one material and fixed nodes")
        with stored(f"{folder}/cases.h5") as f:
            if "shape/tetrahedra" not in f:
                sys.exit(f"peers_organ.py: {folder}/cases.h5 has no solid shape")
        with stored(f"{folder}/model.h5") as f:
            own = len(f["mesh/lattice/corner"])
            self.nodes, self.tetrahedra, self.facets = f["mesh/nodes"][:own], f["mesh/tetrahedra"][()], f["mesh/facets"][()]
            self.held = f["mesh/fixed"][()]
        self.seen = np.setdiff1d(self.facets, self.held)
        self.free = self.facets[~np.isin(self.facets, self.held).all(axis=1)]
        across = np.cross(*(self.nodes[self.free[:, k]] - self.nodes[self.free[:, 0]] for k in (1, 2)))
        self.normals = np.zeros_like(self.nodes)  # area-weighted
        for k in range(3):
            np.add.at(self.normals, self.free[:, k], across)
        paths = tissue.read_cases(f"{folder}/cases.h5")
        self.lost = sum(1 for p in paths if p["lost"] and p["role"] == "held_out")
        self.paths = [p for p in paths if not p["lost"]]
        for role in ("validation", "held_out"):
            if not any(p["role"] == role for p in self.paths):
                sys.exit(f"peers_organ.py: {folder}: no contact of draws.{role} has an FE reference")

    def of(self, role):
        """Contacts, displacements of the tool, outward unit normals, FE forces, and FE displacements of the free
        surface nodes."""
        paths = [p for p in self.paths if p["role"] == role]
        contacts = np.array([p["contact_m"] for p in paths])
        return (contacts, np.array([p["direction"] * p["magnitude_m"][-1] for p in paths]), np.array([self.outward(c) for c in contacts]),
                np.array([p["force_N"][-1] for p in paths]), np.array([p["displacement_m"][-1][self.seen] for p in paths]))

    def outward(self, contact):
        """Outward unit normal at a contact: of the nodes of the nearest free facet, by barycentric weights."""
        a, b, c = (self.nodes[self.free[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        weight = np.stack([np.einsum("ij,ij->i", np.cross(q - contact, r - contact), across) for q, r in ((b, c), (c, a), (a, b))], axis=1)
        weight = np.clip(weight / np.einsum("ij,ij->i", across, across)[:, None], 0, None)
        weight /= weight.sum(axis=1, keepdims=True)
        nearest = np.argmin(np.linalg.norm(np.einsum("ik,kij->ij", weight, np.array([a, b, c])) - contact, axis=1))
        normal = weight[nearest] @ self.normals[self.free[nearest]]
        return normal / np.linalg.norm(normal)

    def under_disc(self, contact, outward, radius):
        """Number of surface nodes under the disc, which the felupe peer prescribes."""
        away = np.linalg.norm(self.nodes[self.seen] - contact, axis=1)[self.normals[self.seen] @ outward > 0]
        return max(1, int((away <= radius).sum()))

    def question(self, model, role, count=None):
        contacts, pushes, outward = (x[:count] for x in self.of(role)[:3])
        return {"nodes": self.nodes.tolist(), "tetrahedra": self.tetrahedra.tolist(), "held": self.held.tolist(), "surface": self.seen.tolist(), "normals": self.normals[self.seen].tolist(),
                "modulus_Pa": model.modulus, "radius_m": model.disc_radius_m, "mass_kg": float(model.node_mass_kg.sum()), "seconds": SECONDS,
                "outward": outward.tolist(), "pushes": [[c.tolist(), p.tolist()] for c, p in zip(contacts, pushes)]}


def factor(answers, truth):
    """Factor that minimises the mean square error of the answers relative to the FE reference."""
    there = [(np.array(a) / np.linalg.norm(t), t / np.linalg.norm(t)) for a, t in zip(answers, truth) if a is not None and np.isfinite(a).all()]
    return sum(a @ t for a, t in there) / sum(a @ a for a, t in there) if there else np.nan


def ours(model, organ):
    """Rows of the energy model: a tick, and an indentation to rest."""
    contacts, pushes, outward, force, shape = organ.of("held_out")
    ticks, in_motion = ticks_of(model, contacts, pushes, outward)
    presses, seconds = [], []
    for c, p in zip(contacts, pushes):
        begin = time.perf_counter()
        presses.append(model.press([c], [p], threads=1))
        seconds.append(1e6 * (time.perf_counter() - begin))
    shapes = off([u[0][organ.seen] for _, u, _ in presses], shape)
    return [(f"**a tick of the energy model**; its force after {SECONDS} s, not completely at rest", f"tissuectl {tissue.__version__}", ticks, off(in_motion, force), None, None),
            ("**an indentation of the energy model, to rest**", f"tissuectl {tissue.__version__}", seconds, off([f[0] for f, _, _ in presses], force), None, shapes)]


def peer(name, script, time_key, model, organ):
    """A peer's row; None if the peer is missing."""
    fitted, answer = ask(script, organ.question(model, "validation", FITTED)), ask(script, organ.question(model, "held_out"))
    if not fitted or not answer:
        return None
    force, shape = organ.of("held_out")[3:]
    by = factor(fitted["force_N"], organ.of("validation")[3])
    scaled = [None if f is None else by * np.array(f) for f in answer["force_N"]]
    shapes = [None if u is None else np.array(u)[organ.seen] for u in answer["displacement_m"]]
    return (name, answer["version"], answer[time_key], off(answer["force_N"], force), (by, off(scaled, force)), off(shapes, shape))


def baselines(evaluation):
    """Rows of the baselines of `tissuectl eval`: errors of force and displacement in per cent."""
    named = {"untrained": "the energy model before training", "heuristic_a_patch": "Van Gelder's springs on the same lattice", "uniform_patch": "springs of one stiffness, best at the training contacts"}
    held_out = evaluation["drawn"]["held_out"]
    percent = lambda value: np.inf if value is None else 100 * value  # noqa: E731
    return [(words, f"tissuectl {tissue.__version__}", None, np.array([percent(c["error"][key]) for c in held_out]), None,
             np.array([percent(c["shape"][key]) for c in held_out])) for key, words in named.items()]


def draw(rows, study, out):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 5), layout="constrained", sharey=True)
    colours = iter(COLOURS[name] for name in ("learned", "heuristic_b", "optimum", "untrained", "heuristic_a", "uniform"))  # Okabe and Ito's
    for name, _, _, force, scaled, shape in rows:
        if shape is None:  # a tick has no displacement at rest
            continue
        colour = next(colours)
        label, wide = name.replace("*", ""), 2.6 if name.startswith("**") else 1.4
        for axis, errors, line in ((left, force, "-"), (left, scaled[1] if scaled else None, "--"), (right, shape, "-")):
            if errors is None:
                continue
            x = np.sort(errors)
            axis.step(np.clip(x, 0.5, 1e3), np.arange(1, len(x) + 1) / len(x), line, where="post", linewidth=wide, label=label if line == "-" else f"{label}, times {scaled[0]:.2f}",
                      color=colour)
    for axis, what in ((left, "force"), (right, "displacement of the free surface")):
        axis.set_xscale("log")
        axis.set_xlim(0.5, 200)
        axis.set_xlabel(f"indentation error of {what} (%)")
        axis.grid(alpha=0.3)
    left.set_ylabel("part of the test contacts with at most this error (1)")
    figure.legend(*left.get_legend_handles_labels(), frameon=False, fontsize=8, ncols=2, loc="lower center")
    figure.get_layout_engine().set(rect=(0, 0.2, 1, 0.8))  # space for the legend
    figure.suptitle(f"Study {study}: indentation errors at {len(rows[0][3])} contacts of the test set")
    save(figure, out)


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: peers_organ.py STUDY OUT.md")
    study, out = sys.argv[1], Path(sys.argv[2])
    folder = f"results/{study}"
    model, organ, evaluation = tissue.Model(f"{folder}/model.h5"), Organ(folder), read_json(f"{folder}/eval.json", EVALUATION)
    peers = {"felupe": peer("neo-Hookean tetrahedra, felupe, to rest", "peer_felupe_tetrahedra.py", "press_us", model, organ),
             "MuJoCo": peer("Saint Venant-Kirchhoff tetrahedra, a step of MuJoCo's flex", "peer_mujoco.py", "step_us", model, organ)}
    rows = ours(model, organ) + [row for row in peers.values() if row] + baselines(evaluation)
    table = "\n".join(f"| {name} | {version} | {spread(us) if us else ''} | {quantiles(force)} | {f'{quantiles(scaled[1])}, times {scaled[0]:.2f}' if scaled else ''} | "
                      f"{quantiles(shape) if shape is not None else ''} |" for name, version, us, force, scaled, shape in rows)
    missing = [name for name, row in peers.items() if not row]
    training = evaluation["training"]
    contacts, _, outward = organ.of("held_out")[:3]
    under = [organ.under_disc(c, n, model.disc_radius_m) for c, n in zip(contacts, outward)]
    text = f"""# `{study}` compared with other models

Written by `make peers STUDY={study}`. The {len(contacts)} test contacts with an FE reference ({organ.lost} have none), the same tool displacements, in one run. Ratios of times are comparable between machines, microseconds are not. Errors of force and of the
free surface's displacement are relative to FE, in per cent: median / p95 (n of N). The energy model has a lattice of {len(model.nodes) - len(organ.nodes)} nodes, trained in {training["seconds"]:.0f} s on {training["paths"]} paths of finite
elements. The tetrahedra are the {len(organ.tetrahedra)} that fill the shape, with {len(organ.nodes)} nodes and without training. They have the same Young's modulus and Poisson's ratio 0.45; nearer to 1/2 they lock. Their forces are
given unscaled, and scaled by one factor that is fitted to the first {FITTED} validation contacts.

| | version | us | force, % | force times a factor, % | displacement, % |
|---|---|---|---|---|---|
{table}

![Errors of force and of displacement]({out.with_suffix(".png").name})

felupe displaces the surface nodes under the disc, {np.median(under):.0f} in the median and {min(under)} to {max(under)}; MuJoCo all nodes of the facets that a rigid disc touches, which may slip along it (`scripts/peers.md`).
{"Not in this run: " + ", ".join(missing) + "." if missing else ""}
"""
    print(text)
    draw(rows, study, out.with_suffix(".png"))
    with written(out) as beside:
        Path(beside).write_text(text)


if __name__ == "__main__":
    main()
