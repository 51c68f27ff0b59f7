"""Names of points: a hash of everything that determines their numbers.

Two points share a name only if they are the same to the last bit, types included: 1 and 1.0 differ. What has no content that
can be read (functions, open files, objects with hidden state) is refused rather than named by its address.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from pathlib import PurePath

import numpy as np


def content_key(*things: object) -> str:
    """Return the same 32 hexadecimal digits for the same content, in every process and on every machine.

    Content is None, numbers, texts, bytes, arrays, paths, dataclasses, and tuples, lists and mappings of them; TypeError for
    all else.
    """
    digest = hashlib.sha256()
    for piece in _pieces(things):
        # the length in front keeps ("ab", "c") apart from ("a", "bc")
        digest.update(b"%d:" % len(piece) + piece)
    return digest.hexdigest()[:32]


def _pieces(thing: object) -> Iterator[bytes]:
    if thing is None or isinstance(thing, (bool, int, str, bytes, PurePath)):
        yield type(thing).__name__.encode() if not isinstance(thing, PurePath) else b"path"
        yield thing if isinstance(thing, bytes) else str(thing).encode()
    elif isinstance(thing, float):
        yield b"float"
        yield thing.hex().encode()
    elif isinstance(thing, (np.ndarray, np.generic)) and not thing.dtype.hasobject:
        yield f"array {thing.dtype.str} {thing.shape}".encode()
        yield thing.tobytes()
    elif isinstance(thing, (tuple, list)):
        yield f"{'list' if isinstance(thing, list) else 'tuple'} {len(thing)}".encode()
        for entry in thing:
            yield from _pieces(entry)
    elif isinstance(thing, Mapping):
        yield f"mapping {len(thing)}".encode()
        yield from sorted(content_key(*pair).encode() for pair in thing.items())
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        yield f"dataclass {type(thing).__module__}.{type(thing).__qualname__}".encode()
        for field in dataclasses.fields(thing):
            # private fields, and those that are no arguments, follow from the others
            if field.compare and field.init and not field.name.startswith("_"):
                yield from _pieces((field.name, getattr(thing, field.name)))
    else:
        raise TypeError(
            f"point = {thing!r}: the content of a {type(thing).__name__} cannot be read, so that it has no key of its own. "
            "Describe points by numbers, texts, arrays, dataclasses, and lists and mappings of them."
        )
