"""Compares a study's block in space with other programs on the same lattice, in one run: peers_study.py STUDY OUT.md

Measures a tick and an indentation to rest of the study's energy model, MuJoCo's flex in time steps under the same tool
displacements, and felupe's solutions for them: the time of each, and the error of its force against FE at the study's
first test contacts. Needs results/STUDY/{model,cases}.h5, build/release/python and build/venv (scripts/venv). A missing
peer is left out, and the page names it."""
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "figures"), "build/release/python"]
import numpy as np  # noqa: E402
import tissue  # noqa: E402
from reference import write_peers  # noqa: E402
from save import written  # noqa: E402

HELD_OUT = 12    # test contacts; MuJoCo takes seconds for each
SECONDS = 1      # simulated time of each indentation in motion
VENV = Path("build/venv/bin/python")


def spread(values, form="{:.3g}"):
    return f"{form.format(np.median(values))} / {form.format(np.quantile(values, 0.95))} ({len(values)})"


def ask(script, question):
    """The output of a peer; None if the peer is missing or fails."""
    if not VENV.exists():
        return None
    with tempfile.TemporaryDirectory() as folder:   # some peers write a log to their working directory
        done = subprocess.run([VENV.absolute(), Path(f"tests/bench/{script}").absolute()], input=json.dumps(question), capture_output=True, text=True, cwd=folder,
                              env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"})
    if done.returncode != 0:
        print(f"peers: no answer of {script}: {(done.stderr.strip().splitlines() or ['no message'])[-1]}", file=sys.stderr)
        return None
    return json.loads(done.stdout.strip().splitlines()[-1])


def held_out(folder):
    """Contacts, tool displacements and FE forces of the first contacts with an FE reference; and how many before the
    last of them have none."""
    drawn = [p for p in tissue.read_cases(f"{folder}/cases.h5") if p["role"] == "held_out"]
    solved = [k for k, p in enumerate(drawn) if not p["lost"]][:HELD_OUT]
    if not solved:
        sys.exit(f"peers_study.py: {folder}: no contact of draws.held_out has an FE reference")
    paths = [drawn[k] for k in solved]
    return (np.array([p["contact_m"] for p in paths]), np.array([p["direction"] * p["magnitude_m"][-1] for p in paths]),
            np.array([p["force_N"][-1] for p in paths]), solved[-1] + 1 - len(solved))


def ticks_of(model, contacts, pushes, outward):
    """Microseconds of each tick along the same trajectories, measured one by one as the peers' steps are; and the force
    on the tissue at the end of each session."""
    times, forces = [], []
    for contact, push, out in zip(contacts, pushes, outward):
        session = tissue.Simulation(model, force_max=100, slew=1e6)
        t = np.arange(round(SECONDS / 1e-3)) * 1e-3
        way = np.minimum(1, t / 0.15)[:, None]
        positions = contact + way * push + (1 - way) * 5e-4 * out
        for k in range(len(positions)):
            begin_ns = time.perf_counter_ns()
            session.ticks(positions[k:k + 1])
            times.append(1e-3 * (time.perf_counter_ns() - begin_ns))
        forces.append(session.contact["force_N"])
    return times, np.array(forces)


def off(answers, truth):
    """Relative errors in per cent, of vectors or of fields; infinite without an answer."""
    return np.array([np.inf if a is None or not np.isfinite(a).all() else 100 * np.linalg.norm(np.array(a) - t) / np.linalg.norm(t) for a, t in zip(answers, truth)])


def quantiles(errors):
    """Median / p95 (n of N), as `tissuectl eval` has them. A missing answer counts as infinite."""
    there, n = np.sort(errors), len(errors)
    words = []
    for place in (0.5 * (n - 1), 0.95 * (n - 1)):
        low, high = there[int(np.floor(place))], there[int(np.ceil(place))]
        words.append(f"{low + (place % 1) * (high - low):.3g}" if np.isfinite(high) else "none")
    return " / ".join(words) + f" ({np.isfinite(errors).sum()} of {n})"


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: peers_study.py STUDY OUT.md")
    study, out = sys.argv[1:]
    model = tissue.Model(f"results/{study}/model.h5")
    contacts, pushes, truth, lost = held_out(f"results/{study}")
    own = model.nodes[model.node_mass_kg == 0]  # without the lattice's nodes
    size, counts = own.max(axis=0), [len(np.unique(np.round(own[:, axis], 9))) for axis in range(3)]
    if np.prod(counts) != len(own):
        sys.exit(f"peers_study.py: {study}: is not a block")
    if len(own) != np.count_nonzero(model.node_mass_kg):
        sys.exit(f"peers_study.py: {study}: the spacing of its springs differs from that of lattice.cells, which the other programs get")
    question = {"size_m": size.tolist(), "counts": counts, "modulus_Pa": model.modulus, "shear_Pa": model.modulus / 3, "radius_m": model.disc_radius_m,
                "mass_kg": float(model.node_mass_kg.sum()), "pushes": [[c.tolist(), p.tolist()] for c, p in zip(contacts, pushes)], "seconds": SECONDS}

    ticks, in_motion = ticks_of(model, contacts, pushes, np.tile([0, 0, 1], (len(contacts), 1)))
    presses = []
    for c, p in zip(contacts, pushes):
        begin = time.perf_counter()
        force, _, _ = model.press([c], [p], threads=1)
        presses.append((1e6 * (time.perf_counter() - begin), force[0]))
    rows = [("**a tick of the energy model**", f"tissuectl {tissue.__version__}", ticks, 1, off(in_motion, truth), "1 ms; including its substeps, safety and contact search")]
    mujoco, felupe = ask("peer_mujoco.py", question), ask("peer_felupe_block.py", question)
    if mujoco:
        rows.append(("a step of MuJoCo's flex", f"mujoco {mujoco['version']}", mujoco["step_us"], ticks, off(mujoco["force_N"], truth),
                     "1 ms, integrator `discrete`; Saint Venant-Kirchhoff tetrahedra, Poisson's ratio 0.45; a rigid disc that displaces all nodes of the facets that it touches"))
    times = [t for t, _ in presses]
    rows.append(("**an indentation of the energy model, to rest**", f"tissuectl {tissue.__version__}", times, 1, off([f for _, f in presses], truth), "Newton with load steps, one core"))
    if felupe:
        rows.append(("an indentation by felupe", f"felupe {felupe['version']}", felupe["press_us"], times, off(felupe["force_N"], truth),
                     "neo-Hooke, one hexahedron per box, three fields, four load steps, one core; the disc is the nodes under it"))
    table = "\n".join(f"| {name} | {version} | {spread(t)} | {'' if beside == 1 else f'{np.median(t) / np.median(beside):.3g}'} | {quantiles(e)} | {differs} |"
                      for name, version, t, beside, e, differs in rows)
    missing = [name for name, answer in (("MuJoCo", mujoco), ("felupe", felupe)) if not answer]
    text = f"""# Comparison with other programs

Written by `make peers`. The lattice of `{study}`, {' x '.join(map(str, counts))} nodes, the first {len(truth)} test contacts with an FE reference ({lost} before the last of these have none), the same tool displacements; all in one
run. Ratios are comparable between machines, microseconds are not. Time: median / p95 (n), of each tick or step. Ratio: median over the median of tissuectl's row above. Error: |force - FE| / |FE|
in per cent, median / p95 (n of N), of the study's own FE, on meshes that are finest at the disc (3 mm). The other programs are not made
for a lattice of 1 cm; their rows show the error of such a lattice without training.

| | version | us | ratio | error of force, % | what differs |
|---|---|---|---|---|---|
{table}

{"Not in this run: " + ", ".join(missing) + ". " if missing else ""}CHAI3D's GEL and SOFA are not in Debian or PyPI (conda-forge has SOFA) and were not run; `scripts/peers.md` states what a fair run of them would need.
"""
    print(text)
    with written(out) as beside:
        Path(beside).write_text(text)
    write_peers(Path(out))


if __name__ == "__main__":
    main()
