"""How worker processes behave."""

from __future__ import annotations

import signal


def leave_interrupts_to_the_parent() -> None:
    """Ignore Ctrl-C in a worker: a terminal sends it to every process, and the parent stops them.

    Without this each worker would print a traceback of its own. Handed to joblib as the
    ``initializer`` of its processes.

    Examples
    --------
    >>> before = signal.getsignal(signal.SIGINT)
    >>> leave_interrupts_to_the_parent()
    >>> signal.signal(signal.SIGINT, before) is signal.SIG_IGN
    True
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
