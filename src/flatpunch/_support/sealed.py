"""Files with a seal: a last line that holds the SHA-256 of everything before it.

HDF5 and zip ignore what follows their end, so that other programs read sealed files as any other. A damaged file is found before
a library sees its bytes: HDF5 may return other numbers for damaged ones, fail deep inside, or never return.
"""

from __future__ import annotations

import hashlib
import re

_MARK = b"# flatpunch seal sha256 "
_SEAL = re.compile(rb"\n" + _MARK + rb"([0-9a-f]{64})\n")
_LENGTH = 1 + len(_MARK) + 64 + 1


class BrokenSeal(ValueError):
    """Bytes that are not those that were written."""


def sealed(content: bytes) -> bytes:
    """Return the content with its seal."""
    return content + b"\n" + _MARK + hashlib.sha256(content).hexdigest().encode() + b"\n"


def unsealed(content: bytes) -> tuple[bytes, bool]:
    """Return what was sealed, and whether there was a seal: files of earlier versions have none.

    Raises
    ------
    BrokenSeal
        If the content is not what was sealed, or its seal is damaged itself.
    """
    end = content[-_LENGTH:]
    match = _SEAL.fullmatch(end)
    if match is not None:
        body = content[:-_LENGTH]
        if hashlib.sha256(body).hexdigest().encode() != match[1]:
            raise BrokenSeal("its bytes are not those that were written")
        return body, True
    if len(end) == _LENGTH and sum(a == b for a, b in zip(end[1:], _MARK, strict=False)) > len(_MARK) // 2:
        raise BrokenSeal("the line at its end is damaged")
    if _MARK in content[-4 * _LENGTH :]:
        raise BrokenSeal("something was added or lost at its end")
    return content, False
