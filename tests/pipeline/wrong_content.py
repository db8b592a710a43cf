"""Scripts on well-formed JSON with wrong content: wrong_content.py ablation|motion|page|FIGURE FILE|RESULTS. FILE or
RESULTS/eval.json is correct.

Removes one value at a time, or replaces it by another type, in the first element of each list, and runs the script. If
there are many such changes, a sample drawn by a seed is run. The script must succeed, or end with exit status 2 and one
line that names the file."""
import contextlib
import copy
import importlib
import io
import json
import random
import shutil
import sys
import tempfile
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path[:0] = [str(SCRIPTS / "figures"), str(SCRIPTS / "report")]
import matplotlib  # noqa: E402

matplotlib.use("Agg")


class Gone:
    """Stands for the removal of a value."""


OTHERS = (Gone, [], {}, "text", None)
MOST = 60


def places(value, at=()):
    inner = value.items() if isinstance(value, dict) else [(0, value[0])] if isinstance(value, list) and value else ()
    for key, part in inner:
        yield (*at, key)
        yield from places(part, (*at, key))


def with_other(value, place, other):
    changed = copy.deepcopy(value)
    part = changed
    for key in place[:-1]:
        part = part[key]
    if other is Gone:
        del part[place[-1]]
    else:
        part[place[-1]] = other
    return changed


def runner(name, file):
    """Returns a function that runs the script on the file; its output is not kept."""
    if name in ("ablation", "motion"):
        script = importlib.import_module(name)
        script.save = lambda figure, out: None
        sys.argv = [name + ".py", str(file), "out.png"]
        return script.main
    if name == "page":
        return lambda: importlib.import_module(name).page(file.parent)
    return lambda: importlib.import_module(name).draw(importlib.import_module("results").load(file.parent))


def main():
    name, source = sys.argv[1], Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        if source.is_dir():
            shutil.copytree(source, folder, dirs_exist_ok=True)
            source = source / "eval.json"
        right, file = json.loads(source.read_text()), Path(folder) / source.name
        run, said, refused, wrong = runner(name, file), io.StringIO(), 0, 0
        changes = [(place, other) for place in places(right) for other in OTHERS]
        changes = random.Random(2008).sample(changes, min(MOST, len(changes)))
        for place, other in [((), None), *changes]:
            file.write_text(json.dumps(with_other(right, place, other) if place else right))
            if "matplotlib.pyplot" in sys.modules:
                matplotlib.pyplot.close("all")
            said.truncate(said.seek(0))
            try:
                with contextlib.redirect_stderr(said):
                    run()
                continue
            except SystemExit as end:
                refused += 1
                if place and end.code == 2 and said.getvalue().count("\n") == 1 and f"{file}: " in said.getvalue():
                    continue
                print(f"{place}: {said.getvalue()}")
            except Exception as error:  # noqa: BLE001  a user would see a traceback
                print(f"{place} {other}: {error!r}")
            wrong += 1
    print(f"{len(changes)} changes, {refused} refused, {wrong} with a wrong result")
    sys.exit(wrong > 0 or refused == 0)


if __name__ == "__main__":
    main()
