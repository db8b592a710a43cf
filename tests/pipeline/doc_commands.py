"""Runs the commands printed in documents: doc_commands.py ROOT COPY PAGE...; prints one "ok - " or "not ok - " line per
check.

A block of code (indented by four, or between ```) is a list of commands, run one by one from the root of COPY, unless a
comment precedes it:
  <!-- a study -->                    a study: written to fem/studies/printed.toml, planned, and its shape meshed
  <!-- continued -->                  the block begins with the files that the one before it left
  <!-- not run: REASON -->            no command of it is run
  <!-- not run [BEGINNING]: REASON -->  commands that begin with BEGINNING are not run; the others are
A word in CAPITALS stands for a file of the reader, which is in COPY/given. A study that `tissuectl new` writes gets
fewer contacts, and is removed before the next block that is not continued. In `code` within a line, targets of make,
commands, options and scripts are checked for existence, not run.
"""
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

LONGEST = 150  # [s] limit of one command
MARK = re.compile(r"<!-- (a study|continued|not run(?: \[(?P<beginning>[^\]]+)\])?: (?P<reason>\S.*?)) -->$")
FILE_HEADS = {"load", "history"}  # `tissuectl load path` is the first line of a file


def blocks(text):
    """Yields (number of the first line, lines, marks) of every block of code."""
    lines, marks, number = text.splitlines(), [], 0
    while number < len(lines):
        line = lines[number]
        fenced = line.startswith("```")
        if fenced or line.startswith("    ") and line.strip() and (number == 0 or not lines[number - 1].strip()):
            begin = number = number + fenced
            while number < len(lines) and (not lines[number].startswith("```") if fenced else not lines[number].strip() or lines[number].startswith("    ")):
                number += 1
            code = [l if fenced else l[4:] for l in lines[begin:number]]
            yield begin + 1, code, marks
            marks, number = [], number + fenced
            continue
        if line.startswith(("<!-- a study", "<!-- continued", "<!-- not run")):
            marks.append((number + 1, line))
        elif line.strip() and not line.startswith("<!--"):
            marks = []
        number += 1


def commands(begin, code):
    """Yields (line number, command). Lines that end in a backslash are joined."""
    whole, at = "", begin
    for number, line in enumerate(code, begin):
        at = at if whole else number
        whole += line.rstrip("\\") if line.endswith("\\") else line
        if not line.endswith("\\"):
            if whole.strip() and not whole.startswith("#"):
                yield at, whole.rstrip()
            whole = ""


class Runner:
    def __init__(self, copy):
        self.copy, self.counts = Path(copy), {"ran": 0, "not run": 0}
        self.failures, self.written = 0, []
        self.environment = {**os.environ, "PATH": f"{self.copy}/build/release:{os.environ['PATH']}", "NO_INSTALL": "1"}

    def check(self, what, trouble):
        print(f"{'not ok' if trouble else 'ok'} - {what}")
        self.failures += bool(trouble)
        for line in str(trouble or "").splitlines()[-12:]:
            print(f"#   {line}")
        sys.stdout.flush()

    def run(self, command):
        """Runs a command. Returns None, or the output with the failure. A server runs until it has printed its
        address."""
        serves = re.search(r"\btissuectl serve\b", command)
        with open(self.copy / "said", "w+b") as said:
            process = subprocess.Popen(["bash", "-c", command], cwd=self.copy, env=self.environment, stdin=subprocess.DEVNULL, stdout=said,
                                       stderr=subprocess.STDOUT, start_new_session=True)
            until, address = time.monotonic() + LONGEST, False
            while process.poll() is None and time.monotonic() < until and not address:
                time.sleep(0.05)
                address = serves and b"http://" in (self.copy / "said").read_bytes()
            running = process.poll() is None
            if running:
                os.killpg(process.pid, signal.SIGTERM)
                process.wait(20)
            words = (self.copy / "said").read_text(errors="replace")
        if address:
            return None
        if running:
            return f"{words}\nstill runs after {LONGEST} s"
        return f"{words}\nexit status {process.returncode}" if process.returncode else None

    def fewer_contacts(self, name):
        study = self.copy / "fem/studies" / f"{name}.toml"
        self.written.append(study)
        text = re.sub(r"^count = .*", "count = 2", study.read_text(), flags=re.M)
        study.write_text(re.sub(r"^(spacing_m|angles_deg) = .*", lambda m: m[1] + (" = 0.04" if m[1] == "spacing_m" else " = [0]"), text, flags=re.M))

    def provide(self):
        """Removes written studies and copies the reader's files, as every block begins with them."""
        for study in self.written:
            study.unlink(missing_ok=True)
        for file in (self.copy / "given").iterdir():
            (self.copy / file.name).write_bytes(file.read_bytes())

    def study(self, code):
        (self.copy / "fem/studies/printed.toml").write_text("\n".join(code) + "\n")
        return self.run("rm -rf results/printed && make STUDY=printed mesh && tissuectl plan --study fem/studies/printed.toml --mesh results/printed/mesh.msh"
                        " --out results/printed/plan.mk && test -s results/printed/plan/collect")

    def page(self, root, name):
        for begin, code, marks in blocks((Path(root) / name).read_text()):
            read = [(number, MARK.match(mark)) for number, mark in marks]
            for number, mark in read:
                if not mark:
                    self.check(f"{name}:{number}: a mark of code", "is none of <!-- a study -->, <!-- continued --> and <!-- not run: REASON -->")
            marks = [mark for _, mark in read if mark]
            if any(mark[1] == "a study" for mark in marks):
                self.counts["ran"] += 1
                self.check(f"{name}:{begin}: a study", self.study(code))
                continue
            continued = any(mark[1] == "continued" for mark in marks)
            marks = [mark for mark in marks if mark[1] != "continued"]
            if any(not mark["beginning"] for mark in marks):
                self.counts["not run"] += 1
                continue
            beginnings = [mark["beginning"] for mark in marks]
            used = set()
            if not continued:
                self.provide()
            for number, command in commands(begin, code):
                skipping = next((b for b in beginnings if command.startswith(b)), None)
                if skipping is not None:
                    used.add(skipping)
                    self.counts["not run"] += 1
                    continue
                self.counts["ran"] += 1
                trouble = self.run(command)
                self.check(f"{name}:{number}: {' '.join(command.split())[:100]}", trouble)
                new = re.search(r"\btissuectl new (\S+)", command)
                if new and not trouble:
                    self.fewer_contacts(new[1])
            for beginning in set(beginnings) - used:
                self.check(f"{name}:{begin}: not run [{beginning}]", "no command begins so")


class Words:
    """Checks that commands within a line of text exist."""

    def __init__(self, copy, root):
        self.copy, self.root = Path(copy), Path(root)
        makefile = (self.root / "Makefile").read_text()
        self.targets = set(re.findall(r"^## ([a-z0-9-]+):", makefile, re.M))
        self.help = {}

    def help_of(self, *words):
        if words not in self.help:
            said = subprocess.run([str(self.copy / "build/release" / words[0]), *words[1:], "--help"], capture_output=True, text=True)
            self.help[words] = said.stdout if said.returncode == 0 else ""
        return self.help[words]

    def trouble(self, code):
        first = code.partition("&&")[0]
        try:
            words = shlex.split(first)
        except ValueError:  # an unbalanced quote, from the sentence
            words = first.split()
        words = [w for w in words if not re.match(r"[A-Z_]+=", w)]
        if not words:
            return None
        program = Path(words[0]).name
        if words[0] == "make":
            said = [w for w in words[1:] if not re.match(r"-|.*[/%'=]", w)]
            unknown = [w for w in said if w not in self.targets]
            return f"make has no target {unknown[0]}" if unknown else None
        if words[0].startswith("scripts/") and len(words) > 1 and not os.access(self.root / words[0], os.X_OK):
            return f"{words[0]} is not a program"
        if words[0].startswith("build/release/bench/"):
            return f"{words[0]} is built by make benches alone: begin with it"
        if program not in ("tissuectl", "tissue-haptic"):
            return None
        topic = (program,)
        if program == "tissuectl" and len(words) > 1 and re.fullmatch("[a-z]+", words[1]) and words[1] not in FILE_HEADS:
            topic = (program, words[1])
            if not re.search(rf"^ +{words[1]} ", self.help_of(program), re.M):
                return f"tissuectl has no command {words[1]}"
        for option in re.findall(r"(?<!\S)--[a-z][a-z_-]*", code):
            if option not in re.findall(r"--[a-z][a-z_-]*", self.help_of(*topic)):
                return f"{' '.join(topic)} has no option {option}"
        return None

    def page(self, runner, name):
        text = (self.root / name).read_text()
        found = []
        for match in re.finditer(r"(?<!`)`([^`]+)`(?!`)", text):
            code = " ".join(match[1].split())
            trouble = self.trouble(code) if re.match(r"([A-Z_]+=\S+ )*(make|tissuectl|tissue-haptic|scripts/|build/release/)", code) else None
            if trouble:
                found.append(f"{name}:{text[:match.start()].count(chr(10)) + 1}: `{code}`: {trouble}")
        runner.check(f"{name}: commands, options, targets and scripts named in the text exist", "\n".join(found))


def main():
    root, copy, pages = sys.argv[1], sys.argv[2], sys.argv[3:]
    runner, words = Runner(copy), Words(copy, root)
    for page in pages:
        words.page(runner, page)
    for page in pages:
        runner.page(root, page)
    print(f"# of {sum(runner.counts.values())} commands {runner.counts['ran']} were run, {runner.counts['not run']} are marked as not run")
    sys.exit(runner.failures > 0)


if __name__ == "__main__":
    main()
