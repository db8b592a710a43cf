"""docs_links.py ROOT PAGE...: exits 0 if every relative link and picture of these pages leads to a file of ROOT, and
every link to a heading leads to an existing one. Otherwise prints the wrong links.

A heading's name in links is GitHub's: lower case, dashes for blanks, no other punctuation. Blocks of code have no
links.
"""
import re
import sys
from pathlib import Path


def prose(text):
    """The text without blocks of code, fenced or indented, and without code within lines."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    lines = (line for line in text.splitlines() if not line.startswith("    "))
    return "\n".join(re.sub(r"`[^`]*`", "", line) for line in lines)


def headings(text):
    names = set()
    for title in re.findall(r"^#+ +(.*)$", text, re.M):
        title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).strip().lower()
        names.add(re.sub(r"[^\w\- ]", "", title).replace(" ", "-"))
    return names


def wrong_links(root, page):
    text = (root / page).read_text()
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, heading = target.partition("#")
        file = (root / page).parent / path if path else root / page
        if not file.exists() or root.resolve() not in [file.resolve(), *file.resolve().parents]:
            yield f"{page}: link to {target}: there is no such file"
        elif heading and heading not in headings(file.read_text()):
            yield f"{page}: link to {target}: there is no such heading"


def main():
    if len(sys.argv) < 3:
        sys.exit("usage: docs_links.py ROOT PAGE...")
    root = Path(sys.argv[1])
    lines = [line for page in sys.argv[2:] for line in wrong_links(root, page)]
    print("\n".join(lines))
    sys.exit(1 if lines else 0)


if __name__ == "__main__":
    main()
