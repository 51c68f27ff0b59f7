"""The page as people use it: a headless Chromium, from the first look to the file that is saved.

Skipped where no browser is found, or Playwright is not installed. FLATPUNCH_SCREENSHOTS names a folder for the pictures of the
documentation, which the tests then take.
"""

import os
import shutil
import threading
import time
import tomllib
from pathlib import Path

import pytest

from flatpunch.app.page import Page
from flatpunch.app.server import AppServer
from flatpunch.files import shipped_cases

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next((path for name in BROWSERS if (path := shutil.which(name))), None)
SCREENSHOTS = os.environ.get("FLATPUNCH_SCREENSHOTS")
FILM = next(path for path in shipped_cases() if path.stem == "elliptic_tip_on_carbon_film")
SECONDS = 60_000
"""Time that a result may take on a busy machine [ms]."""

if BROWSER is None:
    pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} was found", allow_module_level=True)
api = pytest.importorskip("playwright.sync_api", reason="needs Playwright: pip install playwright")


@pytest.fixture(scope="module")
def address():
    """A page that is served, with one process ready."""
    page = Page()
    page.workers.warm()
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


def photo(window, name):
    """Take a picture for the documentation."""
    if SCREENSHOTS:
        window.evaluate("scrollTo(0, 0)")
        time.sleep(2)
        window.screenshot(path=Path(SCREENSHOTS) / f"app_{name}.png")


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
    window.drag_and_drop(
        "#layers .layer:nth-child(1) .handle", "#layers .layer:nth-child(2)", target_position={"x": 100, "y": 150}
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


def test_long_job_shows_progress_and_is_stopped(visit):
    window = solved(visit())
    window.select_option("[name='method']", "bem")
    window.fill("[name='control.points']", "400")
    window.wait_for_selector("#long:not([hidden])")
    window.click("#solve")
    window.wait_for_selector("#status-text:has-text('of 400')")
    # another window is used meanwhile, with its own state
    other = solved(visit("", width=800, scheme="dark"))
    assert other.input_value("[name='control.points']") == "60"
    assert other.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 22, 27)"
    assert other.evaluate("document.documentElement.scrollWidth <= 800")
    window.click("#stop")
    window.wait_for_selector("#long:has-text('Stopped')")


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
