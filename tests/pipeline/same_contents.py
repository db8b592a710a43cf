"""same_contents.py RESULTS RESULTS: exits 0 if two result folders have the same numbers; otherwise prints where they
differ.

Compares every dataset bit by bit, every load path byte by byte, and eval.json without its wall times and hashes.
"""
import json
import sys
from pathlib import Path

import h5py
import numpy as np

NOT_COMPARED = {"seconds", "model_hash", "cases_hash"}   # wall times, and hashes of files that contain wall times


def datasets(file):
    found = {}
    with h5py.File(file) as h5:
        h5.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


def same_array(a, b):
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype == object or b.dtype == object:
        return a.tolist() == b.tolist()
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def without_time(value):
    if isinstance(value, dict):
        return {key: without_time(v) for key, v in value.items() if key not in NOT_COMPARED}
    return [without_time(v) for v in value] if isinstance(value, list) else value


def differences(one, other):
    for name in ("cases.h5", "model.h5"):
        a, b = datasets(one / name), datasets(other / name)
        for dataset in sorted(a.keys() | b.keys()):
            if dataset not in a or dataset not in b or not same_array(a[dataset], b[dataset]):
                yield f"{name}: {dataset}"
    paths = {file.name for folder in (one, other) for file in (folder / "cases").glob("*.csv")}
    for name in sorted(paths):
        a, b = one / "cases" / name, other / "cases" / name
        if not a.exists() or not b.exists() or a.read_bytes() != b.read_bytes():
            yield name
    a, b = (without_time(json.loads((folder / "eval.json").read_text())) for folder in (one, other))
    if a != b:
        yield "eval.json"


found = list(differences(Path(sys.argv[1]), Path(sys.argv[2])))
sys.exit("differ: " + ", ".join(found) if found else 0)
