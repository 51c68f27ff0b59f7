"""Plain records of frozen objects: what a result file says was solved, and what can be read back from it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


def record(thing: object) -> Any:
    """Return dataclasses as {"type": name, field: ...}, arrays and tuples as lists, numbers as they are.

    Functions, and objects of classes that are no dataclasses, are recorded by their name: they cannot be read back.
    """
    if hasattr(thing, "recorded") and not isinstance(thing, type):
        # it stands for another, which says more to a reader
        return record(thing.recorded)
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        fields = {f.name: record(getattr(thing, f.name)) for f in dataclasses.fields(thing) if f.init or f.repr}
        return {"type": type(thing).__name__, **fields}
    if isinstance(thing, np.ndarray):
        return thing.tolist()
    if isinstance(thing, dict):
        return {name: record(value) for name, value in thing.items()}
    if isinstance(thing, (list, tuple)):
        return [record(entry) for entry in thing]
    if isinstance(thing, np.generic):
        return thing.item()
    if callable(thing):
        return f"function {getattr(thing, '__qualname__', type(thing).__name__)}"
    if thing is None or isinstance(thing, (bool, int, float, str)):
        return thing
    # a shape or medium of the user's own: by its name, like a function
    return {"type": type(thing).__name__}
