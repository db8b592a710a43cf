"""A file that cannot be read in its expected form, or cannot be written, ends the program with one line and exit status
2.

`with reading(FILE):` encloses only the code that reads the file, so that a defect elsewhere still gives a traceback.
`read_json(FILE, FORM)` reads JSON and checks the types that later code expects.
"""
import contextlib
import json
import sys
from pathlib import Path


def say(file, why):
    """Prints one line and ends the program. Control characters of a file's name or content are replaced."""
    line = " ".join(f"{Path(sys.argv[0]).name}: {file}: {why}".split())
    print("".join(c if c.isprintable() else "?" for c in line.encode("utf-8", "replace").decode()), file=sys.stderr)
    sys.exit(2)


@contextlib.contextmanager
def reading(file):
    try:
        yield
    except OSError as error:  # h5py's OSErrors have a text and no error number
        say(file, error.strerror or error)
    except KeyError as error:
        say(file, f"has no {error}" if len(str(error).split()) == 1 else error.args[0])
    except Exception as error:  # any error of a reader on bytes of another format
        say(file, error or type(error).__name__)


KINDS = {dict: "an object", list: "a list", str: "a text", float: "a number", int: "a whole number", bool: "true or false", type(None): "null"}
NUMBER_OR_NULL = (float, type(None))  # null is infinite: an answer is missing


class Object(dict):
    """An object of a JSON file. Access to a missing key ends the program."""

    def __init__(self, content, file, place):
        super().__init__(content)
        self.file, self.place = file, place

    def __missing__(self, key):
        say(self.file, f"{self.place}has no '{key}'")


def read_json(file, form, lines=False):
    """The content of a JSON file, or with `lines` the list of its lines' contents. Its form: a type; [form] for a list;
    [form, ...] for a list that is not empty; {key: form} for an object, where the key "*" stands for all that are not
    named; a tuple of forms; None for any. A missing key is reported on access."""
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
    """Checks that lists of an object of read_json have the same length."""
    if len({len(part[key]) for key in keys}) > 1:
        say(part.file, f"{part.place}{', '.join(keys)} differ in length")
