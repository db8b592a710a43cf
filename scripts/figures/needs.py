"""Imported before packages that may be missing. Without one of them the program prints one line on what to install, no
traceback."""
import sys
from pathlib import Path


PACKAGES = {"matplotlib", "numpy", "scipy", "h5py", "jinja2", "markdown_it", "markupsafe", "vtk"}


def told(kind, error, trace):
    if not issubclass(kind, ImportError) or (error.name or "").partition(".")[0] not in PACKAGES:
        return sys.__excepthook__(kind, error, trace)
    print(f"{Path(sys.argv[0]).name}: {error}; install python3-{error.name.partition('.')[0].replace('_', '-')}", file=sys.stderr)


sys.excepthook = told
