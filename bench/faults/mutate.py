#!/usr/bin/env python3
"""Breaks one line of a source at a time and checks whether the tests notice.

    bench/faults/mutate.py TEST SOURCE... [--limit N]

TEST is a test program's name, such as servo_test, which `ninja -C build/release TEST` builds. Each
mutant replaces one operator, comparison or word. Survivors, which no test notices, are printed; the
sources are put back in the end, whatever happens."""

import argparse
import random
import re
import subprocess
import sys
import time
from pathlib import Path

BUILD = Path("build/release")
CHANGES = [(r" <= ", " < "), (r" < ", " <= "), (r" >= ", " > "), (r" > ", " >= "), (r" \+ ", " - "),
           (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "), (r" && ", " || "), (r" \|\| ", " && "),
           (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"\bif \(", "if (!(1 == 1) && "),
           (r" == ", " != "), (r" != ", " == "), (r"\bstd::max\b", "std::min"), (r"= -", "= ")]


def mutants_of(path):
    """Yields (line number, mutated text) for every place where a change applies to code."""
    lines = path.read_text().splitlines(keepends=True)
    for number, line in enumerate(lines):
        if re.match(r"\s*(//|#|template|using|namespace)", line):
            continue
        code = line.split("//")[0]
        for pattern, replacement in CHANGES:
            for match in re.finditer(pattern, code):
                if code[:match.start()].count('"') % 2 == 1:
                    continue  # within a text
                mutated = code[:match.start()] + replacement + code[match.end():] + line[len(code):]
                yield number, line.strip(), mutated.strip(), "".join(
                    [*lines[:number], mutated, *lines[number + 1:]])


def program_of(test):
    return next(BUILD.glob(f"tests/*/{test}"))


def seconds_of(test):
    """Builds and runs a test program that nobody has broken."""
    subprocess.run(["ninja", "-C", BUILD, test], capture_output=True, check=True)
    start = time.monotonic()
    subprocess.run([program_of(test)], capture_output=True, check=True)
    return time.monotonic() - start


def test_notices(test, longest_s):
    """Returns None for a mutant that does not compile, else whether a test fails or never ends."""
    built = subprocess.run(["ninja", "-C", BUILD, test], capture_output=True)
    if built.returncode != 0:
        return None
    try:
        return subprocess.run([program_of(test)], capture_output=True,
                              timeout=longest_s).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("test")
    parser.add_argument("sources", nargs="+", type=Path)
    parser.add_argument("--limit", type=int, help="so many mutants, drawn at random")
    options = parser.parse_args()
    work = [(path, *mutant) for path in options.sources for mutant in mutants_of(path)]
    if options.limit and len(work) > options.limit:
        work = random.Random(1).sample(work, options.limit)
    longest_s = 5.0 + 10.0 * seconds_of(options.test)
    noticed, survivors, invalid = 0, 0, 0
    for path, number, before, after, text in work:
        original = path.read_text()
        try:
            path.write_text(text)
            verdict = test_notices(options.test, longest_s)
        finally:
            path.write_text(original)
        if verdict is None:
            invalid += 1
        elif verdict:
            noticed += 1
        else:
            survivors += 1
            print(f"{path}:{number + 1}: survives\n    {before}\n    {after}", flush=True)
    subprocess.run(["ninja", "-C", BUILD, options.test], capture_output=True, check=True)
    print(f"{noticed} of {noticed + survivors} mutants noticed, {invalid} did not compile")
    return 0


if __name__ == "__main__":
    sys.exit(main())
