#!/usr/bin/env python3
"""Limits of the FE reference: force against depth of one patch contact, for several angles and meshes.

The reference is reliable at a depth and angle if meshes agree and no state is refused. Writes a CSV, one row per
record, with the cause in the last row of a path that ended early. Prints for each angle the depth to which the two
finest meshes that reach it agree within 2 %, and the depth at which each mesh ended.

Columns: formulation, contact_x_m, contact_y_m, angle_deg (of the displacement from the inward normal of the left wall,
positive upwards), end_size_mm (elements at the patch's ends; at the surface twice that), push_mm (displacement),
force_x_mN, force_y_mN (for a thickness of 1 mm), smallest_J, ended (empty, or why the path stopped after this record).

Sample run: python3 scripts/trust_study.py --out trust.csv
"""
import argparse
import csv
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "figures"))
from save import written  # noqa: E402

FEM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fem")
AGREEMENT = 0.02


def said_by(command):
    """A program's exit status and its error output. Ends the study if the program is missing."""
    try:
        run = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        sys.exit(f"trust_study.py: {command[0]}: {error.strerror}")
    return run.returncode, run.stderr.strip() or run.stdout.strip()


def path(work, formulation, x, y, angle, end_size, depth, records):
    """Rows (push_mm, fx_mN, fy_mN, smallest J), and the cause if the path ended early."""
    msh = os.path.join(work, "patch.msh")
    out = os.path.join(work, "path.csv")
    command = ["gmsh", "-v", "1", "-2", "-format", "msh22", os.path.join(FEM, "block_graded.geo"), "-o", msh]
    for key, value in {"contact_x": x, "contact_y": y, "patch_half_width": 0.005, "end_size": end_size,
                       "surface_size": 2 * end_size}.items():
        command += ["-setnumber", key, str(value)]
    status, said = said_by(command)
    if status != 0:
        sys.exit(f"trust_study.py: gmsh: exit status {status}: {(said.splitlines() or ['nothing said'])[-1]}")
    a = math.radians(angle)
    arguments = {"mesh": msh, "out": out, "width": 0.1, "height": 0.1, "thickness": 0.001, "C1": 263, "C2": 491,
                 "cells_x": 10, "cells_y": 10, "contact_x": x, "contact_y": y, "direction_x": repr(math.cos(a)),
                 "direction_y": repr(math.sin(a)), "depth": depth, "records": records, "tolerance": 1e-9,
                 "max_newton": 12, "formulation": formulation, "indenter": "patch"}
    command = ["FreeFem++-nw", "-nw", "-v", "0", os.path.join(FEM, "solve_path.edp")]
    for key, value in arguments.items():
        command += ["-" + key, str(value)]
    status, said = said_by(command)
    rows = []
    for line in open(out) if os.path.exists(out) else ():
        w = line.split(",")
        if w[0] == "step":
            rows.append((1e3 * float(w[2]), 1e3 * float(w[4]), 1e3 * float(w[5]), float(w[8])))
    if not rows:
        sys.exit(f"trust_study.py: FreeFem++-nw: no record, exit status {status}: {(said.splitlines() or ['nothing said'])[-1]}")
    return rows, "" if status == 0 else said.replace("solve_path: ", "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--contact-y-m", type=float, default=0.05, help="on the left wall")
    parser.add_argument("--angles-deg", type=float, nargs="+", default=[-45, -30, -20, -10, 0, 10, 20, 30, 45])
    parser.add_argument("--end-sizes-mm", type=float, nargs="+", default=[5, 2.5, 1.25, 0.625])
    parser.add_argument("--formulations", nargs="+", default=["plane-stress", "plane-strain"])
    parser.add_argument("--depth-mm", type=float, default=20)
    parser.add_argument("--records", type=int, default=40)
    options = parser.parse_args()
    with written(options.out) as beside, open(beside, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["formulation", "contact_x_m", "contact_y_m", "angle_deg", "end_size_mm", "push_mm", "force_x_mN",
                        "force_y_mN", "smallest_J", "ended"])
        for formulation in options.formulations:
            for angle in options.angles_deg:
                paths, ends = [], []
                for size in options.end_sizes_mm:
                    with tempfile.TemporaryDirectory() as work:
                        rows, reason = path(work, formulation, 0, options.contact_y_m, angle, 1e-3 * size,
                                            1e-3 * options.depth_mm, options.records)
                    paths.append(rows)
                    ends.append((size, rows[-1][0], reason))
                    for k, row in enumerate(rows):
                        table.writerow([formulation, 0, options.contact_y_m, angle, size, *(repr(v) for v in row),
                                        reason if k + 1 == len(rows) else ""])
                agreed = 0.0
                for k in range(1, options.records + 1):
                    there = [p[k] for p in paths if len(p) > k]
                    if len(there) < 2 or len(paths[-1]) <= k:
                        break
                    a, b = there[-2], there[-1]
                    if math.hypot(a[1] - b[1], a[2] - b[2]) > AGREEMENT * math.hypot(b[1], b[2]):
                        break
                    agreed = b[0]
                print(f"{formulation}, {angle:g} degrees: the two finest meshes agree within {100 * AGREEMENT:g} % to "
                      f"{agreed:.1f} mm; ended: " + "; ".join(
                          f"{size:g} mm elements at {end:.1f} mm" + (f" ({why[:60]}...)" if why else " (whole path)")
                          for size, end, why in ends), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
