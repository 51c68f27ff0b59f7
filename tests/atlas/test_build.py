"""Builds: error as promised, interrupted and resumed, on a cluster that loses a worker, families from files."""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest

import atlas_tables
import flatpunch as fp
from atlas_tables import Parameter
from atlas_tables.family_file import family_from, read_family
from atlas_tables.solving import panel_edges
from flatpunch import atlas
from flatpunch.files.tables.fields import CaseError
from support.atlas_families import FAMILY_FILE, SMALL, soft_on_stiffer
from support.platforms import SIGNALS


@pytest.fixture(scope="module")
def small():
    return atlas_tables.build(SMALL, workers=1)


def test_meets_its_tolerance(small):
    found = atlas_tables.verify(small, SMALL, points=60, workers=1)
    # what is dropped and left out adds up to a few times the tolerance
    assert max(found.largest[q] for q in ("Kbar", "kappa_1", "kappa_2")) < 5 * SMALL.tolerance
    told = atlas_tables.verified(small, found)
    assert told.bound == found.bound >= 2 * found.largest["Kbar"]
    assert told.attributes["verified_points"] == 60
    assert small.beta_range == (panel_edges(0.5, 2.0)[0][0], panel_edges(0.5, 2.0)[-1][1])


@pytest.mark.long
def test_tighter_tolerance_refines_the_grid(small):
    finer = atlas_tables.build(replace(SMALL, tolerance=1e-9), workers=1)
    assert finer.attributes["grid"][0] > small.attributes["grid"][0]
    found = atlas_tables.verify(finer, SMALL, points=20, workers=1)
    assert found.largest["Kbar"] < 5e-9


def test_interrupted_and_resumed(small, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        atlas_tables.build(SMALL, workers=1, store=tmp_path, progress=stop)
    kept = len(list(tmp_path.glob("*.npz")))
    assert kept >= 2
    begun = []
    again = atlas_tables.build(SMALL, workers=1, store=tmp_path, progress=lambda done, total: begun.append(done))
    assert begun[0] == kept
    beta = np.geomspace(0.5, 2.0, 9)
    for ratio in (0.3, 1.1, 2.9):
        same = small.at(ratio=ratio).normalized_stiffness(beta)
        np.testing.assert_array_equal(again.at(ratio=ratio).normalized_stiffness(beta), same)


@pytest.mark.long
@SIGNALS
def test_on_a_cluster_that_loses_a_worker(small, tmp_path):
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    with (
        dask.config.set({"logging.distributed": "critical"}),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster,
        distributed.Client(cluster.scheduler_address, set_as_default=False) as client,
    ):
        workers = list(client.run(os.getpid).values())

        def lose_one(done, total):
            if done == 2 and workers:
                os.kill(workers.pop(), signal.SIGKILL)

        found = atlas_tables.build(SMALL, scheduler=cluster.scheduler_address, store=tmp_path, progress=lose_one)
    assert len(workers) == 1  # one was lost
    beta = np.geomspace(0.5, 2.0, 9)
    # another process, another order of sums in BLAS
    expected = small.at(ratio=0.7).normalized_stiffness(beta)
    np.testing.assert_allclose(found.at(ratio=0.7).normalized_stiffness(beta), expected, rtol=1e-12)


def test_media_that_cannot_be_solved_are_named():
    far = replace(SMALL, beta=(0.5, 1e8))
    with pytest.raises(RuntimeError, match=r"of 'small' could not be solved; the first, ratio = 0\.3: "):
        atlas_tables.build(far, workers=1)


@pytest.mark.long
def test_a_family_that_is_not_smooth_enough_says_so():
    jump = replace(SMALL, parameters=(Parameter("ratio", "", 1e-9, 1e9, "linear"),), tolerance=1e-12)
    with pytest.raises(RuntimeError, match=r"over ratio still end at .* Narrow the range, choose another scale"):
        atlas_tables.build(jump, workers=1)


def test_a_medium_of_ones_own_table(small):
    medium = soft_on_stiffer(2.0)
    mine = atlas.tabulated(medium, table=small, ratio=2.0)
    tip = fp.Sphere(radius=3.0)
    depth = 0.1
    found, direct = (float(fp.indent(m, tip, depth=depth).force[0]) for m in (mine, medium))
    assert found == pytest.approx(direct, rel=1e-5)
    with pytest.raises(ValueError, match=r"belongs to another medium: at beta = 1"):
        atlas.tabulated(medium, table=small, ratio=1.0)


def test_family_from_a_file(tmp_path):
    path = tmp_path / "gel.toml"
    path.write_text(FAMILY_FILE, encoding="utf-8")
    family, text = read_family(path)
    assert text == FAMILY_FILE
    (gel,) = family.parameters
    assert (gel.name, gel.low, gel.high, gel.scale, gel.unit) == ("gel", 1e4, 1e6, "log", "Pa")
    medium = family.make(gel=5e4)
    assert medium == fp.Medium([fp.Layer(5e4, 0.5, 1e-6)], base=fp.HalfSpace(1e6, 0.5))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("layers.0.young", "layers.0.yung"),
            "path = 'layers.0.yung' is no value of the medium. It has layers.0.young",
        ),
        (('min = "10 kPa"', 'min = "10 nm"'), r"parameters.gel: min = '10 nm'"),
        (('min = "10 kPa"', "min = 10.0"), r"parameters.gel: min = 10\.0"),
        (('"10 kPa"', '"2 MPa"'), "must be finite and ascending"),
        (('scale = "log"', 'scale = "cubic"'), "parameters.gel.scale"),
        (('scale = "log"', 'skale = "log"'), "did you mean 'scale'"),
        (('name = "gel-on-pdms"', 'name = "gel/pdms"'), "becomes a file name"),
        (("tolerance = 1e-6", "tolerance = 1.0"), "between 1e-13 and 1e-3"),
        (("min = 0.5", "min = 5"), "ascending and above zero"),
    ],
)
def test_family_files_that_are_refused(change, message, tmp_path):
    assert change[0] in FAMILY_FILE
    with pytest.raises(CaseError, match=message):
        family_from(FAMILY_FILE.replace(*change), tmp_path / "gel.toml")
