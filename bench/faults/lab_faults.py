"""Faults that laboratories see, injected as those of faults.py are and run over a longer tour of targets.

What happens while a recording is made is a change of its tables: there the truth of the machine does not
count, only what tracker and camera said of it."""

import math
import random

from faults import (CLOSER, Fault, added_to, fit, fit_at_end_point, is_tool, item, pair, pairs_rows, peak,
                    plus, taken_from_other, text, times, tracker_rows, truth, truth_number, turned)

TARGETS = 120
PX_PER_MM = 4.18  # of the paper's cell

CAMERA = r"camera (has )?(shifted|turned|tilted|moved?\b)"
ARM = r"arm's links|the arm stray|link \d has|joint \d has|joint slip|warmth has changed the arm"


def tour_lines():
    """Lines of a table that goes round in four circles, in an order that is random in space."""
    places = [(r, 2 * math.pi * k / 30 + r - 110) for r in (110, 210, 310, 410) for k in range(30)]
    places = [places[37 * i % TARGETS] for i in range(TARGETS)]
    return ["id,x_mm,y_mm\n"] + [f"G{i},{r * math.cos(a):.3f},{r * math.sin(a):.3f}\n"
                                 for i, (r, a) in enumerate(places)]


def tour(cell, *options):
    cell.path("tour.csv").write_text("".join(tour_lines()))
    return cell.servo(*options, targets="tour.csv")


def toured(name, inject, causes):
    return Fault(name, inject, causes, tour)


def last_alone(cell):
    """Visits eight targets far from the drop and one below it."""
    cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,220,110\nT2,-150,260\nT3,-280,-120\nT4,100,300\nT5,300,-200\n"
        "T6,-100,-300\nT7,0,200\nT8,200,200\nT9,110,20\n")
    return cell.servo()


def resumed_after(change):
    """Visits a third of the tour, changes the cell while no program runs, and resumes."""
    def run(cell):
        cell.path("tour.csv").write_text("".join(tour_lines()[:1 + TARGETS // 3]))
        cell.servo(targets="tour.csv")
        change(cell, None)
        return tour(cell, "--resume")
    return run


def resumed_with(change):
    """Visits three targets, changes what they are resumed with, and resumes."""
    def run(cell):
        cell.servo()
        change(cell)
        return cell.servo("--resume")
    return run


def with_direction(cell):
    cell.edit_rows("targets.csv", lambda rows: [{**row, "phi_deg": 30} for row in rows])


def linked_steps(cell):
    """Puts a link to the table of targets in the place of a run's steps."""
    cell.path("run", "steps.csv").unlink()
    cell.path("run", "steps.csv").symlink_to(cell.path("targets.csv").resolve())


def lights(*places):
    """Adds lights that stand still: (x, y, level)."""
    return lambda cell, _: cell.append("truth.yaml", "reference_lamps:\n" + "".join(
        f"  - id: L{i}\n    x_mm: {x}\n    y_mm: {y}\n    z_mm: 0\n    diameter_mm: 8\n"
        f"    peak_level: {level}\n    glow: {{gradient_tool: [0, 0], gradient_view: 0, "
        "halo_tool: [0, 0], halo_view: 0.4, halo_decay_mm: 1.2}\n    rim_harmonics: []\n"
        for i, (x, y, level) in enumerate(places)))


def drop(*bump):
    return text("truth.yaml", r"\n  warp:\n", f"\n  warp:\n    - {list(bump)}\n")


def both(*changes):
    return lambda cell, other: [change(cell, other) for change in changes]


def camera_of_other(cell, other):
    """Puts another camera of its kind on the same stand."""
    theirs = other.path("truth.yaml").read_text().split("\n  focal_px: ")[1].split("\ndrift:")[0]
    cell.edit("truth.yaml", r"\n  focal_px: (.|\n)*?(?=\ndrift:)", lambda _: "\n  focal_px: " + theirs)


def lamps_on_flange(change):
    """Changes where both lamps sit on the tool."""
    return both(*(truth(f"lamp{i}_mm", change) for i in (1, 2)))


def turned_on_flange(degrees):
    a = math.radians(degrees)
    return lamps_on_flange(lambda v: [v[0] * math.cos(a) - v[1] * math.sin(a),
                                      v[0] * math.sin(a) + v[1] * math.cos(a)])


def exchanged_lamps(cell, _):
    for i in (1, 2):
        cell.edit("truth.yaml", rf"lamp{i}_mm:", f"lamp_{i}_mm:")
    for i in (1, 2):
        cell.edit("truth.yaml", rf"lamp_{i}_mm:", f"lamp{3 - i}_mm:")


CELL = [
    *(toured(f"camera drifts by {px} px/h", truth("px_per_h", lambda _, px=px: [px, 0]), CAMERA)
      for px in (3, 10, 300)),
    toured("tripod sags by 4 px within minutes", added_to(
        "drift", "warming: {shift_px: [0, 4], turn_deg: 0.01, growth: 0, time_constant_h: 0.1}"), CAMERA),
    toured("lens grows by 0.1 % within minutes", added_to(
        "drift", "warming: {shift_px: [0, 0], turn_deg: 0, growth: 0.001, time_constant_h: 0.1}"),
        rf"{CLOSER}|{CAMERA}"),
    Fault("camera bumped by 0.3 mm before a run is resumed", lambda cell, _: None, CAMERA,
          resumed_after(truth("translation_mm", item(0, lambda v: v + 0.3)))),
    Fault("joint 1 slips by 0.3 deg before a run is resumed", lambda cell, _: None, r"joint 1 has lost its zero",
          resumed_after(truth("zero_offsets_deg", item(0, lambda v: v + 0.3)))),
    toured("region of interest moved by 64 px", truth("center_px", item(0, lambda v: v + 64)), CAMERA),
    toured("lens locked differently", both(truth("focal_px", lambda f: [1.001 * v for v in f]),
                                           truth("center_px", item(1, lambda v: v + 3))), rf"{CLOSER}|{CAMERA}"),
    toured("filter screwed on the lens", both(truth("focal_px", lambda f: [1.0003 * v for v in f]),
                                              truth("radial", item(0, lambda v: v + 0.002))), CLOSER),
    toured("camera exchanged for another of its kind", camera_of_other, rf"{CLOSER}|{CAMERA}"),
    toured("camera mounted the other way round", truth("quaternion_wxyz", turned(2, 180)), CAMERA),
    *(toured(f"drop of {px} px on the window", drop(3055, 2560, 200, px, 0), r"drop") for px in (8, 2, 0.6, 0.3)),
    *(Fault(f"drop of {px} px on the window above the last target alone", drop(3055, 2560, 200, px, 0), r"drop",
            last_alone) for px in (8, 2, 0.6)),
    *(toured(f"finger print of {px} px on the window", drop(2000, 3300, 500, px, -0.7 * px), rf"drop|view has changed|{CAMERA}")
      for px in (0.4, 1.5)),
    toured("hot air of 1 px below the camera",
           added_to("camera", "air: {sigma_px: 1, time_s: 1, length_px: 1250}"), r"\bair\b|uncertain"),
    *(toured(f"both lamps at level {level}", both(peak(1, level), peak(2, level)), r"saturat|bright")
      for level in (300, 1000)),
    toured("lamp 1 dims to a fifth", peak(1, 30), r"lamps? (1 )?.*dim|not seen"),
    *(toured(f"background light of level {level}", truth_number("background_level", lambda _, v=level: v),
             r"background|bright|saturat|are not seen") for level in (80, 150)),
    *(toured(f"blur of {px} px", truth_number("blur_px", lambda _, v=px: v), r"focus|blur") for px in (3, 8)),
    toured("noisy pictures", truth_number("read_noise_levels", lambda _: 10), r"noise|uncertain|are not seen"),
    toured("lamp 1 sits eccentric in its socket", text("truth.yaml", r"rim_harmonics:\n", "rim_harmonics:\n"
           "      - [0.15, 0, 1]\n"), r"lamp 1 has moved"),
    toured("lamp 1 glows to one side", truth("gradient_tool", lambda _: [0.7, 0]), r"lamp 1"),
    toured("a reflection on the table, as bright as a lamp", lights((130, 40, 150)), r"reflection|lights|no two"),
    toured("a reflection that touches a lamp at a target", lights((136, 0, 60)), r"reflection"),
    toured("three weak reflections", lights((130, 40, 50), (-250, 180, 50), (-40, -300, 50)),
           r"reflection|lights|no two"),
    toured("lamps stand 2 mm higher", truth_number("lamp_height_mm", lambda v: v + 2), rf"{CLOSER}|lamps.*high"),
    toured("tool slid on its flange by 0.3 mm", lamps_on_flange(item(1, lambda v: v + 0.3)),
           r"lamp . has moved|tool has (moved|slid)"),
    toured("tool turned on its flange by 0.5 deg", turned_on_flange(0.5),
           r"joint 3 has lost its zero|tool has turned"),
    toured("lamps exchanged", exchanged_lamps, r"exchange"),
    toured("dry joints that stick", added_to("arm", "hysteresis: {half_width_deg: [0.05, 0.05, 0.05], "
           "forgotten_after_deg: [0.13, 0.13, 0.13]}"), rf"play of joint|{ARM}"),
    *(toured(f"a cable pulls at the arm by {um} um",
             added_to("arm", f"bending: {{largest_um: {um}, slack_deg: 30}}"), rf"cable|{ARM}")
      for um in (150, 800)),
    toured("worn bearings", added_to("arm", "runout: {um: [150, 150, 20], phases_deg: [10, 50, 90]}"),
           rf"bearing|{ARM}"),
    toured("worn gear of joint 1", text("truth.yaml", r"joint1:\n", "joint1:\n      - [0.1, 20, 2]\n"),
           rf"gear|joint 1|{ARM}"),
    toured("a damaged tooth of the belt at joint 2", added_to(
        "arm", "ripple: {joint1: [], joint2: [[0.05, 0, 1]], joint3: [], modulation: [0, 0, 0], "
               "skew: [0, 0, 0]}"), rf"gear|joint 2|{ARM}"),
    toured("a table that shakes the arm", added_to("arm", "scatter: {sigma_um: 200, short_move_factor: 1, "
           "negative_factor: 1}"), r"stops scatter|shake|the arm stray"),
    toured("a belt that slips now and then", lambda cell, _: cell.append(
        "truth.yaml", "outliers: {share: 0.15, from_mm: 0.3, to_mm: 3}\n"), r"slip|stray"),
    toured("motors that heat the arm", added_to(
        "arm", "warming: {growth_um_per_m: 1000, zero_shifts_deg: [0.02, -0.02, 0.01], "
               "motor_time_constant_h: 0.03, link_time_constant_h: 0.06, holding_share: 0.4}"), ARM),
    toured("a heavy load on the tool", truth_number("sag_mm_per_m2", lambda v: 8 * v), rf"sag|load|high|{ARM}"),
    toured("axis of joint 2 leans by 0.2 deg", added_to(
        "arm", "axis_leans_deg: {joint1: [0, 0], joint2: [0.2, 0], joint3: [0, 0]}"), rf"lean|{ARM}"),
    toured("drives 1 and 3 exchanged in the cell file", both(
        text("cell.yaml", "gear_ratio: 50.0", "gear_ratio: 99.0"), text("cell.yaml", "gear_ratio: 100.0",
             "gear_ratio: 50.0"), text("cell.yaml", "gear_ratio: 99.0", "gear_ratio: 100.0")),
        r"gear ratio of joint [13]"),
    toured("the other elbow in the cell file", text("cell.yaml", "elbow: left", "elbow: right"),
           r"elbow|arm \(cell.yaml\)"),
    toured("home in radians", text("cell.yaml", r"home_deg: \[0, 60, 0\]", "home_deg: [0, 1.0472, 0]"), r"home"),
]


def by_hand(name, key):
    return Fault(f"{name} changed by hand", lambda cell, _: cell.edit(
        name, rf"({key})(-?[0-9.]+(?:e-?[0-9]+)?)", lambda m: m[1] + repr(float(m[2]) + 0.001)),
        rf"{name}: was changed after", tour)


def keep_out(disc):
    return text("cell.yaml", r"keep_out: \[\]", f"keep_out: [{disc}]")


MEANT = {"T1": (220, 110), "T2": (-150, 260), "T3": (-280, -120)}
TORN = "id,x_mm,y_mm\nT1,220,110\nT2,-150,260\nT3,-280,-12"

HANDLED = [
    *(by_hand(name, key) for name, key in (
        ("camera.yaml", r"data: \["), ("workplane.yaml", r"translation_mm: \["), ("tool.yaml", r"p_TP_mm: \["),
        ("health.yaml", r"\nseparation_mm: "), ("arm.yaml", r"link_lengths_mm: \["))),
    Fault("arm.yaml of another cell", taken_from_other("arm.yaml"), r"arm.yaml|made with", tour),
    Fault("torn last line of a stream of targets", lambda cell, _: None, r'"line":4.*(newline|torn|end)',
          lambda cell: cell.servo(targets="-", stdin=TORN), MEANT),
    Fault("torn last line of a table of targets", lambda cell, _: cell.path("targets.csv").write_text(TORN),
          r"newline|torn|last line", meant=MEANT),
    Fault("targets given a direction before --resume", lambda cell, _: None, r"direction|phi",
          resumed_with(with_direction)),
    Fault("tolerance changed before --resume", lambda cell, _: None, r"tolerance",
          resumed_with(lambda cell: cell.edit_number("cell.yaml", "tolerance_mm", lambda v: 4 * v))),
    Fault("steps.csv is a link before --resume", lambda cell, _: None, r"steps.csv.*link",
          resumed_with(linked_steps)),
    Fault("map written over the table of targets", lambda cell, _: None, r"targets.csv.*(not|replace)",
          lambda cell: cell.run("planar-fit-error-map", "-o", "targets.csv", "pairs.csv")),
    Fault("map of 40 MB", lambda cell, _: cell.append("map.yaml", "more: [" + "0.123456, " * 4_000_000 + "0]\n"),
          r"map.yaml.*(MB|bytes|large|checksum)"),
    Fault("targets with decimal commas", lambda cell, _: cell.path("targets.csv").write_text(
        "id,x_mm,y_mm\nT1,220,5,110,5\n"), r"targets.csv:2"),
    Fault("keep-out disc in metres", keep_out("{x_mm: 0.22, y_mm: 0.11, radius_mm: 0.05}"), r"keep_out"),
    Fault("keep-out disc's radius in metres", keep_out("{x_mm: 220, y_mm: 110, radius_mm: 0.05}"), r"keep_out"),
    Fault("keep-out disc's place in metres", keep_out("{x_mm: 0.22, y_mm: 0.11, radius_mm: 50}"), r"keep_out"),
]


def training_share(row_id):
    """How far the training had come at a place: 0 before, 1 after it."""
    if row_id.startswith("train_"):
        return int(row_id[6:]) / 199
    return 0.0 if row_id.startswith(("sweep", "grid", "plane")) else 1.0


def shifted_tool(shift_mm):
    """Moves the tool's readings along x by what a share of the training has made of the shift."""
    def change(rows):
        for row in filter(is_tool, rows):
            row["x_mm"] = repr(float(row["x_mm"]) + shift_mm(training_share(row["id"])))
        return rows
    return tracker_rows(change)


def moved_tracker(shift_mm):
    """Moves all readings along x, the monuments' at the end as well."""
    def change(rows):
        end = float(rows[-1]["t_s"])
        for row in rows:
            row["x_mm"] = repr(float(row["x_mm"]) + shift_mm(float(row["t_s"]) / end))
        return rows
    return tracker_rows(change)


def crept_camera(millimetres):
    """Moves what the camera saw; at the end of the training it stands where it still stands."""
    def change(rows):
        for row in rows:
            for u in ("u1_px", "u2_px"):
                if row[u]:
                    row[u] = repr(float(row[u]) + PX_PER_MM * millimetres * (training_share(row["id"]) - 1))
        return rows
    return lambda cell, _: cell.edit_rows("lamps.csv", change)


def changed_numbers(change, which=lambda row: True):
    """Changes the numbers of some readings, one by one."""
    def rows_changed(rows):
        for row in filter(which, rows):
            for axis in ("x_mm", "y_mm", "z_mm"):
                row[axis] = repr(change(float(row[axis])))
        return rows
    return tracker_rows(rows_changed)


def scattered(sigma_mm):
    chance = random.Random(7)
    return lambda v: v + chance.gauss(0.0, sigma_mm)


def renamed(names):
    def change(rows):
        for row in rows:
            row["id"] = names.get(row["id"], row["id"])
        return rows
    return tracker_rows(change)


def exchanged_y_and_z(rows):
    for row in rows:
        row["y_mm"], row["z_mm"] = row["z_mm"], row["y_mm"]
    return rows


def higher_midway(rows):
    for row in filter(is_tool, rows):
        row["z_mm"] = repr(float(row["z_mm"]) + (6.35 if training_share(row["id"]) > 0.5 else 0.0))
    return rows


def mispaired(rows):
    chance = random.Random(7)
    tool = [row for row in rows if is_tool(row)]
    for before, row in zip(tool[:-1], tool[1:]):
        if chance.random() < 0.1:
            row.update({axis: before[axis] for axis in ("x_mm", "y_mm", "z_mm")})
    return rows


def paired(*more, fitting=fit):
    return lambda cell: pair(cell, *more, fitted=lambda cell, said: fitting(cell, said, tour))


def located(cell):
    """Finds the lamps anew, because the frames' table has changed, and continues with the pairs."""
    status, said = cell.run("planar-locate-lamps", "--cell", "cell.yaml", "-o", "lamps.csv", "recording")
    return (status, said) if status else paired()(cell)


def slipped_midway(cell, _):
    """Joint 1 stands 0.05 degrees from where it was sent in the second half of the training."""
    cell.own_tables()

    def change(rows):
        for row in rows:
            if training_share(row["id"]) > 0.5:
                row["theta1_deg"] = f'{float(row["theta1_deg"]) + 0.05:.9f}'
                row["m1_pulses"] = str(int(row["m1_pulses"]) + 139)
        return rows
    cell.edit_rows("recording/frames.csv", change)


def knocked_lamp(cell, other):
    """Lamp 1 is knocked by 0.2 mm midway, and stands there still."""
    def change(rows):
        for row in rows:
            if row["u1_px"] and training_share(row["id"]) > 0.5:
                row["u1_px"] = repr(float(row["u1_px"]) + PX_PER_MM * 0.2)
        return rows
    cell.edit_rows("lamps.csv", change)
    truth("lamp1_mm", item(0, lambda v: v + 0.2))(cell, other)


def recorded(name, inject, causes, run=paired()):
    return Fault(name, inject, causes, run)


REFLECTOR, TRACKER = r"reflector (was|or a lamp creeps)", r"tracker (or the base )?move|the tracker drifts"
CREEPING_CAMERA, SCATTER = rf"{CAMERA}|the camera or the tracker drifts", r"readings .*scatter|sigma_mm"
READ = ("x_reflector_mm", "y_reflector_mm")
GRID = ("--workplane-from", "grid", "--grid")

RECORDED = [
    *(recorded(f"reflector creeps by {mm} mm during the training",
               shifted_tool(lambda s, mm=mm: mm * s), REFLECTOR) for mm in (0.1, 0.2, 0.5, 1.6)),
    *(recorded(f"reflector creeps by {mm} mm, with a map at the end point", shifted_tool(
        lambda s, mm=mm: mm * s), REFLECTOR, paired(fitting=fit_at_end_point)) for mm in (0.2, 0.5, 1.6)),
    *(recorded(f"reflector seated anew by {mm} mm before the training",
               shifted_tool(lambda s, mm=mm: mm * (s > 0.0)), REFLECTOR) for mm in (0.1, 0.4)),
    recorded("tracker creeps by 0.5 mm", moved_tracker(lambda s: 0.5 * s), TRACKER),
    recorded("tracker bumped by 0.3 mm midway", moved_tracker(lambda s: 0.3 * (s > 0.3)), TRACKER),
    *(recorded(f"camera creeps by {mm} mm during the training", crept_camera(mm), CREEPING_CAMERA) for mm in (0.2, 1.6)),
    recorded("readings scatter ten times as stated", changed_numbers(scattered(0.1)), SCATTER),
    recorded("the same, monuments well", changed_numbers(scattered(0.1), is_tool), SCATTER),
    recorded("the same with a map at the end point", changed_numbers(scattered(0.1), is_tool), SCATTER,
             paired(fitting=fit_at_end_point)),
    recorded("readings rounded to 0.1 mm", changed_numbers(lambda v: round(v, 1)), rf"{SCATTER}|round|digit"),
    recorded("one reading in ten is that of the place before", tracker_rows(mispaired),
             r"frozen|repeat|place before|rows"),
    recorded("monuments datum1 and datum2 exchanged", renamed({"datum1": "datum2", "datum2": "datum1"}),
             r"exchange|mirror"),
    recorded("monuments datum1 and datum3 exchanged", renamed({"datum1": "datum3", "datum3": "datum1"}),
             r"exchange"),
    recorded("a monument's place mistyped", text("cell.yaml", r"datum2, x_mm: 450.0", "datum2, x_mm: 405.0"),
             r"datum \(cell.yaml\)|datum2|coordinates in the cell file"),
    recorded("tracker y and z exchanged", tracker_rows(exchanged_y_and_z), r"mirror"),
    recorded("reflector of another height midway", tracker_rows(higher_midway), REFLECTOR),
    *(recorded(f"tracker's scale off by {ppm} ppm", changed_numbers(lambda v, ppm=ppm: v * (1 + ppm * 1e-6)),
               r"scale|the unit") for ppm in (50, 300)),
    recorded("joint 1 slips by 0.05 deg midway", slipped_midway, r"joint 1|slip|lost its", located),
    recorded("lamp 1 knocked by 0.2 mm midway", knocked_lamp,
             r"lamp( 1)?,? (the camera or the tracker )?(has )?moved"),
    *(recorded(f"{name} in pairs", pairs_rows(change), r"changed after", lambda cell: fit(cell, servo=tour))
      for name, change in (
          ("readings times 1.001", times(READ, 1.001)), ("readings plus 15 mm", plus(READ[0], 15)),
          ("angles of joint 1 plus 1 deg", plus("theta1_deg", 1)),
          ("lamp 2 plus 0.1 mm", plus("x_lamp2_mm", 0.1)))),
    recorded("laid board's spacing 49 for 50 mm", lambda cell, _: None, r"pitch|spacing|scale|board",
             paired(*GRID, "circles:11x11:49mm")),
    recorded("laid board stated 5 mm above the lamps", lambda cell, _: None, r"thick|board|dots",
             paired(*GRID, "circles:11x11:50mm", "--board-thickness-mm", "5")),
]

ALL = CELL + HANDLED + RECORDED
