"""Cases and results in words: what `flatpunch check` prints, ten steps of a curve with readable units; and shipped cases."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, Indices
from flatpunch._support.paths import Plain
from flatpunch._support.readable import quantity_of, unit_of
from flatpunch.bem import Grid, required_bytes
from flatpunch.bem.curves import DEFAULT_CELLS
from flatpunch.compliances import compliance
from flatpunch.contact import (
    BoundaryElements,
    Choice,
    Refined,
    SecondOrder,
    default_choice,
    indent,
    method_of,
    pull_off,
)
from flatpunch.contact.curve import NOTABLE_FORCE, percent
from flatpunch.contact.default import EXACT, LIFTS_OFF
from flatpunch.contact.physics import ELASTIC, Physics
from flatpunch.designs import LargestLoad
from flatpunch.files.cases import Case
from flatpunch.files.tables.design import DesignCase
from flatpunch.files.units import readable, text
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Stack
from flatpunch.media.material import in_words
from flatpunch.punch.matrix import sufficient_terms
from flatpunch.stresses import Strength

_CELLS_LEAVE = "0.1 %"
"""Error of the force that boundary elements leave on their default grid; every step has an estimate of its own."""

_BY_TERMS = 2.0**-13
"""Seconds of the first round contact over the square of the number of terms of a graded surface; harmonics take as long again."""

_TIMES = ((2.0, "about a second"), (30.0, "some seconds"), (120.0, "about a minute"), (3600.0, "many minutes"))
"""Words for durations below limits [s]."""


def shipped_cases() -> list[Path]:
    """Return the case files that come with the package, in alphabetical order.

    See Also
    --------
    flatpunch.read_case : Reads one of them.

    Examples
    --------
    >>> print("afm_pyramid_on_gel" in [path.stem for path in fp.files.shipped_cases()])
    True
    """
    here = Path(__file__).resolve()
    # a wheel carries them inside the package, a source tree in its folder `examples`
    for folder in (here.parents[1] / "examples", here.parents[3] / "examples"):
        cases = sorted(folder.glob("*.toml"))
        if cases:
            return cases
    raise ValueError("the shipped cases are missing from this installation; reinstall the package.")


def shipped_beside(name: str) -> list[Path]:
    """Return the files of a folder of the examples: "fit" (curves and the cases of their fits) or "rough" (rough surfaces)."""
    folder = shipped_cases()[0].parent / name
    return sorted([*folder.glob("*.toml"), *folder.glob("*.csv")])


def describe(case: Case) -> Iterator[str]:
    """Yield lines that say what a case would solve.

    See Also
    --------
    flatpunch.read_case : The case.
    flatpunch.files.describe_sample : Bodies and tip alone.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> lines = list(fp.files.describe(fp.read_case(path)))
    >>> print(lines[0])
    Case      Sphere on articular cartilage, stiffer with depth, on bone
    """
    yield from describe_sample(case.title, case.medium, case.indenter, case.physics)
    if case.time is None:
        yield f"Control   {control_words(case.control, case.values)}"
    else:
        yield f"History   {_history(case, case.time)}"
    choice = _choice(case)
    exact = choice.reason == EXACT
    named = EXACT if exact else choice.method.name + ("" if case.method else f" ({choice.reason})")
    yield f"Method    {named}, outline at {case.angles} polar angles"
    yield f"Expected  {_expected(case, choice)}"
    memory, seconds = _cost(case, choice)
    stresses = "" if case.time is not None else _stresses_take(case, seconds)
    yield f"Takes     {takes(memory, seconds)}{stresses}"
    if case.design is not None:
        yield f"Design    {_design(case, case.design, seconds)}"
    if case.slip is not None:
        yield f"Slip      friction {case.slip['friction']:g}, {_slip(case.slip)}"
    if case.stress is not None:
        asked = sum(strength != Strength() for strength in case.stress.strengths + case.stress.upper_strengths)
        yield f"Stress    friction {case.stress.friction:g}, strengths of {asked} layer{'' if asked == 1 else 's'}"


def _choice(case: Case) -> Choice:
    """The method that is named, or the one that `indent` would choose."""
    if case.physics.work_of_adhesion is not None:
        chosen = SecondOrder() if case.method is None else method_of(case.method)
        return Choice(chosen, EXACT if case.indenter.round else "adhesive contacts of other tips", quick=True)
    if case.method is not None:
        method = method_of(case.method)
        cells = isinstance(method, (BoundaryElements, Refined))
        exact = case.indenter.round and not isinstance(method, BoundaryElements)
        return Choice(method, EXACT if exact else "asked for", quick=exact or not cells)
    # histories are judged at their largest depth or force
    steps = case.values if case.time is None else [max(0.0, float(case.values.max()))]
    return default_choice(case.indenter, case.medium, **{case.control: steps})


def _expected(case: Case, choice: Choice) -> str:
    if isinstance(case.physics.relaxation, tuple):
        return "force by rings and time steps, its error estimated with the result"
    if choice is LIFTS_OFF:
        return "the result has the estimate of the force"
    if choice.reason == EXACT:
        return "force and outline exact up to rounding, within the theory"
    method = choice.method
    if isinstance(method, Refined):
        return f"force to about {percent(method.rtol)}; the result has the estimate of every step"
    if isinstance(method, BoundaryElements):
        return f"force to about {_CELLS_LEAVE}; the result has the estimate of every step"
    if case.physics.work_of_adhesion is not None:
        return "force and outline to second order of the asymmetry"
    # longest time that `check` may take for the expected error [s]; beyond, it is left to the result
    if _graded_seconds(case) > 2.0:
        return "the result has the estimate of every step (here it takes as long as solving)"
    largest = case.values[np.argmax(case.values)]
    solved = indent(case.medium, case.indenter, method=method, angles=10, **{case.control: largest})
    force, outline = (float(solved[name].values[0]) for name in ("force_error", "contour_error"))
    return f"force to {percent(force)}, outline to {percent(outline)} of the mean radius at the largest {case.control}"


def _cost(case: Case, choice: Choice) -> tuple[float, float]:
    """Memory that solving takes at most [bytes], and its time to an order of magnitude [s]."""
    steps = case.values.size
    layers = sum(len(body.layers) for _, body in case.medium.sides)
    # bytes: 200 MB of program and libraries, and the outlines while they are made
    memory = 200e6 + 4 * np.dtype(float).itemsize * steps * case.angles
    seconds = 0.1 + 0.01 * layers + 1e-4 * steps + _graded_seconds(case)
    if not choice.quick:
        memory += required_bytes(Grid(DEFAULT_CELLS, DEFAULT_CELLS, 1.0))
        seconds += 2.0 * steps if isinstance(choice.method, BoundaryElements) else 10.0
    return memory, seconds


def _stresses_take(case: Case, solving: float) -> str:
    """Time of `flatpunch stress` in words, where it is another one: under tips that are not round layers act cell by cell."""
    seconds = solving if case.indenter.round else max(solving, 3.0)
    if not case.indenter.round and compliance(case.medium).graded:
        seconds = max(seconds, 100.0)
    return "" if duration(seconds) == duration(solving) else f"; its stresses {duration(seconds)}"


def _design(case: Case, design: DesignCase, solving: float) -> str:
    """What a design varies, and how long it takes: some contacts for each number and start."""
    contacts = 10 * design.starts * (1 + len(design.vary))
    # seconds of one contact beyond what the first one takes for all; a critical load is many pressures
    each = max((solving - 0.1) / 2, 0.3 if isinstance(design.objective, LargestLoad) else 0.02)
    numbers, starts = (
        f"{n} {word}{'s' if n > 1 else ''}" for n, word in ((len(design.vary), "number"), (design.starts, "start"))
    )
    return f"{numbers} varied from {starts}, {duration(contacts * each)}"


def _graded_seconds(case: Case) -> float:
    """Time for a graded surface, which grows with the square of the number of terms: steep gradings need many."""
    if case.medium.free:
        return 0.0
    kernel = compliance(case.medium, membrane=True)
    if not kernel.graded:
        return 0.0
    return _BY_TERMS * sufficient_terms(kernel, 1.0) ** 2 * (1 if case.indenter.round else 2)


def takes(memory: float, seconds: float) -> str:
    """Memory [bytes] and time [s] in words; the memory beside that of the program itself for a small case."""
    return f"at most {memory / 1e6:.0f} MB of memory, {duration(seconds)}"


def duration(seconds: float) -> str:
    """A time [s] in words."""
    return next((said for limit, said in _TIMES if seconds < limit), "hours")


def describe_sample(title: str, medium: Body, indenter: Indenter, physics: Physics = ELASTIC) -> Iterator[str]:
    """Yield the lines about bodies, indenter, relaxation and adhesion.

    See Also
    --------
    flatpunch.files.describe : With the steps.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> for line in fp.files.describe_sample("Gel", gel, tip):
    ...     print(line)
    Case      Gel
    Body      HalfSpace young 5 kPa, poisson 0.5
    Indenter  Sphere radius 5 µm
    """
    yield f"Case      {title or '(no title)'}"
    yield from describe_bodies(medium)
    yield f"Indenter  {words(indenter)}"
    relaxation, work, within = physics.relaxation, physics.work_of_adhesion, physics.within
    if relaxation is not None:
        each = relaxation if isinstance(relaxation, tuple) else (relaxation,)
        yield f"Relaxes   {'; '.join('elastic' if one is None else words(one) for one in each)}"
    if work is not None:
        ends = f", range of action {text(within, 'm')}" if within is not None else ""
        yield f"Adhesion  work {text(work, 'J/m^2').replace('^2', '²')}{ends}"


def describe_bodies(medium: Body) -> Iterator[str]:
    """Yield the lines about what the indenter is pressed into."""
    if medium.free:
        yield f"Body      {words(medium)}"
        return
    for name, body in medium.sides:
        yield from _body(name.title() or "Body", body)


def _body(name: str, body: Stack) -> Iterator[str]:
    if body.membrane:
        yield f"{name:<9} {body.membrane.in_words()}, on the surface"
        name = ""
    if not body.layers:
        yield f"{name:<9} {words(body.base)}"
        return
    for i, layer in enumerate(body.layers):
        below = "bonded to" if layer.bonded else "sliding without friction on"
        if layer.bonded not in (True, False):
            below = f"on {in_words(layer.bonded)}, on"
        layer_words = words(layer, skip=("bonded",))
        yield f"{name if i == 0 else '':<9} {layer_words}, {below} {'the next layer' if i + 1 < len(body.layers) else 'the base'}"
    yield f"{'Base':<9} {words(body.base)}"


def words(thing: object, skip: tuple[str, ...] = ()) -> str:
    """Name a dataclass and its fields, with units where they have one: "Layer young 5 kPa, poisson 0.5"."""
    name = type(thing).__name__
    parts = []
    assert dataclasses.is_dataclass(thing)
    for field in dataclasses.fields(thing):
        value = getattr(thing, field.name)
        if not field.repr or field.name.startswith("_") or field.name in skip or value is None or value == ():
            continue
        parts.append(f"{field.name} {_value(value, unit_of(thing, field.name))}")
    return f"{name} {', '.join(parts)}".strip()


def _value(value: object, unit: str) -> str:
    if dataclasses.is_dataclass(value):
        return f"({words(value)})"
    if isinstance(value, tuple):
        # longest list that is written in full
        if len(value) <= 4 and all(isinstance(entry, float) for entry in value):
            return f"({', '.join(_value(entry, unit) for entry in value)})"
        return f"({len(value)} values)"
    return quantity_of(value, unit)


def _slip(given: Plain) -> str:
    named = [control_words(name, steps) for name, steps in given.items() if name != "friction"]
    return f"at the last step, {named[0] if named else 'from full stick until the contact slides'}"


def control_words(control: str, values: Array) -> str:
    """The quantity that is given and its steps [Pa], [N] or [m], in words."""
    unit = {"pressure": "Pa", "force": "N", "tangential_force": "N"}.get(control, "m")
    first, last = values[0], values[-1]
    if values.size == 1:
        return f"{control} {text(first, unit)}"
    return f"{control}, {values.size} steps from {text(first, unit)} to {text(last, unit)}"


def _history(case: Case, time: Array) -> str:
    unit = "N" if case.control == "force" else "m"
    reached = f"up to {text(float(case.values.max()), unit)}, at the end {text(float(case.values[-1]), unit)}"
    return f"{case.control} at {time.size} times over {text(float(time[-1] - time[0]), 's')}, {reached}"


_ROWS = 10
"""Steps that a table shows; of longer curves, as many at equal distances."""


@dataclass(frozen=True)
class CurveTable:
    """Heading and unit of each column, the rows as text, and which steps of how many they are."""

    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str


def spread(size: int, most: int) -> Indices:
    """Places of at most so many entries, first and last among them, at equal distances."""
    return np.unique(np.linspace(0, size - 1, min(most, size)).round().astype(int))


def curve_table(result: xr.Dataset) -> CurveTable:
    """Return evenly chosen steps of what `indent` or `partial_slip` returned."""
    steps = result.sizes["step"]
    chosen = spread(steps, _ROWS)
    columns, shown = [], []
    for name in _columns(result):
        values, unit = result[name].values, result[name].attrs["units"]
        finite = np.abs(values[np.isfinite(values)])
        factor, prefixed = readable(float(finite.max()) if finite.size else 0.0, unit)
        columns.append((name.replace("_", " "), prefixed.replace("^2", "²")))
        shown.append([_four_digits(values[i] * factor) for i in chosen])
    error = "error" if "stick_radius" in result else "force_error"
    if error in result and result.attrs.get("method_reason") != EXACT:
        columns.append((error.replace("_", " "), "%"))
        shown.append([f"{100 * each:.2g}" for each in result[error].values[chosen]])
    valid = result["valid"].values
    if not valid.all():
        columns.append(("theory", "holds"))
        shown.append(["yes" if valid[i] else "no" for i in chosen])
    caption = f"{len(chosen)} of {steps} steps, {_solved_by(result)}"
    return CurveTable(tuple(columns), tuple(zip(*shown, strict=True)), caption)


def _columns(result: xr.Dataset) -> tuple[str, ...]:
    """Quantities in the table of a result."""
    if "stick_radius" in result:
        return ("tangential_force", "displacement", "stick_radius", "lateral_stiffness", "dissipated_energy")
    names = ("depth", "force", "radius", "area", *(("base_radius",) if "base_radius" in result else ()))
    # the stiffness of a sudden step, infinite under power laws, is of no use in a history
    return ("time", *names) if "time" in result else (*names, "stiffness")


def _four_digits(value: float) -> str:
    """Four digits; areas up to the next prefix, a million times as much, without a power of ten; a dash for no value."""
    if np.isnan(value):
        return "-"
    digits = f"{value:.4g}"
    return f"{float(digits):.0f}" if 1e4 <= abs(value) < 1e6 else digits


def _solved_by(result: xr.Dataset) -> str:
    """The method, unless it is exact whatever its name; of partial slip the normal contact."""
    if "stick_radius" in result:
        force, radius = (text(float(result[name].values[-1]), unit) for name, unit in (("force", "N"), ("radius", "m")))
        return f"friction {result.attrs['friction']:g}, normal force {force}, contact radius {radius}"
    return EXACT if result.attrs["method_reason"] == EXACT else f"method {result.attrs['method']}"


def pull_off_lines(case: Case) -> list[str]:
    """Say where a sticking contact is lost; nothing without adhesion."""
    if (work := case.physics.work_of_adhesion) is None:
        return []
    lost = pull_off(case.medium, case.indenter, work_of_adhesion=work, range_of_action=case.physics.within)
    return [
        f"Pull-off under prescribed {name}: {text(at.force, 'N')} at depth {text(at.depth, 'm')}, radius {text(at.radius, 'm')}"
        + (f"; force may be off by {percent(at.force_error)}" if at.force_error > NOTABLE_FORCE else "")
        for name, at in (("force", lost.force_minimum), ("depth", lost.depth_minimum))
    ]
