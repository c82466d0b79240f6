"""The faults that are injected into a calibrated cell.

A Fault has a name, what it does to a copy of the cell, which program is to notice it, and patterns of
the words that name its cause. Faults of the machine are changes of its truth, which no program but the
virtual devices reads; faults of files are changes of what a user handles."""

import math
import shutil
from dataclasses import dataclass, field
from typing import Callable


@dataclass
class Fault:
    name: str
    inject: Callable  # takes the cell and, for files of another cell, that cell
    causes: str  # a pattern of words that name the cause
    run: Callable = lambda cell: cell.servo()
    meant: dict = field(default_factory=dict)  # places of targets where they are not the table's


def item(index, value):
    """Returns a change of one number of a list."""
    def change(numbers):
        numbers = list(numbers)
        numbers[index] = value(numbers[index]) if callable(value) else value
        return numbers
    return change


def turned(axis, degrees):
    """Returns a change of a quaternion (w, x, y, z): a turn about an axis of the camera."""
    half = math.radians(degrees) / 2
    a = [math.cos(half)] + [math.sin(half) if i == axis else 0.0 for i in range(3)]

    def change(quaternion):
        w, x, y, z = quaternion
        return [a[0] * w - a[1] * x - a[2] * y - a[3] * z, a[0] * x + a[1] * w + a[2] * z - a[3] * y,
                a[0] * y - a[1] * z + a[2] * w + a[3] * x, a[0] * z + a[1] * y - a[2] * x + a[3] * w]
    return change


def truth(key, change):
    return lambda cell, _: cell.edit_numbers("truth.yaml", key, change)


def cell_numbers(key, change):
    return lambda cell, _: cell.edit_numbers("cell.yaml", key, change)


def text(name, pattern, replacement):
    return lambda cell, _: cell.edit(name, pattern, replacement)


def truth_number(key, change):
    return lambda cell, _: cell.edit_number("truth.yaml", key, change)


def added_to(block, line):
    """Adds a key to a block of the truth."""
    return lambda cell, _: cell.edit("truth.yaml", rf"\n{block}:\n", f"\n{block}:\n  {line}\n")


def peak(lamp, level):
    return text("truth.yaml", rf"(lamp{lamp}:\s+diameter_mm: .*\s+peak_level: )\S+", rf"\g<1>{level}")


def taken_from_other(*names):
    return lambda cell, other: [shutil.copy(other.path(name), cell.folder) for name in names]


SHIFT = r"camera has shifted|camera moved"
TURN = r"camera has turned"
CLOSER = r"camera has come closer|focused elsewhere"

MACHINE = [
    *(Fault(f"camera nudged by {mm} mm", truth("translation_mm", item(axis, lambda v, mm=mm: v + mm)),
            SHIFT) for axis, mm in ((0, 0.05), (1, 0.2), (0, 1.0), (1, 5.0), (0, 50.0))),
    *(Fault(f"camera raised by {mm} mm", truth("translation_mm", item(2, lambda v, mm=mm: v + mm)),
            CLOSER) for mm in (0.5, 2.0, 20.0)),
    *(Fault(f"camera turned by {deg} deg", truth("quaternion_wxyz", turned(2, deg)), TURN)
      for deg in (0.02, 0.1, 2.0)),
    *(Fault(f"camera tilted by {deg} deg", truth("quaternion_wxyz", turned(0, deg)),
            r"camera has (tilted|shifted)") for deg in (0.01, 0.1)),
    *(Fault(f"lens refocused, {percent} %",
            truth("focal_px", lambda f, p=percent: [v * (1 + p / 100) for v in f]), CLOSER)
      for percent in (0.02, 0.2)),
    *(Fault(f"lamp {lamp} knocked by {mm} mm along {'xy'[axis]}",
            truth(f"lamp{lamp}_mm", item(axis, lambda v, mm=mm: v + mm)), rf"lamp {lamp} has moved")
      for lamp, axis, mm in ((1, 0, 0.1), (1, 0, 1.0), (1, 1, 1.0), (2, 1, 0.2), (2, 0, -3.0))),
    Fault("lamp 1 dead", peak(1, 0), r"lamps are not seen"),
    Fault("both lamps dim", lambda cell, other: [peak(i, 6)(cell, other) for i in (1, 2)],
          r"lamps are not seen|uncertain"),
    *(Fault(f"direction of joint {j + 1} reversed", truth("directions", item(j, -1)),
            rf"direction of joint {j + 1}") for j in range(3)),
    *(Fault(f"gear of joint {j + 1} times {factor:g}",
            truth("gear_ratios", item(j, lambda v, f=factor: v / f)), rf"gear ratio of joint {j + 1}")
      for j, factor in ((0, 1.005), (1, 1.005), (2, 1.005), (0, 0.98), (1, 1.1), (0, 2.0),
                        (2, math.pi / 180))),
    *(Fault(f"zero of joint {j + 1} off by {deg} deg",
            truth("zero_offsets_deg", item(j, lambda v, d=deg: v + d)), rf"joint {j + 1} has lost its zero")
      for j, deg in ((0, 0.5), (0, 90), (1, 5), (2, 1), (2, -20))),
    Fault("coupling of joint 2 absolute", text("truth.yaml", r"coupling: \[relative, relative\]",
          "coupling: [absolute, relative]"), r"coupling of joint 2"),
    Fault("coupling of joint 3 absolute", text("truth.yaml", r"coupling: \[relative, relative\]",
          "coupling: [relative, absolute]"), r"coupling of joint 3"),
    Fault("positive rotation reversed", text("truth.yaml", "positive_rotation: clockwise",
          "positive_rotation: counterclockwise"), r"positive_rotation|direction of joint"),
    Fault("links 310 and 290 mm", truth("link_lengths_mm", lambda v: [v[0] + 10, v[1] - 10]),
          r"link \d has another length"),
    Fault("link 1 longer by 1 %", truth("link_lengths_mm", item(0, lambda v: v * 1.01)),
          r"link 1 has another length"),
    Fault("link 2 shorter by 2 %", truth("link_lengths_mm", item(1, lambda v: v * 0.98)),
          r"link 2 has another length"),
    *(Fault(f"play of joint {j + 1} grown to {deg} deg", truth("backlash_deg", item(j, deg)),
            rf"play of joint {j + 1} has grown") for j, deg in ((0, 0.15), (1, 0.2))),
    Fault("camera nudged by 3 mm and lamp 2 by 1 mm", lambda cell, _: [
        cell.edit_numbers("truth.yaml", "translation_mm", item(0, lambda v: v + 3)),
        cell.edit_numbers("truth.yaml", "lamp2_mm", item(1, lambda v: v + 1))],
        r"more than one|camera has shifted"),
]

FILES = [
    *(Fault(f"{name} of another cell", taken_from_other(name), rf"{name}|made with")
      for name in ("camera.yaml", "workplane.yaml", "tool.yaml", "map.yaml", "health.yaml")),
    Fault("all vision files of another cell", taken_from_other(
        "camera.yaml", "workplane.yaml", "tool.yaml", "map.yaml", "health.yaml", "arm.yaml"),
          r"camera has|joint \d|more than one"),
    Fault("a weight of the map changed by hand", lambda cell, _: cell.edit(
        "map.yaml", r"(weights\w*:\s*(?:- )?\[)([-0-9.e]+)",
        lambda m: m[1] + repr(float(m[2]) + 0.001)), r"map.yaml: was changed after"),
    Fault("camera calibrated again, the rest forgotten", lambda cell, _: cell.run(
        "planar-calibrate-camera", "--grid", "circles:11x11:50mm", "--model", "rational_polynomial",
        "-o", "camera.yaml", "recording"), r"made with camera.yaml"),
    Fault("pairs made again, the map not", lambda cell, _: (
        cell.run("planar-pair-tracker", "--cell", "cell.yaml", "--lamps", "lamps.csv", "--recording",
                 "recording", "--workplane-from", "grid", "--grid", "circles:11x11:50mm",
                 "--workplane-out", "workplane.yaml", "--tool-out", "tool.yaml", "-o", "pairs.csv")),
        r"map.yaml: was made with"),
    Fault("links exchanged with the cell file's", cell_numbers("link_lengths_mm", lambda _: [310, 290]),
          r"arm \(cell.yaml\)"),
    Fault("links in metres", cell_numbers("link_lengths_mm", lambda v: [x / 1000 for x in v]),
          r"arm \(cell.yaml\)|link"),
    Fault("separation 30 for 40 mm", text("cell.yaml", r"separation_mm: 40.0", "separation_mm: 30.0"),
          r"lamps \(cell.yaml\)|apart"),
    Fault("separation in metres", text("cell.yaml", r"separation_mm: 40.0", "separation_mm: 0.040"),
          r"lamps \(cell.yaml\)|apart"),
    Fault("direction of joint 1 in the cell file", text("cell.yaml", r"direction: 1", "direction: -1"),
          r"direction of joint 1"),
    Fault("gear ratio 100.5 in the cell file", text("cell.yaml", r"gear_ratio: 100.0",
          "gear_ratio: 100.5"), r"gear ratio of joint 1"),
    Fault("image size of another camera", text("cell.yaml", r"width_px: 5120, height_px: 5120",
          "width_px: 4096, height_px: 4096"), r"4096 x 4096 px"),
    Fault("limits in radians", text("cell.yaml", r"joint_limits_deg: \[\[-360, 360\]",
          "joint_limits_deg: [[-6.28, 6.28]"), r"its limits are"),
    Fault("targets in metres", lambda cell, _: cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,0.22,0.11\n"), r"workspace reaches"),
    Fault("target outside the workspace", lambda cell, _: cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,580,0\n"), r"workspace reaches"),
    Fault("target named twice", lambda cell, _: cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,220,110\nT1,-150,260\n"), r"stands twice"),
    Fault("home angle of joint 1 off by 3 deg", text("cell.yaml", r"home_deg: \[0, 60, 0\]",
          "home_deg: [3, 60, 0]"), r"home is not where|joint 1 has lost"),
]


def tracker_rows(change):
    """Changes the readings of the tool in a recording's tracker.csv."""
    def inject(cell, _):
        cell.own_tables()
        cell.edit_rows("recording/tracker.csv", change)
    return inject


def scaled(factor):
    def change(rows):
        for row in rows:
            for axis in ("x_mm", "y_mm", "z_mm"):
                row[axis] = repr(float(row[axis]) * factor)
        return rows
    return change


def swapped_axes(rows):
    for row in rows:
        row["x_mm"], row["y_mm"] = row["y_mm"], row["x_mm"]
    return rows


def moved_reading(which, millimetres):
    def change(rows):
        for i, row in enumerate(rows):
            if which(i, row):
                row["x_mm"] = repr(float(row["x_mm"]) + millimetres)
        return rows
    return change


def is_tool(row):
    return not row["id"].startswith("datum")


def shifted_by_one(rows):
    tool = [row for row in rows if is_tool(row)]
    for before, row in zip(tool[:-1], tool[1:]):
        row["_x"], row["_y"], row["_z"] = before["x_mm"], before["y_mm"], before["z_mm"]
    for row in tool[1:]:
        row["x_mm"], row["y_mm"], row["z_mm"] = row.pop("_x"), row.pop("_y"), row.pop("_z")
    return rows


def frozen(rows):
    tool = [row for row in rows if is_tool(row) and row["id"].startswith("train")]
    for row in tool[100:140]:
        for axis in ("x_mm", "y_mm", "z_mm"):
            row[axis] = tool[100][axis]
    return rows


def pair(cell, *more, fitted=None):
    status, said = cell.run("planar-pair-tracker", "--cell", "cell.yaml", "--lamps", "lamps.csv",
                            "--recording", "recording", "--workplane-out", "workplane.yaml",
                            "--tool-out", "tool.yaml", "--health-out", "health.yaml", "-o",
                            "pairs.csv", *more)
    return (status, said) if status else (fitted or fit)(cell, said)


def fit(cell, said="", servo=lambda cell: cell.servo()):
    status, words = cell.run("planar-fit-error-map", "--cell", "cell.yaml", "--arm-out", "arm.yaml",
                             "-o", "map.yaml", "pairs.csv")
    if status:
        return status, said + words
    status, answer = servo(cell)
    return status, said + words + answer


def fit_at_end_point(cell, said="", servo=lambda cell: cell.servo()):
    """Fits a map at the end point, which reads other columns of the pairs and finds no arm."""
    status, words = cell.run("planar-fit-error-map", "-o", "map.yaml", "pairs.csv")
    cell.edit("cell.yaml", r"arm_found: arm.yaml\n", "")
    if status:
        return status, said + words
    status, answer = servo(cell)
    return status, said + words + answer


def monument(name, millimetres):
    return tracker_rows(moved_reading(lambda _, row: row["id"] == name, millimetres))


def pairs_rows(change):
    return lambda cell, _: cell.edit_rows("pairs.csv", change)


def times(columns, factor):
    def change(rows):
        for row in rows:
            for column in columns:
                row[column] = repr(float(row[column]) * factor)
        return rows
    return change


def plus(column, millimetres):
    def change(rows):
        for row in rows:
            row[column] = repr(float(row[column]) + millimetres)
        return rows
    return change


def exchanged(rows):
    for row in rows:
        for axis in "xy":
            v, t = f"{axis}_vision_mm", f"{axis}_tracker_mm"
            row[v], row[t] = row[t], row[v]
    return rows


def frozen_pairs(rows):
    for row in rows[20:60]:
        row["x_tracker_mm"], row["y_tracker_mm"] = rows[20]["x_tracker_mm"], rows[20]["y_tracker_mm"]
    return rows


VISION, TRACKER = ("x_vision_mm", "y_vision_mm"), ("x_tracker_mm", "y_tracker_mm")

READINGS = [
    *(Fault(f"tracker {name}", tracker_rows(scaled(factor)), r"the unit", pair)
      for name, factor in (("in metres", 0.001), ("times 1000", 1000.0), ("in inches", 1 / 25.4))),
    Fault("tracker x and y swapped", tracker_rows(swapped_axes), r"mirror", pair),
    *(Fault(f"monument datum2 off by {mm} mm", monument("datum2", mm), r"datum2", pair)
      for mm in (0.05, 0.1, 0.5, 2.0)),
    Fault("all monuments shifted by 1 mm", tracker_rows(moved_reading(
        lambda _, row: not is_tool(row), 1.0)), r"joint 1 turns about", pair),
    Fault("tracker rows shifted by one", tracker_rows(shifted_by_one), r"shifted by|one row", pair),
    Fault("40 frozen readings", tracker_rows(frozen), r"frozen|same place|repeated", pair),
    Fault("reflector bumped by 0.36 mm midway", tracker_rows(moved_reading(
        lambda i, row: is_tool(row) and i > 150, 0.36)), r"reflector", pair),
    Fault("lamps.csv of another recording", lambda cell, other: shutil.copy(
        other.path("lamps.csv"), cell.folder), r"lamps.csv", pair),
    Fault("decimal commas", lambda cell, _: (cell.own_tables(), cell.path(
        "recording/tracker.csv").write_text(cell.path("recording/tracker.csv").read_text().replace(
            ",", ";").replace(".", ","))), r"tracker.csv", pair),
    Fault("vision x negated in pairs", pairs_rows(times(VISION[:1], -1)),
          r"mirror|changed after", fit_at_end_point),
    Fault("both x negated in pairs", pairs_rows(times((VISION[0], TRACKER[0]), -1)),
          r"changed after", fit_at_end_point),
    Fault("pairs times 1000 on both sides", pairs_rows(times(VISION + TRACKER, 1000)),
          r"unit|scale|changed after", fit_at_end_point),
    Fault("vision in metres in pairs", pairs_rows(times(VISION, 0.001)),
          r"unit|scale|metres|changed after", fit_at_end_point),
    Fault("tracker plus 15 mm in pairs", pairs_rows(plus(TRACKER[0], 15)),
          r"share|changed after", fit_at_end_point),
    Fault("vision and tracker exchanged in pairs", pairs_rows(exchanged),
          r"exchange|changed after", fit_at_end_point),
    Fault("40 frozen pairs", pairs_rows(frozen_pairs), r"frozen|changed after", fit_at_end_point),
    Fault("grid of wrong count", lambda cell, _: None, r"views of the board", lambda cell: cell.run(
        "planar-calibrate-camera", "--grid", "circles:12x11:50mm", "-o", "c.yaml", "recording")),
    Fault("the same picture five times", lambda cell, _: None, r"usable views|same picture", lambda cell: cell.run(
        "planar-calibrate-camera", "--grid", "circles:11x11:50mm", "-o", "c.yaml",
        *["recording/images/grid_00_0.pgm"] * 5)),
    Fault("recording resumed with another plan", lambda cell, _: (cell.own_tables(), cell.path(
        "plan.csv").write_text("id,plan,x_mm,y_mm,phi_deg\ntrain_000,train,100,200,0\n")),
        r"another plan|other plan|plan", lambda cell: cell.run(
            "planar-record", "--cell", "cell.yaml", "--plan", "plan.csv", "--out", "recording")),
]

ALL = MACHINE + FILES + READINGS
