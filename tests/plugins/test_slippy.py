"""The material for slippy: its table on a stand-in of slippy's base class, and contacts and stresses in slippy itself.

slippy needs Python 3.9, so it has an interpreter of its own, named by the environment variable FLATPUNCH_SLIPPY.
"""

import importlib.util
import json
import os
import subprocess
import sys
from types import ModuleType

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import kernels
from flatpunch.plugins.slippy import write_slippy_material

SPACING, CELLS, RADIUS = 7.8e-4, 101, 1.0
LAYER = fp.Medium([fp.Layer(70e9, 0.33, 0.05)], fp.RigidBase())
FILM = fp.Medium([fp.Layer(70e9, 0.33, 0.02)], fp.HalfSpace(200e9, 0.3))
GRADED = fp.Medium(
    [
        fp.GradedLayer(fp.ExponentialModulus(1e9, 3e9, 0.05), 0.3, 0.05),
        fp.TransverselyIsotropicLayer(2e9, 1e9, 0.3, 0.2, 0.5e9, 0.01),
    ],
    fp.HalfSpace(5e9, 0.3),
)
DEPTHS = [0.005, 0.0202, 0.03]


class _Material:
    """What the file uses of slippy's base class."""

    def __init__(self, name, default_fft=True, **options):
        self.name, self.use_frequency = name, default_fft


def _loaded(path, monkeypatch):
    for name in ("slippy", "slippy.core"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["slippy.core"]._IMMaterial = _Material
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.LayeredMaterial


@pytest.mark.long
@pytest.mark.parametrize(
    "medium", [LAYER, FILM, GRADED, fp.HalfSpace(70e9, 0.33)], ids=["layer", "film", "graded", "body"]
)
def test_table_is_the_kernel(tmp_path, monkeypatch, medium):
    depths = [0.005, 0.0202]
    material = _loaded(write_slippy_material(tmp_path / "body.py", medium, depths=depths), monkeypatch)("body")
    # from waves far longer than all layers to far shorter ones
    for spacing in ((1e-5, 1e-5), (2e-3, 1e-3), (30.0, 20.0)):
        shape = (6, 9)
        qy, qx = (2 * np.pi * np.fft.fftfreq(n, h) for n, h in zip(shape, spacing, strict=True))
        names = [load + along for load in "xyz" for along in "xyz"]
        found = material._influence_matrix_frequency(names, spacing, shape)
        wanted = kernels.surface_compliance(medium, qx, qy[:, None], rtol=0)
        sign = (1, 1, -1)
        for name in names:
            j, i = ("xyz".index(axis) for axis in name)
            entry = wanted[..., i, j] * sign[i] * sign[j]
            scale = np.abs(wanted[..., i, i]).max()
            np.testing.assert_allclose(found[name].ravel()[1:], entry.ravel()[1:], rtol=0, atol=1e-6 * scale)
        stress = kernels.interior(medium, *(q.ravel()[1:] for q in np.meshgrid(qx, qy)), depths)[1]
        for j, load in enumerate(("tangential_x", "tangential_y", "normal")):
            own = getattr(material, f"sss_influence_matrices_{load}")(
                ["xx", "yy", "zz", "yz", "xz", "xy"], spacing, shape, depths
            )
            for i, values in enumerate(own.values()):
                np.testing.assert_allclose(values.reshape(2, -1)[:, 1:].T, stress[..., i, j], rtol=0, atol=1e-6)
    with pytest.raises(ValueError, match="z must be depths of this file"):
        material.sss_influence_matrices_normal(["zz"], (1e-3, 1e-3), (8, 8), [0.01])


def test_mean_displacement_on_a_rigid_base(tmp_path, monkeypatch):
    """There it is that of a uniform traction."""
    material = _loaded(write_slippy_material(tmp_path / "body.py", LAYER), monkeypatch)("body")
    found = material._influence_matrix_frequency(["xx", "zz"], (1e-3, 1e-3), (8, 8))
    wanted = kernels.surface_compliance(LAYER, np.zeros(1), np.zeros(1))[0].real
    assert [found[name][0, 0].real for name in ("xx", "zz")] == pytest.approx([wanted[0, 0], wanted[2, 2]], rel=1e-5)


def test_cells_are_the_influence_coefficients(tmp_path, monkeypatch):
    path = write_slippy_material(tmp_path / "body.py", FILM, spacing=SPACING, cells=8)
    material = _loaded(path, monkeypatch)("body")
    assert not material.use_frequency
    found = material._influence_matrix_spatial(["zz"], (SPACING, SPACING), (16, 16))["zz"]
    wanted = kernels.influence_coefficients(FILM, SPACING, (9, 9))
    np.testing.assert_allclose(found[7:, 7:], wanted, rtol=1e-12)
    for spacing, span in ((2 * SPACING, 16), (SPACING, 40)):
        with pytest.raises(ValueError, match="the file is for 8 cells"):
            material._influence_matrix_spatial(["zz"], (spacing, spacing), (span, span))


_IN_SLIPPY = """
import json, sys
import numpy as np
import slippy
slippy.CORES = 1
import slippy.contact as c
import slippy.surface as s
sys.path.insert(0, sys.argv[1])
n, spacing, radius, depths, presses = json.loads(sys.argv[2])
found = {}
for name, press in presses.items():
    material = __import__(name).LayeredMaterial(name)
    tip = s.RoundSurface((radius,) * 3, extent=(n * spacing,) * 2, shape=(n, n), generate=True)
    flat = s.FlatSurface(shift=(0, 0))
    tip.material, flat.material = material, c.rigid
    model = c.ContactModel(name, tip, flat)
    step = c.StaticStep("contact", interference=press)
    model.add_step(step)
    step.add_sub_model(c.sub_models.SubsurfaceStress(z=np.array(depths), surface=1, stress_components=("vm",)))
    state = model.solve()
    mises = state["surface_1_vm"][:, n // 2, n // 2]
    found[name] = [float(state["loads_z"].sum() * tip.grid_spacing**2), mises.tolist()]
print("RESULT" + json.dumps(found))
"""


def test_contacts_and_stresses_in_slippy(tmp_path):
    """Force to 1e-3; von Mises stress below the centre to 3 %: to slippy the surface repeats after twice its size there."""
    python = os.environ.get("FLATPUNCH_SLIPPY")
    if not python:
        pytest.skip("FLATPUNCH_SLIPPY names no interpreter with slippy")
    media = {"layer": LAYER, "film": FILM}
    presses, wanted = {}, {}
    for name, medium in media.items():
        write_slippy_material(tmp_path / f"{name}.py", medium, depths=DEPTHS, spacing=SPACING, cells=CELLS)
        curve = fp.indent(medium, fp.Sphere(RADIUS), force=[1e6])
        presses[name] = float(curve.depth[0])
        inside = fp.fields(medium, fp.Sphere(RADIUS), 0.0, 0.0, DEPTHS, force=1e6)
        wanted[name] = np.asarray(inside.von_mises)
    given = json.dumps([CELLS, SPACING, RADIUS, DEPTHS, presses])
    ran = subprocess.run(
        [python, "-c", _IN_SLIPPY, str(tmp_path), given], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "RESULT" in ran.stdout, ran.stderr
    for name, (force, mises) in json.loads(ran.stdout.rpartition("RESULT")[2]).items():
        assert force == pytest.approx(1e6, rel=1e-3), name
        np.testing.assert_allclose(mises, wanted[name], rtol=3e-2, err_msg=name)
