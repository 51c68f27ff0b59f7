"""Tables from files, the shipped ones by name, and media that find theirs by themselves.

A file is NetCDF 4 (HDF5) with one family. Coefficients are whole numbers times a step, which the attribute `scale_factor`
gives (the NetCDF convention), each with its degrees; the documentation has the twenty lines that evaluate them.
"""

from __future__ import annotations

import io
from dataclasses import replace
from importlib import resources
from pathlib import Path
from types import NoneType
from typing import Any, cast

import h5netcdf
import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, Indices, instance, one_of, shown
from flatpunch._support.reading import RESULT, Unreadable, as_path, content, is_file, is_folder, shown_path
from flatpunch._support.whole_file import BrokenSeal, unsealed
from flatpunch.atlas.panel import Panel, Parameter, PowerLawPanel, Scale, SparseSeries
from flatpunch.atlas.tables import Outside, Solution, Table
from flatpunch.compliances import compliance
from flatpunch.media import Body, ExponentialModulus, GradedLayer, LinearModulus, Material, TabulatedMedium, underlying
from flatpunch.media.material import young_and_poisson
from flatpunch.punch.matrix import solve_round, sufficient_terms

SCHEMA = 1
"""Version of the layout; files of a later one are refused."""

_GRADING = Parameter("grading", "exponent k of E(z) = E_l (z/l)^k", -0.49, 0.99)
_POISSON = Parameter("poisson", "Poisson ratio nu", 0.0, 0.5)

POWER_LAW = Table(
    "power-law",
    "Half-space whose modulus is a power of depth (closed form, no data)",
    (_GRADING, _POISSON),
    (PowerLawPanel(_GRADING, _POISSON),),
    ROUNDING,
    {"source": "Booker, Balaam and Davis 1985; Giannakopoulos and Suresh 1997", "license": "CC-BY-4.0"},
)


class AtlasFileError(ValueError):
    """A file that is no table of the atlas, or of a later layout.

    See Also
    --------
    flatpunch.atlas.read_table : Raises it.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> print(issubclass(atlas.AtlasFileError, ValueError))
    True
    """


def folder() -> Path:
    """Where the shipped tables are."""
    return Path(str(resources.files("flatpunch.atlas") / "data"))


def families() -> tuple[str, ...]:
    """Names of the shipped tables.

    See Also
    --------
    flatpunch.atlas.table : One of them.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> print(*atlas.families())
    bonded-coating bonded-layer exponential-coating linear-coating sliding-coating sliding-layer
    """
    return tuple(sorted(path.stem for path in folder().glob("*.nc")))


def find_table(name: str | Path) -> Table:
    """A shipped table by its name, or one of your own by its file.

    Parameters
    ----------
    name : str or path
        One of `families()`, "power-law" (closed forms), or a file of your own, name.nc.

    Returns
    -------
    Table

    Raises
    ------
    ValueError, OSError
        If there is no such table.

    See Also
    --------
    flatpunch.atlas.families : The names.
    flatpunch.atlas.tabulated : As a medium.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> layer = atlas.table("bonded-layer")
    >>> print(layer.stiffness_and_moments(np.array([0.5, 1.0]), poisson=0.3)[0].round(4))
    [1.624  2.4835]
    """
    path = as_path("name", name)
    if name == POWER_LAW.name:
        return POWER_LAW
    path = folder() / f"{name}.nc" if name in families() else path
    if not path.suffix:
        raise ValueError(
            f"name = {shown(name)} is no table: there are {', '.join(families())}, and files of your own (name.nc)."
        )
    return _read_once(path, path.stat().st_mtime if is_file(path) else 0.0)


@byte_cached
def _read_once(path: Path, changed: float) -> Table:
    return read_table(path)


def read_table(path: str | Path) -> Table:
    """Read a table.

    Parameters
    ----------
    path : path
        A file that `scripts/atlas_tables` of the repository has written.

    Returns
    -------
    Table

    Raises
    ------
    AtlasFileError, OSError
        If it is no such file.

    See Also
    --------
    flatpunch.atlas.table : By name or file.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> from importlib.resources import files
    >>> path = files("flatpunch.atlas") / "data" / "sliding-layer.nc"
    >>> print(atlas.read_table(path).name)
    sliding-layer
    """
    path = as_path("path", path)
    if not is_file(path) and not is_folder(path):
        raise FileNotFoundError(
            f"{shown_path(path)}: there is no such file. scripts/atlas_tables of the repository makes tables."
        )
    try:
        body, has_seal = unsealed(content(path, RESULT))
        if not has_seal:
            # HDF5 may return other numbers for damaged bytes, or never return
            raise BrokenSeal(
                "it has no line of its checksum at the end; scripts/atlas_tables of the repository makes it again"
            )
        with h5netcdf.File(io.BytesIO(body), "r") as file:
            return _table(file, path)
    except AtlasFileError:
        raise
    except (Unreadable, BrokenSeal) as error:
        raise AtlasFileError(f"{shown_path(path)} is no table of the atlas: {error}.") from None
    except Exception:  # damaged bytes make HDF5 fail in any way
        raise AtlasFileError(f"{shown_path(path)} is no table of the atlas: damaged, or of another kind.") from None


def _table(file: Any, path: Path) -> Table:
    schema = file.attrs.get("flatpunch_atlas_schema")
    if schema is None or int(schema) > SCHEMA:
        known = "it does not say which layout it has" if schema is None else f"its layout is version {schema}"
        raise AtlasFileError(
            f"{path}: {known}; this version reads tables up to {SCHEMA}. A newer flatpunch may read it."
        )
    parameters = tuple(_parameter(file["parameters"], name) for name in str(file["parameters"].attrs["names"]).split())
    low, high = (file["panels"].variables[name][:] for name in ("beta_low", "beta_high"))
    kinds = [name for name in file.groups if name not in ("panels", "parameters")]
    series = {kind: _series(file[kind], parameters) for kind in kinds}
    orders = np.asarray(file["panels"].variables["orders"][:], dtype=int)
    panels = tuple(
        Panel(float(low[i]), float(high[i]), {kind: series[kind][i] for kind in kinds}, orders[i][orders[i] > 0])
        for i in range(low.size)
    )
    attributes = {name: np.asarray(value).tolist() for name, value in file.attrs.items() if not name.startswith("_")}
    for name in ("flatpunch_atlas_schema", "beta_low", "beta_high"):
        attributes.pop(name)
    family, title, bound = (attributes.pop(name) for name in ("family", "title", "relative_error_bound"))
    return Table(str(family), str(title), parameters, panels, float(np.ravel(bound)[0]), attributes)


def _parameter(group: Any, name: str) -> Parameter:
    a = group[name].attrs
    scale = cast("Scale", str(a["scale"]))  # which Parameter checks
    ends = (float(a["low"]), float(a["high"]))
    return Parameter(name, str(a["long_name"]), *ends, scale, float(a["shift"]), str(a["units"]))


def _series(group: Any, parameters: tuple[Parameter, ...]) -> list[SparseSeries]:
    """One kind of function on all panels."""

    def column(name: str) -> Indices:
        return np.asarray(group.variables[name][:], dtype=np.int64)

    # NumPy scalars of one element, as the file gives attributes
    step = float(np.ravel(group.variables["value"].attrs["scale_factor"])[0])
    value: Array = np.asarray(column("value") * step, dtype=float)
    output, beta_degree = column("output"), column("beta_degree")
    degrees = [column(f"degree_{p.name}") for p in parameters]
    outputs, panel = column("outputs"), column("panel_index")
    parts = [slice(*np.searchsorted(panel, [i, i + 1])) for i in range(outputs.size)]
    return [
        SparseSeries(int(n), value[p], output[p], beta_degree[p], tuple(d[p] for d in degrees))
        for n, p in zip(outputs, parts, strict=True)
    ]


def tabulated(
    medium: Body, *, outside: Outside = "solve", table: Table | None = None, **parameters: float
) -> TabulatedMedium:
    """A medium that takes its flat punches from the atlas, for use as any other medium.

    Parameters
    ----------
    medium : Medium
        One layer, homogeneous or graded (LinearModulus, ExponentialModulus), on a base: the table is found by what it is.
    outside : "solve" or "refuse"
        What to do where a contact is smaller or larger than the table holds: solve it directly, as without a table, or raise.
    table : Table, optional
        The table to use: a family of your own, or a shipped family built anew.
    **parameters : float
        Values of its parameters for this medium, where the table is your own.

    Returns
    -------
    TabulatedMedium
        Goes into `flatpunch.indent`, `flatpunch.flat_punch` and all others.

    Raises
    ------
    ValueError
        If no table holds this medium, or the one given belongs to another medium.

    See Also
    --------
    flatpunch.atlas.table : The numbers.
    flatpunch.flat_punch : Solved directly.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> curve = fp.indent(atlas.tabulated(gel), fp.Sphere(radius=5e-6), depth=100e-9)
    >>> print(f"{float(curve.force[0]) * 1e9:.3f} nN")
    1.040 nN
    """
    underlying(medium)
    one_of("outside", outside, ("solve", "refuse"))
    instance("table", table, (Table, NoneType), "a Table: atlas.table(name)")
    if table is not None and table.name not in families():
        solution = table.at(**parameters)
        _check_same(medium, solution)
    elif parameters:
        raise TypeError(
            f"{', '.join(parameters)}: parameters go with a table of your own; here they follow from the medium."
        )
    else:
        solution = _shipped(medium, table)
    return TabulatedMedium(medium, solution if outside == solution.outside else replace(solution, outside=outside))


def _shipped(medium: Body, table: Table | None) -> Solution:
    """Solution of a medium of a shipped family, in its table or in one built anew."""
    name, values = identify(medium) or ("", {})
    if name not in (families() if table is None else (table.name,)):
        raise ValueError(
            f"No table holds this {type(medium).__name__}: the atlas knows one layer on a base, {', '.join(families())}. "
            "Without flatpunch.atlas.tabulated the medium is solved directly."
        )
    try:
        return (table or find_table(name)).at(**values)
    except ValueError as error:
        raise ValueError(f"The medium belongs to {name!r}, but {error}") from error


def _check_same(medium: Body, solution: Solution) -> None:
    """Refuse a table of another medium: one punch is solved directly."""
    kernel = compliance(medium)
    beta = np.array([np.sqrt(np.prod(solution.beta_range))])
    direct = np.pi * solve_round(kernel, beta, sufficient_terms(kernel, float(beta[0]))).flat[0, 0]
    found = float(solution.normalized_stiffness(beta)[0])
    if not abs(found / direct - 1) < max(1e-6, 10 * solution.error):
        raise ValueError(
            f"The table {solution.family!r} with {dict(solution.parameters)} belongs to another medium: at beta = {beta[0]:.3g} "
            f"it says Kbar = {found:.6g}, the medium {direct:.6g}. Check the values of the parameters."
        )


def identify(medium: Body) -> tuple[str, dict[str, float]] | None:
    """Family of a medium and its parameters, whose ranges are not checked; None if no shipped family has it.

    Per wavenumber a layer is in plane strain, so that a bonded layer on a half-space depends on its elastic constants through
    Dundurs' two parameters only (T2).
    """
    stack = medium.single
    if not stack or len(stack.layers) != 1 or stack.layers[0].bonded not in (True, False):
        return None
    layer, base = stack.layers[0], stack.base
    if not base.isotropic:
        if not (layer.isotropic and base.rigid):
            return None
        return ("bonded-layer", {"poisson": layer.isotropic[1]}) if layer.bonded else ("sliding-layer", {})
    if layer.isotropic:
        ratio = layer.surface_modulus / base.surface_modulus
        if not layer.bonded:
            return "sliding-coating", {"modulus_ratio": ratio}
        alpha, beta = dundurs(layer, base)
        return "bonded-coating", {"modulus_ratio": ratio, "dundurs_position": 2 * beta - (alpha - 1) / 2}
    match layer:
        case GradedLayer(bonded=True, anisotropic=False, young=LinearModulus()):
            return _graded("linear-coating", layer, base)
        case GradedLayer(bonded=True, anisotropic=False, young=ExponentialModulus()):
            return _graded("exponential-coating", layer, base)
    return None


def _graded(name: str, layer: GradedLayer, base: Material) -> tuple[str, dict[str, float]] | None:
    """Coating whose modulus ends in that of the half-space below, with one Poisson ratio."""
    top, bottom = layer.young_at(np.array([0.0, layer.thickness]))
    poisson = layer.poisson_at(np.linspace(0.0, layer.thickness, 10))
    young, nu = young_and_poisson(base)
    if not np.isclose(bottom, young, rtol=ROUNDING) or np.abs(poisson - nu).max() > ROUNDING:
        return None
    # a law may end below the layer; then the layer holds a part of it only, which is again a law of the same kind
    return name, {"modulus_ratio": float(top / bottom), "poisson": nu}


def dundurs(film: Material, base: Material) -> tuple[float, float]:
    """Dundurs' parameters (alpha, beta) of two bonded materials [-].

    alpha = (E1* - E2*)/(E1* + E2*), beta = (1/2)(mu1 (1 - 2 nu2) - mu2 (1 - 2 nu1))/(mu1 (1 - nu2) + mu2 (1 - nu1)), with 1 the
    film (Dundurs 1969).

    See Also
    --------
    flatpunch.atlas.tabulated : Coatings by these parameters.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> film = fp.Layer(young=200e9, poisson=0.2, thickness=1e-6)
    >>> alpha, beta = atlas.dundurs(film, fp.HalfSpace(young=70e9, poisson=0.3))
    >>> print(f"{alpha:.3f} {beta:.3f}")
    0.461 0.108
    """
    (mu1, nu1), (mu2, nu2) = _constants("film", film), _constants("base", base)
    below = mu1 * (1 - nu2) + mu2 * (1 - nu1)
    alpha = (film.surface_modulus - base.surface_modulus) / (film.surface_modulus + base.surface_modulus)
    return alpha, (mu1 * (1 - 2 * nu2) - mu2 * (1 - 2 * nu1)) / (2 * below)


def _constants(name: str, part: object) -> tuple[float, float]:
    if not isinstance(part, Material) or part.isotropic is None:
        raise TypeError(f"{name} = {shown(part)} must be isotropic and homogeneous: a Layer or a HalfSpace.")
    return part.isotropic
