"""docs/developer.md, Add an indenter: its two steps, followed in a copy of the source."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/developer.md").read_text(encoding="utf-8")

USES = """
import matplotlib
import numpy as np
import scipy

import flatpunch as fp
from flatpunch.app.jobs.common import case_of
from flatpunch.app.tables import page_tables
from flatpunch.files.descriptions import words

tip = fp.indenters.Ogive(radius=20e-6, inclination=0.3)
half = fp.HalfSpace(young=1e9, poisson=0.3)

# depth and force of a round contact on a half-space by their integrals over the slope
a = 2e-6
curve = fp.indent(half, tip, radius=a)
slope = lambda t: float(tip.slope(np.array(a * np.sin(t)), 0.0))
depth = a * scipy.integrate.quad(slope, 0, np.pi / 2, epsabs=0, epsrel=1e-13)[0]
moment = scipy.integrate.quad(lambda t: slope(t) * np.sin(t) ** 2, 0, np.pi / 2, epsabs=0, epsrel=1e-13)[0]
force = 2 * 1e9 / (1 - 0.3**2) * a**2 * moment
# quadrature of twelve digits
np.testing.assert_allclose([curve.depth[0], curve.force[0]], [depth, force], rtol=1e-11)

case = fp.read_case("case.toml")
assert repr(case.indenter) == repr(fp.indenters.Ogive(20e-6, np.radians(20)))
assert "radius 20 \u00b5m, inclination 20 deg" in words(case.indenter)
try:
    fp.read_case("wrong.toml")
except fp.files.CaseError as error:
    assert "indenter.radius = '-20 um' must be finite and > 0." in str(error), error
else:
    raise AssertionError("a negative radius was taken")

found = fp.sensitivity(half, tip, depth=1e-7)
names = [str(name) for name in found.parameter.values]
assert names[-2:] == ["indenter.radius", "indenter.inclination"], names

wanted = fp.Target("force", float(fp.indent(half, tip, depth=1e-7).force[0]), depth=1e-7)
other = fp.indenters.Ogive(20e-6, 0.35)
solved = fp.design(half, other, vary={"indenter.inclination": (0.1, 0.6)}, objective=wanted)
# the tolerance of the search
np.testing.assert_allclose(solved.indenter.inclination, 0.3, rtol=1e-4)

z = np.linspace(-1e-7, 2e-7, 120)
load = np.zeros(120)
load[z > 0] = fp.indent(half, tip, depth=z[z > 0]).force
load += 2e-3 * load.max() * np.random.default_rng(0).normal(size=120)
fitted = fp.fit(fp.Curve(z, load), half, other, ["indenter.inclination"], contact=0.0, baseline="constant")
assert fitted.estimates["indenter.inclination"].low <= 0.3 <= fitted.estimates["indenter.inclination"].high, fitted

study = fp.sweep("case.toml", {"indenter.radius": "10um, 20um"})
assert study.sizes["indenter.radius"] == 2, study

fields = {field["name"]: field for field in page_tables()["indenter"]["ogive"]["fields"]}
assert fields["radius"]["label"] == "Radius of the arc"
form = {"base.kind": "half-space", "base.young": "1 GPa", "base.poisson": "0.3", "indenter.kind": "ogive"}
form |= {"control.quantity": "depth", "control.start": "10 nm", "control.stop": "30 nm", "control.points": "2"}
form |= {f"indenter.{name}": field["value"] for name, field in fields.items()}
assert case_of(form).indenter.radius == 20e-6

matplotlib.use("agg")
fp.plot_tip(tip)
print("all of it")
"""

CASE = """
base = {{ kind = "half-space", young = "1 GPa", poisson = 0.3 }}
indenter = {{ kind = "ogive", radius = "{}", inclination = "20 deg" }}
control = {{ depth = "50 nm" }}
"""


@pytest.mark.long
def test_a_tip_of_its_own_file_is_known_everywhere(tmp_path):
    part = PAGE.split("## Add an indenter")[1].split("\n## ")[0]
    (file,), (line,) = (re.findall(f"```{kind}\n(.*?)```", part, re.DOTALL) for kind in ("python", "text"))
    source = tmp_path / "source"
    shutil.copytree(ROOT / "src/flatpunch", source / "flatpunch", ignore=shutil.ignore_patterns("__pycache__"))
    (source / "flatpunch/indenters/shapes/ogive.py").write_text(file, encoding="utf-8")
    with (source / "flatpunch/indenters/__init__.pyi").open("a", encoding="utf-8") as stub:
        stub.write(line)
    (tmp_path / "case.toml").write_text(CASE.format("20 um"), encoding="utf-8")
    (tmp_path / "wrong.toml").write_text(CASE.format("-20 um"), encoding="utf-8")
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(source)!r})\n{USES}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout == "all of it\n", done.stderr
