"""whole_files.py FOLDER...: exits 0 if every file in them is complete; otherwise prints the incomplete ones. Unfinished
files (.tmp) and logs (.log) are not read."""
import json
import sys
from pathlib import Path

import h5py


def all_of(file):
    """Reads every dataset and attribute."""
    with h5py.File(file) as h5:
        if "format_version" not in h5.attrs:
            raise ValueError("has no format version")
        h5.visititems(lambda _, item: (dict(item.attrs), item[()] if isinstance(item, h5py.Dataset) else None))


def last_line(file, *allowed):
    lines = file.read_text().rstrip("\n").splitlines()
    if not lines or not lines[-1].startswith(allowed):
        raise ValueError("is cut off")


WHOLE = {
    ".h5": all_of,
    ".json": lambda file: json.loads(file.read_text()),
    ".csv": lambda file: last_line(file, "end", "lost"),
    ".msh": lambda file: last_line(file, "$EndElements"),
    ".html": lambda file: last_line(file, "</html>"),
    ".png": lambda file: file.read_bytes()[-8:-4] == b"IEND" or (_ for _ in ()).throw(ValueError("is cut off")),
    ".mk": lambda file: last_line(file, ""),
    ".md": lambda file: last_line(file, ""),
}

bad = []
for folder in sys.argv[1:]:
    for file in sorted(Path(folder).rglob("*")):
        if file.is_file() and file.suffix in WHOLE:
            try:
                WHOLE[file.suffix](file)
            except (OSError, ValueError, KeyError) as error:
                bad.append(f"{file}: {error}")
sys.exit("\n".join(bad) or 0)
