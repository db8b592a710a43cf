"""Our block in space beside other programs on the same lattice, in one run: peers_study.py STUDY OUT.md

A tick and a press of the study's law, MuJoCo's flex stepping under the same pushes, felupe solving them: what each takes, and how far its force is
from finite elements' of the study at its first held-out contacts. Needs results/STUDY/{model,cases}.h5, build/release/python and build/venv
(scripts/venv); a peer that is not there is left out, and the page says so."""
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

HELD_OUT = 12    # contacts; MuJoCo takes seconds for each
SECONDS = 1      # of each press, ours and MuJoCo's
VENV = Path("build/venv/bin/python")


def spread(values, form="{:.3g}"):
    return f"{form.format(np.median(values))} / {form.format(np.quantile(values, 0.95))} ({len(values)})"


def ask(script, question):
    """What a peer prints; None where it is not there."""
    if not VENV.exists():
        return None
    with tempfile.TemporaryDirectory() as folder:   # some leave a log where they run
        done = subprocess.run([VENV.absolute(), Path(f"tests/bench/{script}").absolute()], input=json.dumps(question), capture_output=True, text=True, cwd=folder,
                              env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"})
    if done.returncode != 0:
        print(f"peers: no answer of {script}: {(done.stderr.strip().splitlines() or ['nothing said'])[-1]}", file=sys.stderr)
        return None
    return json.loads(done.stdout.strip().splitlines()[-1])


def held_out(folder):
    """Contacts, pushes and FE's forces of the first that FE solved; and how many before the last of them FE lost."""
    drawn = [p for p in tissue.read_cases(f"{folder}/cases.h5") if p["role"] == "held_out"]
    solved = [k for k, p in enumerate(drawn) if not p["lost"]][:HELD_OUT]
    if not solved:
        sys.exit(f"peers_study.py: {folder}: finite elements solved no contact of draws.held_out")
    paths = [drawn[k] for k in solved]
    return (np.array([p["contact_m"] for p in paths]), np.array([p["direction"] * p["magnitude_m"][-1] for p in paths]),
            np.array([p["force_N"][-1] for p in paths]), solved[-1] + 1 - len(solved))


def ticks_of(model, contacts, pushes, outward):
    """Microseconds of each tick along the same ways, one by one as the peers' steps are, and the force that a session ends with on the tissue."""
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
    """Relative errors in per cent, of vectors or of fields; without an answer infinite."""
    return np.array([np.inf if a is None or not np.isfinite(a).all() else 100 * np.linalg.norm(np.array(a) - t) / np.linalg.norm(t) for a, t in zip(answers, truth)])


def quantiles(errors):
    """Median / p95 (n of N), as `tissuectl eval` has them; what has no answer counts as infinite."""
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
    own = model.nodes[model.node_mass_kg == 0]  # not the lattice's
    size, counts = own.max(axis=0), [len(np.unique(np.round(own[:, axis], 9))) for axis in range(3)]
    if np.prod(counts) != len(own):
        sys.exit(f"peers_study.py: {study}: is no block")
    if len(own) != np.count_nonzero(model.node_mass_kg):
        sys.exit(f"peers_study.py: {study}: its springs are not as far apart as its lattice.cells, which peers get")
    question = {"size_m": size.tolist(), "counts": counts, "modulus_Pa": model.modulus, "shear_Pa": model.modulus / 3, "radius_m": model.disc_radius_m,
                "mass_kg": float(model.node_mass_kg.sum()), "pushes": [[c.tolist(), p.tolist()] for c, p in zip(contacts, pushes)], "seconds": SECONDS}

    ticks, in_motion = ticks_of(model, contacts, pushes, np.tile([0, 0, 1], (len(contacts), 1)))
    presses = []
    for c, p in zip(contacts, pushes):
        begin = time.perf_counter()
        force, _, _ = model.press([c], [p], threads=1)
        presses.append((1e6 * (time.perf_counter() - begin), force[0]))
    rows = [("**a tick of the law**", f"tissuectl {tissue.__version__}", ticks, 1, off(in_motion, truth), "1 ms; its steps within, safety and contact search included")]
    mujoco, felupe = ask("peer_mujoco.py", question), ask("peer_felupe_block.py", question)
    if mujoco:
        rows.append(("a step of MuJoCo's flex", f"mujoco {mujoco['version']}", mujoco["step_us"], ticks, off(mujoco["force_N"], truth),
                     "1 ms, integrator `discrete`; Saint Venant-Kirchhoff tetrahedra, Poisson's ratio 0.45; a rigid disc that presses all nodes of the facets it touches"))
    times = [t for t, _ in presses]
    rows.append(("**a press of the law, to rest**", f"tissuectl {tissue.__version__}", times, 1, off([f for _, f in presses], truth), "Newton with load steps, one core"))
    if felupe:
        rows.append(("a press by felupe", f"felupe {felupe['version']}", felupe["press_us"], times, off(felupe["force_N"], truth),
                     "neo-Hooke, a hexahedron a box, three fields, four load steps, one core; the disc is the nodes under it"))
    table = "\n".join(f"| {name} | {version} | {spread(t)} | {'' if beside == 1 else f'{np.median(t) / np.median(beside):.3g}'} | {quantiles(e)} | {differs} |"
                      for name, version, t, beside, e, differs in rows)
    missing = [name for name, answer in (("MuJoCo", mujoco), ("felupe", felupe)) if not answer]
    text = f"""# Beside other programs

Written by `make peers`. The lattice of `{study}`, {' x '.join(map(str, counts))} nodes, the first {len(truth)} held-out contacts that finite elements solved (they lost {lost} before the last of these), the same pushes; all in one
run, so that ratios mean something and microseconds little. Time: median / p95 (n), each tick and step by itself. Ratio: of medians, over the row of ours above. Error: |force - FE| / |FE|
in per cent, median / p95 (n of N), FE being the study's own, on meshes that are finest at the disc (3 mm). None of the others was made to be right on springs of
1 cm: what they show is what a lattice of this size is without having learned.

| | version | us | ratio | error of force, % | what differs |
|---|---|---|---|---|---|
{table}

{"Not there in this run: " + ", ".join(missing) + ". " if missing else ""}CHAI3D's GEL and SOFA are not among the packages that we install (Debian's and PyPI's; conda-forge has SOFA) and were not run; `scripts/peers.md` says what a fair run of them would take.
"""
    print(text)
    with written(out) as beside:
        Path(beside).write_text(text)
    write_peers(Path(out))


if __name__ == "__main__":
    main()
