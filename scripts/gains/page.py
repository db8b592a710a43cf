"""The text of results/reference/gains.md: the rules and their prediction errors."""
import textwrap

import numpy as np

from gains.questions import BUDGET, LATTICES, MESHES, NEARS, PATCH, STEPS
from gains.rules import at_step, best_step, budget_exponent, gain_points, gain_rule, gain_table, half_block, iterations_of, left_over, left_rule, one_step, q_lattices, q_ratios, q_rule, springs_of, step_points, step_rule, steps_of, without


def in_words(block):
    return PATCH if block == PATCH else f"{2 * block + 1} x {2 * block + 1}"


def percent(value):
    return f"{100 * value:.3g} %" if np.isfinite(value) else "none"


def span(values, form="{:.3g}"):
    low, high = form.format(min(values)), form.format(max(values))
    return low if low == high else f"{low} to {high}"


def iterations_rows(measured, topology):
    points = step_points(measured, topology)
    for n in LATTICES:
        own, rule = points[points[:, 0] == n], step_rule(without(points, n))
        predicted = iterations_of(rule, n, own[:, 1], topology)
        ratio = own[:, 3] / predicted
        yield (f"| {topology} | {n} | {springs_of(n, topology)} | {span(own[:, 2], '{:.0f}')} | "
               f"{np.median(own[:, 3]):.0f} | {own[:, 3].max():.0f} | {np.median(predicted):.0f} | "
               f"{span(ratio, '{:.2f}')} |")


def restarted(measured, topology, n, step):
    """Fraction of sets that restarted, at the tried step nearest to `step`."""
    near = min(STEPS, key=lambda s: abs(np.log(s / step)))
    return np.mean([r["restarts"] > 0 for r in measured[f"gains-{topology}-{n}"] if r["first_step"] == near])


def gains_rows(measured, topology):
    fitted, one = (gain_table(measured, topology, kind) for kind in ("n, d", "one"))
    for n in LATTICES:
        a, b = fitted[n], one[n]
        best = float(np.exp(np.mean(np.log(a[:, 0]))))
        yield (f"| {topology} | {n} | {span(a[:, 0], '{:.2g}')} | {percent(np.median(a[:, 2]))} | "
               f"{percent(restarted(measured, topology, n, best))} | "
               f"{span(a[:, 1], '{:.2g}')} | {percent(np.median(a[:, 3]))} | {b[0, 1]:.2g} | "
               f"{percent(np.median(b[:, 3]))} | {percent(np.median(a[:, 4]))} |")


def q_rows(measured, topology):
    lattices = q_lattices(measured, topology)
    for n in lattices:
        block, far = q_rule(measured, topology, [m for m in lattices if m != n])
        ours, paper = q_ratios(measured, topology, n, half_block(block, n), far)
        yield (f"| {topology} | {n} | {in_words(block)}, {far:g} | " +
               " | ".join(f"{percent(p)} -> {percent(o)}" for o, p in zip(ours, paper)) + " |")


def displacement_rows(measured):
    for topology in MESHES:
        points, curves = step_points(measured, topology), gain_points(measured, topology)
        for n in LATTICES:
            for d in sorted(set(points[points[:, 0] == n, 1]) | {k[1] for k in curves if k[0] == n}):
                own = points[(points[:, 0] == n) & (points[:, 1] == d), 3]
                curve = curves.get((n, d))
                yield (f"| {topology} | {n} | {1e3 * d:g} | {f'{np.median(own):.0f}' if len(own) else ''} | " +
                       (f"{best_step(curve):.2g} | {percent(curve.min())} |" if curve is not None else " | |"))


def power_law(rule, unit=""):
    return f"{np.exp(rule[0]):.3g}{unit} (n/10)^{rule[1]:.2f} (d/10 mm)^{rule[2]:.2f}"


def rule_lines(measured):
    exponent, _ = budget_exponent(measured)
    for t in MESHES:
        yield (f"`spsa`, {t}: iterations to gap <= 2 % = S + m N/2, N the power of two >= S, "
               f"m = {power_law(step_rule(step_points(measured, t)))}.")
    for t in MESHES:
        curves = gain_points(measured, t)
        yield (f"`spsa-2008`, {t}: first step = {np.exp(gain_rule(curves, 'one')[0]):.2g} E2 (K/{BUDGET})^-{exponent:.2f} "
               "for K iterations, for all n and d; it minimises the largest loss above that of the best step. The best steps themselves follow "
               f"{power_law(gain_rule(curves, 'n, d'), ' E2')} at K = {BUDGET}. With the best step there remains {power_law(left_rule(curves))} of the reducible loss.")
    at_end = sum(step == STEPS[0] for *_, step in budget_exponent(measured)[1])
    if at_end:
        yield (f"The exponent of K is from grid4, n = 11 and 21, K = 1000, {BUDGET} and 20000; {at_end} of the 12 best steps "
               f"are the shortest one tried, {STEPS[0]:g} E2, so the exponent may be larger.")
    usual, tenth, hundredth = (at_step(left_over(measured[name], perturbation=c), one_step(measured)) for name, c in
                               (("gains-grid4-11", 1), ("perturbation-grid4-11", 0.1), ("perturbation-grid4-11", 0.01)))
    yield (f"Its perturbation c = E2, the paper's limit: at that step, on grid4 with n = 11, {percent(usual)} of the reducible loss remain; "
           f"with E2/10 and E2/100, {percent(tenth)} and {percent(hundredth)}. The paper's lower bound, E2/750, is never "
           "reached: c falls as k^-0.101.")
    for t in MESHES:
        block, far = q_rule(measured, t, q_lattices(measured, t))
        if far == 1:
            yield f"Q, {t}: the paper's."
        else:
            where = "the block of nodes that carry the indenter" if block == PATCH else f"{in_words(block)} nodes"
            yield f"Q, {t}: the paper's weights on {where}, {far:g} times the paper's on all others."


def misses(measured):
    """Prediction errors of the rules on the lattice that they were not fitted to, with the largest."""
    for t in MESHES:
        points, curves = step_points(measured, t), gain_points(measured, t)
        ratio, left = [], []
        for n in LATTICES:
            own, rule = points[points[:, 0] == n], step_rule(without(points, n))
            ratio += list(own[:, 3] / iterations_of(rule, n, own[:, 1], t))
            rule = left_rule({k: v for k, v in curves.items() if k[0] != n})
            left += [v.min() / steps_of(rule, *k) for k, v in curves.items() if k[0] == n]
        yield f"{t}: iterations were {min(ratio):.2f} to {max(ratio):.2f} times those predicted, set by set."
        for kind, words in (("one", "one step for all"), ("n, d", "a step by n and d")):
            rows = np.concatenate(list(gain_table(measured, t, kind).values()))
            yield (f"{t}, {words}: the best was {min(rows[:, 0] / rows[:, 1]):.2f} to {max(rows[:, 0] / rows[:, 1]):.2f} "
                   f"times the predicted; with the predicted one the remaining loss is larger by {100 * np.median(rows[:, 3] - rows[:, 2]):.1f} points of the "
                   f"reducible loss (median; {100 * np.max(rows[:, 3] - rows[:, 2]):.1f} at worst).")
        yield f"{t}: the loss that remains with the best step was {min(left):.2f} to {max(left):.2f} times the predicted."


def paragraph(text, bullet=""):
    return textwrap.fill(bullet + text, 120, subsequent_indent=" " * len(bullet), break_long_words=False,
                         break_on_hyphens=False)


def page(measured):
    bullets = lambda lines: [paragraph(line, "- ") for line in lines]  # noqa: E731
    blocks = [
        "# Gains, iterations and Q as functions of mesh size and displacement", "",
        paragraph(
            "Written by `make gains`. The same tissue, the same FE (2.5 mm elements) and the same displacements of a 10 mm wide "
            "patch, on spring lattices of n = 6, 11, 21 and 41 nodes a side; S springs, d the displacement, N the least power of "
            "two that is >= S. `grid4` with the `isotropic` law, `grid8` with `axial`. Five load paths at 2.5, 5, 10 and 15 mm; "
            "n = 41 at 5 and 15 mm only, its iterations on grid8 at 10 mm only, its Q on grid4 only. *Predicted*: by "
            "constants that are fitted to the other lattices."), "",
        "## The rule", "", *bullets(rule_lines(measured)), "",
        "## Errors of prediction for a lattice that was not fitted to", "", *bullets(misses(measured)), "",
        "## `spsa`: iterations to gap <= 2 %", "",
        "| mesh | n | S | steps m | median | most | predicted, median | measured / predicted |",
        "|---|---|---|---|---|---|---|---|", *(r for t in MESHES for r in iterations_rows(measured, t)), "",
        f"## `spsa-2008`: first step, and the loss that remains after {BUDGET} iterations", "",
        paragraph("Remaining part of the reducible loss, (L - L_lb) / (L_heuristic - L_lb), median over the load cases; steps in E2, "
                  "0.003 is the default. The paper's restarts are included: `restarted` is the part of the sets that restarted "
                  "at the best step."), "",
        "| mesh | n | best step | remains | restarted | step by n, d | remains | one step for all | remains | remains with 0.003 |",
        "|---|---|---|---|---|---|---|---|---|---|", *(r for t in MESHES for r in gains_rows(measured, t)), "",
        "## Q", "",
        paragraph("Medians of the certified optimum, first with the paper's Q, then with the one that is chosen on the other lattices. "
                  "That is the Q nearest to the paper's whose resolved-force error (over all nodes that carry the patch) is at "
                  "most one percentage point above the smallest, and whose rel_loss, measured with the paper's Q, is at most a "
                  "tenth larger. *The patch*: the block of nodes that carry it, 3 x 3 up to n = 21 and 5 x 5 with n = 41. On the "
                  "coarser lattices it equals 3 x 3, so only n = 41 tests this part of the rule. The indentation error is of a "
                  "tool that displaces a single point where FE displace a patch, so it grows with the density of nodes."), "",
        "| mesh | n | full weight on, factor of the rest | resolved force error | rel_loss | indentation error of force |",
        "|---|---|---|---|---|---|", *(r for t in MESHES for r in q_rows(measured, t)), "",
        paragraph("grid4, n = 41, factor of the rest 0.1: resolved-force error " + ", ".join(
            f"{percent(q_ratios(measured, 'grid4', 41, near, 0.1)[0][0])} with {in_words(near)} nodes" for near in NEARS) +
            f"; {percent(q_ratios(measured, 'grid4', 41, 1, 1)[0][0])} with the paper's Q."), "",
        "## By displacement", "",
        "| mesh | n | d, mm | `spsa` iterations, median | best first step, E2 | remains |", "|---|---|---|---|---|---|",
        *displacement_rows(measured), ""]
    return "\n".join(blocks)
