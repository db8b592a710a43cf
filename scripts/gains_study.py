"""Measures how gains, iterations and Q should follow mesh size and displacement: gains_study.py PROBE OUT.

The paper leaves such a formula to future work (Sec. 5). Needs results/lattice-{6,11,21,41}/cases.h5. Measurements of
PROBE (scripts/gains_probe.cpp) are kept in results/gains/. They are repeated when a study's cases, the probe or the
options change. Writes OUT.md and OUT.png. Each constant is fitted without one lattice and evaluated on that lattice.
"""
import json
import os
import subprocess
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "figures")]
import needs  # noqa: E402, F401, I001  (before packages that may be missing)
from gains.draw import draw  # noqa: E402
from gains.page import page  # noqa: E402
from gains.questions import MESHES, questions  # noqa: E402
from one_line import read_json  # noqa: E402
from save import save, written  # noqa: E402


def measure(probe, name, nodes, topology, magnitudes, task):
    study, folder = f"lattice-{nodes}", Path("results/gains")
    cases, kept = Path(f"results/{study}/cases.h5"), folder / f"{name}.json"
    options = ["--topology", topology, "--law", MESHES[topology], *(["--magnitude", *magnitudes] if magnitudes else []),
               *task]
    newest = max(Path(probe).stat().st_mtime, cases.stat().st_mtime)
    if kept.exists() and kept.stat().st_mtime > newest:
        answer = read_json(kept, {"options": [str], "rows": [{}]})
        if answer["options"] == options:
            return answer["rows"]
    print(f"gains {name}", file=sys.stderr, flush=True)
    done = subprocess.run([probe, "--study", f"fem/studies/{study}.toml", "--cases", str(cases), *options],
                          stdout=subprocess.PIPE, check=True)
    rows = json.loads(done.stdout)
    folder.mkdir(parents=True, exist_ok=True)
    with written(kept) as beside:
        Path(beside).write_text(json.dumps({"options": options, "rows": rows}))
    return rows


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: gains_study.py PROBE OUT")
    probe, out = sys.argv[1:]
    measured = {name: measure(probe, name, *question) for name, question in questions()}
    text = page(measured)
    print(text)
    with written(out + ".md") as beside:
        Path(beside).write_text(text)
    save(draw(measured), out + ".png")


if __name__ == "__main__":
    main()
