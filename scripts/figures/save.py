"""How every figure is saved: save(figure, out); and any file that must be whole: with written(out) as beside. What the disk or a rule refuses ends the program with one line."""
import contextlib
import errno
import fcntl
import os
import re
import secrets
import stat
from pathlib import Path

from one_line import say


def left_over(out):
    """Removes what a killed program has left beside `out`: of this user, and nobody holds its lock (lib/io/beside.cpp)."""
    name = re.compile(re.escape(os.path.basename(out)) + r"\.tissue-[0-9a-f]{8}\.tmp")
    for entry in os.scandir(os.path.dirname(out) or "."):
        if not name.fullmatch(entry.name):
            continue
        with contextlib.suppress(OSError), open(os.open(entry.path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(file.fileno()).st_uid == os.geteuid() and os.path.samestat(os.fstat(file.fileno()), os.lstat(entry.path)):
                os.unlink(entry.path)


def refuse_links(out):
    """Of another user, on the way to `out` or to where a link on it leads: they are not followed (lib/io/folder.h)."""
    at, left, links = Path("/" if os.path.isabs(out) else "."), list(Path(out).parent.parts), 0
    while left:
        at = at / left.pop(0)
        if not at.is_symlink():
            continue
        if at.lstat().st_uid not in (0, os.geteuid()):
            raise OSError(errno.EPERM, f"cannot write: '{at.name}' is a link of another user, which is not followed: give the path that it leads to", out)
        links += 1
        if links > 40:
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), out)
        to = Path(os.readlink(at))
        left = [*to.parts, *left]
        at = Path("/") if to.is_absolute() else at.parent


def refuse_devices(out):
    """A file in the place of a device or of a pipe would take it away for everybody (lib/io/atomic_file.h)."""
    with contextlib.suppress(FileNotFoundError):
        mode = os.stat(out).st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise OSError(errno.EINVAL, "is a device or a pipe, wanted a file", out)


def drawn(out):
    """A new file beside `out`, open and locked where the disk has locks, and its name, which is drawn: nothing that somebody has planted is followed."""
    for _ in range(100):
        beside = f"{out}.tissue-{secrets.token_hex(4)}.tmp"
        try:
            file = open(os.open(beside, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666), "rb+")
        except FileExistsError:
            continue
        with contextlib.suppress(FileNotFoundError, BlockingIOError):  # another program has taken it for left over
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                raise
            except OSError:
                pass  # some network disks have no locks
            if os.path.samestat(os.fstat(file.fileno()), os.lstat(beside)):
                return file, beside
        file.close()
    raise OSError(errno.EEXIST, "no name beside it is free", out)


@contextlib.contextmanager
def replaced(out):
    """A name of the open file beside `out` that becomes it in the end, or is removed, as lib/io/atomic_file does: its descriptor's, so that what another
    user puts in the place of the drawn name gets nothing. Raises OSError."""
    out = os.fspath(out)
    refuse_links(out)
    refuse_devices(out)
    left_over(out)
    file, beside = drawn(out)
    with file:
        try:
            yield f"/proc/{os.getpid()}/fd/{file.fileno()}"
            try:
                os.fsync(file.fileno())  # its content is on the disk before its name
                if not os.path.lexists(beside) or not os.path.samestat(os.fstat(file.fileno()), os.lstat(beside)):
                    raise OSError(errno.ESTALE, "cannot write: another program has taken the file away that was made beside it")
                os.replace(beside, out)
            except OSError as error:  # the message names the file that was asked for
                raise OSError(error.errno, error.strerror, out) from None
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(beside)
            raise


@contextlib.contextmanager
def written(out):
    """The same, and one line where it cannot be. Within it whole content is written, or another file copied."""
    beside = None
    try:
        with replaced(out) as beside:
            yield beside
    except OSError as error:
        say(out if beside is None or error.filename in (None, beside) else error.filename, error.strerror or error)


def save(figure, out):
    """Written beside and renamed. No date and no version inside: the same data give the same bytes."""
    with written(out) as beside:
        figure.savefig(beside, dpi=110, format="png", metadata={"Software": None})
