"""Faults of what people hand in: tables of other programs, camera files of other pictures, boards, places barred since.

They are injected as those of faults.py are. A file of another program has neither checksum nor origin."""

import re
import subprocess

from faults import Fault, pair, tracker_rows

T1 = "T1,220,110"


def table(content):
    data = content if isinstance(content, bytes) else content.encode()
    return lambda cell, _: cell.path("targets.csv").write_bytes(data)


TABLES = [
    Fault(name, table(content), causes) for name, content, causes in (
        ("targets in UTF-16", f"id,x_mm,y_mm\n{T1}\n".encode("utf-16"), r"UTF-16"),
        ("targets as .xlsx", b"PK\x03\x04\x14\x00\x06\x00" + bytes(200), r"workbook"),
        ("targets as .xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(200), r"workbook"),
        ("targets as G-code", "G21\nG90\nG0 X220 Y110\n", r"G-code"),
        ("targets as a numbered program", "%\nO1000\nN10 G0 X220 Y110\n%\n", r"G-code"),
        ("targets as DXF", "0\nSECTION\n2\nENTITIES\n0\nPOINT\n8\n0\n10\n220\n20\n110\n0\nEOF\n", r"DXF"),
        ("a minus sign of a word processor", "id,x_mm,y_mm\nT1,220,−110\n", r"U\+2212"),
        ("a no-break blank in a number", "id,x_mm,y_mm\nT1,1\u00a0220,110\n", r"U\+00A0"),
        ("decimal commas between commas", "id,x_mm,y_mm\nT1,220,5,110,25\n", r"semicolons"),
        ("pairs as targets, padded by a spreadsheet", f"# format: planar-servo/pairs/1,,,\nid,x_mm,y_mm\n{T1}\n",
         r"of format 'planar-servo/pairs"),
        ("a table without header or numbers", "first,second,third\nred,green,blue\n", r"lacks the column"),
        ("an id twice in a table with tabs", "id\tx_mm\ty_mm\nT1\t220\t110\nT1\t-150\t260\n", r"stands twice"),
    )]


def padded(change):
    """Saves the remarks of pairs.csv as a spreadsheet does, after a change."""
    def inject(cell, _):
        lines = cell.path("pairs.csv").read_text().splitlines()
        cell.path("pairs.csv").write_text("".join(
            (change(line) + ",,,," if line.startswith("#") else line) + "\n" for line in lines))
    return inject


def of_camera(replacement):
    """Changes the hash of the camera among the remarks, in the line behind its role."""
    state = {"is_camera": False}

    def change(line):
        was, state["is_camera"] = state["is_camera"], line == "# role: camera"
        return re.sub(r"\S+$", replacement, line) if was else line
    return change


def refit(cell):
    return cell.run("planar-fit-error-map", "--cell", "cell.yaml", "--arm-out", "arm.yaml", "-o", "map.yaml", "pairs.csv")


ORIGINS = [
    Fault("pairs of another camera, padded by a spreadsheet", padded(of_camera("0" * 64)), r"made with camera.yaml", refit),
    Fault("pairs whose origin was mangled", padded(of_camera("3.4E+38")), r"readably", refit),
]


def followed(*rows, option):
    def run(cell):
        cell.path("path.csv").write_text("x_mm,y_mm,via_x_mm,via_y_mm\n" + "".join(row + "\n" for row in rows))
        return cell.run("planar-servo", "--cell", "cell.yaml", "--path", "path.csv", option)
    return run


def nothing(_cell, _other):
    pass


PATHS = [
    Fault(f"a path to {what}", nothing, r"reach|far beyond|one line", followed("200,100,,", row, option=option))
    for what, row, option in (
        ("1e308 mm, dry run", "1e308,100,,", "--dry-run"), ("1e308 mm, check", "1e308,100,,", "--check"),
        ("1e9 mm, check", "1e9,100,,", "--check"), ("the moon by an arc", "200.002,100,200.001,1e6", "--check"))]


def disc(*places, radius=25):
    text = ", ".join(f"{{x_mm: {x:.2f}, y_mm: {y:.2f}, radius_mm: {radius}}}" for x, y in places)
    return lambda cell: cell.edit("cell.yaml", r"keep_out: \[\]", f"keep_out: [{text}]")


def health_places(cell):
    """Midway between the lamps, where the places of the health file have been seen."""
    numbers = re.findall(r"lamp[12]_mm: *\[([^\]]*)\]", cell.path("health.yaml").read_text())
    lamps = [tuple(float(v) for v in pair.split(",")) for pair in numbers]
    return [tuple((a + b) / 2 for a, b in zip(*two)) for two in zip(lamps[::2], lamps[1::2])]


def barred(count, target="T1,10,150\n"):
    def inject(cell, _):
        disc(*health_places(cell)[:count])(cell)
        cell.path("targets.csv").write_text("id,x_mm,y_mm\n" + target)
    return inject


def doctored(cell):
    """What planar-doctor prints stands on standard output."""
    done = subprocess.run([str((cell.programs / "planar-doctor").resolve()), "--cell", "cell.yaml"], cwd=cell.folder,
                          capture_output=True, text=True)
    return done.returncode, "".join(line + "\n" for line in done.stdout.splitlines() if not line.startswith("well"))


def small_ring(cell, _):
    cell.edit("cell.yaml", r"radius_min_mm: 60, radius_max_mm: 540", "radius_min_mm: 90, radius_max_mm: 100")
    cell.path("targets.csv").write_text("id,x_mm,y_mm\nT1,95,0\n")


WAYS = [
    *(Fault(f"{count} of 4 places of the health file barred since", barred(count), r"cannot be visited again")
      for count in (1, 2, 4)),
    Fault("a barred place, asked by --check", barred(1), r"cannot be visited again", lambda cell: cell.run(
        "planar-servo", "--cell", "cell.yaml", "--targets", "targets.csv", "--check")),
    Fault("a barred place, asked by planar-doctor", barred(1), r"cannot be visited again", doctored),
    Fault("a workspace too narrow for the first moves", small_ring, r"cannot be visited again|first moves"),
]


def foreign_camera(change):
    """The cell's camera as another program wrote it: K, the size, the distortion, and what is changed."""
    def inject(cell, _):
        text = cell.path("camera.yaml").read_text()
        fx, _, cx, _, fy, cy = (float(v) for v in re.search(r"data: \[([^\]]*)\]", text)[1].split(",")[:6])
        size = (5120, 5120)
        written = {"K": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "model": "plumb_bob", "D": [0, 0, 0, 0, 0], "more": "",
                   "size": size, "P": None}
        change(written)
        K = written["K"]
        P = written["P"] or [K[0], 0, K[2], 0, 0, K[4], K[5], 0, 0, 0, 1, 0]
        cell.path("camera.yaml").write_text(
            f"image_width: {written['size'][0]}\nimage_height: {written['size'][1]}\ncamera_name: overhead\n"
            f"camera_matrix: {{rows: 3, cols: 3, data: {K}}}\ndistortion_model: {written['model']}\n"
            f"distortion_coefficients: {{rows: 1, cols: {len(written['D'])}, data: {written['D']}}}\n"
            f"rectification_matrix: {{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}\n"
            f"projection_matrix: {{rows: 3, cols: 4, data: {P}}}\n{written['more']}")
    return inject


def transposed(w):
    w["K"] = [w["K"][i] for i in (0, 3, 6, 1, 4, 7, 2, 5, 8)]


def changed(**values):
    return lambda w: w.update(values)


def halved(w):
    w["K"] = [v / 2 for v in w["K"][:8]] + [1]


def at(index, value):
    def change(w):
        w["K"][index] = value
    return change


def scaled_projection(w):
    K = w["K"]
    w["P"] = [K[0] / 2, 0, K[2] / 2, 0, 0, K[4] / 2, K[5] / 2, 0, 0, 0, 1, 0]


CAMERAS = [
    Fault(name, foreign_camera(change), causes, lambda cell: cell.servo("--accept-stale")) for name, change, causes in (
        ("a camera matrix written by columns", transposed, r"camera.yaml.*(transpos|columns|rows)"),
        ("a camera file of binned pictures", changed(more="binning_x: 2\nbinning_y: 2\n"), r"binning"),
        ("a camera file of a region", changed(more="roi: {x_offset: 320, y_offset: 200, height: 1200, width: 1600, "
                                                   "do_rectify: false}\n"), r"roi|region"),
        ("a camera matrix with skew", at(1, 40.0), r"skew"),
        ("a centre beyond the picture's middle", at(2, 4900.0), r"camera.yaml.*(centre|principal|middle)"),
        ("a camera file of pictures half as large", halved, r"camera file|centre is far|closer"),
        ("plumb_bob with eight coefficients", changed(D=[0.0] * 8), r"plumb_bob|rational"),
        ("a projection matrix of another scale", scaled_projection, r"projection"),
        ("a camera file of another size", changed(size=(2560, 2560)), r"2560 x 2560|different sizes"),
    )]


def boards(grid):
    return lambda cell: cell.run("planar-calibrate-camera", "--grid", grid, "-o", "c.yaml", "recording")


def torn_picture(cell, _):
    cell.own_tables()
    images = cell.path("recording", "images")
    source = images.resolve()
    images.unlink()
    images.mkdir()
    for file in source.glob("grid*"):
        (images / file.name).write_bytes(file.read_bytes()[:100000 if file.name.startswith("grid_00") else None])


BOARDS = [
    Fault("a board of fewer dots than there are", nothing, r"121 dots|views of the board", boards("circles:5x5:50mm")),
    Fault("a plain grid called asymmetric", nothing, r"4 x 11 dots|views of the board", boards("acircles:4x11:20mm")),
    Fault("dots called a chessboard", nothing, r"chessboard|views of the board", boards("chessboard:9x6:25mm")),
    Fault("a grid that cannot be read", nothing, r"is not circles:", boards("dots:11x11:50")),
    Fault("a picture that was torn off", torn_picture, r"cannot be read to its end", boards("circles:11x11:50mm")),
]


def foreign_tracker(columns, *options, rows=lambda rows: rows, by=()):
    """Pairs with the tracker's readings as another program exports them: a title, aligned blanks, no clock."""
    def run(cell):
        lines = [line.split(",") for line in cell.path("recording/tracker.csv").read_text().splitlines()
                 if not line.startswith("#")][1:]
        text = "// Export\nMeasured points\n" + "".join(
            f"{row[0]}   {row[2]:>14} {row[3]:>14} {row[4]:>14}\n" for row in rows(lines))
        cell.path("points.txt").write_text(text)
        return pair(cell, "--tracker", "points.txt", "--separator", " ", "--tracker-columns", columns, *options, *by)
    return run


def renamed(rows):
    return [[row[0].replace("datum", "M"), *row[1:]] for row in rows]


TRACKERS = [
    Fault("monuments by other names in a tracker's export", nothing, r"name of a monument.*M1",
          foreign_tracker("id=1,x=2,y=3,z=4", rows=renamed)),
    Fault("a tracker's export in millimetres called metres", nothing, r"unit",
          foreign_tracker("id=1,x=2,y=3,z=4", "--tracker-unit", "m")),
    Fault("a column that an export has not", nothing, r"points.txt.*(fields|column)", foreign_tracker("id=1,x=2,y=3,z=9")),
    Fault("an export without a clock, to be paired by time", nothing, r"t_s", foreign_tracker(
        "id=1,x=2,y=3,z=4", by=("--pair-by", "time"))),
    Fault("one word among a tracker's numbers", tracker_rows(lambda rows: [
        {**row, "x_mm": "nan" if i == 40 else row["x_mm"]} for i, row in enumerate(rows)]), r"tracker.csv:\d+", pair),
]


def jogged(*lines):
    return lambda cell: cell.run("planar-jog", "--cell", "cell.yaml", stdin="\n".join(lines) + "\n")


OTHERS = [
    Fault("a joint is turned before the drives are on", nothing, r"drives are off", jogged("joint 1 5")),
    Fault("a step of 1e308 mm", nothing, r"too long|finite|at most", jogged("enable", "x 1e308")),
    Fault("an origin that is no address", nothing, r"SCHEME", lambda cell: cell.run(
        "planar-console", "--cell", "cell.yaml", "--origin", "arm.example.org")),
]

ALL = TABLES + ORIGINS + PATHS + WAYS + CAMERAS + BOARDS + TRACKERS + OTHERS
