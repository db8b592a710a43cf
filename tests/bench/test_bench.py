"""The format of results/bench.json: test_bench.py [FILE]. `make bench` runs it after it has written the file; times are
not judged. Prints "ok - sentence" or "not ok - sentence: measured vs wanted"; exits 1 if any failed."""
import json
import math
import sys
from pathlib import Path

KEYS = ["name", "unit", "median", "p95", "n", "peer", "peer_version", "peer_median", "ratio"]
PEER = ["peer", "peer_version", "peer_median", "ratio"]
failed = 0


def check(sentence, wrong):
    """wrong: list of the entries that contradict the sentence."""
    global failed
    failed += bool(wrong)
    print(f"ok - {sentence}" if not wrong else f"not ok - {sentence}: {'; '.join(wrong[:5])} vs none")


def is_number(x):
    return isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)


def main():
    file = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "results" / "bench.json"
    entries = json.load(open(file))
    if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
        check("bench.json is a list of entries", [f"a {type(entries).__name__} or other things in it"])
        return 1
    check("bench.json is a list with at least one entry", [] if entries else ["nothing in it"])
    odd = [str(e.get("name")) for e in entries if list(e) != KEYS]
    check("every entry has exactly the documented keys in order", odd)
    if odd:
        return 1
    names = [e["name"] for e in entries]
    check("no two entries have the same name", sorted({n for n in names if names.count(n) > 1}))
    check("names and units are texts that are not empty", [str(e["name"]) for e in entries
                                        if not all(isinstance(e[k], str) and e[k] for k in ("name", "unit"))])
    check("median and p95 are finite, 0 <= median <= p95, and n > 0",
          [e["name"] for e in entries if not (is_number(e["median"]) and is_number(e["p95"])
                                              and 0 <= e["median"] <= e["p95"]
                                              and isinstance(e["n"], int) and e["n"] > 0)])
    mixed = [e["name"] for e in entries if len({e[k] is None for k in PEER}) > 1]
    check("the peer fields are all present or all null", mixed)
    check("ratio is our median over the peer's",
          [e["name"] for e in entries if e["ratio"] is not None and e["name"] not in mixed
           and not math.isclose(e["ratio"] * e["peer_median"], e["median"], rel_tol=1e-9)])
    exponents = [e for e in entries if ", exponent in " in e["name"]]
    check("an exponent is fitted to four sizes or more", [e["name"] for e in exponents if e["n"] < 4])
    in_space = [e["name"] for e in exponents if "in space" in e["name"]]
    check("if there are exponents, training in space has one each in nodes, springs and paths",
          [f"{of} without one" for of in ("nodes", "springs", "paths")
           if exponents and not any(name.endswith(f"exponent in {of}") for name in in_space)])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
