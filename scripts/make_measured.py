"""Writes a CSV of synthetic measurements of contact force, from FE results with seeded noise.

    scripts/make_measured.py results/surface-measured/cases.h5 fem/data/block_measured.csv

Training set: contacts every 5 mm along the surface, at -40, 0 and 40 degrees to the inward normal, 2.5, 5 and 10 mm
deep. Validation and test sets: the study's drawn contacts at other places that keep 2 mm from the training contacts, up
to 40 degrees and 10 mm. Every measurement is repeated three times. Noise: Gaussian, on each component of force 2 % of
the force, of displacement 0.05 mm.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "figures"))
from save import written  # noqa: E402
from stored import stored  # noqa: E402

SEED, REPEATS, FORCE_NOISE, DISPLACEMENT_NOISE_M = 20261121, 3, 0.02, 0.05e-3
SPACING_M, APART_M, ANGLES_DEG, DEPTHS_M, DEEPEST_M = 5e-3, 2e-3, (-40, 0, 40), (2.5e-3, 5e-3, 10e-3), 10e-3
ROLES = {"train": "train", "validation": "validation", "held_out_full": "validation", "held_out": "held_out"}
WIDTH_M = HEIGHT_M = 0.1


def arc_of(contact):
    """Arc length along the surface, counter-clockwise from the bottom right corner, and the inward normals there."""
    x, y = contact
    tiny, normals = 1e-9, []
    if abs(x - WIDTH_M) < tiny:
        arc = y
        normals.append((-1, 0))
    if abs(y - HEIGHT_M) < tiny:
        arc = HEIGHT_M + WIDTH_M - x
        normals.append((0, -1))
    if abs(x) < tiny:
        arc = 2 * HEIGHT_M + WIDTH_M - y
        normals.append((1, 0))
    return arc, normals


def angles(direction, normals):
    return [np.degrees(np.arctan2(n[0] * direction[1] - n[1] * direction[0], np.dot(n, direction))) for n in normals]


def presses(cases):
    """(role, contact, displacement, force) of each measurement, without noise."""
    for name in cases["path_names"].asstr():
        path = cases["paths"][name]
        role, lost = path["role"].asstr()[:]
        contact, direction = path["contact"][:], path["direction"][:]
        arc, normals = arc_of(contact)
        off_grid = abs(arc / SPACING_M - round(arc / SPACING_M)) * SPACING_M
        off_normal = angles(direction, normals)
        if role == "train":
            wanted = any(abs(a - b) < 1e-3 for a in off_normal for b in ANGLES_DEG)
            depths = DEPTHS_M if off_grid < 1e-6 and wanted else ()
        else:
            deepest = path["depth"][0]
            depths = (deepest,) if role in ROLES and not lost and off_grid >= APART_M \
                and deepest <= DEEPEST_M and min(map(abs, off_normal)) <= max(ANGLES_DEG) else ()
        for depth in depths:
            record = np.flatnonzero(np.abs(path["magnitude"][:] - depth) < 1e-9)
            if len(record):  # the FE path may have ended before this depth
                yield ROLES[role], contact, direction * depth, path["contact_force"][record[0]]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    rng = np.random.default_rng(SEED)
    lines = ["# NOT A MEASUREMENT: finite elements of study `surface-measured` (plane strain, a block of 0.1 m a side,",
             "# a patch 10 mm wide), with Gaussian noise of 2 % of the force on each component of force and 0.05 mm on",
             f"# each of displacement, seed {SEED}. Written by scripts/make_measured.py.",
             "contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [mN],push,repeat,"
             "role"]
    with stored(sys.argv[1]) as cases:
        pressed = list(presses(cases))
    for push, (role, contact, displacement, force) in enumerate(pressed, 1):
        for repeat in range(1, REPEATS + 1):
            u = displacement + DISPLACEMENT_NOISE_M * rng.standard_normal(2)
            f = force + FORCE_NOISE * np.linalg.norm(force) * rng.standard_normal(2)
            numbers = [f"{v:.3f}" for v in (*contact * 1e3, *u * 1e3)] + [f"{v:.1f}" for v in f * 1e3]
            lines.append(",".join(numbers + [str(push), str(repeat), role]))
    with written(sys.argv[2]) as beside:
        Path(beside).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
