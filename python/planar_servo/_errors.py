"""The exceptions of the module; each says what is wrong, what mends it, and where it was found."""

from __future__ import annotations


class _Refused(Exception):
    def __init__(self, message: str, refusals: list[tuple[str, str, str, str]]) -> None:
        super().__init__(message)
        self.refusals = refusals

    @property
    def fault(self) -> str:
        """What is wrong, with the value; of the first of the refusals."""
        return self.refusals[0][0]

    @property
    def remedy(self) -> str:
        """What is allowed or mends it; empty where nothing is known."""
        return self.refusals[0][1]

    @property
    def where(self) -> str:
        """The argument, or FILE, FILE:LINE; empty where the fault says it."""
        return self.refusals[0][2]

    @property
    def cause(self) -> str:
        """The kind of fault, a word such as "missing" (doc/api.md); empty where it is not known."""
        return self.refusals[0][3]


class InputError(_Refused, ValueError):
    """Wrong input: a file or an argument that breaks a rule. Nothing was done.

    ``refusals`` lists every fault found as (fault, remedy, where, cause).
    """


class WorkError(_Refused, RuntimeError):
    """Work that failed on right input: no convergence, a lost device, an arm that was stopped."""


InputError.__module__ = WorkError.__module__ = "planar_servo"
