"""Works a cell through planar-console as programs and pages do: console.py PROGRAM CELL_FOLDER."""
import atexit
import contextlib
import http.client
import json
import math
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from served_console import ServedConsole

PROGRAM, FOLDER = sys.argv[1:]
ONE, OTHER = "1111111111111111", "2222222222222222"
LATE_ORDERS = int(os.environ.get("LATE_ORDERS", "20"))
PATIENCE_S = 60


def check(holds, what):
    if not holds:
        sys.exit(f"FAILED: {what}")


def eventually(holds, what):
    until = time.monotonic() + PATIENCE_S
    while not holds():
        check(time.monotonic() < until, what)
        time.sleep(0.02)


class Console(ServedConsole):
    """A running planar-console, asked with its token for operating unless another is named."""

    def __init__(self, cell, *options):
        super().__init__(PROGRAM, f"{FOLDER}/{cell}", *options)
        atexit.register(self.process.kill)
        self.stops = 0  # that the answers told of
        self.operate, self.read = self.token["operate"], self.token["look on"]
        self.port = int(self.origin.split(":")[2])

    def ask(self, method, path, body=None, token=None, client=ONE, **headers):
        """Returns status and answer, JSON where it is."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        sent = {"Authorization": f"Bearer {self.operate if token is None else token}"}
        if method == "POST":
            sent.update({"X-Planar-Client": client, "X-Planar-Stops": str(self.stops), "Content-Type": "application/json"})
            body = body if isinstance(body, bytes) else json.dumps(body or {})
        sent.update({name.replace("_", "-"): value for name, value in headers.items()})
        with contextlib.closing(connection):
            connection.request(method, path, body, sent)
            answer = connection.getresponse()
            data = answer.read()
        is_json = answer.headers.get("Content-Type", "").startswith("application/json")
        said = json.loads(data) if is_json else data
        self.stops = said.get("stops", self.stops) if isinstance(said, dict) else self.stops
        return answer.status, said

    def post(self, path, body=None, **how):
        return self.ask("POST", path, body, **how)

    def state(self):
        status, state = self.ask("GET", "/api/state")
        while status == 429:
            time.sleep(0.1)
            status, state = self.ask("GET", "/api/state")
        return state

    def turned(self):
        return self.state()["arm"]["joints_deg"][0]

    def rests(self):
        eventually(lambda: self.state()["doing"] == "idle", "the cell does not come to rest")

    def command(self, line):
        status, answer = self.post("/api/command", {"line": line})
        check(status == 200 and answer["done"], f"{line}: {answer}")

    def refused(self, wanted, method, path, body=None, says="", **how):
        status, answer = self.ask(method, path, body, **how)
        check(status == wanted and says in str(answer), f"{method} {path} {how}: {status} {answer}, not {wanted} {says}")

    def opened(self, text):
        """Returns a connection that has sent this and reads nothing."""
        there = socket.socket()
        there.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        there.connect(("127.0.0.1", self.port))
        there.sendall(text.encode())
        return there

    def end(self, how=signal.SIGINT):
        check(super().end(how) == 0, "the console did not end well")


def try_rights(console):
    for token, wanted in (("", 401), ("0" * 32, 401), (console.read, 200), (console.operate, 200)):
        status, _ = console.ask("GET", "/api/state", token=token)
        check(status == wanted, f"the token '{token}' is answered with {status}")
    console.refused(401, "GET", "/", token="", says="no right to read")
    console.refused(303, "GET", f"/?token={console.read}", token="")
    console.refused(403, "POST", "/api/command", {"line": "enable"}, token=console.read, says="may read only")
    for header in ({"Origin": "http://example.org"}, {"Host": "example.org"}, {"Content_Type": "text/plain"},
                   {"X_Planar_Client": ""}):
        console.refused(403, "POST", "/api/command", {"line": "enable"}, **header)
        check(console.post("/api/stop", token=console.read, **header)[0] == 200, "a stop is refused")
    check(console.post("/api/stop", token=console.read)[0] == 200, "a reader cannot stop")


def try_bodies(console):
    console.refused(413, "POST", "/api/targets", b"x" * (2 << 20), says="1 MiB")
    for body in (b"", b"\xff\0", b"[1]", b"[" * 100000, b'{"line": 1}'):
        console.refused(400, "POST", "/api/command", body)
    console.refused(400, "POST", "/api/command", {"line": "save /tmp/x.png"}, says="no command 'save' here")
    console.refused(400, "POST", "/api/targets", {"csv": "id,x_mm,y_mm\nA,1\nB,x,1\n"}, says="has 2 fields")
    console.refused(400, "GET", "/api/place?x_mm=nan&y_mm=1")
    place = {"x_mm": 150, "y_mm": 100}
    for body, says in (({**place, "phi": 90}, "x_mm, y_mm, phi_deg"), ({**place, "y_mm": 1e308}, "10 m"),
                       ({**place, "phi_deg": 1000}, "one turn"), (b'{"x_mm": 1, "x_mm": 2, "y_mm": 1}', "twice")):
        console.refused(400, "POST", "/api/go", body, says=says)
    for kind in ("application/json", "multipart/form-data"):
        check(console.post("/api/stop", b"now!", Content_Type=kind)[0] == 200, "a stop is refused for its body")
    stops = console.state()["stops"]
    late = console.opened(f"POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1:{console.port}\r\n"
                          f"Authorization: Bearer {console.read}\r\nContent-Length: 9\r\n\r\n")
    eventually(lambda: console.state()["stops"] > stops, "a stop waits for its body")
    late.close()
    for header in ("Content_Encoding", "Transfer_Encoding"):
        console.refused(415, "POST", "/api/targets", b"0\r\n\r\n", says="encoded", **{header: "gzip"})
    console.refused(400, "POST", "/api/run", {"out": "../run", "resume": False}, says="letters")
    check(console.state()["operator"] is None, "who was refused keeps the cell")


def try_names(console):
    """A dot in a name is a dot and no other letter."""
    for name in ("/api/lamp/1xjpg", "/api/picturexjpg", "/pagexjs", "/openapixjson"):
        console.refused(404, "GET", name, says="nothing of this name")
    for name in ("/api/lamp/1.jpg", "/api/picture.jpg", "/page.js", "/openapi.json"):
        check(console.ask("GET", name)[0] in (200, 204), f"{name} is not answered")


def try_folder(console):
    for name in ("../secret.html", "%2e%2e/secret.html", "link.html", "cell.yaml", "none.html", "a" * 7000 + ".html"):
        console.refused(404, "GET", f"/reports/{name}")
    check(console.ask("GET", "/api/reports")[1] == [], "reports where none are")


def try_second_consoles(console):
    for arguments, said in ((["--cell", f"{FOLDER}/fast.yaml"], "another planar-console serves this cell"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--port", str(console.port)], "taken"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--port", "1", "--listen", "127.0.0.1:2"], "give the port once"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--listen", "::1"], "[::1]:8377 for IPv6"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--listen", "[::]:0"], "every address"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--tls-cert", "none.pem"], "need each other"),
                            (["--cell", f"{FOLDER}/slow.yaml", "--port", "0", "--token-file", "none"], "none: does not exist")):
        second = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        check(second.returncode == 2 and said in second.stderr, f"{arguments}: {second.stderr}")


def follow(console, told):
    """Keeps the rows of results that the events tell."""
    events = console.opened(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{console.port}\r\n"
                            f"Authorization: Bearer {console.read}\r\n\r\n").makefile("r")
    kind = ""
    for line in events:
        if line.startswith("event: "):
            kind = line.split()[1]
        elif line.startswith("data: ") and kind == "result":
            told.append(json.loads(line[6:]))


def try_run(console):
    console.refused(400, "POST", "/api/run", {"out": "run", "resume": False}, says="no targets")
    check(console.post("/api/targets", {"csv": "id,x_mm,y_mm\nA,330,-250\nB,320,-240\n"})[0] == 200, "no targets")
    console.refused(400, "POST", "/api/run", {"out": "run", "resume": False}, says="enable")
    console.command("enable")
    told = []
    threading.Thread(target=follow, args=(console, told), daemon=True).start()
    check(console.post("/api/run", {"out": "run", "resume": False})[1] == {"job": 1}, "no job")
    console.refused(409, "POST", "/api/command", {"line": "x 1"}, says="at work")
    console.rests()
    job = console.state()["job"]
    check(job["ok"] and job["done"] == 2 and "2 of 2 targets reached" in job["ended"], job)
    eventually(lambda: len(told) == 2, f"results told: {told}")
    check([row["target"] for row in told] == ["A", "B"] and told[0]["status"] == "reached", told)
    check(console.ask("GET", "/reports/run/report.html")[0] == 200, "no report")
    console.refused(400, "POST", "/api/run", {"out": "run", "resume": False}, says="resume")


def try_certificate(console):
    """A broken-off certificate is finished, one is stopped on its way, and what is no certificate is refused."""
    for size, says in (({"cycles": 1}, "cycles"), ({"cycles": 2.5}, "whole number"), ({"targets": "all"}, "targets"),
                       ({"targets": 10 ** 10}, "targets")):
        console.refused(400, "POST", "/api/certificate", {"out": "no", **size}, says=says)
    console.refused(400, "POST", "/api/certificate", {"out": "run"}, says="belongs to no certificate")
    console.refused(400, "POST", "/api/certificate", {"out": "proof", "cycles": 3}, says="begun with other --cycles")
    before = console.state()["job"]
    check(console.post("/api/certificate", {"out": "proof", "cycles": 2, "targets": 1})[0] == 200, "no certificate")
    job = console.state()["job"]
    check((job["kind"], job["done"], job["all"], job["id"]) == ("certificate", 34, 35, before["id"] + 1), job)
    console.refused(409, "POST", "/api/go", {"x_mm": 330, "y_mm": -250}, says="at work")
    console.rests()
    job = console.state()["job"]
    check(job["ok"] and job["done"] == 35 and job["ended"].startswith("35 of 35 moves reached and judged"), job)
    check("proof/certificate.html" in [page["name"] for page in console.ask("GET", "/api/reports")[1]], "no page of it")

    check(console.post("/api/certificate", {"out": "stopped", "cycles": 2, "targets": 1})[0] == 200, "no certificate")
    eventually(lambda: console.state()["job"]["done"] >= 2, "no move is made")
    state = console.state()
    check(state["doing"] == "running" and state["seen_mm"] and state["job"]["left_s"] > 0, state)
    check(console.post("/api/stop", client=OTHER, token=console.read)[0] == 200, "no stop")
    console.rests()
    job = console.state()["job"]
    check(not job["ok"] and 2 <= job["done"] < 35 and "stopped as asked" in job["ended"], job)
    with open(f"{FOLDER}/stopped/cycles.csv", encoding="utf-8") as table:
        check(sum(line[0] in "cvw" and line[1].isdigit() for line in table) == job["done"], "other moves are kept")


def try_path(console):
    """A path with an arc is drawn and followed by the arm alone and by vision; one is stopped on its way."""
    for csv, says in (("x_mm,y_mm\n330,-250\n", "two rows"), ("x_mm,y_mm\n330,-250\n330,-250\n1,x\n", "the path:4"),
                      ("x_mm,y_mm\n330,-250\n900,-250\n", "mm along the path"), ("x,y\n1,2\n", "x_mm")):
        console.refused(400, "POST", "/api/path", {"csv": csv}, says=says)
    check(console.ask("GET", "/api/path")[1] == {"csv": "", "length_mm": 0.0, "places_mm": []}, "a refused path is kept")
    console.refused(400, "POST", "/api/follow", {"out": "path"}, says="there is no path")
    table = "x_mm,y_mm,via_x_mm,via_y_mm\n330,-250,,\n290,-250,310,-230\n290,-260,,\n"
    path = console.post("/api/path", {"csv": table})[1]
    check(path == console.ask("GET", "/api/path")[1] and abs(path["length_mm"] - 20 * math.pi - 10) < 1e-3, path)
    on_arc = [math.hypot(x - 310, y + 250) for x, y in path["places_mm"][:-1]]
    check(len(on_arc) > 30 and max(abs(r - 20) for r in on_arc) < 1e-3 and path["places_mm"][-1] == [290, -260], path)
    for body, says in (({"speeds_mm_s": [60]}, "1 to 50 mm/s"), ({"speeds_mm_s": []}, "no time"),
                       ({"guided_by": ["eye"]}, "arm, vision"), ({"speeds_mm_s": 10}, "speeds_mm_s"), ({"out": "."}, "letters")):
        console.refused(400, "POST", "/api/follow", {"out": "path", **body}, says=says)
    both = {"out": "path", "speeds_mm_s": [50], "guided_by": ["arm", "vision"]}
    check(console.post("/api/follow", both)[0] == 200, "no path is followed")
    eventually(lambda: console.state()["job"]["done"] > 0, "the path is not begun")
    state = console.state()
    check(state["seen_mm"] and state["job"]["all"] == 146 and state["job"]["left_s"] > 0, state)
    console.rests()
    job, rows = console.state()["job"], console.ask("GET", "/api/results")[1]
    check(job["ok"] and job["cause"] is None and job["ended"].count("reached") == 2, job)
    check([(row["guided_by"], row["status"]) for row in rows] == [("arm", "reached"), ("vision", "reached")], rows)
    check(rows[1]["deviation_mean_mm_truth"] < rows[0]["deviation_mean_mm_truth"], "vision does not help")
    check("path/report.html" in [page["name"] for page in console.ask("GET", "/api/reports")[1]], "no page of it")
    with open(f"{FOLDER}/path/path.csv", encoding="utf-8") as kept:
        check(kept.read() == table, "the path is not kept with its run")
    console.refused(400, "POST", "/api/follow", {"out": "path"}, says="holds a run already")

    check(console.post("/api/follow", {"out": "left", "speeds_mm_s": [1]})[0] == 200, "no path is followed")
    eventually(lambda: console.state()["job"]["done"] > 0, "the path is not begun")
    check(console.post("/api/stop", client=OTHER, token=console.read)[0] == 200, "no stop")
    console.rests()
    job = console.state()["job"]
    check(not job["ok"] and 0 < job["done"] < 70, job)
    check(console.post("/api/path", {"csv": " "})[1]["places_mm"] == [], "the path is still there")


def try_experiment(console):
    """An experiment is begun and stopped; the cell is at work meanwhile, and its files stay as they are."""
    opened = console.state()["opened"]
    console.refused(400, "POST", "/api/experiment", {"out": "../no"}, says="letters")
    check(console.post("/api/experiment", {"out": "experiment"})[0] == 200, "no experiment")
    console.refused(409, "POST", "/api/command", {"line": "x 1"}, says="at work")
    eventually(lambda: pathlib.Path(FOLDER, "experiment", "plan.csv").exists(), "nothing is made in its folder")
    check(console.post("/api/stop", client=OTHER, token=console.read)[0] == 200, "no stop")
    console.rests()
    state = console.state()
    job = state["job"]
    check((job["kind"], job["ended"], job["cause"]) == ("experiment", "experiment was stopped", "stopped"), job)
    check(state["opened"] == opened, "the cell was opened anew")


def try_doubt(console):
    """A cell that has changed is not certified: its state says why, and what to do."""
    console.command("enable")
    check(console.post("/api/certificate", {"out": "proof", "cycles": 2, "targets": 1})[0] == 200, "no certificate")
    console.rests()
    state = console.state()
    check(not state["job"]["ok"] and "the cell is not well" in state["job"]["ended"], state)
    check(state["held_by"] and any(doubt["remedy"] for doubt in state["doubts"]), state)


def try_doubted_move(console):
    """A cell that was found well sees its tool far from where it was sent: the certificate ends there, with a remedy."""
    console.command("enable")
    check(console.post("/api/go", {"x_mm": 300, "y_mm": 100})[0] == 200, "no move")
    console.rests()
    check(console.state()["job"]["ok"], console.state())
    file = pathlib.Path(FOLDER, "../doubted/map.yaml")
    before = file.read_text(encoding="utf-8")
    file.write_text(re.sub(r"(tail_m:\n  - \[)[^,]*", r"\g<1>0.01", before), encoding="utf-8")
    check(console.post("/api/certificate", {"out": "proof", "cycles": 2, "targets": 1})[0] == 200, "no certificate")
    console.rests()
    state = console.state()
    check(not state["job"]["ok"] and "no further move was made: mend it, then begin" in state["job"]["ended"], state)
    check(state["held_by"] == state["job"]["ended"] and state["job"]["done"] < 35, state)


def try_record(console):
    with open(f"{FOLDER}/plan.csv", "w", encoding="utf-8") as plan:
        plan.write("id,plan,x_mm,y_mm\nt1,train,330,-250\n")
    order = {"plan": "plan.csv", "out": "recording", "board": None}
    status, answer = console.post("/api/record", order)
    check(status == 200, answer)
    console.rests()
    state = console.state()
    check("1 positions recorded" in state["job"]["ended"] and
          [place["mark"] for place in state["recording"]["places"]] == ["done"], state)
    console.refused(409, "POST", "/api/answer", {"id": 1, "text": ""}, says="not asked now")


def try_step(console):
    """On a cell of which nothing is known: what is next is done where it only makes files, and they are read."""
    files = console.ask("GET", "/api/files")[1]
    check(files["next"]["text"] == "plan: plan.csv does not exist yet", files)
    before = console.state()["opened"]
    status, answer = console.post("/api/step")
    check(status == 200, answer)

    def is_open_anew():
        status, state = console.ask("GET", "/api/state")  # answered at any time
        check(status == 200, state)
        return state["opened"] == before + 1

    eventually(is_open_anew, "the cell is not opened anew")
    state = console.state()
    check(state["job"]["ok"] and state["job"]["ended"] == "plan is done" and state["operator"] is None, state)
    check(console.ask("GET", "/api/files")[1]["next"]["text"].startswith("recording: "), "the recording is not next")
    console.refused(400, "POST", "/api/step", says="next is recording")


def try_jog(console):
    console.command("enable")
    begun = console.turned()
    check(console.post("/api/jog", {"line": "joint 1 -15"})[1] ["begun"], "no jog")
    while abs(console.turned() - begun) < 0.2:
        check(console.post("/api/jog/keep")[1] == {"held": True}, "the jog has ended")
    console.rests()
    lost = console.turned()
    check(-7.5 < lost - begun < -0.1, f"a lost page's jog went from {begun} to {lost} deg")
    console.command("joint 1 0.5")
    check(abs(console.turned() - lost - 0.5) < 0.01, "the arm does not know where it was stopped")


def try_stop(console):
    """Another client stops a command on its way, and takes over what moves."""
    for end in (lambda: console.post("/api/stop", client=OTHER, token=console.read),
                lambda: console.post("/api/operator", {"take": True}, client=OTHER)):
        begun, answers = console.turned(), []
        command = threading.Thread(target=lambda: answers.append(console.post("/api/command", {"line": "joint 1 -15"})))
        command.start()
        eventually(lambda: abs(console.turned() - begun) > 0.2, "nothing moves")
        console.refused(409, "POST", "/api/command", {"line": "x 1"}, client=OTHER)
        check(end()[0] == 200, "no stop")
        command.join()
        check("stopped as asked" in answers[0][1]["text"], answers)
        check(abs(console.turned() - begun) < 14.9, "the arm was not stopped on its way")
    console.refused(409, "POST", "/api/command", {"line": "x 1"}, says="take over")
    check(console.post("/api/operator", {"take": True})[1]["operator"] == ONE, "the floor is not given back")


def try_closed_page(console):
    """Who closes the page gives the cell up within seconds; who only loses the line for a moment does not."""
    head = f" HTTP/1.1\r\nHost: 127.0.0.1:{console.port}\r\nAuthorization: Bearer {console.operate}\r\n\r\n"
    watch = console.opened(f"GET /api/events?client={OTHER}" + head)
    page = console.opened(f"GET /api/events?client={ONE}" + head)
    check(console.post("/api/command", {"line": "joint 1 0.1"})[0] == 200, "no move")
    check(console.state()["operator"] == ONE, "nobody moves the cell")
    page.close()
    page = console.opened(f"GET /api/events?client={ONE}" + head)
    time.sleep(6)
    check(console.state()["operator"] == ONE, "a page that came back has lost the cell")
    page.close()
    eventually(lambda: console.state()["operator"] is None, "a closed page keeps the cell")
    watch.close()


def try_late_orders(console):
    """What was ordered before a stop and comes later begins no more, with the number of stops or without."""
    for i in range(LATE_ORDERS):
        known = console.state()["stops"]
        said = {"X_Planar_Stops": str(known) if i % 2 else ""}
        order = threading.Thread(target=lambda: console.post("/api/go", {"x_mm": 330, "y_mm": -250 + 5 * (i % 3)}, **said))
        order.start()
        time.sleep(0.0015 * (i % 20))
        check(console.post("/api/stop")[0] == 200, "no stop")
        order.join()
        console.rests()
        rests = console.turned()
        console.refused(409, "POST", "/api/command", {"line": "joint 1 1"}, says="after this was ordered", X_Planar_Stops=str(known))
        time.sleep(0.4)  # longer than an order is on its way
        check(console.state()["doing"] == "idle" and console.turned() == rests, "the arm moved after a stop")
    check(console.post("/api/command", {"line": "joint 1 0.1"})[0] == 200, "no order is taken any more")


def try_floods(console):
    """Slow, silent and too many clients delay no stop."""
    head = f" HTTP/1.1\r\nHost: 127.0.0.1:{console.port}\r\nAuthorization: Bearer {console.read}\r\n"
    clients = [console.opened("GET /api/events" + head + "\r\n") for _ in range(64)]
    clients += [console.opened("GET /api/picture.jpg" + head + "\r\n") for _ in range(100)]
    clients += [console.opened("") for _ in range(100)] + [console.opened("GET /api/st") for _ in range(100)]
    check(console.post("/api/stop")[0] == 200, "no stop while others read slowly")
    for client in clients:
        client.close()
    statuses = set()
    for _ in range(3000):
        statuses.add(console.ask("GET", "/api/state")[0])
    check(statuses <= {200, 429}, statuses)
    check(console.post("/api/stop")[0] == 200, "no stop in a flood of requests")
    time.sleep(1.0)  # the next requests are within the rate again


def try_end(console):
    """Ctrl-C ends a move by its ramp, and then the program."""
    begun, answers = console.turned(), []
    command = threading.Thread(target=lambda: answers.append(console.post("/api/command", {"line": "joint 1 15"})))
    command.start()
    eventually(lambda: abs(console.turned() - begun) > 0.2, "nothing moves")
    console.end()
    command.join()
    check("stopped as asked" in answers[0][1]["text"], answers)


def main():
    kept = pathlib.Path(FOLDER, "token")
    kept.write_text("Kept-over_restarts\n", encoding="utf-8")
    kept.chmod(0o600)
    fast = Console("fast.yaml", "--listen", "127.0.0.1:0", "--token-file", str(kept))
    check(fast.operate == "Kept-over_restarts" != fast.read, fast.printed)
    with open("console.txt", "w", encoding="utf-8") as printed:
        printed.writelines(fast.printed)
    for what in (try_rights, try_bodies, try_names, try_folder, try_second_consoles, try_run, try_certificate, try_path, try_experiment, try_record):
        what(fast)
    check(fast.ask("GET", "/api/picture.jpg")[1][:2] == b"\xff\xd8", "no picture")
    fast.end(signal.SIGTERM)
    moved = Console("../moved/fast.yaml")
    try_doubt(moved)
    moved.end()
    doubted = Console("../doubted/cell.yaml")
    try_doubted_move(doubted)
    doubted.end()
    fresh = Console("../fresh/cell.yaml")
    try_step(fresh)
    fresh.end()
    slow = Console("slow.yaml")
    for what in (try_jog, try_stop, try_closed_page, try_late_orders, try_floods, try_end):
        what(slow)


main()
