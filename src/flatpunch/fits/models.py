"""Forward model and limits of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, BadValue, real
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch.fits.adhesion import branch
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.elastic.model import ForwardModel, table_of
from flatpunch.fits.parameters.sample import Sample, Scale, ends
from flatpunch.fits.parameters.settings import FitMethod, Free
from flatpunch.fits.viscoelastic import HistoryModel

FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""

Model = ForwardModel | AdhesiveModel | HistoryModel


def model_of(sample: Sample, free: Mapping[str, Free], method: FitMethod) -> Model:
    """The forward model of a case, kept for the next curve; starting values in `free` differ from those of the sample."""
    sample.check(free)
    starts = {name: real(name, f.start) for name, f in free.items() if f.start is not None}
    return _made(sample.replaced(starts), tuple(free), method)


def forget_models() -> None:
    """Forget all models and their tables, which grow with the curves that they have seen.

    Interpolation moves results by up to the tables' 1e-9; after this call they are those of a new process, to the last digit.
    """
    _made.cache_clear()
    table_of.cache_clear()
    branch.forget_tables()


@byte_cached
def _made(sample: Sample, free: tuple[str, ...], method: FitMethod) -> Model:
    if sample.adhesive:
        return AdhesiveModel(sample, free, method)
    if sample.relaxing:
        return HistoryModel(sample, free, method)
    return ForwardModel(sample.medium, sample.indenter, free, method, sample.physics.finite_strain)


def segments(adhesive: bool, over_time: bool) -> tuple[str, ...]:
    """Parts of a cycle that can be fitted, the one that "auto" means first."""
    return ("retract", "both") if adhesive else ("both",) if over_time else ("approach",)


def check_segment(segment: str, known: Sequence[str]) -> None:
    """Refuse a part of a cycle that the physics has no use for."""
    if segment not in ("auto", *known):
        words = " or ".join(map(repr, ("auto", *known)))
        raise BadValue(
            "segment",
            repr(segment),
            f"does not go with this case; it is {words}. Retracts are fitted with work_of_adhesion, cycles with relaxation.",
        )


def check_free(sample: Sample, free: Mapping[str, Free]) -> None:
    """Refuse limits that a start does not lie between, without making a model."""
    sample.check(free)
    for name, what in free.items():
        number = sample.numbers[name]
        _between(number, number.value if what.start is None else what.start, what, ends(number))


def bounds(model: Model, free: Mapping[str, Free]) -> tuple[Array, Array]:
    """Limits in internal parameters."""
    pairs = [_between(model.numbers[n], model.numbers[n].value, free[n], model.ends(n)) for n in model.free]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def _between(number: Place, start: float, limits: Free, ends: tuple[float, float]) -> tuple[float, float]:
    scale, name = Scale.of(number), number.path
    begin, far = scale.internal(start), np.log(FAR)
    low, high = (end if np.isfinite(end) else begin + way for end, way in zip(ends, (-far, far), strict=True))
    if limits.minimum is not None:
        low = max(_limit(number, "minimum", limits.minimum), ends[0])
    if limits.maximum is not None:
        high = min(_limit(number, "maximum", limits.maximum), ends[1])
    # the start has been there and back
    slack = ROUNDING * max(1.0, abs(begin))
    if not low - slack <= begin <= high + slack or low == high:
        words = [
            text(v, number.number.unit or "") if v is not None else "none"
            for v in (start, limits.minimum, limits.maximum)
        ]
        raise BadValue(name, "", f": the start {words[0]} must lie between minimum {words[1]} and maximum {words[2]}.")
    return low, high


def _limit(number: Place, which: str, value: float) -> float:
    scale, name = Scale.of(number), f"{number.path} {which}"
    value = real(name, value)
    if scale.form != "plain" and value <= 0:
        raise ValueError(f"{name} = {value!r} must be > 0.")
    if scale.form == "slope" and value > np.pi / 2:
        raise ValueError(f"{name} = {value!r} must not exceed pi/2.")
    return scale.internal(value)
