"""Archives from outside (.zip, .npz, .xlsx, force maps of JPK): their unpacked size is asked before anything is unpacked."""

from __future__ import annotations

import zipfile
from pathlib import Path

from flatpunch._support.reading import Unreadable

UNPACKED = 2_000_000_000
"""Largest size of all files of an archive together [bytes]."""

FILES = 200_000
"""Most files of an archive; force maps hold some for each curve."""


def check_archive(path: Path) -> None:
    """Refuse archives that unpack to more than can be read; what is no archive is left to its reader.

    Python unpacks no more than the sizes that an archive states, whatever it holds.

    Raises
    ------
    Unreadable
        With the size.
    """
    try:
        with path.open("rb") as file:
            if not zipfile.is_zipfile(file):
                return
            with zipfile.ZipFile(file) as archive:
                entries = archive.infolist()
    # what `zipfile` raises on damaged lists of files, and on kinds of archives that it does not read
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
        raise Unreadable("damaged: its list of files cannot be read") from None
    size = sum(entry.file_size for entry in entries)
    if len(entries) > FILES:
        raise Unreadable(f"an archive of {len(entries)} files; at most {FILES} are read")
    if size > UNPACKED:
        raise Unreadable(f"an archive that unpacks to {size / 1e9:.3g} GB; at most {UNPACKED / 1e9:g} GB are read")
