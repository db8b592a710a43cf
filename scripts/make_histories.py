"""Writes a CSV of synthetic measurements along displacement histories, from FE results with seeded noise.

    scripts/make_histories.py results/relax/cases.h5 fem/data/block_histories.csv

From study `relax`: two ramps and one random indentation to fit the Prony series to, and the next four of each kind
`ramp`, `release`, `sine` and `poke` as the test set, without those whose contacts are within 2 mm of a fitted one. 50
samples a second. Noise: Gaussian, on each component of force 2 % of the largest force of the history.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "figures"))
from save import written  # noqa: E402
from stored import stored  # noqa: E402

SEED, NOISE, RATE_HZ = 20261123, 0.02, 50
APART_MM = 2
TRAIN, HELD_OUT = {"ramp": 2, "poke": 1}, {"ramp": 4, "release": 4, "sine": 4, "poke": 4}


def chosen(names, kinds, lost, counts):
    """Indices of the first `counts` histories of each kind that have an FE reference."""
    of_kind = {kind: [i for i in range(len(names)) if str(kinds[i]) == kind and not lost[i]] for kind in counts}
    return [i for kind, count in counts.items() for i in of_kind[kind][:count]]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    rng = np.random.default_rng(SEED)
    lines = ["# NOT A MEASUREMENT: finite elements of study `relax` (plane strain, a block of 0.1 m a side, a patch 10 mm wide,",
             f"# branches of 0.30, 0.25, 0.20 at 0.05, 1, 10 s), {RATE_HZ} readings a second, with Gaussian noise of {100 * NOISE:g} % of a history's largest",
             f"# force on each component, seed {SEED}. Written by scripts/make_histories.py.",
             "history,kind,time [s],contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [mN],role"]
    with stored(sys.argv[1]) as cases:
        h = cases["histories"]
        names, kinds, lost = (h[key].asstr()[:] for key in ("name", "group", "lost"))
        first = h["offset"][:]
        used, alone, near = {}, [], []
        fitted = [1e3 * h["contact_place"][i] for i in chosen(names, kinds, lost, TRAIN)]
        for i, name in enumerate(names):
            kind = str(kinds[i])
            count = used.get(kind, 0)
            if lost[i] or count >= TRAIN.get(kind, 0) + HELD_OUT.get(kind, 0):
                continue
            used[kind] = count + 1
            rows = slice(first[i], first[i + 1])
            t, push, force = h["time"][rows], h["push"][rows], h["force"][rows]
            at = np.arange(0, t[-1], 1 / RATE_HZ)
            noise = NOISE * np.linalg.norm(force, axis=1).max()
            read = np.array([[np.interp(s, t, force[:, a]) for a in (0, 1)] for s in at])
            if count >= TRAIN.get(kind, 0) and min(np.hypot(*(1e3 * h["contact_place"][i] - c)) for c in fitted) < APART_MM:
                rng.standard_normal(2 * len(at))  # keeps the noise of all other histories unchanged
                near.append(str(name))
                continue
            if count >= TRAIN.get(kind, 0):
                alone.append(noise * np.sqrt(2 / np.mean(np.sum(read**2, axis=1))))
            x, y = 1e3 * h["contact_place"][i]
            for s, f in zip(at, read):
                u = [1e3 * np.interp(s, t, push[:, a]) for a in (0, 1)]
                f = [1e3 * (v + noise * rng.standard_normal()) for v in f]
                role = "train" if count < TRAIN.get(kind, 0) else "held_out"
                lines.append(f"{name},{kind},{s:.2f},{x:.3f},{y:.3f},{u[0]:.4f},{u[1]:.4f},{f[0]:.1f},{f[1]:.1f},{role}")
    if near:
        print(f"left out, within {APART_MM} mm of the training histories: {', '.join(near)}")
    print(f"noise alone, rms over time over the force's, of the test histories: median {100 * np.median(alone):.1f} %, largest {100 * max(alone):.1f} %")
    with written(sys.argv[2]) as beside:
        Path(beside).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
