"""A file that cannot be read as what it must be ends the program with one line and exit status 2.

`with reading(FILE):` stands around what reads the file, and nothing else: a fault of our own still shows where it is.
"""
import contextlib
import sys
from pathlib import Path


def say(file, why):
    """Ends the program; a terminal obeys no control byte of a file's name or content."""
    line = " ".join(f"{Path(sys.argv[0]).name}: {file}: {why}".split())
    print("".join(c if c.isprintable() else "?" for c in line.encode("utf-8", "replace").decode()), file=sys.stderr)
    sys.exit(2)


@contextlib.contextmanager
def reading(file):
    try:
        yield
    except OSError as error:  # h5py's own have no error number, but a text
        say(file, error.strerror or error)
    except KeyError as error:
        say(file, f"has no {error}" if len(str(error).split()) == 1 else error.args[0])
    except Exception as error:  # whatever a reader meets in bytes that are none of its kind
        say(file, error or type(error).__name__)
