"""A client of planar-console: a script looks on, or works a cell, beside its page.

    console = Console("http://127.0.0.1:8377/?token=...")   # as planar-console prints it
    console.set_targets("id,x_mm,y_mm\\nA,200,100\\n")
    for result in console.run("first"):
        print(result["target"], result["status"])

Answers are the JSON of the API, with its units in the names; doc/api.md describes them, and the
console itself in OpenAPI at /openapi.json. InputError says what was refused (400), WorkError why the
console does not act: no right (401, 403), the cell is at work or somebody else moves it (409), or it
does not answer.
"""

from __future__ import annotations

import json
import math
import os
import secrets
import ssl
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Iterator
from typing import Any

from ._errors import InputError, WorkError

_ON_ITS_WAY_S = 1.0  # longer than the console takes an unnumbered order for one from before a stop
_PATIENCE_S = 10.0  # an idle console sends its state every second


class Console:
    """A planar-console at the address that it prints, with the right of the address's token."""

    def __init__(self, address: str, certificate: str | os.PathLike[str] | None = None) -> None:
        """certificate: the file that a console with https was given, where no authority signed it."""
        parts = urllib.parse.urlsplit(address)
        tokens = urllib.parse.parse_qs(parts.query).get("token")
        if parts.scheme not in ("http", "https") or not parts.netloc or not tokens:
            fault = f"{address!r} is no address of a console"
            raise InputError(fault, [(fault, "give it as planar-console prints it", "address", "invalid")])
        self._origin = f"{parts.scheme}://{parts.netloc}"
        self._tls = None if certificate is None else ssl.create_default_context(cafile=certificate)
        self._stops, self._stopped_s = 0, -math.inf  # the number of the own stop, and when
        self._headers = {"Authorization": f"Bearer {tokens[0]}", "X-Planar-Client": secrets.token_hex(16)}

    def cell(self) -> dict[str, Any]:
        """Returns what does not change while the console runs: arm, workspace, camera, map."""
        return dict(self._json("/api/cell"))

    def state(self) -> dict[str, Any]:
        """Returns what the cell does, where the arm is, doubts with their remedies, and the job."""
        return dict(self._json("/api/state"))

    def files(self) -> dict[str, Any]:
        """Returns the cell's files with what made them, and what of the work is next."""
        return dict(self._json("/api/files"))

    def place(self, x_mm: float, y_mm: float, phi_deg: float | None = None) -> dict[str, Any]:
        """Returns whether a place can be reached, and how well vision knows it."""
        query = {"x_mm": x_mm, "y_mm": y_mm} | ({} if phi_deg is None else {"phi_deg": phi_deg})
        return dict(self._json("/api/place?" + urllib.parse.urlencode(query)))

    def picture(self) -> bytes:
        """Returns the newest picture of the camera as JPEG, at most 1280 px wide; empty before the first one."""
        with self._open("/api/picture.jpg") as answer:
            return bytes(answer.read())

    def events(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yields what happens: ('state', ...), ('line', ...) of the log, ('result', ...) of a target.

        It begins with what happened last and goes on until it is closed.
        """
        kind = ""
        with self._open("/api/events") as stream:
            for line in _lines(stream, self._origin):
                field, _, value = line.decode().rstrip("\n").partition(": ")
                if field == "event":
                    kind = value
                elif field == "data":
                    yield kind, json.loads(value)
        raise _unanswered(self._origin, "it has ended")

    def targets(self) -> list[dict[str, Any]]:
        """Returns the targets that run() would visit."""
        return list(self._json("/api/targets"))

    def set_targets(self, csv: str) -> list[dict[str, Any]]:
        """Checks a table of targets and keeps it; InputError.refusals lists every fault."""
        return list(self._json("/api/targets", {"csv": csv})["targets"])

    def command(self, line: str) -> str:
        """Does a line as planar-jog takes it, such as 'enable', 'home' or 'x 5', and returns its answer.

        Raises InputError for a line that is no command, and for what the arm may not do; WorkError for what fails, and
        for a motion that was stopped.
        """
        answer = self._json("/api/command", {"line": line}, patience_s=None)
        if not answer["done"]:
            raise WorkError(answer["text"], [(answer["text"], "", line, "stopped")])
        return str(answer["text"])

    def run(self, out: str, resume: bool = False) -> Iterator[dict[str, Any]]:
        """Visits the targets, and yields each result as it comes; the run's folder is `out`.

        Left early, by break or by Ctrl-C, it stops the arm. Raises WorkError where the run ends badly.
        """
        yield from self._job(self._json("/api/run", {"out": out, "resume": resume})["job"])

    def go(self, x_mm: float, y_mm: float, phi_deg: float | None = None) -> dict[str, Any]:
        """Positions once by vision, and returns the result."""
        target = {"x_mm": x_mm, "y_mm": y_mm} | ({} if phi_deg is None else {"phi_deg": phi_deg})
        (result,) = self._job(self._json("/api/go", target)["job"])
        return result

    def set_path(self, csv: str) -> dict[str, Any]:
        """Checks a path and keeps it; returns its length and places. InputError.refusals lists every fault."""
        return dict(self._json("/api/path", {"csv": csv}))

    def follow(
        self, out: str, speeds_mm_s: tuple[float, ...] = (10.0,), guided_by: tuple[str, ...] = ("vision",)
    ) -> Iterator[dict[str, Any]]:
        """Follows the path once at each speed by 'arm' and 'vision', as named, and yields how each pass went.

        The run's folder is `out`. Left early, by break or by Ctrl-C, it stops the arm. Raises WorkError where the
        path's end was not reached every time.
        """
        body = {"out": out, "speeds_mm_s": list(speeds_mm_s), "guided_by": list(guided_by)}
        yield from self._job(self._json("/api/follow", body)["job"])

    def certify(self, out: str, cycles: int = 30, targets: int = 100) -> str:
        """Certifies the cell as planar-certify does, and returns what was found; the page is in the folder `out`.

        The same call continues a certificate that was broken off. Raises WorkError where the cell is in doubt, or
        where a move missed its target or was not judged.
        """
        return self._ended(self._json("/api/certificate", {"out": out, "cycles": cycles, "targets": targets}, 60.0))

    def experiment(self, out: str) -> str:
        """Makes or continues an experiment on a copy of a virtual cell as planar-experiment does; the report is in `out`.

        Raises InputError for a real cell, WorkError where the experiment fails.
        """
        return self._ended(self._json("/api/experiment", {"out": out}))

    def step(self, board: str = "circles:11x11:50mm") -> str:
        """Does what is next of the work where that only makes files, and returns what was done.

        board is the calibration board. The console then opens the cell anew, with the new files.
        Raises WorkError where the step fails.
        """
        opened = self.state()["opened"]
        done = self._ended(self._json("/api/step", {"board": board}, 60.0))
        until = time.monotonic() + _PATIENCE_S
        while time.monotonic() < until:
            try:
                if self.state()["opened"] > opened:
                    break
            except WorkError:
                pass
            time.sleep(0.1)
        return done

    def check(self) -> None:
        """Checks whether the cell still is as it was calibrated. Raises WorkError where it is not."""
        self._ended(self._json("/api/check", {}))

    def stop(self) -> None:
        """Slows the arm to rest and ends what runs, whoever began it."""
        self._stops, self._stopped_s = self._json("/api/stop", {})["stops"], time.monotonic()

    def take_over(self) -> None:
        """Makes this client the one that moves the cell; what moves is stopped first."""
        self._json("/api/operator", {"take": True})

    def release(self) -> None:
        """Lets any other client move the cell."""
        self._json("/api/operator", {"take": False})

    def _ended(self, begun: dict[str, Any]) -> str:
        for _ in self._job(begun["job"]):
            pass
        return str(self.state()["job"]["ended"])

    def _job(self, number: int) -> Iterator[dict[str, Any]]:
        ended = False
        try:
            for kind, event in self.events():
                if kind == "result" and event["job"] == number:
                    yield event
                job = event["job"] if kind == "state" else None
                if job and job["id"] == number and job["ended"] is not None:
                    ended = True
                    if not job["ok"]:
                        raise WorkError(job["ended"], [(job["ended"], "", job["name"], "")])
                    return
        finally:
            if not ended:
                self.stop()

    def _json(self, path: str, body: dict[str, Any] | None = None, patience_s: float | None = _PATIENCE_S) -> Any:
        with self._open(path, body, patience_s) as answer:
            return json.load(answer)

    def _open(self, path: str, body: dict[str, Any] | None = None, patience_s: float | None = _PATIENCE_S) -> Any:
        data = None if body is None else json.dumps(body).encode()
        headers = dict(self._headers)
        if body is not None:
            headers["Content-Type"] = "application/json"
            if time.monotonic() < self._stopped_s + _ON_ITS_WAY_S:  # not ordered before the own stop
                headers["X-Planar-Stops"] = str(self._stops)
        request = urllib.request.Request(self._origin + path, data, headers)
        try:
            return urllib.request.urlopen(request, timeout=patience_s, context=self._tls)
        except urllib.error.HTTPError as error:
            raise _refused(error, path) from None
        except OSError as error:
            raise _unanswered(self._origin, str(getattr(error, "reason", error))) from None


def _lines(stream: Any, origin: str) -> Iterator[bytes]:
    while True:
        try:
            line = stream.readline()
        except OSError as error:
            raise _unanswered(origin, str(error)) from None
        if not line:
            return
        yield line


def _refused(error: urllib.error.HTTPError, path: str) -> InputError | WorkError:
    try:
        answer = json.load(error)
        refusals = [(f["fault"], f["remedy"], f["where"], f["cause"]) for f in answer.get("faults", [answer])]
    except (ValueError, KeyError, AttributeError):
        refusals = [(f"{path} answers {error.code} {error.reason}", "", "", "device")]
    text = "\n".join("; ".join(part for part in (where, fault, remedy) if part) for fault, remedy, where, _ in refusals)
    return InputError(text, refusals) if error.code == 400 else WorkError(text, refusals)


def _unanswered(origin: str, why: str) -> WorkError:
    fault = f"the console at {origin} does not answer: {why}"
    return WorkError(fault, [(fault, "start planar-console, and give the address that it prints", "", "device")])
