"""What a result says is to be cited for it: what it used and nothing else, the same as text, BibTeX and in the paper."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.fits import Tip, fit_film
from flatpunch.literature import bibliography

ROOT = Path(__file__).resolve().parents[2]
GEL = fp.Medium([fp.Layer(5e3, 0.5, 1e-6)], fp.RigidBase())
BEAD, SPRING = fp.Sphere(5e-6), fp.StandardLinearSolid(0.5, 1.0)
UP, DOWN = [1e-8, 1e-7], [1e-8, 1e-7, 5e-8]
ALWAYS = {"flatpunch", "forsbach2023"}


def relaxing(depth):
    return fp.indent(GEL, BEAD, depth=depth, time=range(len(depth)), relaxation=SPRING)


def curve(name="one"):
    depth = np.linspace(-1e-7, 2e-7, 200)
    force = np.zeros(200)
    force[depth > 0] = fp.indent(GEL, BEAD, depth=depth[depth > 0]).force
    return fp.Curve(depth, force + 1e-12 * np.random.default_rng(0).normal(size=200), name=name)


def rough():
    surface = fp.self_affine(32, 10e-9, rms_slope=0.1, cut_off=80e-9)
    return fp.rough_contact(GEL, surface, pressure=1e3, fields=True), GEL, surface


def film():
    tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(1e15, 0.0))
    contact = fp.indent(
        COATING, fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5))), depth=np.linspace(50e-9, 500e-9, 20)
    )
    test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    return fit_film(test, COATING, tip)


COATING = fp.Medium([fp.Layer(20e9, 0.25, 1e-6)], base=fp.HalfSpace(130e9, 0.28))
DEEP = fp.Medium([fp.Layer(5e3, 0.5, 5e-6)], fp.RigidBase())
THIN = {"dimitriadis2002", "garcia2018", "chadwick2002"}
COATED = {"gao1992", "perriot2004", "bec2006"}
CASES = {
    "round": (lambda: fp.indent(GEL, BEAD, depth=1e-7), set()),
    "first order": (lambda: fp.indent(GEL, fp.Pyramid(4, 0.3), depth=1e-7, method="first-order"), set()),
    "bem": (
        lambda: fp.indent(GEL, fp.Pyramid(4, 0.3), depth=1e-7, method=fp.BoundaryElements(grid=64)),
        {"polonsky1999"},
    ),
    "adhesion": (lambda: fp.indent(GEL, BEAD, depth=1e-7, work_of_adhesion=1e-4), {"johnson1971"}),
    "finite range": (
        lambda: fp.indent(GEL, BEAD, depth=1e-7, work_of_adhesion=1e-4, range_of_action=1e-9),
        {"johnson1971", "maugis1992"},
    ),
    "loop": (lambda: fp.adhesion_loop(GEL, BEAD, depth=1e-7, work_of_adhesion=1e-4), {"johnson1971"}),
    "growing": (lambda: relaxing(UP), {"lee1960"}),
    "shrinking": (lambda: relaxing(DOWN), {"lee1960", "ting1966"}),
    "graded": (
        lambda: fp.indent(fp.PowerLawHalfSpace(1e5, 0.4, 1e-6, 0.3), BEAD, depth=1e-7),
        {"giannakopoulos1997"},
    ),
    "wood": (
        lambda: fp.indent(fp.TransverselyIsotropicHalfSpace(1e9, 5e9, 0.3, 0.1, 5e8), BEAD, depth=1e-9),
        {"delafargue2004"},
    ),
    "fields": (lambda: fp.fields(GEL, BEAD, x=[0.0], y=0.0, z=[1e-7], depth=1e-7), {"eason1955"}),
    "patch": (
        lambda: fp.fields(GEL, [fp.PatchLoad(np.full((2, 2), 1e3), 1e-6)], x=[0.0], y=0.0, z=[1e-7]),
        {"love1929"},
    ),
    "slip": (
        lambda: fp.partial_slip(GEL, BEAD, friction=0.3, depth=1e-7, tangential_force=0.0),
        {"mindlin1949", "ciavarella1998"},
    ),
    "sensitivity": (lambda: fp.sensitivity(GEL, BEAD, depth=1e-7), {"barber1974"}),
    "rough": (lambda: rough()[0], {"polonsky1999", "yastrebov2017"}),
    "stresses under it": (lambda: fp.rough_stresses(GEL, rough()[0], [1e-8]), {"polonsky1999"}),
    "theories": (lambda: fp.rough_theories(*rough()), {"persson2001", "greenwood1966"}),
    "film": (film, {"oliver1992", "king1987", "saha2002", *COATED}),
    "correction": (lambda: fp.correct(3e3, DEEP, BEAD, depth=1e-6), {"long2011", *THIN}),
    "formulas on a gel": (lambda: fp.compare_formulas(GEL, BEAD, depth=1e-6), THIN),
    "formulas on a coating": (lambda: fp.compare_formulas(COATING, BEAD, depth=1e-8), {"clifford2009", *THIN, *COATED}),
    "fit": (lambda: fp.fit(curve(), GEL, BEAD, ["layers[0].young"]), {"transtrum2012"}),
    "posterior": (
        lambda: fp.fit(curve(), GEL, BEAD, ["layers[0].young"]).posterior(draws=200),
        {"foremanmackey2013", "goodman2010", "terbraak2006"},
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_a_result_names_what_it_used(name):
    made, wanted = CASES[name]
    found = fp.cite(made())
    assert {each.key for each in found.entries} == ALWAYS | wanted
    assert all(each.reason for each in found.entries)
    assert fp.__version__ in found.bibtex


def test_fits_of_relaxing_and_joint_samples():
    depth = np.concatenate([np.linspace(-1e-7, 2e-7, 150), np.full(50, 2e-7)])
    time, force = np.arange(200) * 0.01, np.zeros(200)
    touching = depth > 0
    force[touching] = fp.indent(GEL, BEAD, depth=depth[touching], time=time[touching], relaxation=SPRING).force
    noise = 1e-12 * np.random.default_rng(0).normal(size=200)
    measured = fp.Curve(depth, force + noise, time=time)
    found = fp.fit(measured, GEL, BEAD, ["layers[0].young"], relaxation=SPRING)
    assert {each.key for each in fp.cite(found).entries} == ALWAYS | {"lee1960", "ting1966", "transtrum2012"}
    joint = fp.fit_together([curve(), curve("two")], GEL, BEAD, ["layers[0].young"])
    assert {each.key for each in fp.cite(joint).entries} == ALWAYS | {"transtrum2012"}


def test_the_command_prints_and_writes_the_same(tmp_path):
    from flatpunch.cli.app import app

    result = fp.indent(GEL, BEAD, depth=1e-7, work_of_adhesion=1e-4)
    for ending in (".nc", ".csv"):
        fp.save(result, tmp_path / f"gel{ending}")
        done = CliRunner().invoke(app, ["cite", str(tmp_path / f"gel{ending}"), "-o", str(tmp_path / "gel.bib")])
        assert done.exit_code == 0, done.output
        assert "Surface energy and the contact of elastic solids" in " ".join(done.output.split())
        assert (tmp_path / "gel.bib").read_text(encoding="utf-8") == fp.cite(result).bibtex


def test_what_is_no_result_is_refused():
    for wrong in (None, 3, "gel.nc", GEL, fp.indent(GEL, BEAD, depth=1e-7).drop_attrs()):
        with pytest.raises(TypeError, match="must be a result of this package"):
            fp.cite(wrong)


def test_every_reference_is_complete_and_used():
    """An article has all that finds it; each is chosen by some result."""
    for key, each in bibliography().items():
        assert {"authors", "title", "year", "kind"} <= set(each.entry), key
        if each.entry["kind"] == "article":
            assert {"journal", "volume", "pages"} <= set(each.entry), key
        assert key == "flatpunch" or str(each.entry["year"]) in key
    assert set(bibliography()) == ALWAYS.union(*(wanted for _, wanted in CASES.values()))


def test_the_versions_of_a_release_agree():
    """Package, CITATION.cff, Zenodo and conda; the recipe has the dependencies of pyproject.toml."""
    recipe = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    zenodo = (ROOT / ".zenodo.json").read_text(encoding="utf-8")
    assert f'version: "{fp.__version__}"' in recipe
    assert f"\nversion: {fp.__version__}\n" in citation
    assert f'"version": "{fp.__version__}"' in zenodo
    date = re.search(r"date-released: (\S+)", citation)[1]
    assert f'"publication_date": "{date}"' in zenodo
    assert f"## [{fp.__version__}] - {date}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = {"matplotlib": "matplotlib-base"}
    wanted = [f"    - {named.get(n, n)} >={v}" for n, v in (d.split(">=") for d in project["dependencies"])]
    run = recipe[recipe.index("  run:\n") : recipe.index("\ntests:")].splitlines()[2:]
    assert [line for line in run if line] == wanted


def test_the_paper_cites_what_exists():
    """Each key of its text is an entry; entries of the package's bibliography are the same there."""
    folder = ROOT / "packaging" / "joss"
    text, entries = ((folder / f"paper.{kind}").read_text(encoding="utf-8") for kind in ("md", "bib"))
    keys = set(re.findall(r"^@\w+{(\w+),", entries, re.MULTILINE))
    assert set(re.findall(r"@(\w+)", text)) == keys
    assert all(each.bibtex in entries for key, each in bibliography().items() if key in keys)
