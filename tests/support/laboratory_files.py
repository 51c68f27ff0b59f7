"""Files as instruments export them, of random curves with known truth: what a fit of each must give.

The bodies are half-spaces under paraboloids, whose force is that of Hertz, and hard bodies under a tip with A = 24.5 h_c^2.
"""

import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from openpyxl import Workbook

from flatpunch.fits.films.oliver_pharr import DIAMOND

CASE = """
[base]
kind = "half-space"
young = {{ fit = "{start:.6g} Pa" }}
poisson = {poisson}
[indenter]
kind = "paraboloid"
radius = "{radius:.6g} m"
"""
FILM_CASE = """
layers = [{ young = { fit = "50 GPa" }, poisson = 0.25, thickness = "1 mm" }]
base = { kind = "half-space", young = "72 GPa", poisson = 0.25 }
indenter = { kind = "berkovich" }
[film]
area_coefficients = [24.5]
beta = 1.0
"""


@dataclass(frozen=True)
class Made:
    """A file, its case, and the modulus [Pa] that a fit must find, or the words that must name what it is."""

    path: Path
    case: str
    young: float | None = None
    words: str = ""
    film: bool = False
    note: str = ""


@dataclass(frozen=True)
class Bead:
    """A random paraboloid on a random soft half-space."""

    young: float
    poisson: float
    radius: float
    deepest: float

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Bead":
        radius = 10 ** rng.uniform(-5.7, -4.7)
        return cls(
            10 ** rng.uniform(3.0, 4.5), float(rng.choice([0.3, 0.45, 0.5])), radius, rng.uniform(0.05, 0.2) * radius
        )

    def force(self, depth: Any) -> Any:
        """[N], zero before the contact."""
        stiff = 4 / 3 * self.young / (1 - self.poisson**2) * np.sqrt(self.radius)
        return stiff * np.maximum(depth, 0.0) ** 1.5

    @property
    def largest(self) -> float:
        """[N]."""
        return float(self.force(self.deepest))

    def case(self, rng: np.random.Generator, more: str = "") -> str:
        """Case file, whose start is off by up to a factor of five."""
        start = self.young * 5 ** rng.uniform(-1, 1)
        return CASE.format(start=start, poisson=self.poisson, radius=self.radius) + more

    def behind(self, piezo: Any, k: float) -> Any:
        """Force over the position of the cantilever's base [N]."""
        depth = np.linspace(0, 2 * self.deepest, 20_000)
        return np.interp(piezo, depth + self.force(depth) / k, self.force(depth), left=0.0)


def _rows(path: Path, titles: str, *columns: Any, sep: str = ",", decimal: str = ".", encoding: str = "utf-8") -> Path:
    lines = [sep.join(f"{v:.9g}".replace(".", decimal) for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([titles, *lines]) + "\n", encoding=encoding)
    return path


def _noisy(rng: np.random.Generator, force: Any, share: float = 0.002) -> Any:
    return force + share * np.ptp(force) * rng.normal(size=np.size(force))


def _ramp(bead: Bead, k: float, rng: np.random.Generator, points: int = 1200) -> tuple[Any, Any]:
    """Positions of the cantilever's base on the approach, from well before the contact [m], and the force [N]."""
    last = bead.deepest + bead.largest / k
    piezo = np.linspace(-rng.uniform(0.4, 1.2) * last, last, points)
    return piezo, bead.behind(piezo, k)


def _spring(bead: Bead, rng: np.random.Generator) -> float:
    """A cantilever that bends 0.5 to 3 times as far as the tip goes in [N/m]."""
    return float(f"{bead.largest / bead.deepest / rng.uniform(0.5, 3.0):.3g}")


def load_hold(folder: Path, rng: np.random.Generator) -> Made:
    """A ramp of load, a hold with creep, an unloading; segments under one of several titles, or none."""
    bead = Bead.random(rng)
    n, creep = int(rng.integers(200, 700)), rng.uniform(0.02, 0.1) * bead.deepest
    out = np.linspace(-rng.uniform(0.2, 0.6) * bead.deepest, 0, int(rng.integers(60, 300)))
    load = np.linspace(0, bead.largest, n)
    down = bead.deepest * np.linspace(0, 1, n) ** (2 / 3)
    hold = bead.deepest + creep * (1 - np.exp(-np.linspace(0, 3, n // 3)))
    back = np.linspace(1, 0, n)
    depth = np.concatenate([out, down, hold, hold[-1] * back ** (2 / 3)])
    force = np.concatenate([0 * out, load, np.full(n // 3, bead.largest), bead.largest * back])
    force = _noisy(rng, force, 0.003)
    title = str(rng.choice(["SegmentID", "Segment ID", "segment", "Seg", "SegmentType", ""]))
    number = np.repeat([1, 2, 3], [out.size + n, n // 3, n])
    columns = [np.arange(depth.size) * 0.1, (depth - depth[0]) * 1e6, force * 1e6]
    head = "Time (s)\tPd (µm)\tFn (µN)" + (f"\t{title}" if title else "")
    path = folder / "hold.txt"
    _rows(path, head, *columns, *([number] if title else []), sep="\t")
    top = "Indentation\n\n   Acquisition rate :\t10.0 [Hz]\n   Linear loading\n\nMeasured values\n"
    path.write_text(top + path.read_text(encoding="utf-8").replace(head, head + "\n"), encoding="utf-8")
    return Made(path, bead.case(rng), bead.young)


def chiaro(folder: Path, rng: np.random.Generator) -> Made:
    """Header with the constant, columns of load, indentation, cantilever and piezo; another constant is given."""
    bead = Bead.random(rng)
    k, factor = _spring(bead, rng), float(rng.choice([0.5, 1.7, 2.5]))
    piezo, force = _ramp(bead, k, rng)
    piezo, force = np.append(piezo, piezo[::-1]), np.append(force, force[::-1])
    bent = _noisy(rng, force) / k
    head = f"Date\t01/02/2030\nk (N/m)\t{k:.6g}\nTip radius (um)\t{bead.radius * 1e6:.3f}\nModel: Hertz\nComment: \n\n"
    path = folder / "bead_Indentation_001.txt"
    titles = "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary"
    base = piezo - piezo[0]
    columns = [np.arange(base.size) * 1e-3, k * bent * 1e6, (base - bent) * 1e9, bent * 1e9, base * 1e9, 0 * base]
    _rows(path, titles, *columns, sep="\t")
    path.write_text(head + path.read_text(encoding="utf-8"), encoding="utf-8")
    if rng.random() < 0.5:
        with zipfile.ZipFile(folder / "bead.zip", "w") as archive:
            archive.write(path, path.name)
        path = folder / "bead.zip"
    return Made(path, bead.case(rng, f'[curve]\nspring_constant = "{k * factor:.6g} N/m"\n'), bead.young * factor)


def exported(folder: Path, rng: np.random.Generator) -> Made:
    """A .tab or .h5 of afmformats whose spring constant the user replaces."""
    from afmformats.mod_force_distance import AFMForceDistance

    bead = Bead.random(rng)
    k, factor = _spring(bead, rng), float(rng.choice([0.5, 1.7, 2.5]))
    piezo, force = _ramp(bead, k, rng)
    piezo, force = np.append(piezo, piezo[::-1]), _noisy(rng, np.append(force, force[::-1]))
    kind = str(rng.choice(["tab", "hdf5"]))
    path = folder / ("curve.tab" if kind == "tab" else "curve.h5")
    columns = {
        "force": force,
        "height (measured)": piezo[-1] - piezo,
        "segment": np.repeat([0, 1], force.size // 2).astype(np.uint8),
        "time": np.arange(force.size) * 1e-3,
    }
    known = {"imaging mode": "force-distance", "spring constant": k, "sensitivity": 5e-8, "enum": 0, "path": path}
    AFMForceDistance(columns, {**known, "point count": force.size}).export_data(path, fmt=kind)
    # deflections stay and forces grow: the depth is the file's, and so the modulus grows with the force
    return Made(path, bead.case(rng, f'[curve]\nspring_constant = "{k * factor:.6g} N/m"\n'), bead.young * factor)


def breakthrough(folder: Path, rng: np.random.Generator) -> Made:
    """The force drops once by 5 to 15 % of its largest value, at 60 to 97 % of the depth, and rises as before."""
    bead = Bead.random(rng)
    depth = np.linspace(-rng.uniform(0.3, 1) * bead.deepest, bead.deepest, 1500)
    place = rng.uniform(0.6, 0.97) * bead.deepest
    force = bead.force(depth) - np.where(depth > place, rng.uniform(0.05, 0.15) * bead.largest, 0.0)
    path = _rows(folder / "curve.csv", "depth (nm),force (nN)", depth * 1e9, _noisy(rng, force) * 1e9)
    return Made(path, bead.case(rng), bead.young, note="does not describe the force")


def start_backwards(folder: Path, rng: np.random.Generator) -> Made:
    """The stage first goes back by 2 to 10 % of its way."""
    bead = Bead.random(rng)
    way = np.linspace(-0.5 * bead.deepest, bead.deepest, 1500)
    back = np.linspace(way[0] + rng.uniform(0.02, 0.1) * np.ptp(way), way[0], int(rng.integers(20, 200)))
    depth = np.concatenate([back, way, way[::-1][: int(rng.integers(0, 1500))]])
    sign = float(rng.choice([-1, 1]))
    columns = sign * depth * 1e9, _noisy(rng, bead.force(depth)) * 1e9
    return Made(_rows(folder / "curve.csv", "depth (nm),force (nN)", *columns), bead.case(rng), bead.young)


def jpk_text(folder: Path, rng: np.random.Generator) -> Made:
    """JPK's text export: titles and units behind their labels, a block for each segment."""
    bead = Bead.random(rng)
    k = _spring(bead, rng)
    piezo, force = _ramp(bead, k, rng, 900)
    blocks = []
    for i, (name, part) in enumerate((("extend", slice(None)), ("retract", slice(None, None, -1)))):
        read = _noisy(rng, force[part])
        height = 1.2e-5 - piezo[part]
        rows = zip(height + read / k, read, height, height, np.arange(900) * 1e-3, strict=True)
        titles = "verticalTipPosition vDeflection strainGaugeHeight height time"
        head = f"# segmentIndex: {i}\n# segment: {name}\n# columns: {titles}\n"
        head += f'# fancyNames: "Vertical Tip Position" "Vertical Deflection"\n# springConstant: {k:.6g}\n'
        head += "# sensitivity: 5.0E-8\n# units: m N m m s\n#\n"
        blocks.append(head + "\n".join(" ".join(f"{v:.9E}" for v in row) for row in rows))
    path = folder / "curve.txt"
    path.write_text("# jpk-force-version: 2\n#\n" + "\n\n".join(blocks) + "\n")
    return Made(path, bead.case(rng), bead.young)


def nanoscope_text(folder: Path, rng: np.random.Generator) -> Made:
    """NanoScope's text export: extend and retract side by side, units inside the titles, nm or V."""
    bead = Bead.random(rng)
    k, sensitivity = _spring(bead, rng), rng.uniform(20, 120)
    piezo, force = _ramp(bead, k, rng)
    base = (piezo - piezo[0]) * 1e9
    there, back = (_noisy(rng, force) / k * 1e9 for _ in range(2))
    more = f'[curve]\nspring_constant = "{k:.6g} N/m"\n'
    path = folder / "nanoscope.txt"
    if rng.random() < 0.5:
        titles = "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_V_Ex\tDefl_V_Rt"
        _rows(path, titles, base, base, there / sensitivity, back / sensitivity, sep="\t")
        more += f'sensitivity = "{sensitivity:.9g} nm/V"\n'
    else:
        titles = "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_nm_Ex\tDefl_nm_Rt\tDefl_pN_Ex\tDefl_pN_Rt"
        _rows(path, titles, base, base, there, back, k * there * 1e3, k * back * 1e3, sep="\t")
    return Made(path, bead.case(rng, more), bead.young)


def words_below(folder: Path, rng: np.random.Generator) -> Made:
    """Anton Paar's, FemtoTools' or Hysitron's text: words above and below the titles, units in a row of their own."""
    bead = Bead.random(rng)
    depth = np.linspace(-0.5 * bead.deepest, bead.deepest, 1000)
    depth = np.append(depth, depth[::-1])
    force, time = _noisy(rng, bead.force(depth)), np.arange(2000) * 0.01
    kind = int(rng.integers(3))
    path = folder / ("curve" + str(rng.choice([".txt", ".asc", ""])))
    if kind == 0:
        titles, words = "Time\tPd\tFn\tFnRef", "[s]\t[nm]\t[µN]\t[µN]\n"
        _rows(path, titles, time, depth * 1e9, force * 1e6, force * 1e6, sep="\t")
        top = "Indentation\nIndenter: sphere\nApproach speed :\t2000 [nm/min]\n\n"
    elif kind == 1:
        titles, words = "Index;Time;Displacement;Force", "-;s;um;uN\nSweep up and down;;;\n"
        _rows(path, titles, np.arange(2000), time, depth * 1e6, force * 1e6, sep=";")
        top = "FemtoTools Nanoindenter\nSensor;FT-S200\n\n"
    else:
        titles, words = "Depth (nm)\tLoad (µN)\tTime (s)", ""
        _rows(path, titles, depth * 1e9, force * 1e6, time, sep="\t")
        top = "\nTue Jan 01 10:00:00 2030\n\nNumber of Points = 2000\n"
    text = path.read_text(encoding="utf-8").replace(titles + "\n", f"{titles}\n{words}", 1)
    path.write_text(top + text, encoding="latin-1")
    return Made(path, bead.case(rng), bead.young)


def imprint(folder: Path, rng: np.random.Generator) -> Made:
    """A sharp tip on a polymer behind a cantilever: plastic loading, an imprint of 30 to 90 % of the depth."""
    k, deepest, largest = rng.uniform(30, 200), rng.uniform(50e-9, 300e-9), 10 ** rng.uniform(-5.3, -4.3)
    left = rng.uniform(0.3, 0.9)
    up, back = np.linspace(0, 1, 600), np.linspace(1, 0, 600)
    depth = np.concatenate([np.linspace(-2 * deepest, 0, 400), deepest * up, deepest * (left + (1 - left) * back)])
    depth = np.append(depth, np.linspace(left * deepest, -2 * deepest, 500))
    force = np.concatenate([np.zeros(400), largest * up**2, largest * back**1.5, np.zeros(500)])
    force = _noisy(rng, force)
    path = _rows(folder / "curve.csv", "piezo (nm),force (uN)", (depth + force / k) * 1e9, force * 1e6)
    case = CASE.format(start=1e9, poisson=0.3, radius=1e-7).split("[indenter]")[0] + '[indenter]\nkind = "berkovich"\n'
    return Made(path, case + f'[curve]\nspring_constant = "{k:.6g} N/m"\n', words="imprint")


@dataclass(frozen=True)
class Hard:
    """A hard body under a tip with A = 24.5 h_c^2: tests of a load cycle each."""

    young: float
    hardness: float

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Hard":
        return cls(10 ** rng.uniform(10.3, 11.3), 10 ** rng.uniform(8.8, 9.8))

    def cycle(self, h_c: float, rng: np.random.Generator) -> tuple[Any, Any, float]:
        """Depth [m], force [N] and the stiffness of the unloading [N/m]."""
        plane = self.young / (1 - 0.25**2)
        stiffness = 2 * h_c * np.sqrt(24.5 / np.pi) / (1 / plane + 1 / DIAMOND.surface_modulus)
        force = self.hardness * 24.5 * h_c**2
        depth = h_c + 0.75 * force / stiffness
        exponent, up, back = rng.uniform(1.25, 1.6), np.linspace(0, 1, 60), np.linspace(1, 0, 80)
        fall = depth - exponent * force / stiffness * (1 - back)
        h = np.concatenate([depth * up, np.full(20, depth), fall])
        return (
            h,
            _noisy(rng, np.concatenate([force * up**2, np.full(20, force), force * back**exponent]), 5e-4),
            stiffness,
        )

    def tests(self, rng: np.random.Generator, count: int) -> list[tuple[Any, Any, float]]:
        """Tests to growing loads."""
        return [self.cycle(h_c, rng) for h_c in np.geomspace(60e-9, 500e-9, count)]


def _book(path: Path, sheets: dict[str, list[list[Any]]], rng: np.random.Generator) -> Path:
    book = Workbook()
    book.remove(book.active)
    names = list(sheets)
    if rng.random() < 0.5:
        names = [*names[1:], names[0]]
    for name in names:
        sheet = book.create_sheet(name)
        for row in sheets[name]:
            sheet.append(row)
    book.save(path)
    return path


def results_sheet(folder: Path, rng: np.random.Generator) -> Made:
    """A workbook of tests with a sheet that has one row a test, of any length; one test is cut off in half of them."""
    body, count = Hard.random(rng), int(rng.integers(8, 25))
    tests = body.tests(rng, count)
    titles = [
        ["Test", "Pmax", "Maximum Displacement", "Target Load"],
        ["Test #", "Load", "Depth", "E"],
        ["Name", "Load At Max Load", "Displacement At Max Load", "Modulus From Unload"],
    ][int(rng.integers(3))]
    name = str(rng.choice(["Results", "Summary", "Tabelle1", "Sheet1", "Required Inputs"]))
    rows: list[list[Any]] = [titles, [None, "mN", "nm", "mN"]]
    rows += [[i + 1, float(f.max() * 1e3), float(h.max() * 1e9), 1.0] for i, (h, f, _) in enumerate(tests)]
    sheets = {name: rows}
    bad = int(rng.integers(count)) if rng.random() < 0.5 else -1
    for i, (h, f, _) in enumerate(tests):
        end = 40 if i == bad else h.size
        body_rows = [[None, 0.1 * j, float(f[j] * 1e3), float(h[j] * 1e9)] for j in range(end)]
        sheets[f"Test {i + 1}"] = [["Markers", "Time", "Load", "Depth"], [None, "s", "mN", "nm"], *body_rows]
    return Made(_book(folder / "tests.xlsx", sheets, rng), FILM_CASE, body.young, film=True)


def one_stiffness(folder: Path, rng: np.random.Generator) -> Made:
    """A column of stiffness with one value a test, the largest float or nothing elsewhere."""
    body, sheets = Hard.random(rng), {}
    none = [1.79e308, None][int(rng.integers(2))]
    for i, (h, f, s) in enumerate(body.tests(rng, int(rng.integers(6, 12)))):
        at = int(rng.choice([0, int(np.argmax(f)), h.size - 1]))
        rows = [[None, float(h[j] * 1e9), float(f[j] * 1e3), 0.1 * j, s if j == at else none] for j in range(h.size)]
        titles = ["Segment", "Displacement Into Surface", "Load On Sample", "Time On Sample", "Stiffness"]
        sheets[f"Test {i + 1:03d}"] = [titles, [None, "nm", "mN", "s", "N/m"], *rows]
    return Made(_book(folder / "tests.xlsx", sheets, rng), FILM_CASE, body.young, film=True)


def folder_of_tests(folder: Path, rng: np.random.Generator) -> Made:
    """A folder with one test a file, beside a text that is none."""
    body = Hard.random(rng)
    (tests := folder / "tests").mkdir()
    for i, (h, f, _) in enumerate(body.tests(rng, int(rng.integers(5, 10)))):
        path = _rows(
            tests / f"array_{i:04d}.txt",
            "Depth (nm)\tLoad (µN)\tTime (s)",
            h * 1e9,
            f * 1e6,
            0.1 * np.arange(h.size),
            sep="\t",
        )
        head = f"Tue Jan 01 10:00:00 2030\n\nNumber of Points = {h.size}\n"
        path.write_text(head + path.read_text(encoding="utf-8"), encoding="latin-1")
    if rng.random() < 0.5:
        (tests / "notes.txt").write_text("Six tests on glass.\n")
    return Made(tests, FILM_CASE, body.young, film=True)


def odd_unloading(folder: Path, rng: np.random.Generator) -> Made:
    """An unloading with creep and a tail, which no power law with an exponent of 1 to 2 describes."""
    h, f, _ = Hard.random(rng).cycle(rng.uniform(100e-9, 400e-9), rng)
    deepest, largest, back = h.max(), f.max(), np.linspace(1, 0, 200)
    fall = deepest * (1 - rng.uniform(0.25, 0.6) * (1 - back)) + 0.01 * deepest * np.sin(np.pi * back) * (back > 0.7)
    depth = np.append(h[:80], fall)
    force = np.append(f[:80], _noisy(rng, largest * back ** rng.uniform(2.8, 6.0), 3e-4))
    path = _rows(folder / "curve.csv", "depth (nm),force (mN)", depth * 1e9, force * 1e3)
    return Made(path, FILM_CASE, words="exponent", film=True)


FILES: dict[str, Callable[[Path, np.random.Generator], Made]] = {
    each.__name__: each
    for each in (
        load_hold,
        chiaro,
        exported,
        breakthrough,
        start_backwards,
        jpk_text,
        nanoscope_text,
        words_below,
        imprint,
        results_sheet,
        one_stiffness,
        folder_of_tests,
        odd_unloading,
    )
}
