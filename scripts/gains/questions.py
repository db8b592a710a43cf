"""Measurements for gains, iterations and Q: the lattices, steps and weights."""

LATTICES = [6, 11, 21, 41]

MESHES = {"grid4": "isotropic", "grid8": "axial"}

STEPS = [0.001, 0.002, 0.004, 0.008, 0.016, 0.032, 0.064]

GAP = 0.02  # gap to the least loss at which `spsa` is finished

BUDGET = 5000  # where the paper's learning curve flattens (Fig. 4)

FARS = [1, 0.3, 0.1, 0.03, 0.01, 0.001]

NEARS = [1, 2, 4]

PATCH = "the patch"  # the nodes with a part of its force: 3 x 3 up to n = 21, 5 x 5 on n = 41

SOME = ["0.005", "0.015"]  # magnitudes where all four would take too long [m]


def questions():
    """All measurements: name -> (nodes a side, topology, magnitudes, task of the probe and its options)."""
    steps = ["--first-step", *map(str, STEPS)]
    for n in LATTICES:
        for topology in MESHES:
            largest = n == 41
            some = SOME if largest else []
            yield f"iterations-{topology}-{n}", (n, topology, ["0.01"] if largest and topology == "grid8" else some,
                                                 ["iterations", "--gap", str(GAP)])
            yield f"gains-{topology}-{n}", (n, topology, some, ["gains", "--budget", str(BUDGET), *steps, "--repeats",
                                                                "1" if largest else "2"])
            if not (largest and topology == "grid8"):
                yield f"weights-{topology}-{n}", (n, topology, SOME, [
                    "weights", "--near", *map(str, NEARS), "--far", *map(str, FARS)])
    yield "perturbation-grid4-11", (11, "grid4", [], ["gains", "--budget", str(BUDGET), *steps, "--repeats", "2",
                                                      "--perturbation", "0.01", "0.1"])
    for n in (11, 21):
        yield f"budget-grid4-{n}", (n, "grid4", SOME, ["gains", "--budget", "1000", "20000", *steps])
