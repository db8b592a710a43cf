"""Damaged shape files, .stl and .msh, meshed by gmsh and scripts/mesh: damaged_shapes.py FILE STUDY COUNT [FIRST], run
in a copy of the project.

Runs scripts/mesh with the arguments that make uses for STUDY, on FILE itself and on COUNT damaged copies of it, with
the random seeds FIRST (0), FIRST + 1, ... Each run must end within a minute: with a mesh and no output, or with exit
status 1, one line and no mesh. Prints "N meshed, N refused", and a line for each violation with the name of the kept
file. gmsh is a separate program, so the changes are random and not guided by libFuzzer. tests/fuzz/fuzz_msh.cpp tests
the reader of gmsh's output."""
import random
import re
import subprocess
import sys
from pathlib import Path

NUMBERS = ["nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "0", "-0", "-1", "1", "2", "1e9", "2147483648", "18446744073709551615", "9" * 400, "0x10", "1,5", ""]
WORDS = ['"', "solid", "endsolid", "facet", "vertex", "$Nodes", "$EndElements", "\0", "\r", "\xe4", "%s%n", "`touch broken`", "$(touch broken)", "../../x", "n" * 5000]


def damaged(text, draw):
    """One to five changes of lines, words, numbers and bytes."""
    lines = text.split("\n")
    for _ in range(draw.choice([1, 1, 2, 5])):
        if not lines:
            break
        k, how = draw.randrange(len(lines)), draw.randrange(9)
        words = lines[k].split(" ")
        if how == 0:
            del lines[k:k + draw.choice([1, 1, 7, 70])]
        elif how == 1:
            lines.insert(k, lines[draw.randrange(len(lines))])
        elif how == 2:
            lines[k:k] = lines[k:k + draw.choice([7, 70, 700])]
        elif how == 3 and draw.random() < 0.3:
            del lines[k:]
        elif how in (4, 5):
            words[draw.randrange(len(words))] = draw.choice(NUMBERS + WORDS)
            lines[k] = " ".join(words)
        elif how == 6:  # another number, in a line with several numbers
            k = draw.choice([i for i, line in enumerate(lines) if len(re.findall(r"\d+", line)) > 2] or [k])
            words = lines[k].split(" ")
            words[draw.randrange(len(words))] = repr(draw.choice([draw.uniform(-100, 100), draw.uniform(0, 0.06), draw.randrange(100)]))
            lines[k] = " ".join(words)
        elif how == 7:  # a line that begins or ends a section, or contains a count
            k = draw.choice([i for i, line in enumerate(lines) if "solid" in line or line.startswith("$") or re.fullmatch(r"[\d ]{1,20}", line)] or [k])
            lines[k] = draw.choice(["solid", "$Elements", "", draw.choice(NUMBERS), " ".join(draw.choice(NUMBERS) for _ in range(4)), 'solid a"b'])
        elif lines[k]:
            at = draw.randrange(len(lines[k]))
            lines[k] = lines[k][:at] + chr(draw.randrange(1, 256)) + lines[k][at + 1:]
    return "\n".join(lines).encode("latin-1", "replace")


def main():
    base, study, count, first = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int((sys.argv[4:] or ["0"])[0])
    text, kept = base.read_text("latin-1"), Path("damaged")
    kept.mkdir(exist_ok=True)
    tissuectl, of_study = "build/release/tissuectl", ["--study", f"fem/studies/{study}.toml"]
    subprocess.run([tissuectl, "plan", *of_study, "--out", kept / "plan.mk"], check=True)
    arguments = re.search(r"^SHAPE_ARGUMENTS := (.*)$", (kept / "plan.mk").read_text(), re.M)[1].split()
    meshed = refused = broken = 0
    for number in (None, *range(first, first + count)):
        shape, out = kept / f"{base.stem}-{number}{base.suffix}", kept / f"{base.stem}-{number}.made.msh"
        shape.write_bytes(text.encode("latin-1") if number is None else damaged(text, random.Random(number)))
        try:
            done = subprocess.run(["scripts/mesh", out, shape, *arguments, "--", tissuectl, "shape", *of_study], capture_output=True, timeout=60)
            status, said = done.returncode, done.stderr.decode(errors="replace")
        except subprocess.TimeoutExpired:
            status, said = "a minute", ""
        if status == 0 and not said and out.exists():
            meshed += 1
        elif status == 1 and said.count("\n") == 1 and not out.exists():
            refused += 1
        else:
            broken += 1
            print(f"{shape.resolve()}: status {status}, {'a mesh' if out.exists() else 'no mesh'}, printed {said[:300]!r}")
            continue
        for file in kept.glob(f"{base.stem}-{number}.*"):
            file.unlink()
    if Path("broken").exists():
        broken += 1
        print("a command in a damaged file was run")
    print(f"{meshed} meshed, {refused} refused")
    sys.exit(broken > 0 or meshed == 0 or refused == 0)


if __name__ == "__main__":
    main()
