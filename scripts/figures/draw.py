"""Draws one figure of a study: draw.py FIGURE RESULTS OUT.png.

FIGURE is a module beside this file (contours, force, learning, springs, errors) with draw(results) -> figure.
"""
import importlib
import logging
import sys
from pathlib import Path

# a home that cannot be written to is no news here
logging.getLogger("matplotlib").setLevel(logging.ERROR)
import needs  # noqa: E402, F401, I001  (before what may be missing)
import matplotlib  # noqa: E402

matplotlib.use("Agg")

import results  # noqa: E402  (after the backend is chosen)
from save import save  # noqa: E402


def main():
    if len(sys.argv) != 4:
        sys.exit("usage: draw.py FIGURE RESULTS OUT.png")
    name, folder, out = sys.argv[1:]
    if not (Path(__file__).parent / f"{name}.py").is_file():
        sys.exit(f"draw.py: there is no figure '{name}'")
    data = results.load(folder)
    figure = importlib.import_module(name).draw(data)
    save(figure, out)


if __name__ == "__main__":
    main()
