"""How every figure is saved: save(figure, out)."""
import os
import sys
from pathlib import Path


def save(figure, out):
    """Written beside and renamed; ends the program with one line when the disk refuses. No date and no version inside:
    the same data give the same bytes."""
    beside = f"{out}.tmp"
    try:
        figure.savefig(beside, dpi=110, format="png", metadata={"Software": None})
        os.replace(beside, out)
    except OSError as error:
        if os.path.exists(beside):
            os.unlink(beside)
        sys.exit(f"{Path(sys.argv[0]).name}: {out}: {error.strerror}")
