"""Saves figures, save(figure, out), and files that must be complete, `with written(out) as beside`. A refused write
ends the program with one line."""
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
    """Removes temporary files of killed programs beside `out`: files of this user that are not locked
    (lib/io/beside.cpp)."""
    name = re.compile(re.escape(os.path.basename(out)) + r"\.tissue-[0-9a-f]{8}\.tmp")
    for entry in os.scandir(os.path.dirname(out) or "."):
        if not name.fullmatch(entry.name):
            continue
        with contextlib.suppress(OSError), open(os.open(entry.path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(file.fileno()).st_uid == os.geteuid() and os.path.samestat(os.fstat(file.fileno()), os.lstat(entry.path)):
                os.unlink(entry.path)


def refuse_links(out):
    """Refuses links of another user on the path to `out`, and on the path to the target of a link on it
    (lib/io/folder.h)."""
    at, left, links = Path("/" if os.path.isabs(out) else "."), list(Path(out).parent.parts), 0
    while left:
        at = at / left.pop(0)
        if not at.is_symlink():
            continue
        if at.lstat().st_uid not in (0, os.geteuid()):
            raise OSError(errno.EPERM, f"cannot write: '{at.name}' is a link of another user, which is not followed: give the path of its target", out)
        links += 1
        if links > 40:
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), out)
        to = Path(os.readlink(at))
        left = [*to.parts, *left]
        at = Path("/") if to.is_absolute() else at.parent


def refuse_devices(out):
    """Refuses a device or a pipe: replacing it by a file would remove it for every program (lib/io/atomic_file.h)."""
    with contextlib.suppress(FileNotFoundError):
        mode = os.stat(out).st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise OSError(errno.EINVAL, "is a device or a pipe, wanted a file", out)


def drawn(out):
    """A new file beside `out`, open and locked where the file system has locks, and its random name, so that a planted
    file or link is not used."""
    for _ in range(100):
        beside = f"{out}.tissue-{secrets.token_hex(4)}.tmp"
        try:
            file = open(os.open(beside, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666), "rb+")
        except FileExistsError:
            continue
        with contextlib.suppress(FileNotFoundError, BlockingIOError):  # another program has removed it as left over
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                raise
            except OSError:
                pass  # some network file systems have no locks
            if os.path.samestat(os.fstat(file.fileno()), os.lstat(beside)):
                return file, beside
        file.close()
    raise OSError(errno.EEXIST, "no name beside it is free", out)


@contextlib.contextmanager
def replaced(out):
    """Name of an open file beside `out` that replaces `out` at the end, or is removed on an error, as in
    lib/io/atomic_file. It is the name of the descriptor, so that a file that another user puts in place of the random
    name receives nothing. Raises OSError."""
    out = os.fspath(out)
    refuse_links(out)
    refuse_devices(out)
    left_over(out)
    file, beside = drawn(out)
    with file:
        try:
            yield f"/proc/{os.getpid()}/fd/{file.fileno()}"
            try:
                os.fsync(file.fileno())  # the content must be on the disk before the name
                if not os.path.lexists(beside) or not os.path.samestat(os.fstat(file.fileno()), os.lstat(beside)):
                    raise OSError(errno.ESTALE, "cannot write: another program has taken the file away that was made beside it")
                os.replace(beside, out)
            except OSError as error:  # the message names the requested file
                raise OSError(error.errno, error.strerror, out) from None
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(beside)
            raise


@contextlib.contextmanager
def written(out):
    """As `replaced`, but an OSError ends the program with one line. Inside, the whole content is written, or another
    file copied."""
    beside = None
    try:
        with replaced(out) as beside:
            yield beside
    except OSError as error:
        say(out if beside is None or error.filename in (None, beside) else error.filename, error.strerror or error)


def save(figure, out):
    """Writes a temporary file and renames it. It has no date and no version, so the same data give the same bytes."""
    with written(out) as beside:
        figure.savefig(beside, dpi=110, format="png", metadata={"Software": None})
