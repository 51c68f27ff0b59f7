"""Speed target of the page: sliders answer ten times a second for round tips and series.

Measured is what a worker process does for one answer, each time with a value that it has not seen.
"""

import itertools
import tomllib

import pytest

from flatpunch.app.form import form_of
from flatpunch.app.jobs.formulas import correct_modulus
from flatpunch.app.jobs.press import press, warm_up
from flatpunch.files import shipped_cases

GEL = {
    "layers.0.young": "5 kPa",
    "layers.0.poisson": "0.5",
    "layers.0.thickness": "1.2 um",
    "base.kind": "half-space",
    "base.young": "70 GPa",
    "base.poisson": "0.22",
    "control.quantity": "depth",
    "control.start": "10 nm",
    "control.stop": "300 nm",
    "control.points": "60",
    "correct.depth": "300 nm",
    "correct.reported": "8 kPa",
}
BEAD = {**GEL, "indenter.kind": "sphere", "indenter.radius": "5 um"}
PYRAMID = {
    **GEL,
    "indenter.kind": "pyramid",
    "indenter.sides": "4",
    "indenter.half_opening_angle": "35 deg",
    "method": "fourth-order",
}
FILM = form_of(
    tomllib.loads(
        next(path for path in shipped_cases() if path.stem == "elliptic_tip_on_carbon_film").read_text(encoding="utf-8")
    )
)


@pytest.mark.parametrize(
    ("job", "form", "field", "unit"),
    [
        (press, BEAD, "indenter.radius", "um"),
        (press, BEAD, "layers.0.thickness", "um"),
        (press, BEAD, "layers.0.young", "kPa"),
        (press, PYRAMID, "layers.0.thickness", "um"),
        (press, FILM, "layers.0.young", "GPa"),
        (correct_modulus, BEAD, "correct.reported", "kPa"),
    ],
    ids=["bead-radius", "bead-thickness", "bead-modulus", "pyramid-thickness", "film-modulus", "correct"],
)
def test_answers_of_a_slider(benchmark, job, form, field, unit):
    warm_up()
    start = float(form[field].split()[0])
    values = itertools.count()

    def answer():
        found = job({**form, field: f"{start * (1 + 0.01 * next(values)):.4g} {unit}"}, False)
        assert "problems" not in found

    answer()
    benchmark.pedantic(answer, rounds=10)
    if benchmark.enabled:
        seconds = benchmark.stats.stats.median
        assert seconds < 0.1, f"{1e3 * seconds:.0f} ms for an answer, the target is 100 ms"
