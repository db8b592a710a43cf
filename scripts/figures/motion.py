"""Indentations in the running simulation until the force is constant: motion.py REALTIME.json OUT.png, from `make realtime`.

Force against time and against depth, the state at rest against the static solution, and the effect of a switch of
spring sets.
"""
import sys

import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from one_line import NUMBER_OR_NULL, of_one_length, read_json, say  # noqa: E402
from save import save  # noqa: E402

CURVE = {"time_s": [float], "force_N": [float], "depth_m": [float]}
FORM = {"study": str, "presses": [{"static_error": NUMBER_OR_NULL, "force_N": [float], "static_N": [NUMBER_OR_NULL], "curve": CURVE}],
        "switches": [{"innovation": float, "force_jump_N": float, "from": int, "to": int, "curve": CURVE}]}


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: motion.py REALTIME.json OUT.png")
    data = read_json(sys.argv[1], FORM)
    switches, study = data["switches"], data["study"]  # of spring sets; an energy model has no switches
    presses = [p for p in data["presses"] if None not in (p["static_error"], *p["static_N"])]
    for p in presses:
        of_one_length(p["curve"], "time_s", "force_N", "depth_m")
    for s in switches:
        of_one_length(s["curve"], "time_s", "force_N")
    if not presses:
        say(sys.argv[1], "none of its indentations has a static equilibrium")
    figure, axes = plt.subplots(2, 2, figsize=(11, 7.6), layout="constrained")
    time, depth, rest, switch = axes.flat
    most = max(np.linalg.norm(p["force_N"]) for p in presses)
    unit, name = (1e3, "mN") if most < 0.1 else (1, "N")
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(presses)))
    for press, colour in zip(presses, colours):
        curve = press["curve"]
        time.plot(curve["time_s"], np.array(curve["force_N"]) * unit, color=colour, linewidth=1)
        depth.plot(np.array(curve["depth_m"]) * 1e3, np.array(curve["force_N"]) * unit, color=colour, linewidth=1)
        rest.plot(np.linalg.norm(press["static_N"]) * unit, np.linalg.norm(press["force_N"]) * unit, "o", color=colour)
    for axis, label in ((time, "time (s)"), (depth, "displacement of the contact (mm)")):
        axis.set_xlabel(label)
        axis.set_ylabel(f"force along the displacement ({name})")
    limit = [0, 1.05 * most * unit]
    rest.plot(limit, limit, color="0.6", linewidth=0.8, zorder=0)
    rest.set_xlabel(f"force in static equilibrium ({name})")
    rest.set_ylabel(f"force of the simulation at rest ({name})")
    worst = max(p["static_error"] for p in presses)
    count = len(data["presses"])
    rest.set_title(f"{count} indentations, largest difference from the static force {100 * worst:.2g} %" if len(presses) == count else
                   f"{len(presses)} of {count} indentations have an answer, largest difference from the static force {100 * worst:.2g} %", fontsize=10)

    switch.set_visible(bool(switches))
    largest = max((s for s in switches if s["innovation"] == 1), key=lambda s: s["force_jump_N"], default=None)
    for s in switches:
        if largest and (s["from"], s["to"]) == (largest["from"], largest["to"]):
            slow = s["innovation"] < 1
            switch.plot(np.array(s["curve"]["time_s"]) * 1e3, np.array(s["curve"]["force_N"]) * unit,
                        color="#0072B2" if slow else "#D55E00", label=f"smoothing gain {s['innovation']:g}",
                        linewidth=2 if slow else 1)
    if largest:
        switch.set_title(f"switch from spring set {largest['from']} to set {largest['to']}", fontsize=10)
        switch.legend(frameon=False)
    switch.set_xlabel("time after the switch (ms)")
    switch.set_ylabel(f"force along the displacement ({name})")
    figure.suptitle(f"Study {study}: indentations in the 1 kHz simulation until the force is constant")
    save(figure, sys.argv[2])


if __name__ == "__main__":
    main()
