"""docs/developer.md, Add a kind of layer or base: its two steps, followed in a copy of the source."""

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

import flatpunch as fp
from flatpunch.app.jobs.common import case_of
from flatpunch.app.tables import page_tables
from flatpunch.media.paths import numbers

tip = fp.Sphere(10e-6)
gel = fp.Medium([fp.media.RubberLayer(shear=1.7e3, thickness=2e-6)], fp.RigidBase())
same = fp.Medium([fp.Layer(5.1e3, 0.5, 2e-6)], fp.RigidBase())
contact, known = (fp.indent(body, tip, depth=2e-7) for body in (gel, same))
# rounding
np.testing.assert_allclose(contact.force, known.force, rtol=1e-13)

assert fp.read_case("case.toml").medium == gel
try:
    fp.read_case("wrong.toml")
except fp.files.CaseError as error:
    assert "layers[0].shear = '-1.7 kPa' must be finite and > 0." in str(error), error
else:
    raise AssertionError("a negative modulus was taken")
assert "shear 1.7 kPa" in "\\n".join(fp.files.describe(fp.read_case("case.toml")))

found = numbers(gel, tip)
assert [each.path for each in found] == ["layers[0].shear", "layers[0].thickness", "indenter.radius"]
assert (found[0].number.what, found[0].number.unit) == ("shear modulus", "Pa")
slopes, theirs = (fp.sensitivity(body, tip, depth=2e-7).force for body in (gel, same))
by_shear, by_young = slopes.sel(parameter="layers[0].shear"), theirs.sel(parameter="layers[0].young")
np.testing.assert_allclose(by_shear, by_young, rtol=1e-11)

wanted = fp.Target("force", float(contact.force[0]), depth=2e-7)
other = fp.Medium([fp.media.RubberLayer(3e3, 2e-6)], fp.RigidBase())
solved = fp.design(other, tip, vary={"layers[0].shear": (1e3, 1e4)}, objective=wanted)
# the tolerance of the search
np.testing.assert_allclose(solved.medium.layers[0].shear, 1.7e3, rtol=1e-4)

study = fp.sweep("case.toml", {"layers.0.shear": "1 kPa, 2 kPa"})
assert study.sizes["layers.0.shear"] == 2, study

fields = {field["name"]: field for field in page_tables()["layers"]["rubber"]["fields"]}
assert fields["shear"]["label"] == "Shear modulus"
form = {"base.kind": "rigid", "layers.0.kind": "rubber", "indenter.kind": "sphere", "indenter.radius": "10 um"}
form |= {f"layers.0.{name}": field["value"] for name, field in fields.items() if field["value"]}
form |= {"control.quantity": "depth", "control.values": "100 nm"}
assert case_of(form).medium.layers[0].shear == 1e3

matplotlib.use("agg")
fp.plot_medium(gel)
print("all of it")
"""

CASE = """
layers = [{{ kind = "rubber", shear = "{}", thickness = "2 um" }}]
base = {{ kind = "rigid" }}
indenter = {{ kind = "sphere", radius = "10 um" }}
control = {{ depth = "200 nm" }}
"""


@pytest.mark.long
def test_a_layer_of_its_own_file_is_known_everywhere(tmp_path):
    part = PAGE.split("## Add a kind of layer or base")[1].split("\n## ")[0]
    file, line = (re.findall(f"```{kind}\n(.*?)```", part, re.DOTALL)[0] for kind in ("python", "text"))
    source = tmp_path / "source"
    shutil.copytree(ROOT / "src/flatpunch", source / "flatpunch", ignore=shutil.ignore_patterns("__pycache__"))
    (source / "flatpunch/media/rubber.py").write_text(file, encoding="utf-8")
    with (source / "flatpunch/media/__init__.py").open("a", encoding="utf-8") as room:
        room.write(line)
    (tmp_path / "case.toml").write_text(CASE.format("1.7 kPa"), encoding="utf-8")
    (tmp_path / "wrong.toml").write_text(CASE.format("-1.7 kPa"), encoding="utf-8")
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(source)!r})\n{USES}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout == "all of it\n", done.stderr
