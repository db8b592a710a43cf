"""What accuracy costs and what each idea buys: ablation.py ABLATION.json OUT.png, from `make ablation`.

Left: error on held-out contacts against FE solves, as training contacts get closer. Right: every variant.
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from save import save  # noqa: E402


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: ablation.py ABLATION.json OUT.png")
    with open(sys.argv[1]) as f:
        variants = json.load(f)["variants"]
    whole = variants[0]
    # the same law and objective, fewer contacts along the surface
    thinned = [v for v in variants if all(v[key] == whole[key] for key in ("topology", "law", "objective", "ridge",
                                                                           "angles_deg", "magnitudes_m"))]
    thinned.sort(key=lambda v: v["fe_paths"])
    figure, (cost, ideas) = plt.subplots(1, 2, figsize=(13, 4.8), layout="constrained",
                                         gridspec_kw={"width_ratios": [1, 1.2]})
    for model, colour, label in (("learned", "#0072B2", "learned, blended"), ("learned_nearest", "#E69F00", "nearest set"),
                                 ("force_table", "#000000", "FE force table")):
        for measure, style in (("median", "-o"), ("p95", "--o")):
            cost.plot([v["fe_paths"] for v in thinned], [100 * v["held_out"][model][measure] for v in thinned], style,
                      color=colour, markersize=5, label=f"{label}, {measure}")
    for v in thinned:
        cost.annotate(f"{1e3 * v['spacing_m']:g} mm", (v["fe_paths"], 100 * v["held_out"]["learned"]["median"]),
                      textcoords="offset points", xytext=(8, -13), ha="center", fontsize=8)
    cost.set_xscale("log")
    cost.set_yscale("log")
    cost.set_xticks([v["fe_paths"] for v in thinned], [str(v["fe_paths"]) for v in thinned])
    cost.minorticks_off()
    cost.set_yticks([1, 2, 5, 10, 20], ["1 %", "2 %", "5 %", "10 %", "20 %"])
    cost.set_xlabel("FE load paths to train on (contacts this far apart)")
    cost.set_ylabel("closed-loop error, held out, core range")
    cost.grid(color="0.9")
    cost.set_ylim(0.9, 120)  # room for the legend
    cost.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")

    for row, v in enumerate(variants):
        for model, colour, marker in (("one_set", "#CC79A7", "D"), ("learned_nearest", "#E69F00", "s"),
                                      ("learned", "#0072B2", "o")):
            if model not in v["held_out"]:
                continue
            s = v["held_out"][model]
            ideas.plot([100 * s["median"], 100 * s["p95"]], [row, row], color=colour, linewidth=1)
            ideas.plot(100 * s["median"], row, marker, color=colour, markersize=7,
                       label={"one_set": "one set", "learned_nearest": "nearest set",
                              "learned": "sets blended"}[model] if row == 0 else None)
    ideas.set_yticks(range(len(variants)), [v["name"] for v in variants], fontsize=8)
    ideas.invert_yaxis()
    ideas.set_xscale("log")
    ideas.set_xticks([1, 2, 5, 10, 20, 50, 100], [f"{x} %" for x in (1, 2, 5, 10, 20, 50, 100)])
    ideas.set_xlabel("closed-loop error, held out, core range: median, and line to p95")
    ideas.grid(color="0.9")
    ideas.legend(frameon=False, fontsize=8)
    figure.suptitle("What accuracy costs, and what each idea buys")
    save(figure, sys.argv[2])


if __name__ == "__main__":
    main()
