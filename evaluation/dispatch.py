"""One dispatcher for this process, worker processes, and a Dask cluster.

Every way yields results as they finish and keeps one BLAS thread per worker; which way a task took
leaves no trace in its result. What all tasks share is sent to a worker once, not with each task.
"""

from __future__ import annotations

import pickle
import socket
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar
from urllib.parse import urlsplit

from joblib.externals.loky.process_executor import ProcessPoolExecutor
from threadpoolctl import threadpool_limits

from datasets.worker_processes import leave_interrupts_to_the_parent
from evaluation.code_version import code_hash
from evaluation.task_process import ONE_THREAD, run_in_own_process
from shading_model.errors import RelightlabError

Item = TypeVar("Item")
Result = TypeVar("Result")
CONNECTION_SECONDS = 10
SCHEMES = ("tcp", "tls")
CHANGED_CODE = (
    "the code of relightlab has changed since the run began, and would give numbers that belong to"
    " no version: what was measured is kept, start the run again"
)
CANNOT_LOAD = "a worker process cannot load what the cells are measured with"
_shared: list[Callable[[Any], Any]] = []
"""In a worker process, the work it does."""


def dispatch(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    workers: int = 1,
    scheduler: str | None = None,
) -> Iterator[tuple[Item, Result | None]]:
    """Yield each item with its result, in the order of finishing.

    Parameters
    ----------
    work : callable
        Picklable; it returns faults as results, so that an exception here is a broken worker.
    items : sequence
        Picklable.
    workers : int
        Processes; with one, the work is done in this process.
    scheduler : str, optional
        Address of a Dask scheduler, ``tcp://host:port``; then `workers` plays no part.

    Yields
    ------
    item, result
        The result is None for an item whose worker process died twice, the second time while it
        did nothing else.

    Raises
    ------
    RelightlabError
        If there is no worker, the work cannot be sent to one, the scheduler cannot be reached or
        stops, or a worker of the cluster cannot do the work.
    """
    if workers < 1:
        raise RelightlabError(f"expected at least one worker, got {workers}")
    if scheduler is not None:
        yield from _on_cluster(work, items, scheduler)
    elif workers == 1:
        for item in items:
            yield item, _on_one_thread(work, item)
    else:
        yield from _in_processes(_pickled(work), items, workers)


def _on_one_thread(work: Callable[[Item], Result], item: Item) -> Result:
    with threadpool_limits(limits=1):
        return work(item)


def _pickled(work: Callable[[Item], Result]) -> bytes:
    try:
        return pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise RelightlabError(
            f"what the cells are measured with cannot be sent to another process ({error}):"
            " define it in a module, or use --workers 1"
        ) from error


def _in_processes(
    work: bytes, items: Sequence[Item], workers: int
) -> Iterator[tuple[Item, Any | None]]:
    """Run in worker processes; whatever was in flight when one died is tried again, alone."""
    left = deque(items)
    while left:
        in_flight: dict[Future[Any], Item] = {}
        try:
            with _pool(work, workers) as pool:
                yield from _until_done(pool, left, in_flight, workers)
        except BrokenProcessPool:
            for item in in_flight.values():
                yield item, _alone(work, item)


def _until_done(
    pool: Any, left: deque[Item], in_flight: dict[Future[Any], Item], workers: int
) -> Iterator[tuple[Item, Any]]:
    while left or in_flight:
        # One more than can run, so that a worker need not wait for this process.
        while left and len(in_flight) <= workers:
            in_flight[pool.submit(_do_shared_work, left[0])] = left[0]
            left.popleft()
        finished, _ = wait(in_flight, return_when=FIRST_COMPLETED)
        for future in finished:
            result = future.result()
            yield in_flight.pop(future), result


def _alone(work: bytes, item: Item) -> Any | None:
    try:
        with _pool(work, 1) as pool:
            return pool.submit(_do_shared_work, item).result()
    except BrokenProcessPool:
        return None


@contextmanager
def _pool(work: bytes, workers: int) -> Iterator[Any]:
    pool = ProcessPoolExecutor(
        workers, initializer=_share, initargs=(work, code_hash()), env=dict(ONE_THREAD)
    )
    unfinished = True
    try:
        yield pool
        unfinished = False
    finally:
        # After Ctrl-C nobody waits for the tasks that are running.
        pool.shutdown(wait=True, kill_workers=unfinished)


def _share(work: bytes, code: str) -> None:
    """Load the work of a worker process; a fault is told when the first item is asked for."""
    leave_interrupts_to_the_parent()
    if code != code_hash():
        _shared[:] = [partial(_refuse, CHANGED_CODE)]
        return
    try:
        _shared[:] = [pickle.loads(work)]  # noqa: S301  bytes of the process that started this one
    except Exception as error:  # noqa: BLE001  an initializer that raises says nothing to anyone
        reason = f"{type(error).__name__}: {error}"
        _shared[:] = [partial(_refuse, f"{CANNOT_LOAD} ({reason})")]


def _refuse(reason: str, _item: Any) -> None:
    raise RelightlabError(reason)


def _do_shared_work(item: Any) -> Any:
    return _on_one_thread(_shared[0], item)


def _on_cluster(
    work: Callable[[Item], Result], items: Sequence[Item], scheduler: str
) -> Iterator[tuple[Item, Any | None]]:
    """Run on Dask, which repeats the tasks of a worker it loses; suspects are tried again alone."""
    with _client(scheduler) as client:
        # A task of its own rather than scattered data, which would be lost with its worker.
        shared = client.submit(bytes, _pickled(work), pure=False)
        suspects: list[Item] = []
        for item, result, lost in _as_completed(client, shared, items, scheduler):
            if lost:
                suspects.append(item)
            else:
                yield item, result
        for suspect in suspects:
            for item, result, _ in _as_completed(client, shared, [suspect], scheduler):
                yield item, result


@contextmanager
def _client(scheduler: str) -> Iterator[Any]:
    try:
        import distributed  # noqa: PLC0415
    except ImportError as error:
        raise RelightlabError(
            "--scheduler needs Dask: install the extra 'cluster' of relightlab"
        ) from error
    library: Any = distributed  # it has no types
    try:
        _wait_for_listener(scheduler)
        client = library.Client(scheduler, timeout=CONNECTION_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise RelightlabError(
            f"no Dask scheduler answers at {scheduler}: start one, or leave --scheduler out"
        ) from error
    with client:
        yield client


def _wait_for_listener(address: str) -> None:
    """Raise OSError or ValueError if nothing listens; a Dask client that fails leaves threads."""
    parts = urlsplit(address)
    if parts.scheme not in SCHEMES or parts.hostname is None or parts.port is None:
        raise ValueError(f"not the address of a scheduler: {address}")
    end = time.monotonic() + CONNECTION_SECONDS
    while True:
        try:
            socket.create_connection((parts.hostname, parts.port), CONNECTION_SECONDS).close()
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)
        else:
            return


def _as_completed(
    client: Any, shared: Any, items: Sequence[Item], scheduler: str
) -> Iterator[tuple[Item, Any, bool]]:
    """Yield items with their results, and whether the workers that tried it were lost."""
    import distributed  # noqa: PLC0415

    library: Any = distributed  # it has no types
    futures = {
        client.submit(run_in_own_process, shared, code_hash(), pickle.dumps(item), pure=False): item
        for item in items
    }
    for future in library.as_completed(futures, loop=client.loop):
        result, error = _outcome(future)
        if error is not None and not isinstance(error, library.KilledWorker):
            raise RelightlabError(
                f"the run on the Dask cluster at {scheduler} stopped ({error}): what was measured"
                " is kept; every worker needs this version of relightlab and its data"
            ) from error
        yield futures.pop(future), result, error is not None


def _outcome(future: Any) -> tuple[Any, Exception | None]:
    """Return the result or the fault; waits if the result was lost with its worker just now."""
    try:
        return future.result(), None
    except CancelledError:
        return None, RuntimeError("the scheduler went away")
    except Exception as error:  # noqa: BLE001  told from the loss of a worker by whoever asks
        return None, error
