"""Sphinx: the documents as one site with a search (`make docs`), static files without a server.

The pages are the project's Markdown where it lies: the source folder is the project's, so a link works on a git host and
here. `make docs` makes warnings errors: a page that index.md does not list, a link to nothing, a heading that does not
exist. Formulas become MathML, which browsers draw themselves. TISSUE_MODULE is the folder of the Python module.
"""
import os
import sys

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.util import logging

sys.path.insert(0, os.environ["TISSUE_MODULE"])

project, author, html_title = "tissuectl", "the authors of tissuectl", "tissuectl"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
include_patterns = ["*.md", "cli/**.md", "fem/**.md", "lib/**.md", "results/*.md", "results/reference/*.md", "scripts/**.md"]
exclude_patterns = [".git", "build", "tests"]
root_doc = "scripts/docs/index"
html_extra_path = ["index.html"]  # from the site's folder to root_doc
html_theme = "furo"
html_static_path, html_css_files = ["site.css"], ["site.css"]
html_copy_source = html_show_sphinx = html_show_copyright = False
smartquotes = False               # -- begins an option

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4          # headings have the names that a git host gives them
highlight_language = "text"       # of indented blocks: commands, formulas, lines of files

autodoc_member_order = "bysource"


def draw(inline):
    def visit(translator, node):
        try:
            formula = latex2mathml.tex2mathml(node.astext(), inline=inline)
            translator.body.append(formula if inline else f'<div class="formula">{formula}</div>')
        except SyntaxError as error:
            logging.getLogger(__name__).warning("formula %s: %s", " ".join(node.astext().split()), error, location=node)
        raise nodes.SkipNode

    return visit, None


def as_printed(app, what, name, obj, options, lines):
    """Docstrings are plain text: an indented part keeps its lines, and a line after a full stop is a paragraph."""
    text, indented = [], False
    for line in lines:
        literal = line.startswith("    ")
        if literal and not indented:
            text += ["", "::", ""]
        elif text and not literal and (indented or text[-1].endswith(".")):
            text.append("")
        indented = literal
        text.append(line)
    lines[:] = text


def setup(app):
    app.add_html_math_renderer("mathml", draw(True), draw(False))
    app.connect("autodoc-process-docstring", as_printed)
