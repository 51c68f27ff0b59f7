"""The paper's statements, each with the number that confirms or contradicts it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact import MethodName, indent
from paper import base_stress
from paper.cases import TITLES, Body, Shape, indenter, medium
from paper.data import FAST, NAMES, Curves, Map, Outlines


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of the paper.

    Attributes
    ----------
    name : str
        Short name.
    text : str
        What the paper says.
    verdict : str
        "confirmed", "contradicted", or in which part it is which.
    finding : str
        What was found, in words and numbers.
    numbers : dict of float
        The numbers by name.
    """

    name: str
    text: str
    verdict: str
    finding: str
    numbers: dict[str, float]


def eccentricity_error(maps: list[Map]) -> Statement:
    """Errors of e below 10 %."""
    numbers: dict[str, float] = {}
    parts = []
    for found in maps:
        e_g = found.eccentricity[1:, None]
        exact = e_g + found.excess["bem"][1:]
        for method in FAST:
            error = np.abs((e_g + found.excess[method][1:]) / exact - 1)
            numbers[f"{found.body} {method}"] = float(np.nanmax(error))
            numbers[f"{found.body} {method} share below 5 %"] = float(np.mean(error < 0.05))
            i, j = np.unravel_index(int(np.nanargmax(error)), error.shape)
            if method == "first-order":
                parts.append(
                    f"{TITLES[found.body]}: at most {error[i, j]:.1%}, at e_g = {found.eccentricity[1 + i]:g} and h = "
                    f"{10 ** found.log_thickness[1 + i, j]:.2g} a0; below 5 % on {np.mean(error < 0.05):.0%} of the map"
                )
    worst = max(numbers[f"{m.body} first-order"] for m in maps)
    second = max(numbers[f"{m.body} second-order"] for m in maps)
    ending = f" Second order: at most {second:.1%}."
    return Statement(
        "eccentricity error",
        "The relative error of the contact eccentricity is less than 10 %, in most parameter ranges significantly less.",
        "confirmed" if worst < 0.1 else "contradicted in part",
        "First order, " + "; ".join(parts) + "." + ending,
        numbers,
    )


def never_below(found: Map) -> Statement:
    """On an unbonded layer e >= e_g."""
    lowest = {method: float(np.nanmin(found.excess[method])) for method in found.excess}
    # the boundary elements' own scatter, seen where second order is exact to 1e-5: the lowest e_g of the map
    scatter = float(np.max(np.abs(found.excess["bem"][1] - found.excess["second-order"][1])))
    confirmed = lowest["bem"] > -scatter
    return Statement(
        "unbonded: e never below e_g",
        "For the unbonded layer the contact eccentricity is never smaller than the indenter eccentricity; the first-order "
        "method gives slightly negative differences for thin layers and large e_g.",
        "confirmed" if confirmed and lowest["first-order"] < -scatter else "contradicted",
        f"Lowest e - e_g on the map: boundary elements {lowest['bem']:+.4f} (scatter {scatter:.4f}), second order "
        f"{lowest['second-order']:+.4f}, first order {lowest['first-order']:+.4f}.",
        {**lowest, "scatter": scatter},
    )


def half_space_range(maps: list[Map]) -> Statement:
    """How thick a layer must be to answer like a half-space."""
    numbers: dict[str, float] = {}
    parts = []
    for found in maps:
        for method in ("bem", *FAST):
            e_g, log_h, excess = found.fine[method]
            middle = int(np.argmin(np.abs(e_g - 0.6)))
            row, limit = excess[middle], _half_space_excess(method, float(e_g[middle]))
            numbers[f"{found.body} {method} at 10"] = float(np.interp(1.0, log_h, row) - limit)
            # thinnest layer down to which e - e_g stays within 0.002 of the half-space's
            off = np.flatnonzero(np.abs(row - limit) > 0.002)
            last = 10 ** log_h[off.max()] if off.size else 10 ** log_h[0]
            numbers[f"{found.body} {method} leaves"] = float(last)
        parts.append(
            f"{TITLES[found.body]}, e_g near 0.6: e leaves its half-space value by 0.002 at h = "
            + ", ".join(f"{_thick(numbers[f'{found.body} {m} leaves'])} a0 ({NAMES[m]})" for m in ("bem", *FAST))
            + f"; at h = 10 a0 it is off by {numbers[f'{found.body} bem at 10']:+.4f} (boundary elements) and "
            f"{numbers[f'{found.body} first-order at 10']:+.4f} (first order)"
        )
    confirmed = all(abs(numbers[f"{m.body} bem at 10"]) < 0.002 for m in maps)
    return Statement(
        "half-space until h = 10 a0",
        "The half-space solution holds until about h = 10 a0, a lot longer than first order estimates.",
        "confirmed" if confirmed else "contradicted in part",
        "; ".join(parts) + ".",
        numbers,
    )


def _thick(value: float) -> str:
    """The map ends at 100: what has left there already leaves somewhere beyond."""
    return f"{value:.2g}" if value < 99 else "100 or more"


def _half_space_excess(method: MethodName, e_g: float) -> float:
    """e - e_g on a half-space; boundary elements are compared with the exact ellipse, which second order's is to 0.1 e^4."""
    from flatpunch.reference import elliptic

    if method == "bem":
        exact = elliptic.elliptic_paraboloid(1 - e_g**2, 1.0, 1.0, depth=1.0)
        long, short = exact.half_axis_x, exact.half_axis_y
    else:
        result = indent(medium("half-space"), indenter("ellipse", e_g), depth=1.0, method=method, angles=4)
        long, short = (float(a) for a in result.contour.values[0, :2])
    return float(np.sqrt(1 - (short / long) ** 2)) - e_g


def corners(pair: list[Outlines]) -> Statement:
    """The outline at the pyramid's edges."""
    numbers: dict[str, float] = {}
    parts = []
    for found in pair:
        exact, phi = found.contours["bem"], found.phi
        corner = int(np.argmin(np.abs(phi - np.pi / 4)))
        away = np.abs((phi + np.pi / 4) % (np.pi / 2) - np.pi / 4) < np.pi / 8
        for method in FAST:
            ratio = found.contours[method] / exact - 1
            numbers[f"{found.body} {method} corner"] = float(ratio[corner])
            numbers[f"{found.body} {method} sides"] = float(np.max(np.abs(ratio[away])))
        parts.append(
            f"{TITLES[found.body]}: at the corners first order is off by {numbers[f'{found.body} first-order corner']:+.1%} "
            f"(within 22.5 degrees of the middle of a side: at most {numbers[f'{found.body} first-order sides']:.1%}), second "
            f"order by {numbers[f'{found.body} second-order corner']:+.1%} "
            f"({numbers[f'{found.body} second-order sides']:.1%})"
        )
    off = [abs(numbers[f"{found.body} first-order corner"]) for found in pair]
    sides = [numbers[f"{found.body} first-order sides"] for found in pair]
    return Statement(
        "corners of the pyramid",
        "The contact domain is predicted very well except for the sharp corners, less badly for the bonded incompressible layer.",
        "confirmed" if off[1] < off[0] and max(sides) < min(off) else "contradicted",
        "; ".join(parts) + ". First order cuts the corners short, second order draws them out.",
        numbers,
    )


def force_curves(sets: list[list[Curves]]) -> Statement:
    """How near the force curves are, under both normalisations."""
    numbers: dict[str, float] = {}
    parts = []
    for group in sets:
        case = group[0]
        name = f"{case.body} {case.shape} {case.eccentricity:g}"
        label = TITLES[case.body] + (f", e_g = {case.eccentricity:g}" if case.shape == "ellipse" else ", pyramid")
        for method in FAST:
            for same in (True, False):
                worst = max(float(np.max(np.abs(c.force_deviation(method, same=same)))) for c in group)
                numbers[f"{name} {method} {'same' if same else 'exact'}"] = worst
        parts.append(
            f"{label}: {numbers[f'{name} first-order same']:.1%} and {numbers[f'{name} first-order exact']:.1%} "
            f"(second order {numbers[f'{name} second-order same']:.2%} and {numbers[f'{name} second-order exact']:.2%})"
        )
    pyramids = {k: v for k, v in numbers.items() if "pyramid" in k and "first-order" in k} or numbers
    same_worst, exact_worst = (max(v for k, v in pyramids.items() if ending in k) for ending in ("same", "exact"))
    # a line's width on the paper's linear axes
    almost_perfect = 0.03
    verdict = "contradicted"
    if same_worst < almost_perfect:
        verdict = (
            "confirmed"
            if exact_worst < almost_perfect
            else "confirmed only if each method is scaled by its own half-space"
        )
    return Statement(
        "almost perfect force curves",
        "The agreement of the force curves is very good, for the pyramid almost perfect.",
        verdict,
        "Largest deviation of first order from the boundary elements, each over the largest half-space force of the same method, "
        "and both over the exact one: "
        + "; ".join(parts)
        + ". Scaled alike, a constant share of first order's error at given depth cancels. Almost perfect is taken as "
        f"within {almost_perfect:.0%} for the pyramid.",
        numbers,
    )


def thin_layers(radii: tuple[float, ...] = (5.0, 15.0, 50.0)) -> Statement:
    """Thin layers as power-law grading: dlnF/dlna0 = n + 1 + k."""
    numbers: dict[str, float] = {}
    parts = []
    limits: tuple[tuple[Body, int], ...] = (("unbonded", 1), ("bonded", 3))
    shapes: tuple[tuple[Shape, int], ...] = (("ellipse", 2), ("pyramid", 1))
    for body, k in limits:
        for shape, n in shapes:
            found = _local_exponent(body, shape, np.array(radii)) - n - 1
            numbers |= {f"{body} {shape} k at {a:g}": float(v) for a, v in zip(radii, found, strict=True)}
            values = ", ".join(f"{v:.3f}" for v in found)
            parts.append(f"{TITLES[body]}, {shape}: k = {values} (limit {k})")
    near = all(
        abs(numbers[f"{body} {shape} k at {radii[-1]:g}"] - k) < 0.1 * k for body, k in limits for shape, _ in shapes
    )
    return Statement(
        "thin layers as power-law grading",
        "A thin layer behaves like a power-law graded half-space with k = 1 (unbonded) or k = 3 (bonded and incompressible).",
        "confirmed" if near else "contradicted",
        "k from dlnF/dlna0 = n + 1 + k (mean profile) at a0/h = "
        + ", ".join(f"{a:g}" for a in radii)
        + ": "
        + "; ".join(parts)
        + ".",
        numbers,
    )


def _local_exponent(body: Body, shape: Shape, radius: Array) -> Array:
    """dlnF/dlna0 by central differences; 1 % steps make them good to 1e-4."""
    step = 1.01
    around = np.sort(np.concatenate([radius / step, radius * step]))
    tip = indenter(shape, 0.5)
    force = indent(medium(body), tip, radius=around, method="first-order", angles=4).force.values
    return np.asarray(np.log(force[1::2] / force[::2]) / np.log(around[1::2] / around[::2]))


def base_tension(
    round_stress: dict[float, base_stress.BaseStress], others: dict[str, tuple[Array, Array]]
) -> Statement:
    """Tension under an unbonded layer."""
    worst = max(round_stress, key=lambda a: round_stress[a].tension)
    found = round_stress[worst]
    numbers = {f"round {a:g}": s.tension for a, s in round_stress.items()}
    numbers |= {"worst": found.tension, "worst at": worst, "pull": max(s.pull for s in round_stress.values())}
    for name, (_, tension) in others.items():
        numbers[name] = float(np.max(tension))
    listed = "; ".join(f"{name}: at most {np.max(y):.2%}" for name, (_, y) in others.items())
    thick = round_stress[min(round_stress)]
    return Statement(
        "tension at the base",
        "Tensile stresses between an unbonded layer and its base are too small to alter the contact significantly.",
        "confirmed" if found.tension < 0.02 else "contradicted",
        f"Round paraboloid: the largest tension is {found.tension:.2%} of the peak pressure, at a0 = {worst:.2g} h, "
        f"{found.where:.2g} h from the axis. The force in tension is largest under thick layers, {thick.pull:.1%} of the normal "
        f"force at a0 = {min(round_stress):.2g} h. "
        + (f"Other indenters, over the peak pressure: {listed}. " if listed else "")
        + "Receding contact matters where nothing presses the layer down, such as its own weight.",
        numbers,
    )
