"""Indentation errors against the numbers of FE paths and of parameters: ablation.py ABLATION.json OUT.png, from `make ablation`.

Left: error on the test set against the number of training paths. Right: against the number of parameters.
"""
import math
import sys

import needs  # noqa: F401, I001  (before packages that may be missing)
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from one_line import NUMBER_OR_NULL, read_json  # noqa: E402
from results import nothing  # noqa: E402
from save import save  # noqa: E402

STATISTICS = {measure: NUMBER_OR_NULL for measure in ("median", "p95", "max")}
FORM = {"variants": [{"held_out": {"learned": {**STATISTICS, "n": int, "of": int, "shape": STATISTICS}}, "fe_paths": int, "numbers": int}, ...]}
ERRORS = (("force", "#0072B2"), ("shape", "#D55E00"))
NAMES = {"force": "contact force", "shape": "displacement"}


def error_of(variant, error, measure):
    learned = variant["held_out"]["learned"]
    value = (learned if error == "force" else learned["shape"])[measure]
    return math.nan if value is None else 100 * value  # null is infinite: an answer is missing


def answered(variant):
    """"n of N" below the note where an answer is missing, since p95 or max has no point there; else empty."""
    learned = variant["held_out"]["learned"]
    return "" if learned["n"] == learned["of"] else f"\n{learned['n']} of {learned['of']}"


def draw(axes, variants, key, note):
    variants = sorted(variants, key=lambda v: v[key])
    at = [v[key] for v in variants]
    for error, colour in ERRORS:
        for measure, style in (("median", "-o"), ("p95", "--o"), ("max", ":o")):
            axes.plot(at, [error_of(v, error, measure) for v in variants], style, color=colour, markersize=4,
                      label=f"{NAMES[error]}, {measure}")
    for v in variants:
        axes.annotate(note(v), (v[key], 0.97), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(at, [str(a) for a in at])
    axes.minorticks_off()
    ticks = (0.5, 1, 2, 5, 10, 20)
    axes.set_yticks(ticks, [f"{t:g} %" for t in ticks])
    axes.grid(color="0.9")


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: ablation.py ABLATION.json OUT.png")
    variants = read_json(sys.argv[1], FORM)["variants"]
    whole = variants[0]
    same = [v for v in variants if all(v[k] == whole[k] for k in ("area_cap_E2", "shape_scale", "magnitudes_m"))]
    same_paths = [v for v in same if v["arcs_m"] == whole["arcs_m"] and v["angles_deg"] == whole["angles_deg"]]
    drawn = [e for v in same for error, _ in ERRORS for measure in ("median", "p95", "max") if math.isfinite(e := error_of(v, error, measure))]
    if not drawn:
        return save(nothing("No model of the ablation has an answer at half of the test contacts"), sys.argv[2])
    figure, (paths, numbers) = plt.subplots(1, 2, figsize=(13, 4.8), layout="constrained", sharey=True)
    draw(paths, [whole] + [v for v in same if v not in same_paths], "fe_paths", lambda v: f"{v['numbers']} parameters{answered(v)}")
    draw(numbers, same_paths, "numbers", answered)
    paths.margins(x=0.08)
    paths.set_xlabel("number of FE load paths in the training set")
    paths.set_ylabel("indentation error, test set, core range")
    paths.tick_params(labelleft=True)
    numbers.set_xlabel(f"number of parameters of the model, trained on {whole['fe_paths']} load paths")
    numbers.legend(frameon=False, fontsize=8, ncols=2, loc="upper right")
    top = max(drawn)
    paths.set_ylim(top=1.6 * top)  # space for the notes
    figure.suptitle("Indentation errors against the numbers of load paths and of parameters")
    save(figure, sys.argv[2])


if __name__ == "__main__":
    main()
