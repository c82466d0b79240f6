"""A calibrated cell in a folder, which faults are injected into and programs are run on."""

import csv
import math
import re
import shutil
import subprocess
from pathlib import Path

NUMBER = r"-?[0-9.]+(?:e-?[0-9]+)?"


class CellFolder:
    """Holds cell.yaml, truth.yaml and the calibration files of one cell."""

    def __init__(self, programs, folder):
        self.programs = Path(programs)
        self.folder = Path(folder)

    def path(self, *names):
        return self.folder.joinpath(*names)

    def copy_to(self, folder):
        """Copies the files, but no recording and no run; a recording is linked."""
        shutil.rmtree(folder, ignore_errors=True)
        Path(folder).mkdir(parents=True)
        for file in self.folder.iterdir():
            if file.is_file():
                shutil.copy(file, folder)
            elif file.name == "recording":
                (Path(folder) / "recording").symlink_to(file.resolve())
        return CellFolder(self.programs, folder)

    def edit(self, name, pattern, replacement):
        """Replaces the one place where the pattern occurs; a text or a function of the match."""
        text = self.path(name).read_text()
        changed, count = re.subn(pattern, replacement, text, count=1)
        if count != 1:
            raise SystemExit(f"{self.path(name)}: has no '{pattern}'")
        self.path(name).write_text(changed)

    def edit_numbers(self, name, key, change):
        """Changes the list of numbers of a key, which stands on one line."""

        def changed(match):
            values = change([float(v) for v in match[2].split(",")])
            return match[1] + ", ".join(repr(float(v)) for v in values) + match[3]

        self.edit(name, rf"({key}: *\[)([^\[\]]*)(\])", changed)

    def edit_number(self, name, key, change):
        self.edit(name, rf"({key}: *)({NUMBER})", lambda m: m[1] + repr(change(float(m[2]))))

    def edit_rows(self, name, change):
        """Gives all rows of a table, as dictionaries, to `change`, which returns the new ones."""
        lines = self.path(name).read_text().splitlines()
        remarks = [line for line in lines if line.startswith("#")]
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        rows = change(rows)
        if self.path(name).is_symlink() or not rows:
            raise SystemExit(f"{self.path(name)}: cannot be changed")
        with open(self.path(name), "w", newline="") as out:
            out.write("".join(line + "\n" for line in remarks))
            writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)

    def own_tables(self):
        """Copies the recording's tables, so that they can be changed; its images stay linked."""
        link = self.path("recording")
        source = link.resolve()
        link.unlink()
        link.mkdir()
        (link / "images").symlink_to(source / "images")
        for file in source.iterdir():
            if file.is_file():
                shutil.copy(file, link)

    def append(self, name, lines):
        self.path(name).write_text(self.path(name).read_text() + lines)

    def use_found_arm(self):
        """Names the arm that was found in the cell file, as a user of today's chain does."""
        if "arm_found:" not in self.path("cell.yaml").read_text():
            self.append("cell.yaml", "arm_found: arm.yaml\n")

    def run(self, program, *arguments, stdin=None):
        """Runs a program in the folder. Returns its exit status and its messages, among which are
        the errors that it answers to lines of standard input."""
        done = subprocess.run([str((self.programs / program).resolve()), *map(str, arguments)],
                              cwd=self.folder, input=stdin, capture_output=True, text=True,
                              timeout=600)
        refused = [line for line in done.stdout.splitlines(True) if line.startswith('{"line":')
                   and '"error":' in line]
        return done.returncode, done.stderr + "".join(refused)

    def servo(self, *options, out="run", targets="targets.csv", stdin=None):
        if "--resume" not in options:
            shutil.rmtree(self.path(out), ignore_errors=True)
        return self.run("planar-servo", "--cell", "cell.yaml", "--targets", targets, "--out", out,
                        *options, stdin=stdin)

    def true_errors_mm(self, out="run", meant=None):
        """Returns the true errors of the targets that a run calls reached, from their own places or
        from those (x, y) that were meant."""
        results = self.path(out) / "results.csv"
        if not results.exists():
            return []
        with open(results) as table:
            rows = csv.DictReader(line for line in table if not line.startswith("#"))
            return [self.error_mm(row, (meant or {}).get(row["target"])) for row in rows
                    if row["status"] == "reached" and row["after_truth_mm"]]

    @staticmethod
    def error_mm(row, meant):
        if meant is None:
            return float(row["after_truth_mm"])
        return math.hypot(*(float(row[f"{axis}_mm"]) + float(row[f"after_truth_d{axis}_mm"]) - place
                            for axis, place in zip("xy", meant)))


def make_cell(programs, seed, folder, like="paper"):
    """Draws a cell, records and calibrates it. Returns its folder."""
    folder = Path(folder)
    if not (folder / "map.yaml").exists():
        shutil.rmtree(folder, ignore_errors=True)
        drawn = CellFolder(programs, folder.parent)
        folder.parent.mkdir(parents=True, exist_ok=True)
        for program, *arguments in (
            ("planar-virtual-cell", "draw", "--seed", seed, "--like", like, "-o", folder.name),
            ("planar-experiment", "--cell", f"{folder.name}/cell.yaml", "--out",
             f"{folder.name}/experiment", "-q")):
            status, said = drawn.run(program, *arguments)
            if status != 0:
                raise SystemExit(f"{program}: {said}")
        for file in (folder / "experiment" / "ours").iterdir():
            if file.is_file():
                shutil.copy(file, folder)
        (folder / "experiment" / "recording").rename(folder / "recording")
        shutil.rmtree(folder / "experiment")
    cell = CellFolder(programs, folder)
    cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,220,110\nT2,-150,260\nT3,-280,-120\n")
    return cell

