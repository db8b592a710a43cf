"""Writes a CSV of synthetic force measurements, from FE results with seeded noise.

    scripts/make_pokes.py results/patient-lump/cases.h5 held_out_full pokes.csv --seed 1

One measurement for each contact of the role, at the largest depth of its load path, in an order drawn with the seed.
Columns as for measured contacts (results/FORMATS.md).
"""
import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "figures"))
from one_line import say  # noqa: E402
from save import written  # noqa: E402
from stored import stored  # noqa: E402


def pokes(cases, role):
    """(contact, displacement, force) of each contact of the role that has an FE reference."""
    for name in cases["path_names"].asstr():
        path = cases["paths"][name]
        its_role, lost = path["role"].asstr()[:]
        if its_role == role and not lost:
            yield path["contact"][:], path["direction"][:] * path["magnitude"][-1], path["contact_force"][-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("cases")
    parser.add_argument("role")
    parser.add_argument("out")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--noise", type=float, default=0.02, help="standard deviation of a component of force, over the force (default 0.02)")
    parser.add_argument("--outliers", type=float, default=0, help="part of the measurements whose force is ten times too large (default 0)")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    with stored(options.cases) as cases:
        rows = list(pokes(cases, options.role))
    if not rows:
        say(options.cases, f"has no path of role {options.role}")
    axes = "xyz"[:len(rows[0][0])]
    columns = [f"{what}_{a} [{unit}]" for what, unit in (("contact", "mm"), ("displacement", "mm"), ("force", "mN")) for a in axes]
    lines = [f"# NOT A MEASUREMENT: finite elements, with Gaussian noise of {100 * options.noise:g} % of the force on each component,",
             f"# {100 * options.outliers:g} % of outliers, seed {options.seed}. Written by scripts/make_pokes.py.", ",".join(columns)]
    for i in rng.permutation(len(rows)):
        contact, push, force = rows[i]
        force = force + options.noise * np.linalg.norm(force) * rng.standard_normal(len(force))
        if rng.random() < options.outliers:
            force = 10 * force
        lines.append(",".join([f"{1e3 * v:.4f}" for v in (*contact, *push)] + [f"{1e3 * v:.2f}" for v in force]))
    with written(options.out) as beside:
        Path(beside).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
