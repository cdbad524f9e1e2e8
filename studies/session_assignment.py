"""The schedules of a study by task and order, from which each new session is given one."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from studies.schedules import Schedule, make_schedules
from studies.study_records import Study


@lru_cache(maxsize=8)
def schedule_book(study: Study) -> Mapping[tuple[str, int], Schedule]:
    """Return every schedule of a study, the same whenever the study is served.

    Parameters
    ----------
    study : Study

    Returns
    -------
    mapping of (str, int) to Schedule
        By task and order.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> book = schedule_book(bare_study(pairs=2))
    >>> sorted(book), len(book["task-1", 0].entries)
    ([('task-1', 0), ('task-1', 1), ('task-1', 2), ('task-1', 3)], 8)
    """
    return MappingProxyType({(one.task, one.order): one for one in make_schedules(study)})
