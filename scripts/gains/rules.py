"""Rules for steps, iterations and Q, with constants fitted to the measurements. `measured`: {name of the measurement:
rows of the probe}."""
import numpy as np

from gains.questions import BUDGET, FARS, GAP, LATTICES, NEARS, PATCH, STEPS


def springs_of(nodes, topology):
    """Number of springs of the lattice: rows, columns and diagonals, with those along the fixed edge."""
    cells = nodes - 1
    return 2 * cells * nodes + (2 * cells * cells if topology == "grid8" else 0)


def cycle_of(springs):
    """Perturbations for one gradient of `spsa`: the least power of two that is not below the number of springs
    (spsa.h)."""
    return 1 << (springs - 1).bit_length()


def fit(columns, values):
    return np.linalg.lstsq(np.column_stack(columns), np.log(values), rcond=None)[0]


def step_points(measured, topology):
    """(nodes a side, displacement, steps m, iterations to GAP) of every load case. Ends the program if one stopped
    before GAP, since its number of iterations is unknown."""
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
    """Part of the reducible loss that is left, (L - L_lb) / (L_heuristic - L_lb): median over paths and repeats for
    every first step. `where`: values of keys that select the rows."""
    rows = [r for r in rows if all(abs(r[k] - v) < 1e-9 for k, v in where.items())]
    return np.array([np.median([(r["rel_loss"] - r["bound"]) / (r["start"] - r["bound"])
                                for r in rows if r["first_step"] == step]) for step in STEPS])


def best_step(curve):
    """The step at the minimum of a curve over STEPS, by the parabola through the lowest point and its neighbours."""
    k = int(np.argmin(curve))
    if k in (0, len(curve) - 1):
        return STEPS[k]
    a, b, c = curve[k - 1:k + 2]
    return STEPS[k] * 2 ** (0.5 * (a - c) / (a - 2 * b + c))


def at_step(curve, step):
    return float(np.interp(np.log(step), np.log(STEPS), curve))


def gain_points(measured, topology):
    """(nodes a side, displacement) -> curve of left_over."""
    curves = {}
    for n in LATTICES:
        rows = measured[f"gains-{topology}-{n}"]
        for d in sorted({r["magnitude_m"] for r in rows}):
            curves[n, d] = left_over(rows, magnitude_m=d)
    return curves


def gain_rule(curves, kind):
    """kind "n, d": step = a (n / 10)^b (d / 10 mm)^e, fitted to the best steps. kind "one": one step with the least
    maximum of the loss left over that of the best step, because too long a step costs more than too short a one."""
    if kind == "one":
        steps = np.geomspace(STEPS[0], STEPS[-1], 121)
        cost = [max(at_step(c, step) - c.min() for c in curves.values()) for step in steps]
        return np.array([np.log(steps[int(np.argmin(cost))]), 0, 0])
    n, d = np.array(list(curves)).T
    return fit([np.ones_like(n), np.log(n / 10), np.log(d / 0.01)], [best_step(c) for c in curves.values()])


def budget_exponent(measured):
    """Exponent p of step ~ budget^-p, from budgets of 1000, 5000 and 20,000 on two lattices; and the fitted points."""
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
    """Median of a relative error. null (an answer is missing) counts as infinite, as in lib/eval/statistics.h."""
    return np.median([np.inf if row[key] is None else row[key] for row in rows])


def q_ratios(measured, topology, n, near, far):
    """Medians over cases of (resolved force error, rel_loss, indentation error of force), with this Q and with the
    paper's."""
    rows = measured[f"weights-{topology}-{n}"]
    def medians(near, far):
        some = [r for r in rows if r["near"] == near and r["far"] == far]
        return np.array([median_of(some, k) for k in ("resolved", "rel_loss", "closed_loop")])
    return medians(near, far), medians(1, 1)


def half_block(block, n):
    """Number of nodes from the contact to the edge of a block: `block` itself, or as many as carry the patch of 5 mm
    half-width."""
    return -(-(n - 1) * 5 // 100) if block == PATCH else block


def q_rule(measured, topology, lattices):
    """The (block, far) nearest to the paper's among those whose resolved force error is within one percentage point of
    the smallest, and whose rel_loss rises by at most a tenth on every lattice."""
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
    """For every lattice: (best steps, those predicted without it, loss left at the best, at the predicted, and at
    0.003)."""
    curves, table = gain_points(measured, topology), {}
    for n in LATTICES:
        rule = gain_rule({k: v for k, v in curves.items() if k[0] != n}, kind)
        own = {k: v for k, v in curves.items() if k[0] == n}
        predicted = {k: float(np.clip(steps_of(rule, *k), STEPS[0], STEPS[-1])) for k in own}
        table[n] = np.array([[best_step(v), predicted[k], at_step(v, best_step(v)), at_step(v, predicted[k]),
                              at_step(v, 0.003)] for k, v in own.items()])
    return table


def left_rule(curves):
    """Fit of the loss that is left at the best step: a (n / 10)^b (d / 10 mm)^e."""
    n, d = np.array(list(curves)).T
    return fit([np.ones_like(n), np.log(n / 10), np.log(d / 0.01)], [c.min() for c in curves.values()])


def one_step(measured):
    return float(np.exp(gain_rule(gain_points(measured, "grid4"), "one")[0]))
