"""Finds words that documents must not use, each with its replacement (lib/GLOSSARY.md): docs_words.py ROOT FILE...

Code, names between backticks, link targets, quotations and generated tables are ignored. Prints one line per word
found; exits 1 if there is one.
"""
import re
import sys
from pathlib import Path

WORDS = {  # pattern: replacement
    r"\btruth\b": "FE reference",
    r"\bclosed[- ]loop (?:error|answer|force)s?\b": "indentation error, equilibrium; closed loop is of a hand in feedback",
    r"\bheld[- ]out\b": "test set",
    r"\bstands? beside\b": "baseline, or what it is",
    r"\brivals?\b": "baseline",
    r"\bledgers?\b": "energy log, session statistics",
    r"\bcrumpl\w*": "self-intersecting, buckled",
    r"\bfloppy\b": "with zero-energy modes",
    r"\bpatients?\b": "target tissue",
    r"\bbeliev\w*": "gated; a program does not believe",
    r"\bnobody\b": "the actor, or the passive",
    r"\b(?:the|a|its|learned|trained|untrained|energy) laws?\b(?! of)": "energy model; a material law is one of a material",
    r"\b(?:was|is|are|were|been) told\b": "printed, reported",
    r"\bspectr(?:um|a)\b": "Prony series",
    r"\bstrokes?\b": "displacement history",
    r"\bpok(?:e|es|ed|ing)\b": "force measurement, to press",
}


def prose(text):
    """Lines of a document with their numbers, without code, links, comments and quotations."""
    generated = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("<!-- begin "):
            generated = True
        if not generated and not line.startswith("    "):
            yield number, re.sub(r"`[^`]*`|\]\([^)]*\)|<!--.*?-->|\"[^\"]*\"", " ", line)
        if line.startswith("<!-- end "):
            generated = False


def main():
    root, found = Path(sys.argv[1]), 0
    for name in sys.argv[2:]:
        for number, line in prose((root / name).read_text()):
            for pattern, instead in WORDS.items():
                for word in re.findall(pattern, line, re.IGNORECASE):
                    print(f"{name}:{number}: '{word}': write {instead}")
                    found += 1
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
