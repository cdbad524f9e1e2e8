"""One dispatcher for this process, worker processes, and a Dask cluster.

Every way yields results as they finish and one BLAS thread per worker; which way a task took
leaves no trace in its result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError
from threadpoolctl import threadpool_limits

from datasets.worker_processes import leave_interrupts_to_the_parent
from shading_model.errors import RelightlabError

Item = TypeVar("Item")
Result = TypeVar("Result")
CONNECTION_SECONDS = 10


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
        The result is None for an item whose worker process died twice, once beside other items
        and once alone.

    Raises
    ------
    RelightlabError
        If there is no worker, or the scheduler cannot be reached.
    """
    if workers < 1:
        raise RelightlabError(f"expected at least one worker, got {workers}")
    if scheduler is not None:
        yield from _on_cluster(work, items, scheduler)
    elif workers == 1:
        for item in items:
            yield item, _on_one_thread(work, item)
    else:
        yield from _in_processes(work, items, workers)


def _on_one_thread(work: Callable[[Item], Result], item: Item) -> Result:
    with threadpool_limits(limits=1):
        return work(item)


def _in_processes(
    work: Callable[[Item], Result], items: Sequence[Item], workers: int
) -> Iterator[tuple[Item, Result | None]]:
    """Run in worker processes; items in flight when one dies are tried again, one at a time."""
    left = dict(enumerate(items))
    try:
        for number, result in _pool(work, left, workers):
            yield left.pop(number), result
    except TerminatedWorkerError:
        for number, item in list(left.items()):
            try:
                ((_, result),) = _pool(work, {number: item}, 1)
            except TerminatedWorkerError:
                yield item, None
            else:
                yield item, result


def _pool(
    work: Callable[[Item], Result], items: dict[int, Item], workers: int
) -> Iterator[tuple[int, Result]]:
    jobs = (delayed(_numbered)(work, number, item) for number, item in list(items.items()))
    with parallel_config(backend="loky", initializer=leave_interrupts_to_the_parent):
        # Two jobs, never one, or joblib would work in this process.
        parallel = Parallel(
            n_jobs=max(workers, 2), return_as="generator_unordered", pre_dispatch=workers
        )
        yield from parallel(jobs)


def _numbered(work: Callable[[Item], Result], number: int, item: Item) -> tuple[int, Result]:
    return number, _on_one_thread(work, item)


def _on_cluster(
    work: Callable[[Item], Result], items: Sequence[Item], scheduler: str
) -> Iterator[tuple[Item, Result | None]]:
    import distributed  # noqa: PLC0415

    cluster: Any = distributed  # it has no types
    try:
        client = cluster.Client(scheduler, timeout=CONNECTION_SECONDS)
    except OSError as error:
        raise RelightlabError(
            f"no Dask scheduler answers at {scheduler}: start one, or leave --scheduler out"
        ) from error
    with client:
        futures = {client.submit(_on_one_thread, work, item, pure=False): item for item in items}
        for future in cluster.as_completed(futures):
            broken = future.exception() is not None
            yield futures[future], None if broken else future.result()
            future.release()
