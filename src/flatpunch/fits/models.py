"""Forward model and limits of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, BadValue, real
from flatpunch._support.prefixes import text
from flatpunch.contact.physics import FiniteStrain
from flatpunch.fits.adhesion import branch
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.elastic import model as elastic_model
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.scaling import internal, plain_limits
from flatpunch.fits.parameters.settings import FitMethod, Free
from flatpunch.fits.report.quantities import unit_of
from flatpunch.fits.viscoelastic.model import HistoryModel

FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""

Model = ForwardModel | AdhesiveModel | HistoryModel


def model_of(
    sample: Sample, free: Mapping[str, Free], method: FitMethod, finite_strain: FiniteStrain | None = None
) -> Model:
    """The forward model of a case, kept for the next curve; starting values in `free` differ from those of the sample."""
    if finite_strain is not None and (sample.work_of_adhesion, sample.relaxation) != (None, None):
        raise ValueError("finite_strain does not go with work_of_adhesion and relaxation; leave one of them out.")
    for name in free:
        sample.check(name)
    starts = {name: real(name, f.start) for name, f in free.items() if f.start is not None}
    started = sample.replaced(starts)
    try:
        return _kept(started, tuple(free), method, finite_strain)
    except TypeError:
        return _made(started, tuple(free), method, finite_strain)


@byte_cached
def _kept(sample: Sample, free: tuple[str, ...], method: FitMethod, finite_strain: FiniteStrain | None) -> Model:
    return _made(sample, free, method, finite_strain)


def forget_models() -> None:
    """Forget all models and their tables, which grow with the curves that they have seen.

    Interpolation moves results by up to the tables' 1e-9; after this call they are those of a new process, to the last digit.
    """
    _kept.cache_clear()
    elastic_model.forget_tables()
    branch.forget_tables()


def _made(sample: Sample, free: tuple[str, ...], method: FitMethod, finite_strain: FiniteStrain | None) -> Model:
    if sample.work_of_adhesion is not None:
        return AdhesiveModel(sample, free, method)
    if sample.relaxation is not None:
        return HistoryModel(sample, free, method)
    return ForwardModel(sample.medium, sample.indenter, free, method, finite_strain)


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
    for name, what in free.items():
        _between(name, what.start if what.start is not None else sample.value(name), what)


def bounds(model: Model, free: Mapping[str, Free]) -> tuple[Array, Array]:
    """Limits in internal parameters."""
    starts = model.externals(model.start())
    pairs = [_between(name, starts[name], free[name]) for name in model.free]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def _between(name: str, start: float, limits: Free) -> tuple[float, float]:
    begin = internal(name, start)
    low, high = plain_limits(name) or (begin - np.log(FAR), begin + np.log(FAR))
    if limits.minimum is not None:
        low = internal(name, _limit(name, "minimum", limits.minimum))
    if limits.maximum is not None:
        high = internal(name, _limit(name, "maximum", limits.maximum))
    # the start has been there and back
    slack = ROUNDING * max(1.0, abs(begin))
    if not low - slack <= begin <= high + slack or low == high:
        unit = unit_of(name)
        words = [text(v, unit) if v is not None else "none" for v in (start, limits.minimum, limits.maximum)]
        raise BadValue(name, "", f": the start {words[0]} must lie between minimum {words[1]} and maximum {words[2]}.")
    return low, high


def _limit(name: str, which: str, value: float) -> float:
    value = real(f"{name} {which}", value)
    plain = plain_limits(name)
    if plain is None and value <= 0:
        raise ValueError(f"{name} {which} = {value!r} must be > 0.")
    return float(np.clip(value, *plain)) if plain else value
