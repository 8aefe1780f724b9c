"""The points of a sweep traced by this process, by local ones, or by the workers of a cluster."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from mpfcad.errors import InputError, MpfcadError
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.point.trace import Point, trace_point
from mpfcad.store import code_hash, versions

if TYPE_CHECKING:
    from distributed import Client

#: How long to wait for a scheduler and for a worker, and how often to look for them [s].
_PATIENCE, _LOOK = 30.0, 5.0


def running() -> dict[str, str]:
    """Return the versions that figures come from, and the hash of the code."""
    return {**versions(), "code": code_hash()}


def trace_there(point: Point, asked: dict[str, str]) -> dict[str, Any]:
    """Return the figures of a point, where this process runs what the asking one does.

    Raises
    ------
    InputError
        when it runs another version, whose figures would not be those of this sweep.
    """
    here = running()
    for name, version in asked.items():
        if here.get(name) != version:
            raise InputError(
                f"a worker runs {name} {here.get(name, 'none')[:20]}: expected {version[:20]}, as "
                "here: install the same versions"
            )
    return trace_point(point)


@contextmanager
def traced_points(
    points: dict[int, Point], scheduler: str | None, workers: int | None
) -> Iterator[Iterator[tuple[int, dict[str, Any]]]]:
    """Give the results as they come in, in any order; a task of a lost worker is done again.

    Raises
    ------
    InputError
        when the scheduler does not answer or is lost, has no worker or none any more, or one of
        another version.
    """
    if scheduler is None and workers == 1:
        yield ((i, trace_point(point)) for i, point in points.items())
        return
    from dask import config
    from distributed import Client, LocalCluster

    # A worker that is killed costs its task one attempt; it is not the task's fault.
    with config.set({"distributed.scheduler.allowed-failures": 10}):
        cluster = scheduler or LocalCluster(
            n_workers=workers or available_threads(),
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
        )
        client = None
        try:
            client = Client(cluster, timeout=_PATIENCE)
            client.wait_for_workers(1, timeout=_PATIENCE)
        except (OSError, ValueError) as error:  # a TimeoutError is an OSError
            if client is not None:
                client.close(timeout=1)
            reason = " ".join(str(error).split())[:120]
            raise InputError(
                f"--scheduler: {scheduler}: {reason}: expected a Dask scheduler with workers"
            ) from None
        try:
            asked = running()
            futures = {
                client.submit(trace_there, point, asked, pure=False): i
                for i, point in points.items()
            }
            yield _results(client, futures, scheduler)
        finally:
            client.close(timeout=1)
        if not isinstance(cluster, str):
            cluster.close()


def _results(
    client: "Client", futures: dict[Any, int], scheduler: str | None
) -> Iterator[tuple[int, dict[str, Any]]]:
    from distributed import KilledWorker

    where = f"--scheduler: {scheduler}" if scheduler else "--workers"
    for done in _finished(client, set(futures), where):
        try:
            yield futures[done], done.result()
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        except MpfcadError:
            raise
        except KilledWorker as error:
            raise InputError(
                f"{where}: {error.allowed_failures + 1} workers died while they traced one point: "
                "expected workers with memory enough"
            ) from None
        except (ImportError, AttributeError, TypeError) as error:
            # What a worker raises whose package lacks what is asked of it.
            reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
            raise InputError(
                f"{where}: a worker cannot do it ({reason}): expected the same "
                "version of mpfcad on each worker"
            ) from None


def _finished(client: "Client", left: set[Any], where: str) -> Iterator[Any]:
    """Give each future once it is done, as long as there is somebody who works on them.

    Raises
    ------
    InputError
        beginning with `where`, when the scheduler is lost or stays silent, or has no worker left.
    """
    from concurrent.futures import CancelledError

    from distributed import wait

    alone = 0.0
    while left:
        try:
            done, left = wait(left, timeout=_LOOK, return_when="FIRST_COMPLETED")
        except TimeoutError:
            alone = 0.0 if _has_worker(client, where) else alone + _LOOK
            if alone > _PATIENCE:
                raise InputError(
                    f"{where}: no worker is left, since {alone:.0f} s: expected workers until the "
                    "last point is traced; what is done is kept"
                ) from None
            continue
        except CancelledError:
            raise InputError(
                f"{where}: the connection was lost: expected a Dask scheduler that stays; what "
                "is done is kept"
            ) from None
        yield from done


def _has_worker(client: "Client", where: str) -> bool:
    """Tell whether the scheduler has a worker."""
    try:
        found = client.sync(client.scheduler.identity, callback_timeout=_PATIENCE)
    except OSError as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"{where}: does not answer ({reason}): expected a Dask scheduler that stays; what is "
            "done is kept"
        ) from None
    return bool(found["workers"])
