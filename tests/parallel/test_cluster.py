"""Points on a real Dask cluster: workers that are lost, schedulers that do not answer, packages that do not match."""

import sys
import threading
import warnings

import pytest

from flatpunch import FlatpunchWarning
from flatpunch.parallel import calls, solve_points
from flatpunch.parallel import worker as on_dask
from support import sample_points as functions
from support.platforms import SIGNALS


@pytest.fixture(scope="module")
def cluster():
    """Two workers with one thread each."""
    dask = pytest.importorskip("dask")
    distributed = pytest.importorskip("distributed")
    with (
        dask.config.set({"logging.distributed": "critical"}),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as made,
    ):
        yield made


@pytest.mark.long
@SIGNALS
def test_points_on_a_cluster_that_loses_a_worker(cluster, tmp_path):
    marks, seen = str(tmp_path), []
    points = {x: (x, marks) for x in ("once", *range(20))}
    store = tmp_path / "points"
    found = solve_points(
        functions.deadly, points, scheduler=cluster.scheduler_address, store=store, progress=lambda *at: seen.append(at)
    )
    assert found.failed == {}
    assert [found[x].numbers["x"] for x in points] == list(points)
    assert (tmp_path / "been-here-once").exists()
    assert seen[0] == (0, 21)
    assert seen[-1] == (21, 21)
    # the same points elsewhere: they are there
    assert solve_points(functions.deadly, points, workers=1, store=store).fresh == 0


@pytest.mark.long
@SIGNALS
# both workers are down for a while, on a busy machine for longer than is silently waited
@pytest.mark.filterwarnings("ignore:All workers of the scheduler")
def test_a_point_that_costs_every_worker_is_given_up_and_takes_no_other_with_it(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(
        cluster.scheduler, "allowed_failures", 0
    )  # the scheduler gives up on all that a lost worker had
    points = {x: (x, str(tmp_path)) for x in ("always", *range(20))}
    found = solve_points(functions.deadly, points, scheduler=cluster.scheduler_address)
    assert list(found.failed) == ["always"]
    assert found.failed["always"].startswith("WorkerLost: ")
    assert [found[x].numbers["x"] for x in range(20)] == list(range(20))


def test_failures_threads_and_a_client_of_ones_own(cluster):
    from distributed import Client

    with Client(cluster.scheduler_address, set_as_default=False) as client:
        found = solve_points(functions.square_but_not_of_three, range(200), scheduler=client)
        assert found.failed == {3: "ValueError: x = 3 is refused"}
        assert [found[i].numbers["square"] for i in range(4, 200)] == [i * i for i in range(4, 200)]
        assert solve_points(functions.threads, [0], scheduler=client)[0].numbers["threads"] == 1
        assert client.status == "running"


def test_the_packages_must_match(cluster, monkeypatch):
    monkeypatch.setattr(on_dask, "__version__", "9.9")
    with pytest.raises(ValueError, match=r"needs flatpunch 9\.9 and has .*Install the same version"):
        solve_points(functions.square, [1], scheduler=cluster.scheduler_address)
    monkeypatch.setattr(on_dask.platform, "python_version_tuple", lambda: ("3", "1", "0"))
    with pytest.raises(ValueError, match=r"runs Python 3.*this is Python 3\.1: use the same"):
        solve_points(functions.square, [1], scheduler=cluster.scheduler_address)


def test_nobody_there(monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(on_dask, "PATIENCE", 0.5)
    for address in ("tcp://127.0.0.1:1", "nonsense://x"):
        with pytest.raises(ConnectionError, match=r"does not answer.*dask scheduler"):
            solve_points(functions.square, [1], scheduler=address)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=":0", silence_logs=50, processes=False) as empty,
        pytest.raises(ConnectionError, match=r"has no workers\. Start some: `dask worker"),
    ):
        solve_points(functions.square, [1], scheduler=empty.scheduler_address)


@pytest.mark.long
def test_workers_that_are_all_gone_are_reported_and_waited_for(monkeypatch):
    """The call goes on with those that join later, and loses nothing."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(calls, "_TICK", 0.1)
    with distributed.LocalCluster(n_workers=1, dashboard_address=":0", silence_logs=50, processes=False) as made:

        def progress(done, total):
            if done == 1:
                monkeypatch.setattr(on_dask, "PATIENCE", 0.5)
                made.scale(0)
                threading.Timer(4.0, made.scale, [1]).start()

        points = [(0.3, i) for i in range(8)]
        with pytest.warns(
            FlatpunchWarning, match=r"All workers of the scheduler at .* are gone.*until one joins: `dask worker"
        ):
            found = solve_points(functions.slowly_named, points, scheduler=made.scheduler_address, progress=progress)
    assert [int(found[i].numbers["name"]) for i in range(8)] == list(range(8))


def test_without_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ValueError, match=r"pip install flatpunch\[dask\]"):
        solve_points(functions.square, [1], scheduler="tcp://127.0.0.1:1")


@pytest.mark.long
def test_nothing_to_do_needs_no_cluster(tmp_path):
    solve_points(functions.square, [1], workers=1, store=tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solve_points(functions.square, [1], store=tmp_path, scheduler="tcp://127.0.0.1:1").fresh == 0


class _WithoutWorkers:
    status = "running"

    def get_executor(self, *, pure):
        pass

    def nthreads(self):
        return {}

    def scheduler_info(self):
        return {"address": "tcp://10.0.0.1:8786"}


def test_a_short_time_without_workers_is_no_warning(monkeypatch):
    now, team = [0.0], on_dask.Cluster(_WithoutWorkers())
    monkeypatch.setattr(on_dask.time, "monotonic", lambda: now[0])
    for now[0] in (0.0, 0.9 * on_dask.PATIENCE):
        team.wait()
    now[0] = 1.1 * on_dask.PATIENCE
    with pytest.warns(FlatpunchWarning, match=r"All workers of the scheduler at tcp://10\.0\.0\.1:8786 are gone"):
        team.wait()
    team.wait()  # said once
