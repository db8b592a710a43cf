"""Compares the speed of our programs with that of others: bench.py [--make MAKE] [--quick] PROGRAM...   (`make bench`)

Writes results/bench.json, a list of {"name", "unit", "median", "p95", "n", "peer", "peer_version", "peer_median",
"ratio"}. ratio = our median / the peer's median, both from this run and measured alternately. The peer fields are null
where there is no peer, or where it is not installed (scripts/venv). Prints the same as a table. A slow machine is not
an error.

PROGRAM     build/.../bench_NAME, made from tests/bench/bench_NAME.cpp, or a script tests/bench/bench_NAME.py.
            This script runs bench_train in parts, and tissue-haptic for a minute, alternating with cyclictest. Any
            other program is run once as `bench_NAME results/paper` and prints a JSON list of {"name", "unit",
            "samples"}, or of finished entries.
--quick     leaves out the last parts: how the cost of training in space grows; the whole study `surface` from clean,
            which takes longer than all the rest, its training alone, and how its cost grows
"""
import argparse
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parent / "figures"))
from save import written  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
STUDY = "fem/studies/paper.toml"
SOLID = "fem/studies/block3-quick.toml"
RESULTS = "results/paper"
WORK = "build/bench"                    # temporary: FE results for timing only
VENV = ROOT / "build" / "venv" / "bin" / "python"
PEERS = "tests/bench"
KEYS = ["name", "unit", "median", "p95", "n", "peer", "peer_version", "peer_median", "ratio"]

FE_ROUNDS = 3
SETS = [0, 3, 6, 9, 12, 15]             # 6 of the 18: every kind of path, both magnitudes
SESSION_S = 20                          # [s] of each of three sessions, and of cyclictest after each
PRIORITY = 80                           # real-time priority of tissue-haptic
SAME_FORCE = 1e-6                       # relative; a peer whose force differs by more does not solve the same problem


# ---- entries

def quantile(samples, q):
    """Quantile of the samples by linear interpolation between order statistics."""
    s = sorted(samples)
    at = q * (len(s) - 1)
    low = math.floor(at)
    return s[low] + (at - low) * (s[min(low + 1, len(s) - 1)] - s[low])


def entry(name, unit, samples, peer=None, peer_version=None, peer_samples=()):
    e = dict.fromkeys(KEYS)
    e.update(name=name, unit=unit, median=quantile(samples, 0.5), p95=quantile(samples, 0.95), n=len(samples))
    if peer_samples:
        theirs = quantile(peer_samples, 0.5)
        e.update(peer=peer, peer_version=peer_version, peer_median=theirs, ratio=e["median"] / theirs)
    return e


def note(text):
    print(f"bench: {text}", file=sys.stderr, flush=True)


def table(entries):
    def number(x):
        return "" if x is None else f"{x:.3g}" if x < 1e4 else f"{x:.0f}"

    rows = [["", "median", "p95", "unit", "n", "peer", "its median", "ratio"]]
    for e in entries:
        peer = "" if e["peer"] is None else f"{e['peer']} {e['peer_version']}"
        rows.append([e["name"], number(e["median"]), number(e["p95"]), e["unit"], str(e["n"]), peer,
                     number(e["peer_median"]), number(e["ratio"])])
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    left = {0, 3, 5}
    for row in rows:
        print("  ".join(w.ljust(n) if k in left else w.rjust(n)
                        for k, (w, n) in enumerate(zip(row, widths))).rstrip())


# ---- running programs

def environment():
    """The environment without the variables of `make bench`: makes started here must not be its sub-makes."""
    env = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES")}
    return {**env, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "LC_ALL": "C"}


def run(command, **options):
    """The program's stdout. Raises RuntimeError with the last line of stderr."""
    done = subprocess.run([str(w) for w in command], cwd=ROOT, env=environment(), text=True, capture_output=True,
                          **options)
    if done.returncode != 0:
        words = (done.stderr.strip() or done.stdout.strip() or "no word").splitlines()[-1]
        raise RuntimeError(f"{Path(str(command[0])).name} exits with {done.returncode}: {words}")
    return done.stdout


def timed(command):
    """stdout, wall seconds, and processor seconds of the program and its children."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    out = run(command)
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return out, wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Peer:
    """A Python program in build/venv. Its first failure is reported; after that it is not run again."""

    def __init__(self, name):
        self.name, self.version, self.there = name, None, VENV.exists()
        if not self.there:
            note(f"no {name}: build/venv does not exist, so there is no comparison")

    def ask(self, script, *arguments):
        """(what it printed as JSON, wall seconds, processor seconds), or None."""
        if not self.there:
            return None
        try:
            out, wall, cpu = timed([VENV, f"{PEERS}/{script}", *arguments])
            answer = json.loads(out)
        except (RuntimeError, json.JSONDecodeError) as error:
            note(f"no {self.name}: {error}")
            self.there = False
            return None
        self.version = answer["version"]
        return answer, wall, cpu


# ---- finite elements

def contact_forces(csv):
    """[s, fx, fy] of every record of a load path."""
    rows = [line.split(",") for line in open(csv) if line.startswith("step,")]
    return [[float(row[k]) for k in (2, 4, 5)] for row in rows]


def worst_difference(ours, theirs):
    """Largest relative difference of two paths' contact forces; infinite if they do not have the same records."""
    if len(ours) != len(theirs):
        return math.inf
    return max(math.dist(a[1:], b[1:]) / math.hypot(*b[1:]) if abs(a[0] - b[0]) < 1e-9 else math.inf
               for a, b in zip(ours[1:], theirs[1:]))


def against_felupe(name, felupe, plan, folder, paths, processes, ours, rounds):
    """Entries of wall and processor time. ours() runs our program and returns (wall, cpu); felupe runs the same paths,
    alternately."""
    mine, its, same = [], [], True
    for _ in range(rounds):
        mine.append(ours())
        answer = same and felupe.ask("peer_felupe.py", "--plan", plan, "--results", folder, "--processes", processes,
                                     "--only", ",".join(paths))
        if answer:
            forces = answer[0]["forces"]
            worst = max(worst_difference(contact_forces(ROOT / folder / "cases" / f"{p}.csv"), forces[p])
                        for p in paths)
            its.append(answer[1:])
            same = worst <= SAME_FORCE
            if not same:
                note(f"{name}: felupe's contact forces differ by {worst:.1e}, so its time is not compared")
                its = []
    return [entry(f"{name}, {what}", "s", [t[k] for t in mine], "felupe", felupe.version, [t[k] for t in its])
            for k, what in ((0, "wall"), (1, "processor"))]


def bench_finite_elements(make, felupe):
    """The paper's nine load paths, then one on a mesh with 16 times as many elements. felupe solves the same discrete
    problem: same mesh file, P2 plane stress, 7 quadrature points, records and tolerance."""
    folder = f"{WORK}/paper"
    make = [make, "--no-print-directory", "-j2", "STUDY=paper", f"R={folder}"]
    run([*make, "mesh"])
    plan = (ROOT / folder / "plan.mk").read_text()
    lines = dict(re.findall(r"cases/([^/\s]+)\.csv: PATH_ARGUMENTS = (.*)", plan))
    paths = [p for p, line in lines.items() if f"{folder}/mesh.msh" in line.replace("$(R)", folder)]
    targets = [f"{folder}/cases/{p}.csv" for p in paths]

    def nine():
        for target in targets:
            (ROOT / target).unlink(missing_ok=True)
        return timed([*make, *targets])[1:]

    entries = against_felupe(f"FE paper, {len(paths)} paths, P2 plane stress, point, make -j2", felupe,
                             f"{folder}/plan.mk", folder, paths, 2, nine, FE_ROUNDS)

    # One of the paths on 40 x 40 cells, 13,122 unknowns; then one short record, for the start-up cost.
    fine = f"{WORK}/fine"
    (ROOT / fine / "plan").mkdir(parents=True, exist_ok=True)
    line = lines["left"].replace("$(R)", fine)
    for key, value in (("depth", 0.005), ("records", 10)):
        line = re.sub(rf"-{key} \S+", f"-{key} {value}", line)
    (ROOT / fine / "plan.mk").write_text(f"$(R)/cases/left.csv: PATH_ARGUMENTS = {line}\n")
    (ROOT / fine / "plan" / "path-left").touch()
    run(["gmsh", "-v", "1", "-2", "-format", "msh22", "-setnumber", "cells_x", 40, "-setnumber", "cells_y", 40,
         "fem/block.geo", "-o", f"{fine}/mesh.msh"])
    entries += against_felupe("FE left path to 5 mm, 13122 unknowns, 1 process", felupe, f"{fine}/plan.mk", fine,
                              ["left"], 1, lambda: timed(["scripts/solve_path", fine, "left", *line.split()])[1:],
                              FE_ROUNDS)
    start = re.sub(r"-records \S+", "-records 1", re.sub(r"-depth \S+", "-depth 0.0001", lines["left"]))
    start = start.replace("$(R)", folder).split()
    times = [timed(["scripts/solve_path", fine, "left", *start])[1:] for _ in range(5)]
    return entries + [entry("FE start-up and one record of a path of paper, processor", "s", [t[1] for t in times])]


# ---- training

def bench_training(program, noisyopt, qiskit):
    cases = f"{RESULTS}/cases.h5"
    entries = [entry(**e) for e in json.loads(run([program, "sets", STUDY, cases]))]
    losses = f"{WORK}/losses.json"
    (ROOT / WORK).mkdir(parents=True, exist_ok=True)
    (ROOT / losses).write_text(run([program, "export", STUDY, cases]))
    iterations = json.loads((ROOT / losses).read_text())[0]["iterations"]

    ours = {optimizer: {"iteration": [], "rel_loss": []} for optimizer in ("spsa", "spsa-2008")}
    theirs = {peer.name: {"iteration": [], "rel_loss": []} for peer in (noisyopt, qiskit)}
    loss_us, loss_by = [], {}
    for s in SETS:
        for optimizer, peer in (("spsa", noisyopt), ("spsa-2008", qiskit)):
            for e in json.loads(run([program, "iterate", STUDY, cases, optimizer, s])):
                ours[optimizer][e["name"]] += e["samples"]
            loss_us += json.loads(run([program, "loss", STUDY, cases, s]))[0]["samples"]
            answer = peer.ask("peer_spsa.py", peer.name, losses, s)
            if answer:
                answer = answer[0]
                theirs[peer.name]["iteration"].append(answer["iteration_us"])
                theirs[peer.name]["rel_loss"].append(answer["rel_loss"])
                loss_by.setdefault((answer["loss_by"], answer["loss_by_version"]), []).append(answer["loss_us"])

    by, us = max(loss_by.items(), key=lambda item: len(item[1]), default=((None, None), []))
    entries.append(entry("train paper, loss (9), one evaluation, processor", "us", loss_us, *by, us))
    for optimizer, samples in ours.items():
        for what, name, unit in (("iteration", "an iteration, processor", "us"),
                                 ("rel_loss", f"rel_loss after at most {iterations} iterations", "1")):
            for peer in (noisyopt, qiskit):
                sentence = f"train paper, {len(SETS)} sets, {optimizer}, {name}, beside {peer.name}"
                entries.append(entry(sentence, unit, samples[what], peer.name, peer.version, theirs[peer.name][what]))
    return entries + printed_entries([program, "lattice"])


def train_alone(tissuectl, study, cases, out):
    """Wall seconds and peak memory [MB] of one process."""
    begin = time.perf_counter()
    with open(os.devnull, "wb") as nowhere:
        child = subprocess.Popen([tissuectl, "train", "--study", study, "--cases", cases, "--out", out], cwd=ROOT,
                                 env=environment(), stdout=nowhere, stderr=nowhere)
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise RuntimeError(f"tissuectl train exits with {child.returncode}")
    return time.perf_counter() - begin, used.ru_maxrss / 1024


def bench_whole_study(make, tissuectl, train_program, study):
    """The whole study from an empty folder to figures and report; then its training alone, and how the cost of training
    grows."""
    folder, file = f"{WORK}/{study}", f"fem/studies/{study}.toml"
    shutil.rmtree(ROOT / folder, ignore_errors=True)
    wall = timed([make, "--no-print-directory", "-j2", "all", f"STUDY={study}", f"R={folder}"])[1]
    entries = [entry(f"{study}: the whole study from clean, FE included, make -j2, wall", "s", [wall])]
    cases = f"{folder}/cases.h5"
    seconds, megabytes = train_alone(tissuectl, file, cases, f"{folder}/again.h5")
    entries += [entry(f"{study}: its training, one process, wall", "s", [seconds]),
                entry(f"{study}: its training, one process, peak memory", "MB", [megabytes])]
    # An energy model has no spring sets; those of surface-sets, at the same contacts, are timed in its place.
    sets = {"surface": "surface-sets"}.get(study, study)
    return entries + printed_entries([train_program, "scaling", f"fem/studies/{sets}.toml", cases])


# ---- the 1 kHz loop on this machine

def cyclictest(seconds):
    """Largest lateness [us] of a thread without work. None if there is no cyclictest; the cause is printed."""
    command = ["cyclictest", "-q", "-m", "-p", str(PRIORITY), "-i", "1000", "-t", "1", "-D", str(seconds),
               "--laptop"]             # keeps the processor's sleep states, as tissue-haptic does
    try:
        out = run(command)
        return float(re.search(r"Max:\s*(\d+)", out).group(1))
    except (OSError, RuntimeError, AttributeError) as error:
        note(f"no cyclictest: {str(error).strip() or 'it printed no known result'}")
        return None


def cyclictest_version():
    try:
        words = subprocess.run(["cyclictest", "--help"], text=True, capture_output=True)
        return re.search(r"V (\S+)", words.stdout + words.stderr).group(1)
    except (OSError, AttributeError):
        return None


def bench_sessions(program, seconds):
    """Three sessions, alternating with cyclictest of the same priority, interval and duration."""
    study = "surface" if (ROOT / "results/surface/model.h5").exists() else "paper"
    command = [program, f"results/{study}/model.h5", "--device", "virtual", "--motion", "poke",
               "--json", "--seconds", seconds]
    ours, machine = [], []
    for _ in range(3):
        ours.append(json.loads(run(command)))
        if len(machine) == len(ours) - 1:
            machine += [late for late in [cyclictest(seconds)] if late is not None]
    if len(machine) < len(ours):
        machine = []
    version = cyclictest_version()
    for session in ours:
        for notice in session["details"]["notices"]:
            note(notice)
    what = f"haptic: {3 * seconds} s of study {study} at 1 kHz, poke"

    def count(key):
        return sum(session[key] for session in ours)

    return [entry(f"{what}, overruns", "ticks", [count("misses")]),
            entry(f"{what}, overruns that the program caused", "ticks", [count("misses_program")]),
            entry(f"{what}, tick p99", "us", [s["tick_us"]["p99"] for s in ours]),
            entry(f"{what}, longest tick", "us", [max(s["tick_us"]["max"] for s in ours)]),
            entry(f"{what}, latency p50", "us", [s["lateness_us"]["p50"] for s in ours]),
            entry(f"{what}, largest latency of {seconds} s", "us", [s["lateness_us"]["max"] for s in ours],
                  "cyclictest", version, machine),
            entry(f"{what}, largest latency", "us", [max(s["lateness_us"]["max"] for s in ours)],
                  "cyclictest", version, [max(machine)] if machine else [])]


# ---- all other programs

def printed_entries(command):
    """Entries that a program prints: finished ones, or ones with samples."""
    return [entry(**e) if "samples" in e else {**dict.fromkeys(KEYS), **e} for e in json.loads(run(command))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make", default="make", help="make program with which FE is timed")
    parser.add_argument("--quick", action="store_true", help="without training in space and the whole study from clean")
    parser.add_argument("--study", default="surface", help="study that is run from clean")
    parser.add_argument("--session", type=int, default=SESSION_S, metavar="s",
                        help="length of each of the three sessions of tissue-haptic")
    parser.add_argument("programs", nargs="*", metavar="PROGRAM")
    options = parser.parse_args()
    begin = time.perf_counter()

    parts = [("finite elements", lambda: bench_finite_elements(options.make, Peer("felupe")))]
    train_program = None
    for program in options.programs:
        if Path(program).name == "tissue-haptic":
            parts.append(("sessions of tissue-haptic", lambda p=program: bench_sessions(p, options.session)))
        elif Path(program).name == "bench_train":
            train_program = program
            parts.append(("training", lambda p=program: bench_training(p, Peer("noisyopt"), Peer("qiskit-algorithms"))))
        else:
            parts.append((Path(program).name, lambda p=program: printed_entries([p, RESULTS])))
    if train_program and not options.quick:
        tissuectl = Path(train_program).parents[1] / "tissuectl"
        parts.append(("training in space", lambda: printed_entries([train_program, "space", SOLID])))
        parts.append((f"the whole study {options.study}",
                      lambda: bench_whole_study(options.make, tissuectl, train_program, options.study)))
    entries, failed = [], 0
    for name, part in parts:
        print(f"bench {name}", file=sys.stderr, flush=True)
        try:
            entries += part()
        except (RuntimeError, OSError, json.JSONDecodeError, KeyError) as error:
            note(f"{name} failed: {error}")
            failed = 1

    out = ROOT / "results" / "bench.json"
    with written(out) as beside:
        Path(beside).write_text("[\n" + ",\n".join(" " + json.dumps(e) for e in entries) + "\n]\n")
    table(entries)
    print(f"{len(entries)} entries in results/bench.json, {time.perf_counter() - begin:.0f} s")
    return failed


if __name__ == "__main__":
    sys.exit(main())
