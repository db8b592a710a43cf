"""Adaptation of an energy model to target tissues that it was not trained on: table and figure of `make patient`.

    scripts/patient_study.py PROBE OUT PATIENT...

PROBE is the program of scripts/adapt_probe.cpp; the files that TISSUES names must exist. Writes OUT.md and OUT.png. In
the plane also the row of README.md and the table of results/RESULTS.md that reference.py makes of OUT.md. Every number
is the median over three seeds of order and noise; in space one seed is run.
"""
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "figures")]
import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from reference import write_patients
from save import save, written

SEEDS = (11, 12, 13)
SHOWN = (0, 1, 2, 3, 5, 10, 20, 40, 60)


def plane(name):
    return ["--model", "results/surface-quick/model.h5", "--cases", f"results/patient-{name}/cases.h5"]


SPACE = ["--model", "results/block3-quick/model.h5", "--most", "40"]
# target tissue: its description, and the arguments of the probe
TISSUES = {
    "stiff": ("x 1.5", plane("stiff")),
    "soft": ("x 0.6", plane("soft")),
    "ogden": ("another material law", plane("ogden")),
    "lump": ("an inclusion", plane("lump")),
    "layers": ("layers, an inclusion", plane("layers")),
    "stiff3": ("in space, x 1.5", [*SPACE, "--cases", "results/block3-quick/cases.h5", "--pokes", "held_out_near", "--factor", "1.5"]),
    "nodule3": ("in space, a nodule", [*SPACE, "--cases", "results/nodule3/cases.h5", "--pokes", "validation"]),
}
# without "chosen places": to choose the next place takes half a minute in space
IN_SPACE = ("field", "field alone", "one scale")
# method: options of the probe, colour of its line
WAYS = {
    "field, chosen places": (["--method", "field", "--told"], "#0072b2"),
    "field": (["--method", "field"], "#56b4e9"),
    "field alone": (["--method", "field", "--alone"], None),
    "all measurements at once": (["--method", "refit"], "0.6"),
    "elements alone": (["--method", "elements", "--alone"], None),
    "terms of the energy model": (["--method", "terms"], "#009e73"),
    "one scale": (["--method", "scale"], "#e69f00"),
    "gradient": (["--method", "gradient"], "#cc79a7"),
    "SPSA": (["--method", "spsa"], "#d55e00"),
    "field, contacts 1 mm off": (["--method", "field", "--place", "1"], None),
    "field, 10 % outliers": (["--method", "field", "--outliers", "0.1"], None),
}


class Failed(Exception):
    """A probe that ended with an error, with its message."""


def seeds_of(patient):
    return SEEDS[:1] if patient.endswith("3") else SEEDS


def measure(probe, patients):
    """target tissue -> method -> output of the probe, one for each seed."""
    def one(patient, options, seed):
        command = [probe, *TISSUES[patient][1], "--seed", str(seed), *options]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True)  # its stderr is shown
        if done.returncode != 0:
            raise Failed(f"patient_study.py: {' '.join(command)}: exit status {done.returncode}")
        return json.loads(done.stdout)

    with ThreadPoolExecutor(2) as pool:
        jobs = {(p, w, s): pool.submit(one, p, WAYS[w][0], s) for p in patients for w in WAYS
                if not p.endswith("3") or w in IN_SPACE for s in seeds_of(p)}
        out = {}
        for done, ((patient, way, _), job) in enumerate(jobs.items(), 1):
            try:
                out.setdefault(patient, {}).setdefault(way, []).append(job.result())
            except Failed as failed:
                pool.shutdown(cancel_futures=True)
                sys.exit(str(failed))
            print(f"patient [{done}/{len(jobs)}] {patient}: {way}", file=sys.stderr)
        return out


def at(runs, pokes, key):
    """Median over seeds after this number of measurements, or after the last one if there were fewer."""
    rows = [max((c for c in run["curve"] if c["pokes"] <= pokes), key=lambda c: c["pokes"]) for run in runs]
    # null is infinite: an answer is missing
    return float(np.median([np.inf if row[key] is None else row[key] for row in rows]))


def per_cent(value):
    return f"{100 * value:.1f}" if np.isfinite(value) else "none"


def fewest(ways):
    """"n of N" answers on the test set, for the model of this target tissue with the fewest."""
    worst = min((c for runs in ways.values() for run in runs for c in run["curve"]), key=lambda c: c["n"] / c["of"])
    return f"{worst['n']} of {worst['of']}"


def table(measured):
    held_out = next(iter(next(iter(measured.values())).values()))[0]["curve"][0]["of"]
    space = all(patient.endswith("3") for patient in measured)
    shown = [n for n in SHOWN if not space or n <= 40]
    what = ("Written by `make patient3`. The energy model of `block3-quick`; FE of `block3-quick` with all forces times 1.5, and of `nodule3`," if space else
            "Written by `make patient`. The energy model of `surface-quick`; FE of the studies `patient-NAME`, indentations of 3 to 10 mm, up to 30 degrees off")
    where = "all over the top," if space else "the normal, anywhere on the surface,"
    lines = ["# Adaptation to synthetic target tissues that the model was not trained on" + (", in space" if space else ""), "", what,
             f"{where} with 2 % of noise on each component of force. |model - FE| / |FE| of the contact force",
             f"on about {held_out} test contacts of the same tissue, median / p95 in per cent, after so many measurements; " + ("of one seed of" if space else f"medians over {len(SEEDS)} seeds of"),
             "order and noise. Field: one unknown a node; one scale is estimated too, and the more probable of the two is used. Alone: without one scale." +
             ("" if space else " All measurements at once: the optimum to which the field alone converges, with the same prior."), ""]
    for patient, ways in measured.items():
        lines += [f"## {patient}: {TISSUES[patient][0]}", "", f"Answered at {fewest(ways)} test contacts or more in each cell; a missing answer is an infinite error.", "", "| | " + " | ".join(map(str, shown)) + " |", "|---|" + "---|" * len(shown)]
        for way, runs in ways.items():
            lines.append(f"| {way} | " + " | ".join(f"{per_cent(at(runs, n, 'median'))} / {per_cent(at(runs, n, 'p95'))}" for n in shown) + " |")
        lines.append("")
    told = "field" if space else "field, chosen places"
    lines += ["## Posterior standard deviation", "", f"Part of the test forces, in per cent, that lie inside the filter's predicted regions of 68 % and of 95 % probability; method: {told}.", "",
              "| | " + " | ".join(map(str, shown)) + " |", "|---|" + "---|" * len(shown)]
    for patient, ways in measured.items():
        runs = ways[told]
        lines.append(f"| {patient} | " + " | ".join(f"{100 * at(runs, n, 'inside68'):.0f} / {100 * at(runs, n, 'inside95'):.0f}" for n in shown) + " |")
    runs = [run for ways in measured.values() for run in ways[told]]
    middle = {key: np.median([run[key]["median"] for run in runs]) for key in ("update_ms", "rank_ms") if key in runs[0]}
    lines += ["", f"An update of the field ({runs[0]['unknowns']} unknowns): {middle['update_ms']:.2f} ms" +
              (f", the choice of the next of up to 60 places {middle['rank_ms']:.0f} ms" if "rank_ms" in middle else "") +
              f" (medians over {len(runs)} runs, two at a time).", ""]
    return "\n".join(lines)


def figure(measured):
    fig, axes = plt.subplots(1, len(measured), figsize=(3.1 * len(measured), 3.3), sharey=True, squeeze=False, layout="constrained")
    shown = [n for n in SHOWN if n <= 40 or not all(patient.endswith("3") for patient in measured)]
    for axis, (patient, ways) in zip(axes[0], measured.items()):
        for way, (_, colour) in WAYS.items():
            if colour is None or way not in ways:
                continue
            axis.plot(range(len(shown)), [100 * at(ways[way], n, "median") for n in shown], color=colour, label=way,
                      linewidth=2.4 if way == "field, chosen places" else 1.3, linestyle=":" if way == "all measurements at once" else "-")
        axis.set_xticks(range(len(shown)), shown)
        axis.set_yscale("log")
        axis.set_yticks([1, 2, 5, 10, 20, 50], [1, 2, 5, 10, 20, 50])
        axis.minorticks_off()
        axis.set_title(f"{patient}: {TISSUES[patient][0]}", fontsize=9)
        axis.set_xlabel("number of measurements")
    axes[0, 0].set_ylabel("median indentation error of force, test set (%)")
    axes[0, -1].legend(frameon=False, fontsize=7)
    return fig


def main():
    if len(sys.argv) < 4 or any(word.startswith("-") for word in sys.argv):
        sys.exit(__doc__)
    probe, out, patients = sys.argv[1], sys.argv[2], sys.argv[3:]
    unknown = [patient for patient in patients if patient not in TISSUES]
    if unknown:
        sys.exit(f"patient_study.py: {unknown[0]}: is not a target tissue; there are {', '.join(TISSUES)}")
    measured = measure(probe, patients)
    with written(f"{out}.md") as beside:
        Path(beside).write_text(table(measured))
    if any(not patient.endswith("3") for patient in measured):
        write_patients(Path(f"{out}.md"))
    save(figure(measured), f"{out}.png")


if __name__ == "__main__":
    main()
