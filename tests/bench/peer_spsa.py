#!/usr/bin/env python3
"""SPSA of noisyopt and qiskit-algorithms on the losses of `bench_train export`: peers of scripts/bench.py.

Both have the settings of spsa-2008: the same start and iterations, exponents 0.602 and 0.101, and perturbation E2. The
gain a is calibrated to the same mean first step, 0.003 E2, with the A of each (noisyopt's is fixed at 1 % of the
iterations). noisyopt respects the bounds; qiskit has none, so its result is projected onto the box before it is
evaluated. The loss is a matrix-vector product by numpy or by scipy's sparse matrix, whichever is faster on this
machine. Times are processor times.

Prints {"version", "peer", "iteration_us", "rel_loss", "loss_us", "loss_by"} as one line of JSON.
Sample run: build/venv/bin/python tests/bench/peer_spsa.py noisyopt build/bench/losses.json 3
"""
import json
import os
import sys
import time
from importlib.metadata import version

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np
import scipy
import scipy.sparse

ALPHA, GAMMA, FIRST_STEP, ESTIMATES = 0.602, 0.101, 0.003, 10  # as in lib/train/spsa_2008.h


def losses(s):
    """The loss of one spring set, as a function by numpy and one by scipy."""
    target = np.array(s["target"])
    sparse = scipy.sparse.csr_array((s["value"], (s["row"], s["column"])), shape=(len(target), len(s["start"])))
    dense = np.ascontiguousarray(sparse.toarray())

    def by(matrix):
        def loss(theta):
            r = target - matrix @ theta
            return np.sqrt(r @ r)
        return loss

    return {"numpy": by(dense), "scipy": by(sparse)}


def evaluation_us(loss, theta, calls=200):
    """Time of one evaluation [us], median over ten batches."""
    times = []
    for _ in range(10):
        begin = time.process_time()
        for _ in range(calls):
            loss(theta)
        times.append(1e6 * (time.process_time() - begin) / calls)
    return float(np.median(times))


def calibrated(loss, start, c, unit, A, rng):
    """The gain a for a mean first step of FIRST_STEP E2."""
    slopes = []
    for _ in range(ESTIMATES):
        delta = rng.choice([-1.0, 1.0], size=len(start))
        slopes.append(abs(loss(start + c * delta) - loss(start - c * delta)) / (2 * c))
    return FIRST_STEP * unit * (A + 1) ** ALPHA / np.mean(slopes)


def main():
    peer, file, index = sys.argv[1], sys.argv[2], int(sys.argv[3])
    s = json.load(open(file))[index]
    start, lo, hi, unit, iterations = (np.array(s["start"]), np.array(s["lo"]), np.array(s["hi"]), s["unit"],
                                       s["iterations"])
    ways = losses(s)
    us = {name: evaluation_us(loss, start) for name, loss in ways.items()}
    way = min(us, key=us.get)
    loss = ways[way]
    if abs(loss(start) / s["start_loss"] - 1) > 1e-12:
        raise RuntimeError(f"this loss is not the exported one: {loss(start)} for {s['start_loss']}")
    rng = np.random.default_rng(2008 + index)
    np.random.seed(2008 + index)

    if peer == "noisyopt":
        from noisyopt import minimizeSPSA
        a = calibrated(loss, start, unit, unit, 0.01 * iterations, rng)
        begin = time.process_time()
        theta = minimizeSPSA(loss, start.copy(), bounds=np.stack([lo, hi], 1), niter=iterations, paired=False, a=a,
                             alpha=ALPHA, c=unit, gamma=GAMMA).x
    elif peer == "qiskit-algorithms":
        from qiskit_algorithms.optimizers import SPSA
        from qiskit_algorithms.optimizers.spsa import powerseries
        from qiskit_algorithms.utils import algorithm_globals
        algorithm_globals.random_seed = 2008 + index
        A = 0.1 * iterations
        a = calibrated(loss, start, unit, unit, A, rng)
        method = SPSA(maxiter=iterations, learning_rate=lambda: powerseries(a, ALPHA, A),
                      perturbation=lambda: powerseries(unit, GAMMA))
        begin = time.process_time()
        theta = method.minimize(loss, start.copy()).x
    else:
        raise SystemExit(f"peer_spsa: {peer} is not known; allowed: noisyopt, qiskit-algorithms")
    seconds = time.process_time() - begin
    reached = loss(np.clip(theta, lo, hi)) / np.linalg.norm(s["target"])
    print(json.dumps({"peer": peer, "version": version(peer), "iteration_us": 1e6 * seconds / iterations,
                      "rel_loss": float(reached), "loss_us": us[way],
                      "loss_by": way, "loss_by_version": {"numpy": np, "scipy": scipy}[way].__version__}))


if __name__ == "__main__":
    main()
