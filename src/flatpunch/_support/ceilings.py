"""Largest sizes of a problem: beyond them memory or time run out, which is said at once instead of after an hour.

They are far above what a contact needs; nobody is meant to reach them by design.
"""

from __future__ import annotations

STEPS = 1_000_000
"""Steps of a curve, or times of a history: 100 MB of results without outlines."""

ANGLES = 100_000
"""Polar angles of an outline."""

SIDES = 100
"""Faces of a pyramid: beyond, it is its round limit to 2e-4, which takes a hundred times less."""

LAYERS = 2000
"""Layers of a body: C(k) takes time in proportion, about a second for each solved radius at this number."""

CELLS = 4096
"""Cells along a side in boundary elements: 16 million cells take some GB."""

POINTS = 200_000
"""Points of a sweep or of a table of the atlas."""

INSIDE = 2_000_000
"""Points inside a body at which fields are wanted in one call: about 2 GB of arrays."""

NUMBERS = 50_000_000
"""Numbers of one argument: 400 MB. Every argument has a ceiling of its own below."""

OUTLINES = NUMBERS
"""Steps times angles of one result."""

AT_ONCE = 2_000_000
"""Numbers of one intermediate array: larger sums are made in parts. Half or twice as many cost no time."""
