"""The page as people use it: a headless Chromium, from the first look to the file that is saved.

Skipped where no browser is found, or Playwright is not installed. FLATPUNCH_SCREENSHOTS names a folder for the pictures of the
documentation, which the tests then take.
"""

import json
import os
import shutil
import threading
import tomllib
from pathlib import Path

import pytest

from flatpunch.app.limits import LIMITS
from flatpunch.app.page import Page
from flatpunch.app.server import AppServer
from flatpunch.files import shipped_cases

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next(filter(None, map(shutil.which, BROWSERS)), None)
SCREENSHOTS = os.environ.get("FLATPUNCH_SCREENSHOTS")
FILM = next(path for path in shipped_cases() if path.stem == "elliptic_tip_on_carbon_film")
SECONDS = 180_000  # that a result may take on a busy machine [ms]
if BROWSER is None:
    pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} was found", allow_module_level=True)
api = pytest.importorskip("playwright.sync_api", reason="needs Playwright: pip install playwright")


@pytest.fixture(scope="module")
def address():
    """A page that is served, with one process ready, as `serve` does."""
    page = Page()
    page.workers.submit("press:warm_up").wait(LIMITS.silent)
    with AppServer(page, port=0) as server:
        thread = threading.Thread(target=lambda: server.serve_forever(poll_interval=0.05))
        thread.start()
        yield server.address
        server.shutdown()
        thread.join()
    page.workers.close()


@pytest.fixture(scope="module")
def browser():
    with api.sync_playwright() as driver:
        # root may not use the sandbox
        options = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
        found = driver.chromium.launch(executable_path=BROWSER, args=options)
        yield found
        found.close()


@pytest.fixture
def visit(browser, address):
    """Open the page in a window of its own; requests to anywhere else, and errors of its scripts, fail the test."""
    contexts, wrong = [], []

    def opened(query="", width=1200, scheme="light"):
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, accept_downloads=True
        )
        contexts.append(context)
        window = context.new_page()
        window.set_default_timeout(SECONDS)
        window.on("pageerror", lambda error: wrong.append(str(error)))
        window.on(
            "console", lambda line: wrong.append(line.text) if line.type == "error" and "400" not in line.text else None
        )
        window.on(
            "request",
            lambda request: None if request.url.startswith((address, "blob:", "data:")) else wrong.append(request.url),
        )
        window.goto(address + query)
        window.wait_for_selector("body[data-ready]")
        return window

    yield opened
    for context in contexts:
        context.close()
    assert wrong == []


def solved(window):
    """Wait until what is shown belongs to the form."""
    window.wait_for_selector("#shown .grid")
    window.wait_for_function("() => !document.querySelector('#shown').classList.contains('stale')")
    return window


def example(window, label):
    """Load a shipped example, by the beginning of its title, and wait for its result."""
    titles = window.locator("#example option").all_inner_texts()
    window.evaluate("document.querySelector('#shown').replaceChildren()")
    window.select_option("#example", label=next(title for title in titles if title.startswith(label)))
    return solved(window)


def downloaded(window, kind):
    """Save a file of the tab; return its content."""
    with window.expect_download() as saved:
        window.click(f"[data-save='{kind}']")
    return Path(saved.value.path()).read_bytes()


def photo(window, name):
    """Take a picture for the documentation, as tall as its results."""
    if SCREENSHOTS:
        window.wait_for_selector("#status", state="hidden")
        window.evaluate("scrollTo(0, 0)")
        bottom = window.evaluate("document.querySelector('#results').getBoundingClientRect().bottom")
        window.set_viewport_size({"width": 1200, "height": round(bottom) + 10})
        # pictures follow their cards
        window.wait_for_timeout(500)
        window.screenshot(path=Path(SCREENSHOTS) / f"app_{name}.png")
        window.set_viewport_size({"width": 1200, "height": 900})


def test_example_to_download(visit, tmp_path):
    window = visit()
    window.select_option("#example", label=tomllib.loads(FILM.read_text(encoding="utf-8"))["title"])
    solved(window)
    assert window.input_value("[name='layers.0.young']") == "259 GPa"
    window.wait_for_selector("text=10 of 40 steps, method fourth-order")
    for kind in ("toml", "csv", "nc", "svg", "py"):
        with window.expect_download() as saved:
            window.click(f"[data-save='{kind}']")
        assert saved.value.suggested_filename == f"elliptic_tip_on_a_hard_carbon_film_on_steel.{kind}"
        saved.value.save_as(tmp_path / f"a.{kind}")
    assert tomllib.loads((tmp_path / "a.toml").read_text(encoding="utf-8")) == tomllib.loads(
        FILM.read_text(encoding="utf-8")
    )
    # the address is the state: another window shows the same
    other = solved(visit("?" + window.url.partition("?")[2]))
    assert other.inner_text("#shown table") == window.inner_text("#shown table")
    photo(window, "press")


def test_problems_stand_beside_their_field_while_typing(visit):
    window = solved(visit())
    young = window.locator("[name='layers.0.young']")
    young.fill("5 kN")
    window.wait_for_selector("[data-name='layers.0.young'] .error:has-text('dimension of a force')")
    assert young.get_attribute("aria-invalid") == "true"
    assert "stale" in window.get_attribute("#shown", "class")
    photo(window, "problem")
    young.fill("6 kPa")
    window.wait_for_function("() => !document.querySelector('[aria-invalid]')")
    solved(window)


def test_layers_are_moved_by_mouse_and_keyboard(visit):
    window = solved(visit())
    window.click("#add-layer")
    window.fill("[name='layers.1.young']", "80 kPa")
    window.fill("[name='layers.1.thickness']", "3 um")
    order = "[...document.querySelectorAll('#layers [name$=young]')].map((input) => input.value).join()"
    window.focus("#layers .layer:nth-child(2) [aria-label='Move up']")
    window.keyboard.press("Enter")
    assert window.evaluate(order) == "80 kPa,5 kPa"
    # below the middle of the other layer, whatever its fields
    below = window.locator("#layers .layer:nth-child(2)").bounding_box()["height"] - 10
    window.drag_and_drop(
        "#layers .layer:nth-child(1) .handle", "#layers .layer:nth-child(2)", target_position={"x": 100, "y": below}
    )
    assert window.evaluate(order) == "5 kPa,80 kPa"
    window.wait_for_function("() => document.querySelector('#shown').textContent.includes('E = 80 kPa')")
    window.wait_for_url("**layers.1.young=80+kPa**")


def test_keyboard_changes_a_value_and_solves(visit):
    window = solved(visit())
    before = window.inner_text("#shown table")
    window.focus("[name='indenter.radius']")
    window.keyboard.press("ArrowUp")
    assert window.input_value("[name='indenter.radius']") == "5.25 um"
    window.wait_for_function("(before) => document.querySelector('#shown table').innerText !== before", arg=before)


def test_nothing_is_cut_off_on_a_phone(visit):
    window = solved(visit(width=390))
    for tab in ("press", "fit", "correct", "coating", "slip", "compare"):
        window.click(f"#tab-{tab}")
        assert window.evaluate("document.documentElement.scrollWidth") == 390, tab
        fields = window.eval_on_selector_all(
            "input, select, textarea, button",
            "all => all.filter((e) => e.offsetParent && e.getBoundingClientRect().right > 390).map((e) => e.name || e.id)",
        )
        assert fields == [], tab


def test_curves_are_kept_and_compared(visit):
    window = solved(visit())
    window.click("#keep")
    window.wait_for_selector("#shown .readout:has-text('force / kept 1 1')")
    assert window.is_disabled("#keep")
    window.fill("[name='layers.0.young']", "10 kPa")
    window.wait_for_function("() => document.querySelector('#shown').classList.contains('stale')")
    solved(window)
    window.wait_for_selector("#shown .legend:has-text('kept 1: layers.0.young 5 kPa')")
    (said,) = (
        text for text in window.locator("#shown .readout li").all_inner_texts() if text.startswith("force / kept 1")
    )
    assert float(said.split()[-1]) == pytest.approx(2, rel=1e-3)  # glass is rigid beside both gels
    window.click("#drop-kept")
    assert window.locator("#shown .legend:has-text('kept')").count() == 0


def test_long_job_shows_progress_and_is_stopped(visit):
    window = solved(visit())
    window.fill("[name='title']", "mine")
    window.select_option("[name='method']", "bem")
    window.fill("[name='control.points']", "400")
    window.wait_for_selector("#long:not([hidden])")
    window.click("#solve")
    window.wait_for_selector("#status-text:has-text('of 400')")
    # another window is used meanwhile, with its own state
    other = solved(visit("", width=800, scheme="dark"))
    assert other.input_value("[name='control.points']") == "60"
    assert other.input_value("[name='title']") == ""
    assert other.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 22, 27)"
    assert other.evaluate("document.documentElement.scrollWidth <= 800")
    # and so is this one: a quick form of the same tab, and another tab, are solved while the job goes on
    window.select_option("[name='method']", "")
    solved(window)
    window.click("#tab-correct")
    window.wait_for_selector("#shown .readout:has-text('reported over layer')")
    window.click("#tab-press")
    solved(window)
    window.wait_for_selector("#status-text:has-text('of 400')")
    window.select_option("[name='method']", "bem")
    window.wait_for_function("() => document.querySelector('#shown').classList.contains('stale')")
    window.click("#stop")
    window.wait_for_selector("#long:has-text('Stopped')")
    # what is known of the same form does not take the message away
    window.dispatch_event("[name='method']", "input")
    window.wait_for_selector("#long:has-text('Stopped'):has-text('Solving takes')")


def test_details_of_what_is_no_longer_shown_are_stopped(visit):
    """A pressure that takes long: another tab shows no progress of it, and the job is ended."""
    window = solved(visit())
    running = json.dumps({"state": "running", "key": "slow", "seconds": 9.0, "progress": None})
    window.route("**/api/detail?*", lambda route: route.fulfill(body=running))
    window.route("**/api/job?key=slow", lambda route: route.fulfill(body=running))
    window.route("**/api/stop?key=slow", lambda route: route.fulfill(body="{}"))
    window.focus("[aria-label='Step']")
    window.keyboard.press("ArrowLeft")
    window.wait_for_selector("#status-text:has-text('Solving, 9 s')")
    with window.expect_request("**/api/stop?key=slow"):
        window.click("#tab-correct")
    window.wait_for_selector("#shown .readout:has-text('reported over layer')")
    assert window.is_hidden("#status")


def test_case_file_is_opened(visit, tmp_path):
    window = solved(visit())
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("layers = [", encoding="utf-8")
    window.set_input_files("#case-file", wrong)
    window.wait_for_selector("#problems:has-text('not valid TOML')")
    window.set_input_files("#case-file", FILM)
    window.wait_for_function("() => document.querySelector('[name=\"layers.0.young\"]').value === '259 GPa'")
    solved(window)
    assert window.is_hidden("#problems")


def test_correct_from_example_to_link(visit):
    window = example(visit(), "Correct: Thin gel")
    assert "layer 2.608 kPa" in window.inner_text("#shown .readout")
    photo(window, "correct")
    window.fill("[name='correct.depth']", "300 N")
    window.wait_for_selector("[data-name='correct.depth'] .error:has-text('dimension of a force')")
    window.fill("[name='correct.depth']", "300 nm")
    window.wait_for_selector("#shown .readout:has-text('reported over layer 2.319')")
    assert downloaded(window, "csv").startswith(b"formula,young [Pa]")
    window.wait_for_url("**correct.depth=300+nm**")
    other = solved(visit("?" + window.url.partition("?")[2]))
    assert other.inner_text("#shown table") == window.inner_text("#shown table")


def test_coating_section_map_and_stop(visit):
    window = example(visit(), "Coating: Hard")
    assert "First failure: yield in layer 2" in window.inner_text("#shown")
    photo(window, "coating")
    image = "document.querySelector('#shown image').getAttribute('href')"
    before = window.evaluate(image)
    window.select_option("[aria-label='What is drawn']", label="von Mises over yield stress")
    window.wait_for_function(f"(before) => {image} !== before", arg=before)
    # a strength is wrong beside its layer
    window.fill("[name='layers.0.stress.tensile']", "2 N")
    window.wait_for_selector("[data-name='layers.0.stress.tensile'] .error:has-text('dimension of a force')")
    window.fill("[name='layers.0.stress.tensile']", "2 GPa")
    window.check("[name='map']")
    window.fill("[name='vary.layers.0.thickness']", "0.5 um:20 um:60:log")
    window.wait_for_selector("#long:not([hidden])")
    window.click("#solve")
    window.wait_for_selector("#status-text:has-text('of 60')")
    window.click("#stop")
    window.wait_for_selector("#long:has-text('Stopped')")
    count = 4 if SCREENSHOTS else 2  # the picture of the documentation has eight cells
    window.fill("[name='vary.layers.0.thickness']", f"1 um:16 um:{count}:log")
    window.fill("[name='vary.stress.friction']", "0:0.4:2")
    window.wait_for_selector("#long:not(:has-text('Stopped'))")
    window.click("#solve")
    window.wait_for_selector(f"#shown .in-cell >> nth={2 * count - 1}")
    photo(window, "map")
    assert b"vary" in downloaded(window, "toml")


def test_compare_and_every_tab_by_keyboard(visit):
    window = example(visit(), "Compare: AFM pyramid")
    # the formula for pyramids, +0.00 %, beside the cone's
    row = window.locator("#shown tr", has_text="flatpunch").inner_text().split("\t")
    assert row[2:5] == ["all depths"] * 3
    photo(window, "compare")
    window.set_viewport_size({"width": 800, "height": 900})
    window.focus("#tab-compare")
    for name in ("press", "fit", "correct", "coating", "slip", "compare"):
        window.keyboard.press("ArrowRight")
        assert window.evaluate("document.activeElement.id") == f"tab-{name}"
        assert window.get_attribute(f"#tab-{name}", "aria-selected") == "true"
        assert window.evaluate("document.documentElement.scrollWidth <= 800")
        # every field that is shown has a name for those who do not see it
        assert (
            window.evaluate(
                "[...document.querySelectorAll('#form input, #form select')].filter((each) => each.offsetParent && "
                "!each.labels?.length && !each.ariaLabel).map((each) => each.outerHTML)"
            )
            == []
        )


def test_files_that_are_too_large_are_refused_before_they_are_sent(visit, tmp_path):
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(51_000_000)
    window = visit("?tab=fit")
    window.set_input_files("#curve-file", large)
    window.wait_for_selector("#upload-error:has-text('files of up to 50 MB')")


@pytest.mark.slow
def test_a_curve_of_20_megabytes_is_fitted(visit, tmp_path):
    lines = (FILM.parent / "fit" / "thin_gel.csv").read_text(encoding="utf-8").splitlines()
    many = "\n".join([lines[0], *(line for line in lines[1:] for _ in range(2000))])
    (tmp_path / "large.csv").write_text(many, encoding="utf-8")
    window = visit("?tab=fit")
    example(window, "Fit: Thin gel")
    window.set_input_files("#curve-file", tmp_path / "large.csv")
    window.wait_for_selector("#shown .preview:has-text('1600000 points')")
    window.click("#solve")
    window.wait_for_selector("#shown pre:has-text('large: 1')")


def test_curve_is_dropped_fitted_and_saved(visit):
    window = solved(visit())
    window.select_option("#example", label="Fit: Thin gel under a bead")
    window.wait_for_selector("#shown :text('What was found')")
    assert "2.6 kPa" in window.inner_text("#shown table")
    photo(window, "fit")
    window.set_input_files(
        "#curve-file", files=[{"name": "words.csv", "mimeType": "text/csv", "buffer": b"no numbers"}]
    )
    window.wait_for_selector("#upload-error:has-text('no rows of numbers')")
    curve = (FILM.parent / "fit" / "thin_gel.csv").read_bytes()
    window.set_input_files("#curve-file", files=[{"name": "mine.csv", "mimeType": "text/csv", "buffer": curve}])
    window.wait_for_selector("#long:has-text('Fit this case')")
    window.click("#solve")
    window.wait_for_selector("#shown pre:has-text('mine: 800 points')")
    with window.expect_download() as saved:
        window.click("[data-save='csv']")
    assert "mine" in Path(saved.value.path()).read_text(encoding="utf-8")


def test_the_baseline_is_chosen_beside_the_button(visit):
    """Visible without unfolding or scrolling, on this tab alone; it decides over a baseline that is tilted."""
    window = visit("?tab=fit")
    baseline = window.locator("[data-name='fit.baseline'] select")
    assert baseline.count() == 1
    assert not baseline.is_visible()  # there is no button yet
    assert not window.locator("[data-name='fit.loss'] select").is_visible()
    example(window, "Fit: Thin gel")
    title, *rows = (FILM.parent / "fit" / "thin_gel.csv").read_text(encoding="utf-8").splitlines()
    pairs = [tuple(map(float, row.split(","))) for row in rows]
    rise = max(force for _, force in pairs)
    tilted = [f"{depth},{force + 0.2 * rise * i / len(pairs)}" for i, (depth, force) in enumerate(pairs)]
    curve = "\n".join([title, *tilted]).encode()
    window.set_input_files("#curve-file", files=[{"name": "tilted.csv", "mimeType": "text/csv", "buffer": curve}])
    window.wait_for_selector("#long:has-text('Fit this case')")
    assert baseline.is_visible()
    gap = window.locator("#solve").bounding_box()["y"] - baseline.bounding_box()["y"]
    assert 0 < gap < 100
    for chosen, other in (("constant", "linear"), ("auto", "constant")):
        baseline.select_option(chosen)
        window.click("#solve")
        window.wait_for_selector(f"#shown :text(\"with baseline = '{other}'\")")
    window.click("#tab-press")
    assert not baseline.is_visible()
