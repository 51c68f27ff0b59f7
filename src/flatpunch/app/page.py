"""Requests of the page and what is returned to them. Sockets and browsers are not needed here; `server` puts it on the net.

GET  /                      the page, and its parts below /static
GET  /api/start             tables of the form, examples
POST /api/solve             body: form; ?tab=press&run=1 -> a result, or a job
GET  /api/job?key=...       state of a job; POST /api/stop?key=... ends it
POST /api/detail            body: form; ?tab=press&name=pressure&step=3
POST /api/curve?name=...    body: a measured file -> the text of the field `upload`
POST /api/case              body: text of a case file -> its form
GET, POST /file/press.csv   the form as query or body -> a file
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from importlib.resources import files
from pathlib import Path
from urllib.parse import parse_qsl

from flatpunch._support.messages import message
from flatpunch._support.paths import Plain
from flatpunch._version import __version__
from flatpunch.app.form import FormError, address_of, case_text, fields_of, form_of
from flatpunch.app.limits import LIMITS
from flatpunch.app.store import Store, Uploads, shipped_fits
from flatpunch.app.tables import page_tables
from flatpunch.app.tabs import FILES, TABS, Tab, script
from flatpunch.app.workers import Job, Workers
from flatpunch.files import CaseError, shipped_cases
from flatpunch.files.cases import LARGEST, parsed

_ALSO = {"correct": "correct", "coating": "stress", "slip": "slip", "compare": "afm_pyramid_on_gel"}
"""Tabs for which a shipped case is an example too, by a table that it has or by its name."""

_TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "svg": "image/svg+xml",
    "png": "image/png",
    "csv": "text/csv; charset=utf-8",
    "nc": "application/x-netcdf",
    "toml": "application/toml; charset=utf-8",
    "py": "text/x-python; charset=utf-8",
}


@dataclass(frozen=True)
class Answer:
    """What is sent back: status, content, its type, and the name under which a browser saves it."""

    status: int
    content: bytes
    type: str = "application/json"
    name: str | None = None


@dataclass(frozen=True)
class Request:
    """What a browser asks for."""

    method: str
    path: str
    query: str = ""
    body: bytes = b""

    @property
    def options(self) -> dict[str, str]:
        """Query as names and values."""
        return dict(parse_qsl(self.query))


class NotHere(ValueError):
    """Something that the page does not have."""


@dataclass
class Page:
    """The page: its workers, and what it keeps in memory.

    Nothing of it belongs to one visitor: what a request needs is in the request, and results are kept by the form they belong to.
    """

    workers: Workers = field(default_factory=Workers)

    def __post_init__(self) -> None:
        self._uploads = Uploads()
        self._results: Store[Plain] = Store(LIMITS.kept, lambda result: len(result.get("kept", b"")) + 10_000)

    def answer(self, request: Request) -> Answer:
        """Return the answer to a request; whatever goes wrong is one, too."""
        try:
            return self._routed(request)
        except NotHere as error:
            return _problem(HTTPStatus.NOT_FOUND, str(error))
        except (FormError, CaseError) as error:
            return _problem(HTTPStatus.BAD_REQUEST, str(error), getattr(error, "field", ""))
        except Exception as error:
            return _problem(HTTPStatus.INTERNAL_SERVER_ERROR, message(error))

    def _routed(self, request: Request) -> Answer:
        if request.method == "GET":
            if request.path == "/":
                return _static("page.html")
            if match := re.fullmatch(r"/static/([a-z_]+\.(?:js|css|svg))", request.path):
                return _static(match[1])
            if request.path == "/api/start":
                return _json(start())
            if request.path == "/api/job":
                return self._state(self._job(request))
        if match := re.fullmatch(r"/file/([a-z]+)\.([a-z]+)", request.path):
            return self._file(match[1], match[2], _form(request) or fields_of(request.query))
        if request.method == "POST":
            if request.path == "/api/solve":
                return self._solve(_tab(request), _form(request), request.options.get("run") == "1")
            if request.path == "/api/detail":
                return self._detail(_tab(request), _form(request), request.options)
            if request.path == "/api/stop":
                self._job(request).stop()
                return _json({"state": "stopped"})
            if request.path == "/api/curve":
                return _json({"upload": self._uploads.put(request.options.get("name", "curve"), request.body)})
            if request.path == "/api/case":
                return _json({"form": address_of(read_case_text(request.body))})
        raise NotHere(f"{request.method} {request.path} is nothing that this page has.")

    def _job(self, request: Request) -> Job:
        job = self.workers.find(request.options.get("key", ""))
        if job is None:
            raise NotHere("this job is no longer known; solve it again.")
        return job

    def _solve(self, tab: Tab, fields: dict[str, str], run: bool) -> Answer:
        name = _name(tab, fields)
        known = self._results.get(name)
        if known is not None:
            return _json({"state": "done", "result": _without_kept(known)})
        return self._state(self._started(tab, fields, run, name), LIMITS.soon)

    def _started(self, tab: Tab, fields: dict[str, str], run: bool, name: str) -> Job:
        def keep(outcome: Plain) -> None:
            if "kept" in outcome:
                self._results.put(name, outcome)

        upload = (self._uploads.get(fields.get("upload", "")),) if tab.uploads else ()
        return self.workers.submit(tab.solve, fields, run, *upload, long=run, keep=keep)

    def _state(self, job: Job, seconds: float = 0.0) -> Answer:
        if not job.wait(seconds):
            return _json({"state": job.state, "key": job.key, "progress": job.progress, "seconds": job.seconds})
        if job.state == "done":
            return _json({"state": "done", "result": _without_kept(job.outcome)})
        return _json({"state": job.state, "message": job.outcome})

    def _kept(self, tab: Tab, fields: dict[str, str]) -> bytes:
        """What solving a form has kept; it is solved now if that is no longer there."""
        name = _name(tab, fields)
        known = self._results.get(name)
        if known is None:
            job = self._started(tab, fields, True, name)
            _wait(job)
            known = job.outcome if job.state == "done" else {"problems": [{"text": job.outcome or "it was stopped."}]}
        if "kept" not in known:
            raise FormError("\n".join(problem["text"] for problem in known.get("problems", ())))
        kept: bytes = known["kept"]
        return kept

    def _detail(self, tab: Tab, fields: dict[str, str], options: Mapping[str, str]) -> Answer:
        name = options.get("name", "")
        if name in tab.previews:
            job = self.workers.submit(tab.previews[name], fields, self._uploads.get(fields.get("upload", "")))
            return self._state(job, LIMITS.soon)
        function = tab.details.get(name)
        if function is None:
            raise NotHere("this tab has no such detail.")
        step = int(options["step"]) if options.get("step", "").isdecimal() else 0
        return self._state(self.workers.submit(function, fields, self._kept(tab, fields), step), LIMITS.soon)

    def _file(self, tab_name: str, kind: str, fields: dict[str, str]) -> Answer:
        if tab_name not in TABS or kind not in FILES:
            raise NotHere(f"there is no file {tab_name}.{kind}.")
        tab = TABS[tab_name]
        stem = _stem(fields.get("title", "")) or tab_name
        if kind == "toml":
            content = case_text(fields, tab_name).encode("utf-8")
        elif kind == "py":
            content = script(tab, fields, stem).encode("utf-8")
        else:
            job = self.workers.submit(tab.file, fields, self._kept(tab, fields), kind)
            _wait(job)
            if job.state != "done":
                raise FormError(job.outcome or "it was stopped.")
            content = job.outcome
        return Answer(HTTPStatus.OK, content, _TYPES[kind], f"{stem}.{kind}")


def _wait(job: Job) -> None:
    """Wait for a job, which is stopped when it takes longer than a request may."""
    if not job.wait(LIMITS.longest):
        job.finish(
            "failed",
            f"it took longer than {LIMITS.longest / 60:g} minutes and was stopped. Solve it on the page first.",
        )
        job.stop()


def start() -> Plain:
    """Return what the page needs to draw itself: the tables of the form, the shipped cases as forms, the version."""
    examples = [example for path in shipped_cases() for example in _examples(path, "press")]
    examples += [example for path in shipped_fits() for example in _examples(path, "fit")]
    return {"version": __version__, "tables": page_tables(), "examples": examples}


def _examples(path: Path, tab: str) -> Iterator[dict[str, str]]:
    """A shipped case as the form of a tab, and of others that it has a table for."""
    data = parsed(path.read_text(encoding="utf-8"), path)
    # the range of a map is there, but the section comes first
    fields = {name: text for name, text in form_of(data).items() if name != "map"}
    title = fields.get("title", path.stem)
    if tab == "fit":
        fields["upload"] = f"shipped/{path.stem}.csv"
    tabs = [tab, *(other for other, wanted in _ALSO.items() if wanted in data or path.stem == wanted)]
    for name in tabs:
        words = "" if name == "press" else f"{name.capitalize()}: "
        yield {"title": f"{words}{title}", "tab": name, "form": address_of(fields)}


def read_case_text(body: bytes) -> dict[str, str]:
    """Return the form of a case file that was uploaded; it need not be a valid case, but valid TOML."""
    if len(body) > LARGEST:
        raise FormError(f"the case file is larger than {LARGEST / 1e6:g} MB, the most that is read.")
    try:
        return form_of(parsed(body.decode("utf-8-sig"), Path("case.toml")))
    except UnicodeDecodeError:
        raise FormError("this is no text file; a case file is TOML in UTF-8.") from None


def _form(request: Request) -> dict[str, str]:
    return fields_of(request.body.decode("utf-8", errors="replace"))


def _tab(request: Request) -> Tab:
    name = request.options.get("tab", "")
    if name not in TABS:
        raise NotHere(f"there is no tab {name!r}.")
    return TABS[name]


def _name(tab: Tab, fields: Mapping[str, str]) -> str:
    """Name of a result: what it depends on, and nothing else."""
    return hashlib.sha256(f"{tab.name}?{address_of(dict(sorted(fields.items())))}".encode()).hexdigest()


def _stem(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")[:60]


def _static(name: str) -> Answer:
    found = files("flatpunch.app") / "static" / name
    if not found.is_file():
        raise NotHere(f"there is no {name}.")
    return Answer(HTTPStatus.OK, found.read_bytes(), _TYPES[name.rpartition(".")[2]])


def _without_kept(outcome: Mapping[str, object]) -> Plain:
    return {name: value for name, value in outcome.items() if name != "kept"}


def _json(data: object, status: int = HTTPStatus.OK) -> Answer:
    return Answer(status, json.dumps(data, allow_nan=False).encode())


def _problem(status: int, text: str, field: str = "") -> Answer:
    return _json({"problems": [{"field": field, "text": text}]}, status)
