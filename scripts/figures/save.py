"""How every figure is saved: save(figure, out); and any file that must be whole: with written(out) as beside."""
import contextlib
import fcntl
import os
import sys
from pathlib import Path


@contextlib.contextmanager
def written(out):
    """The name of a file beside `out` that becomes it in the end, or is removed. It is ours alone meanwhile: a second
    program that writes the same waits for its lock, as lib/io/atomic_file does."""
    beside = f"{out}.tmp"
    while True:
        lock = open(beside, "ab")
        fcntl.flock(lock, fcntl.LOCK_EX)
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(lock.fileno()), os.stat(beside)):
                break
        lock.close()  # the other one has moved it into place
    with lock:
        try:
            yield beside
            os.fsync(lock.fileno())  # its content is on the disk before its name
            os.replace(beside, out)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(beside)
            raise


def save(figure, out):
    """Written beside and renamed; ends the program with one line when the disk refuses. No date and no version inside:
    the same data give the same bytes."""
    try:
        with written(out) as beside:
            figure.savefig(beside, dpi=110, format="png", metadata={"Software": None})
    except OSError as error:
        sys.exit(f"{Path(sys.argv[0]).name}: {out}: {error.strerror}")
