"""A study's reference record, results/reference/STUDY.json: its content, and the comparison of two records.

Only reference.py and regress read and write records, through this file. SI units, stated in names (_N, _m, _E2); errors
and losses are relative. Stages: `paths` (FE), `trained` (spring sets), `evaluation`.

Rounding differs between types of machine and between versions of compiler and libraries, so a record names those it was
made with. With the same ones, counts and hashes must be equal. With others, hashes are not compared. The tolerances are
then about a hundred times the changes of the paper study with OpenBLAS's kernels for three other processors
(OPENBLAS_CORETYPE = Nehalem, Sandybridge, SkylakeX; in brackets below). Values that belong to one of many minimisers of
a loss are then not compared (ONE_OF_MANY).
"""
import ctypes
import datetime
import functools
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(1, str(Path(__file__).resolve().parent / "figures"))
from one_line import fitted, read_json  # noqa: E402
from save import written  # noqa: E402
from stored import stored  # noqa: E402

SCHEMA = 2
FOLDER = Path(__file__).resolve().parent.parent / "results" / "reference"
EVALUATION = {"study": str, "version": str, "seed": int, "lost": {"*": [str]}, "drawn": {"*": [{"name": str}]}}
RECORD = {"made": {"date": str}, "machine": {}, "study": str, "unique": bool}
NOT_COMPARED = {"schema", "made", "machine", "unique"}
NOT_KEPT = {"study", "version", "format_version", "seed", "seconds", "model_hash", "cases_hash", "trained_errors", "curves", "drawn", "drawn_curves", "drawn_shapes", "places", "each", "pairs",
            "kkt_residual", "kkt_residual_max"}  # recorded elsewhere, wall times, large data, and residuals of rounding
PACKAGES = ["gmsh", "freefem++", "libfreefem++", "libc6", "libeigen3-dev", "libgsl27", "libhdf5-103-1", "libnlopt0",
            "libopenblas0-pthread", "libstdc++6", "libumfpack5"]


class RecordError(Exception):
    """A record is missing or cannot be compared."""


class Rule(NamedTuple):
    pattern: str       # regular expression for the key
    relative: float    # a number may move by relative * |reference| + absolute
    absolute: float
    kind: str          # "number", "count" (equal on the same machine), "hash" (compared on the same machine only)


# The first rule that matches a key is used. In brackets: largest change with other kernels.
RULES = [
    Rule(r"theta_hash$", 0, 0, "hash"),
    Rule(r"^paths/.*/newton$", 0.05, 3, "count"),                        # [none]
    # [3 %: iteration at which SPSA stops]
    Rule(r"/(iterations|evaluations|restarts|restarted_sets)(/|$)", 0.1, 2, "count"),
    # A fit stops when 5e-6 of its errors are left to gain, so parameters vary along flat directions of the loss.
    Rule(r"/training/(terms|starts|objective)(/|$)", 0.02, 0.02, "number"),
    Rule(r"/(contact_force_N|smallest_J|energy_J)(/|$)", 1e-7, 1e-10, "number"),  # [3e-15]; Newton stops at 1e-10
    Rule(r"/gap(/|$)", 1e-5, 1e-4, "number"),                            # [1e-9]; 1e-4 of L_lb, or of 5 % of the force
    Rule(r"/(sets|n|of|missing|no_reference|floppy_sets|force_steps|force_falls)$", 0, 0, "number"),
    Rule(r"/springs/learned", 0.02, 1e-6, "number"),                     # [6e-4]; flat directions of the loss
    Rule(r"/learned[^/]*/(rel_loss)(/|$)", 1e-6, 1e-7, "number"),        # [6e-10]
    Rule(r"/histories/", 1e-3, 1e-4, "number"),                          # rounding differences grow from tick to tick
    # [1.3e-6]; errors of force and displacement of sets that are trained iteratively
    Rule(r"/learned|/two_tools/.*/alone", 1e-3, 1e-4, "number"),
    # [1e-13]; an equilibrium is accurate to 1e-10 of its forces, which is a larger displacement where a mesh is
    # compliant
    Rule(r"/(shape|shape_max_over_depth|closed_loop_shape)(/|$)", 1e-4, 1e-5, "number"),
    Rule(r"", 1e-6, 1e-7, "number"),                                     # [4e-11]; exact solutions and heuristics
]


# Values that differ between minimisers of one loss. They are compared on the same machine, or where the minimiser is
# unique (is_unique). The learned sets' loss is one of them: SPSA stops within 1e-4 of the minimum, at a different point
# of a flat valley.
ONE_OF_MANY = re.compile(r"^evaluation/(closed_loop/trained/optimum|springs/optimum|ridge_front/0/(distance_E2|smallest_eigenvalue_E2)$|"
                         r"cases/.*/optimum/closed_loop_|cases/.*/learned/rel_loss)")


class Moved(NamedTuple):
    key: str
    was: object
    now: object
    tolerance: str

    def __str__(self):
        return f"{self.key}: {text(self.was)} -> {text(self.now)} ({self.tolerance})"


def text(value):
    return f"{value:.10g}" if isinstance(value, float) else str(value)


@functools.cache  # fixed for the run, since writing records changes the checkout
def commit():
    """The checkout's commit, with + if files differ from it; - without git."""
    def git(*words):
        said = subprocess.run(["git", "-C", str(FOLDER.parent.parent), *words], capture_output=True, text=True, check=True)
        return said.stdout.strip()
    try:
        return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return "-"


# ---- content of a record

def of(results, command):
    """The record of a results folder: reads cases.h5, model.h5 and eval.json."""
    results = Path(results)
    evaluation = read_json(results / "eval.json", EVALUATION)
    evaluation.get("lost", {}).pop("train", None)  # `paths` contains these
    if not evaluation.get("lost"):
        evaluation.pop("lost", None)
    with stored(results / "cases.h5") as cases:
        names = list(cases["path_names"].asstr())
        paths = {name: load_path(cases["paths"][name]) for name in names}
    with stored(results / "model.h5") as model:
        sets, training, unique = "\n".join(model["cases/names"].asstr()), trained(model), is_unique(model)
    return rounded({
        "schema": SCHEMA,
        "made": {"command": command, "commit": commit(), "date": datetime.date.today().isoformat(), "version": evaluation["version"]},
        "machine": machine(),
        "study": evaluation["study"],
        "seed": evaluation["seed"],
        "paths": paths,
        "path_order": digest("\n".join(names).encode()),
        "set_order": digest(sets.encode()),
        "trained": training,
        "unique": unique,
        "evaluation": kept(evaluation),
    })


def load_path(path):
    """Summary of a load path: its last record, which depends on all earlier ones."""
    short = {"records": len(path["magnitude"]), "lost": int(path["role"].asstr()[1] != "")}
    if short["records"]:
        short["contact_force_N"] = path["contact_force"][-1].tolist()
    if "newton_iterations" in path:  # FE paths only, not measured ones
        short["newton"] = int(path["newton_iterations"][()].sum())
    if short["records"] and "smallest_J" in path:
        short["smallest_J"] = float(path["smallest_J"][-1])
    return short


def trained(model):
    """For an energy model only its constants: eval.json has its parameters and the outcome of its fit."""
    if "law" in model:
        return {"law": {"theta_hash": theta_hash(model["law/constants"])}}
    return {**{name: spring_sets(model["trained"][name]) for name in model["optimizers"].asstr()},
            "optimum": {"theta_hash": theta_hash(model["optimum/theta"])},
            "one_set": {"theta_hash": theta_hash(model["one_set"])}}


def is_unique(model):
    """False where loss (9) has many minimisers: springs outnumber the free nodes' equations, as on grid8. Which
    minimiser is found then depends on rounding, hence on the machine."""
    nodes, dimension = model["mesh/nodes"].shape
    return "law" in model or len(model["mesh/springs"]) <= dimension * (nodes - len(model["mesh/fixed"]))


def spring_sets(group):
    return {"theta_hash": theta_hash(group["theta"]), "status": once(list(group["status"].asstr())),
            "iterations": once(group["iterations"][()].tolist()), "restarts": once(group["restarts"][()].tolist())}


def once(values):
    """One value if all sets share it, else the list."""
    return values[0] if len(set(values)) == 1 else values


def theta_hash(theta):
    return digest(np.ascontiguousarray(theta[()], dtype="<f8").tobytes())


def digest(data):
    return hashlib.blake2b(data, digest_size=8).hexdigest()


def kept(value):
    """The evaluation without the keys of NOT_KEPT. Lists of cases become tables by name; of contacts without a
    reference only names are kept."""
    if isinstance(value, dict):
        return {key: kept(v) for key, v in value.items() if key not in NOT_KEPT}
    if isinstance(value, list) and value and isinstance(value[0], dict) and "name" in value[0]:
        return {row["name"]: kept({key: v for key, v in row.items() if key != "name"}) for row in value}
    if isinstance(value, list):
        return [kept(v) for v in value]
    return value.split(":")[0] if isinstance(value, str) and ": " in value else value


def rounded(value):
    """Rounds to ten digits, more than any tolerance needs."""
    if isinstance(value, dict):
        return {key: rounded(v) for key, v in value.items()}
    if isinstance(value, list):
        return [rounded(v) for v in value]
    return float(f"{value:.10g}") if isinstance(value, float) else value


def machine():
    """Processor, compiler, library versions and BLAS kernels. With the same ones, results are equal bit by bit."""
    cpu = {}
    try:
        for line in Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines():
            name, _, value = line.partition(":")
            cpu[name.strip()] = value.strip()
    except OSError:
        pass
    names = [platform.machine()] + [cpu.get(k, "") for k in ("vendor_id", "cpu family", "model", "stepping")]
    return {"cpu": " ".join(names), "blas": blas_kernels(), "compiler": first_line(["g++", "--version"]),
            "packages": " ".join(first_line(["dpkg-query", "-W", "-f", "${Package} ${Version}; "] + PACKAGES).split())}


def blas_kernels():
    """The kernels that OpenBLAS chooses for the processor or OPENBLAS_CORETYPE. Each rounds sums differently."""
    try:
        name = ctypes.CDLL("libopenblas.so.0").openblas_get_corename
    except (OSError, AttributeError):
        return ""
    name.restype = ctypes.c_char_p
    return name().decode()


def first_line(command):
    try:
        return (subprocess.run(command, capture_output=True, text=True).stdout.splitlines() or [""])[0]
    except OSError:
        return ""


# ---- files

def read(path):
    path = Path(path)
    try:
        record = json.loads(path.read_text())
    except FileNotFoundError:
        raise RecordError(f"{path}: there is no such reference; --accept writes one") from None
    except (OSError, ValueError) as error:
        raise RecordError(f"{path}: cannot read: {error}") from None
    schema = record.get("schema", 1) if isinstance(record, dict) else None
    if schema != SCHEMA:
        raise RecordError(f"{path}: is of schema {schema}, wanted {SCHEMA}; --accept writes a new one")
    return fitted(record, RECORD, path, "")


def write(path, record):
    """Writes a temporary file and renames it. An old record that differs only in `made` is kept."""
    path = Path(path)
    try:
        old = read(path)
        if {**old, "made": None} == {**record, "made": None}:
            return
    except RecordError:
        pass
    with written(path) as beside:
        Path(beside).write_text(dump(record) + "\n")


def dump(value, indent=0):
    """JSON with one line for each part without further structure, so that a diff shows only the values that changed."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else []
    if not any(isinstance(v, dict) or isinstance(v, list) and len(v) > 2 for v in inner):
        return json.dumps(value)
    pad = " " * (indent + 1)
    rows = [json.dumps(key) + ": " + dump(v, indent + 1) for key, v in value.items()] if isinstance(value, dict) \
        else [dump(v, indent + 1) for v in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return opening + "\n" + ",\n".join(pad + row for row in rows) + "\n" + " " * indent + closing


# ---- comparison of two records

def same_machine(reference, now):
    return reference["machine"] == now["machine"]


def differences(reference, now):
    """Values that changed by more than their tolerance, as a list of Moved in the order of the stages."""
    same = same_machine(reference, now)
    moved = []
    for key in [k for k in list(reference) + [k for k in now if k not in reference] if k not in NOT_COMPARED]:
        compare(key, reference.get(key), now.get(key), same, moved)
    return [m for m in moved if same or now["unique"] or not (ONE_OF_MANY.match(m.key) and is_number(m.was) and is_number(m.now))]


def is_number(value):
    return isinstance(value, (int, float))


def compare(key, was, now, same, moved):
    if isinstance(was, dict) and isinstance(now, dict):
        for name in list(was) + [k for k in now if k not in was]:
            if name not in now:
                moved.append(Moved(f"{key}/{name}", "there", "gone", "exact"))
            elif name not in was:
                moved.append(Moved(f"{key}/{name}", "not there", "new", "exact"))
            else:
                compare(f"{key}/{name}", was[name], now[name], same, moved)
        return
    rule = next(r for r in RULES if re.search(r.pattern, key))
    if rule.kind == "count" and not same and isinstance(was, list) != isinstance(now, list):
        was, now = (v if isinstance(v, list) else [v] * len(now if isinstance(now, list) else was) for v in (was, now))
    if isinstance(was, list) and isinstance(now, list):
        if len(was) != len(now):
            moved.append(Moved(key, f"{len(was)} values", f"{len(now)} values", "exact"))
        else:
            for i, (a, b) in enumerate(zip(was, now)):
                compare(f"{key}/{i}", a, b, same, moved)
        return
    if was == now or rule.kind == "hash" and not same:
        return
    if not all(isinstance(v, (int, float)) for v in (was, now)) or rule.kind == "hash":
        moved.append(Moved(key, was, now, "exact"))
        return
    allowed = 0 if same and rule.kind == "count" else rule.relative * abs(was) + rule.absolute
    if not abs(now - was) <= allowed:  # true for a NaN
        moved.append(Moved(key, was, now, f"allowed {allowed:.2g}" if allowed else "exact"))


def counted(value):
    """Number of values that a record compares."""
    if isinstance(value, dict):
        return sum(counted(v) for k, v in value.items() if k not in NOT_COMPARED)
    return sum(map(counted, value)) if isinstance(value, list) else 1
