"""Files of atomic force microscopes and nanoindenters, through the package afmformats (extra `afm`)."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch.fit.curve import Curve, CurveError


def read_afm(
    path: str | Path,
    *,
    spring_constant: float | None = None,
    sensitivity: float | None = None,
    height: str = "height (measured)",
) -> list[Curve]:
    """Read all curves of a microscope file.

    Parameters
    ----------
    path : path
        Any file that afmformats knows (JPK, Asylum, HDF5, tab, NT-MDT, Chiaro), also inside a .zip.
    spring_constant : float, optional
        Cantilever [N/m]; needed where the file does not say, otherwise it must be left out or takes the place of the file's.
    sensitivity : float, optional
        Deflection per signal [m/V], for files with raw signals.
    height : str
        Which height to use: "height (measured)" or "height (piezo)".

    Returns
    -------
    list of Curve
        Approach and retract as they are; depth = -(height + force/k), as heights there grow away from the sample.

    Raises
    ------
    CurveError
        If afmformats is not installed or cannot read the file.
    """
    path = Path(path)
    override = {
        name: value
        for name, value in (("spring constant", spring_constant), ("sensitivity", sensitivity))
        if value is not None
    }
    if path.suffix.lower() == ".zip":
        return _zipped(path, override, height)
    return [_curve(data, path, i, height) for i, data in enumerate(_loaded(path, override))]


def _zipped(path: Path, override: dict[str, float], height: str) -> list[Curve]:
    """afmformats takes a zip for a workshop file; here it is only a wrapping."""
    try:
        with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory() as folder:
            names = [name for name in archive.namelist() if not name.endswith("/")]
            if len(names) != 1:
                raise CurveError(f"{path.name}: {len(names)} files inside; unpack it and read them one by one.")
            inner = Path(folder) / Path(names[0]).name
            inner.write_bytes(archive.read(names[0]))
            return [_curve(data, path, i, height) for i, data in enumerate(_loaded(inner, override))]
    except zipfile.BadZipFile as error:
        raise CurveError(f"{path.name}: damaged ({error}).") from None


def _loaded(path: Path, override: dict[str, float]) -> Any:
    try:
        import afmformats
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs afmformats: pip install 'flatpunch[afm]'.") from None
    try:
        return afmformats.load_data(path, meta_override=override)
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        # some errors of afmformats derive from BaseException
        raise CurveError(f"{path.name}: {_explained(error)}") from None


def _explained(error: BaseException) -> str:
    kind, text = type(error).__name__, str(error).splitlines()[0] if str(error) else "no reason given"
    if kind == "MissingMetaDataError":
        return f"the file does not say everything ({text}). Pass spring_constant=... [N/m] and sensitivity=... [m/V]."
    return f"afmformats cannot read it ({kind}: {text})."


def _curve(data: Any, path: Path, index: int, height: str) -> Curve:
    name = path.stem if index == 0 else f"{path.stem}-{index}"
    columns = list(data.columns)
    k = data.metadata.get("spring constant")
    try:
        force = np.asarray(data["force"], dtype=float)
        if height not in columns:
            raise CurveError(f"{path.name}: no column {height!r}; there are {', '.join(columns)}.")
        position = np.asarray(data["tip position" if "tip position" in columns else height], dtype=float)
        segment = np.asarray(data["segment"]) if "segment" in columns else np.zeros(force.size, dtype=int)
    except (KeyboardInterrupt, SystemExit, GeneratorExit, CurveError):
        raise
    except BaseException as error:
        raise CurveError(f"{path.name}: {_explained(error)}") from None
    meta = {"source": str(path.name), "segment": segment, "metadata": dict(data.metadata)}
    k = float(k) if k is not None and np.isfinite(k) else None
    if "tip position" in columns:
        return Curve(-position, force, spring_constant=k, name=name, meta=meta)
    if k is None:
        raise CurveError(
            f"{path.name}: the file does not say the cantilever's spring constant. Pass spring_constant=... [N/m]."
        )
    return Curve.from_piezo(-position, force, k, name=name, meta=meta)
