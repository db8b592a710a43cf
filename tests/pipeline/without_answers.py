"""without_answers.py RESULTS: exits 0 if every figure of a study and its report.html are drawn without any answer of
the learned model, and without any FE reference of the drawn contacts. Its eval.json is changed accordingly in a copy,
in the format of results/FORMATS.md.
"""
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def none_of(statistics, lost):
    """Marks all answers, or with `lost` all references, as missing."""
    if not isinstance(statistics, dict):
        return
    if "no_reference" in statistics:
        of = statistics["of"]
        statistics.update(median=None, p95=None, max=None, n=0, missing=0 if lost else of, no_reference=of if lost else 0)
    for inner in statistics.values():
        none_of(inner, lost)


def no_answer(e):
    e.pop("drawn_shapes", None)
    for role, contacts in e.get("drawn", {}).items():
        none_of(e["closed_loop"][role]["learned"], lost=False)
        for contact in contacts:
            contact["error"]["learned"] = contact.get("shape", {})["learned"] = None
    for curve in e.get("drawn_curves", []):
        curve["models_N"]["learned"] = [None] * len(curve["fe_N"])
    for place in e.get("map", {}).get("places", []):
        place["learned_N"] = None
    if "contrast" in e.get("map", {}):
        e["map"]["contrast"]["learned"] = None
    for history in e.get("histories", {}).get("each", []):
        history["learned_N"] = [None] * len(history["fe_N"])
        history["error"]["learned"] = {"rms": None, "peak": None}


def all_lost(e):
    for role in e.get("drawn", {}):
        none_of(e["closed_loop"][role], lost=True)
    for key in ("drawn", "drawn_shapes", "drawn_curves"):
        e.pop(key, None)
    for key in ("places", "contrast"):
        e.get("map", {}).pop(key, None)
    if "histories" in e:
        e["histories"].pop("each", None)
        e["histories"]["groups"] = {group: {"elastic": models["elastic"]} for group, models in e["histories"]["groups"].items()}
        none_of(e["histories"], lost=True)


SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def main():
    results = Path(sys.argv[1])
    evaluation = (results / "eval.json").read_text()
    for change in (no_answer, all_lost):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "results"
            shutil.copytree(results, folder, ignore=shutil.ignore_patterns("cases", "*.msh"))
            e = json.loads(evaluation)
            change(e)
            (folder / "eval.json").write_text(json.dumps(e))
            commands = [[SCRIPTS / "figures" / "draw.py", figure.stem, folder, figure] for figure in sorted(folder.glob("figures/*.png"))]
            for command in commands + [[SCRIPTS / "report" / "page.py", folder, folder / "report.html"]]:
                done = subprocess.run([sys.executable, *command], stderr=subprocess.PIPE, text=True)
                if done.returncode != 0:
                    sys.exit(f"{change.__name__}: {' '.join(map(str, command[:2]))}: {done.stderr.strip()}")


if __name__ == "__main__":
    main()
