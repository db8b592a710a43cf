"""A study's report as one HTML file: page.py RESULTS OUT.html

Reads report.md, eval.json, the figures that report.md shows, and the provenance in model.h5 and cases.h5. Texts and
tables are report.md's. Added are the main number, key figures, captions, and sortable tables. The file needs no other
file. The same results give the same bytes.
"""
import base64
import re
import sys
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "figures"))
try:
    import jinja2  # noqa: E402
    from markdown_it import MarkdownIt  # noqa: E402
    from markupsafe import Markup, escape  # noqa: E402
    from stored import stored  # noqa: E402
except ImportError as error:
    sys.exit(f"page.py: {error}; install python3-{(error.name or '').replace('_', '-')}, which the report is made with")

from results import EVALUATION, LABELS  # noqa: E402  (the figures' names of the models)
from one_line import read_json, reading, say  # noqa: E402
from save import written  # noqa: E402

LONG_LIST = 5          # longer lists are folded
PORTRAIT_COLUMNS = 14  # tables with more columns are printed in landscape format
CAPTIONS = {
    "contours": "Displacement of two load cases in finite elements",
    "force": "Force at the loaded node against tool displacement, all nodes at their FE displacement (Fig. 3 of the paper)",
    "learning": "Loss of each spring set against iterations (Fig. 4 of the paper)",
    "springs": "Trained spring stiffnesses (Fig. 6 of the paper)",
    "errors": "Errors of each model at the training contacts",
    "character": "Differences of the spring sets from the heuristic, and the least loss against that difference",
    "held_out": "Indentation error of force at contacts of the test set",
    "held_out_force": "Force against tool displacement at contacts of the test set",
    "histories": "Force over time in displacement histories of the test set",
    "shape": "Deformed tissue at contacts of the test set, in finite elements and in the model; indentation errors of displacement and of force",
    "map": "Force of straight indentations over the top, in finite elements and in the model; an inclusion is below",
    "solid": "Section through a contact of the test set: displacement in finite elements, in the model, and their difference",
}


class ReportError(Exception):
    """A file is missing, or report.md does not have the form that tissuectl writes."""


def percent(value):
    return "none" if value is None else f"{100 * value:.1f} %"


# ---- head of the report

def lead(e):
    """The main number, and the key figures: [(value, description)]."""
    closed, figures = e["closed_loop"], []
    if "held_out" in closed:
        learned = closed["held_out"]["learned"]
        number = learned["median"]
        figures += [(learned["p95"], "95th percentile"),
                    (learned["max"], "largest of " + n_of(learned, "contacts"))]
        if learned.get("shape"):
            figures.append((learned["shape"]["median"], "indentation error of displacement, median"))
        figures += best_baseline(closed["held_out"], e)
        if "held_out_full" in closed:
            full = closed["held_out_full"]["learned"]
            figures.append((full["median"], f"median over the full range of depth and angle, {n_of(full, 'contacts')}"))
    else:
        trained = closed["trained"]["learned"]
        loss = {model: errors["rel_loss"]["median"] for model, errors in e["open_loop"].items()}
        number = loss["learned"]
        figures += [(loss["optimum"], "certified optimum of this mesh"),
                    (loss["heuristic_a"], "Van Gelder's heuristic"),
                    (trained["median"], f"indentation error of force, {n_of(trained, 'load cases')}")]
        figures += best_baseline(closed["trained"], e)
    if e.get("truth_check", {"n": 0})["n"]:
        figures.append((e["truth_check"]["median"], f"change of the FE force on a finer mesh, {n_of(e['truth_check'], 'indentations')}"))
    return percent(number), [(percent(value), what) for value, what in figures]


def n_of(statistics, what):
    """"n of N", as in report.md (lib/eval/statistics.h)."""
    text = f"{statistics['n']} of {statistics['of']} {what}"
    for key, words in (("missing", "without an answer"), ("no_reference", "without a reference")):
        text += f", {statistics[key]} {words}" if statistics[key] else ""
    return text


def best_baseline(errors, e):
    """Median indentation error of force of the best untrained springs, if they have an answer."""
    medians = {m: v["median"] for m, v in errors.items() if v["median"] is not None and m.startswith(("heuristic", "uniform"))}
    best = min(medians, key=medians.get, default=None)
    return [(medians[best], f"best untrained springs ({label(best, e) or best}), indentation error of force")] if best else []


# ---- Markdown to HTML

def picture(folder, source):
    """A PNG as a data URI."""
    file = folder / source
    if file.suffix != ".png" or not file.is_file():
        raise ReportError(f"{file}: is not a figure that can be put inline")
    with reading(file):
        return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode()


def label(model, e):
    """A model's name in words; "" where it has none."""
    words = {**LABELS, "untrained": "the energy model before training",
             "heuristic_a_patch": "Van Gelder's springs, contact of the model",
             "heuristic_b_patch": "the same, E2 = (C1 + C2) t",
             "uniform_patch": "springs of one stiffness, contact of the model",
             "force_table": "measured forces at the training contacts, interpolated" if "measurement" in e else "FE forces at the training contacts, interpolated"}
    for training in [e["training"]] + e.get("training_also", []):
        if "terms" in training:
            words["learned"] = f"an energy model with {len(training['terms'])} parameters"
            continue
        own = training["optimizer"]
        words["learned" if training is e["training"] else "learned_" + re.sub("[-:]", "_", own)] = f"trained by {own}"
    if model in words:
        return words[model]
    base, _, mesh = model.partition("_grid")
    return f"{words[base]}, grid{mesh.replace('_', ' ')}" if mesh and base in words else ""


def named(text, e):
    """A cell's HTML. The name of a model, as `heuristic_a`, gets its description below."""
    words = label(text, e)
    return Markup(f"{escape(text)}<small>{escape(words)}</small>") if words else escape(text)


class Column(NamedTuple):
    group: str    # heading over several columns, or ""
    name: str
    cells: list


def columns(head, body, heading):
    """Columns of a table. A column with "a / b / c" in every cell becomes three if they have names: from the column's
    own heading ("gap median / max") or from the section's ("...: median / p95 / max")."""
    found = []
    for i, title in enumerate(head):
        cells = [row[i] for row in body]
        parts = [cell.split(" / ") for cell in cells]
        count = max((len(p) for p in parts), default=1)
        group, names = title, heading.rpartition(": ")[2].split(" / ")
        own = title.split(" / ")
        if len(own) > 1:
            group, first = next(own[0].rsplit(mark, 1) for mark in (": ", ", ", " ") if mark in own[0])
            names = [first] + own[1:]
        parts = [p * count if p == ["none"] else p for p in parts]
        if count > 1 and len(names) == count and all(len(p) == count for p in parts):
            found += [Column(group, name, [p[k] for p in parts]) for k, name in enumerate(names)]
        else:
            found.append(Column("", title, cells))
    return found


def table(tokens, heading, e):
    """A table's HTML, from its tokens."""
    rows = []
    for token in tokens:
        if token.type == "tr_open":
            rows.append([])
        elif token.type == "inline":
            rows[-1].append(token.content)
    found = columns(rows[0], rows[1:], heading)
    grouped = any(c.group for c in found)
    marks = []  # CSS classes: the row's name, and the first column of a group
    for i, c in enumerate(found):
        parted = i > 0 and c.group != found[i - 1].group
        marks.append(Markup(' class="row"') if i == 0 else Markup(' class="first"') if parted else "")
    top, below = [], []
    for i, c in enumerate(found):
        cell = Markup('<th scope="col" data-column="{}"{}{}>{}</th>')
        if not c.group:
            top.append(cell.format(i, Markup(' rowspan="2"') if grouped else "", marks[i], c.name))
            continue
        if i == 0 or found[i - 1].group != c.group:
            width = sum(1 for other in found if other.group == c.group)
            top.append(Markup('<th scope="colgroup" colspan="{}">{}</th>').format(width, named(c.group, e)))
        below.append(cell.format(i, "", marks[i], c.name))
    lines = [Markup("<tr>{}</tr>").format(Markup("").join(cells)) for cells in (top, below) if cells]
    body = [Markup("<tr>{}</tr>").format(Markup("").join(
        Markup("<td{}>{}</td>").format(marks[i], named(c.cells[r], e) if i == 0 else c.cells[r])
        for i, c in enumerate(found))) for r in range(len(rows) - 1)]
    line = Markup("\n")
    kind = "table wide" if len(found) > PORTRAIT_COLUMNS else "table"
    return Markup('<div class="{}" tabindex="0" role="region" aria-label="{}"><table>\n<thead>\n{}\n</thead>\n'
                  '<tbody>\n{}\n</tbody>\n</table></div>\n').format(
                      kind, heading.replace("`", ""), line.join(lines), line.join(body))


def to_html(markdown, text, heading, e):
    """A section's HTML: tables by table(), long lists folded, the rest as Markdown. A unit stays on the line of its
    number."""
    tokens = markdown.parse(text.replace(" %", "\u00a0%"))
    out, at = [], 0
    while at < len(tokens):
        kind, level = tokens[at].type, tokens[at].level
        end = at + 1
        if tokens[at].nesting == 1:
            closing = kind.replace("_open", "_close")
            end = next(i for i in range(at, len(tokens)) if tokens[i].type == closing and tokens[i].level == level) + 1
        block = tokens[at:end]
        items = sum(1 for t in block if t.type == "list_item_open")
        if kind == "table_open":
            out.append(table(block, heading, e))
        else:
            html = markdown.renderer.render(block, markdown.options, {})
            if items > LONG_LIST:
                html = f"<details><summary>Show all {items}</summary>\n{html}</details>\n"
            out.append(html)
        at = end
    return Markup("".join(out))


def sections(text):
    """report.md as (first part without its title, [(heading, Markdown)])."""
    parts = re.split(r"^## +(.+)$", text, flags=re.M)
    return re.sub(r"^# .*$", "", parts[0], count=1, flags=re.M), list(zip(parts[1::2], parts[2::2]))


def anchor(heading):
    return re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-")


# ---- provenance

def provenance(folder, e):
    """[(label, value)]: the commands and inputs that made the results."""
    rows = [("Made by", f"make all STUDY={e['study']}"), ("Version", f"tissuectl {e['version']}"), ("Seed", e["seed"])]
    for name, word in (("cases.h5", "Cases"), ("model.h5", "Training")):
        with stored(folder / name) as file:
            says = {key: value.decode() if isinstance(value, bytes) else value for key, value in file.attrs.items()}
            rows.append((word, says["command"]))
            rows += [(f"Input of {word.lower()}", f"{key[6:]} (XXH3 {value})") for key, value in says.items()
                     if key.startswith("input:") and not key.endswith(".csv")]
    return rows


def page(folder):
    e = read_json(folder / "eval.json", EVALUATION)
    with reading(folder / "report.md"):
        report = (folder / "report.md").read_text()
    first, found = sections(report)
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table")
    figures = []
    body = []
    for heading, text in found:
        if heading == "Figures":
            for name, source in re.findall(r"!\[(\w+)\]\(([^)]+)\)", text):
                figures.append({"name": name, "caption": CAPTIONS.get(name, name), "data": picture(folder, source)})
        else:
            body.append({"id": anchor(heading), "heading": Markup(markdown.renderInline(heading)),
                         "html": to_html(markdown, text, heading, e)})
    first = re.sub(r"^Written by .*$", "", first, flags=re.M)  # the foot of the page has the provenance
    number, key_figures = lead(e)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(HERE), autoescape=True, trim_blocks=True,
                                     lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    return environment.get_template("page.html").render(
        study=e["study"], number=number, key_figures=key_figures, lead=to_html(markdown, first, "", e),
        figures=figures, sections=body, provenance=provenance(folder, e),
        style=Markup((HERE / "page.css").read_text()), script=Markup((HERE / "page.js").read_text()))


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: page.py RESULTS OUT.html")
    folder, out = Path(sys.argv[1]), Path(sys.argv[2])
    try:
        text = page(folder)
    except ReportError as error:
        say(folder, error)
    with written(out) as beside:
        Path(beside).write_text(text)


if __name__ == "__main__":
    main()
