"""Values as people read them: 3.2e-7 m is 320 nm."""

from __future__ import annotations

import math

_LETTERS = "afpnµm kMGT"
PREFIXES = {3 * (i - _LETTERS.index(" ")): letter.strip() for i, letter in enumerate(_LETTERS)}


def readable(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor and unit that bring `largest` between 1 and 1000: 3.2e-7 m reads 320 nm.

    Only simple SI units take a prefix: "m", "N", "Pa", "N/m", "J/m^2" (the prefix belongs to the first), "m^2" (squared with
    it). Seconds take none that lengthens them.
    """
    power = 2 if unit == "m^2" else 1
    if not math.isfinite(largest) or largest == 0:
        return 1.0, unit
    # The tolerance keeps 1e-6 m from reading 1000 nm when its logarithm rounds down.
    exponent = 3 * math.floor(math.log10(abs(largest)) / (3 * power) + 1e-9)
    exponent = min(max(exponent, min(PREFIXES)), 0 if unit == "s" else max(PREFIXES))
    return 10.0 ** (-exponent * power), PREFIXES[exponent] + unit


def text(value: float, unit: str) -> str:
    """Return a value as people read it: 1.2e-06, "m" gives "1.2 µm"; angles are in degrees."""
    if not math.isfinite(value):
        return str(value)
    if unit == "rad":
        return f"{math.degrees(value):.4g} deg"
    factor, prefixed = readable(value, unit) if unit else (1.0, "")
    return f"{value * factor:.4g} {prefixed}".rstrip()
