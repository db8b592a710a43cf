"""Rules for steps, iterations and Q, each constant fitted to what was measured: `measured` is {question: rows of the probe}."""
import numpy as np

from gains.questions import BUDGET, FARS, GAP, LATTICES, NEARS, PATCH, STEPS


def springs_of(nodes, topology):
    """Springs of the lattice: rows, columns and diagonals; the fixed row's own as well."""
    cells = nodes - 1
    return 2 * cells * nodes + (2 * cells * cells if topology == "grid8" else 0)


def cycle_of(springs):
    """Perturbations of one gradient of `spsa`: the power of two that holds the springs (spsa.h)."""
    return 1 << (springs - 1).bit_length()


def fit(columns, values):
    return np.linalg.lstsq(np.column_stack(columns), np.log(values), rcond=None)[0]


def step_points(measured, topology):
    """(nodes a side, displacement, steps m, iterations to GAP) of every load case. Ends the program where one stopped before: how long it takes nobody knows."""
    points = []
    for n in LATTICES:
        rows = measured[f"iterations-{topology}-{n}"]
        if short := [r for r in rows if not r["gap"] <= GAP * (1 + 1e-9)]:
            raise SystemExit(f"gains: {len(short)} of {len(rows)} sets of {topology}, {n} nodes a side, stopped before a gap of {100 * GAP:g} % ({short[0]['status']}): no rule is fitted to the others")
        for r in rows:
            S = r["springs"]
            points.append((n, r["magnitude_m"], (r["iterations"] - S) / (cycle_of(S) / 2), r["iterations"]))
    return np.array(points)


def step_rule(points):
    n, d, m, _ = points.T
    return fit([np.ones_like(n), np.log(n / 10), np.log(d / 0.01)], m)


def steps_of(rule, n, d):
    return np.exp(rule[0]) * (n / 10) ** rule[1] * (d / 0.01) ** rule[2]


def iterations_of(rule, n, d, topology):
    S = springs_of(n, topology)
    return S + cycle_of(S) / 2 * steps_of(rule, n, d)


def left_over(rows, **where):
    """Median over paths and repeats, for every first step."""
    rows = [r for r in rows if all(abs(r[k] - v) < 1e-9 for k, v in where.items())]
    return np.array([np.median([(r["rel_loss"] - r["bound"]) / (r["start"] - r["bound"])
                                for r in rows if r["first_step"] == step]) for step in STEPS])


def best_step(curve):
    """The lowest point of a curve over STEPS, between them by the parabola through it and its neighbours."""
    k = int(np.argmin(curve))
    if k in (0, len(curve) - 1):
        return STEPS[k]
    a, b, c = curve[k - 1:k + 2]
    return STEPS[k] * 2 ** (0.5 * (a - c) / (a - 2 * b + c))


def at_step(curve, step):
    return float(np.interp(np.log(step), np.log(STEPS), curve))


def gain_points(measured, topology):
    """(nodes a side, displacement) -> curve."""
    curves = {}
    for n in LATTICES:
        rows = measured[f"gains-{topology}-{n}"]
        for d in sorted({r["magnitude_m"] for r in rows}):
            curves[n, d] = left_over(rows, magnitude_m=d)
    return curves


def gain_rule(curves, kind):
    """kind "n, d": step = a (n / 10)^b (d / 10 mm)^e, fitted to the best ones; "one": the step that costs least where
    it costs most, because too long a step costs more than too short a one."""
    if kind == "one":
        steps = np.geomspace(STEPS[0], STEPS[-1], 121)
        cost = [max(at_step(c, step) - c.min() for c in curves.values()) for step in steps]
        return np.array([np.log(steps[int(np.argmin(cost))]), 0, 0])
    n, d = np.array(list(curves)).T
    return fit([np.ones_like(n), np.log(n / 10), np.log(d / 0.01)], [best_step(c) for c in curves.values()])


def budget_exponent(measured):
    """step ~ budget^-p, from budgets of 1000, 5000 and 20,000 on two lattices."""
    points = []
    for n in (11, 21):
        for d in (0.005, 0.015):
            for budget in (1000, BUDGET, 20000):
                rows = measured[f"gains-grid4-{n}"] if budget == BUDGET else measured[f"budget-grid4-{n}"]
                points.append((n, d, budget, best_step(left_over(rows, magnitude_m=d, budget=budget))))
    points = np.array(points)
    group = [((points[:, 0] == n) & (points[:, 1] == d)).astype(float) for n in (11, 21) for d in (0.005, 0.015)]
    return -fit([*group, np.log(points[:, 2])], points[:, 3])[-1], points


def median_of(rows, key):
    """Of a relative error that is null where an answer is missing: it counts as infinite, as everywhere (lib/eval/statistics.h)."""
    return np.median([np.inf if row[key] is None else row[key] for row in rows])


def q_ratios(measured, topology, n, near, far):
    """Median over cases of (resolved error, rel_loss, closed-loop error), and the same under the paper's Q."""
    rows = measured[f"weights-{topology}-{n}"]
    def medians(near, far):
        some = [r for r in rows if r["near"] == near and r["far"] == far]
        return np.array([median_of(some, k) for k in ("resolved", "rel_loss", "closed_loop")])
    return medians(near, far), medians(1, 1)


def half_block(block, n):
    """Nodes from the contact to the edge of a block: a number, or as many as carry the patch of 5 mm half-width."""
    return -(-(n - 1) * 5 // 100) if block == PATCH else block


def q_rule(measured, topology, lattices):
    """(block, far) nearest to the paper's among those whose resolved error is within a point of the smallest; rel_loss
    may rise by a tenth at most on every lattice."""
    candidates = []
    for rank, block in enumerate([PATCH, *NEARS]):
        for far in FARS:
            pairs = [q_ratios(measured, topology, n, half_block(block, n), far) for n in lattices]
            if max(ours[1] / paper[1] for ours, paper in pairs) <= 1.10:
                candidates.append((float(np.mean([ours[0] for ours, _ in pairs])), far, -rank, block))
    least = min(candidates)[0]
    _, far, _, block = max((c for c in candidates if c[0] <= least + 0.01), key=lambda c: c[1:3])
    return block, far


def q_lattices(measured, topology):
    return [n for n in LATTICES if f"weights-{topology}-{n}" in measured]


def without(points, n):
    return points[points[:, 0] != n]


def gain_table(measured, topology, kind):
    """For every lattice: (best steps, predicted without it, left at best, left at predicted, left at 0.003)."""
    curves, table = gain_points(measured, topology), {}
    for n in LATTICES:
        rule = gain_rule({k: v for k, v in curves.items() if k[0] != n}, kind)
        own = {k: v for k, v in curves.items() if k[0] == n}
        predicted = {k: float(np.clip(steps_of(rule, *k), STEPS[0], STEPS[-1])) for k in own}
        table[n] = np.array([[best_step(v), predicted[k], at_step(v, best_step(v)), at_step(v, predicted[k]),
                              at_step(v, 0.003)] for k, v in own.items()])
    return table


def left_rule(curves):
    """What is left at the best step: a (n / 10)^b (d / 10 mm)^e."""
    n, d = np.array(list(curves)).T
    return fit([np.ones_like(n), np.log(n / 10), np.log(d / 0.01)], [c.min() for c in curves.values()])


def one_step(measured):
    return float(np.exp(gain_rule(gain_points(measured, "grid4"), "one")[0]))
