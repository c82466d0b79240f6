"""Lamps followed through a sequence of pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable, Iterator

from ._core import LampPair, LampTracker

if TYPE_CHECKING:
    import numpy as np


def track_lamps(
    images: Iterable[np.ndarray[Any, Any]], method: str = "auto", **expected: Any
) -> Iterator[LampPair]:
    """Locates both lamps in one picture after the other.

    Where they were seen last tells where to look next, and which is which: of the first pair lamp 1
    is the one that LampTracker puts first. expected goes to LampTracker.locate().
    """
    tracker = LampTracker(method)
    last = expected.pop("predicted_px", None)
    for image in images:
        pair = tracker.locate(image, predicted_px=last, **expected)
        if pair.status in ("ok", "ambiguous"):
            last = pair.uv_px
        yield pair
