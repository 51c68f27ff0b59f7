"""One page with its worker processes for all tests of a process."""

import json
from types import SimpleNamespace
from urllib.parse import urlencode

import pytest

from flatpunch.app.page import Page, Request
from flatpunch.app.workers import Workers


@pytest.fixture(scope="session")
def page():
    """Page without a socket, with one process ready."""
    found = Page(Workers(2))
    yield found
    found.workers.close()


@pytest.fixture
def ask(page):
    """Requests as a browser sends them: `ask.post(path, form)` returns the data, `ask.solve(tab, form)` waits for the result."""

    def post(path, form=(), body=None):
        path, _, query = path.partition("?")
        content = urlencode(dict(form)).encode() if body is None else body
        return page.answer(Request("POST", path, query, content))

    def get(path):
        path, _, query = path.partition("?")
        return page.answer(Request("GET", path, query))

    def solve(tab, form, run=True):
        state = json.loads(post(f"/api/solve?tab={tab}&run={int(run)}", form).content)
        while "key" in state:
            page.workers.find(state["key"]).wait()
            state = json.loads(get(f"/api/job?key={state['key']}").content)
        return state.get("result", state)

    return SimpleNamespace(post=post, get=get, solve=solve)
