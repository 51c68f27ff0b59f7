"""Sizes in the header of an Igor binary wave (.ibw), before its reader believes them.

The reader takes each part to be as long as the header says; a damaged size makes it loop or allocate for minutes. Layout:
WaveMetrics, Technical Note 003, "Igor Binary Format".
"""

from __future__ import annotations

import struct
from pathlib import Path

from flatpunch.fit.measured.curve import CurveError

_HEADERS = {1: "hi h", 2: "hiii h", 3: "hiiii h", 5: "hh15i"}
"""Version of the format -> fields of its first header: the version, a checksum and the sizes of the parts that follow."""
_SIZES = {1: slice(1, 2), 2: slice(1, 3), 3: slice(1, 4), 5: slice(2, 15)}
"""Which of these fields are sizes of parts of the file [bytes]."""


def check_sizes(path: Path) -> None:
    """Refuse a wave whose parts are longer than its file.

    Raises
    ------
    CurveError
        If a size is negative, or all of them together are more than there is.
    """
    with path.open("rb") as file:
        start = file.read(64)
    length = path.stat().st_size
    # the version is a small number: its first byte is zero where the larger byte comes first
    order = ">" if start[:1] == b"\0" else "<"
    version = struct.unpack_from(f"{order}h", start)[0] if len(start) >= 2 else 0
    form = order + _HEADERS.get(version, "")
    if version not in _HEADERS or len(start) < struct.calcsize(form):
        raise CurveError(f"{path.name}: no Igor binary wave, or cut off. Export it anew.")
    sizes = struct.unpack_from(form, start)[_SIZES[version]]
    # older versions count 16 bytes of padding, which may be missing at the end of a file
    if min(sizes) < 0 or struct.calcsize(form) + sum(sizes) > length + 16:
        raise CurveError(
            f"{path.name}: its header announces more than the {length} bytes of the file. It is damaged; copy or export it anew."
        )
