"""Draws one figure of a study: draw.py FIGURE RESULTS OUT.png.

FIGURE is a module beside this file with draw(results) -> figure, for example contours, force or learning.
"""
import importlib
import logging
import sys
from pathlib import Path

# a home directory without write permission causes a warning that does not matter here
logging.getLogger("matplotlib").setLevel(logging.ERROR)
import needs  # noqa: E402, F401, I001  (before packages that may be missing)
import matplotlib  # noqa: E402

matplotlib.use("Agg")

import results  # noqa: E402  (after the backend is chosen)
from save import save  # noqa: E402


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: draw.py FIGURE RESULTS OUT.png")
    name, folder, out = sys.argv[1:]
    figures = sorted(file.stem for file in Path(__file__).parent.glob("*.py") if "\ndef draw(results" in file.read_text())
    if name not in figures:
        sys.exit(f"draw.py: there is no figure '{name}'; there are {', '.join(figures)}")
    data = results.load(folder)
    figure = importlib.import_module(name).draw(data)
    save(figure, out)


if __name__ == "__main__":
    main()
