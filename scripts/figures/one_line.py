"""A file that cannot be read as what it must be, or not be written, ends the program with one line and exit status 2.

`with reading(FILE):` stands around what reads the file, and nothing else: a fault of our own still shows where it is. JSON comes by
`read_json(FILE, FORM)`, so that what is made of it later finds the types it needs.
"""
import contextlib
import json
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


KINDS = {dict: "an object", list: "a list", str: "a text", float: "a number", int: "a whole number", bool: "true or false", type(None): "null"}
NUMBER_OR_NULL = (float, type(None))  # null: infinite, an answer is missing


class Object(dict):
    """Of a JSON file; to ask it for a key that it lacks ends the program."""

    def __init__(self, content, file, place):
        super().__init__(content)
        self.file, self.place = file, place

    def __missing__(self, key):
        say(self.file, f"{self.place}has no '{key}'")


def read_json(file, form, lines=False):
    """What a JSON file holds, or with `lines` the list of what its lines hold. Its form: a type, [form] a list, [form, ...] one that is not empty,
    {key: form} an object, whose key "*" stands for all that are not named, or a tuple of forms; None is any. A key may be missing until it is asked for."""
    with reading(file):
        text = Path(file).read_text()
        content = [json.loads(line) for line in text.splitlines()] if lines else json.loads(text)
    return fitted(content, form, file, "")


def fitted(content, form, file, place):
    forms = {type(f) if isinstance(f, (dict, list)) else f: f for f in (form if isinstance(form, tuple) else (form,))}
    kind = float if type(content) is int and int not in forms else type(content)
    at = f"{place}: " if place else ""
    if form is None:
        form = kind()
    elif kind not in forms:
        say(file, f"{at}is {KINDS[type(content)]}, wanted {' or '.join(KINDS[f] for f in forms)}")
    else:
        form = forms[kind]
    if kind is dict:
        return Object({key: fitted(value, form.get(key, form.get("*")), file, f"{place}.{key}" if place else key) for key, value in content.items()}, file, at)
    if kind is list:
        if ... in form and not content:
            say(file, f"{at}is empty")
        return [fitted(value, form[0] if form else None, file, f"{place}[{k}]") for k, value in enumerate(content)]
    return content


def of_one_length(part, *keys):
    """Lists of an object of read_json that belong together."""
    if len({len(part[key]) for key in keys}) > 1:
        say(part.file, f"{part.place}{', '.join(keys)} differ in length")
