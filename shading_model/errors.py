"""Errors a user can cause, each told in one sentence."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class RelightlabError(Exception):
    """A fault in what the user gave: what was expected, what came, what to do.

    The command line prints the sentence and exits with code 2.

    Examples
    --------
    >>> raise RelightlabError("expected a mask of shape (h, w), got (h, w, 3)")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: expected a mask of shape (h, w), got (h, w, 3)
    """


def unknown_name(kind: str, name: str, available: Iterable[str]) -> RelightlabError:
    """Return the error for a name that is not in a registry.

    Parameters
    ----------
    kind : str
        What was looked for, in words: ``"detail source"``.
    name : str
        What the user wrote.
    available : iterable of str
        The names that exist.

    Returns
    -------
    RelightlabError
        To be raised by the caller.

    Examples
    --------
    >>> print(unknown_name("detail source", "gt", ["default", "gt-shading"]))
    Unknown detail source 'gt'. Did you mean 'gt-shading'? Available: default, gt-shading.
    >>> print(unknown_name("object", "racoon", ["raccoon", "sun"]))
    Unknown object 'racoon'. Did you mean 'raccoon'? Available: raccoon, sun.
    """
    names = list(available)
    beginning = [known for known in names if name and known.startswith(name)]
    close = difflib.get_close_matches(name, names, n=1) or beginning
    hint = f" Did you mean {close[0]!r}?" if close else ""
    return RelightlabError(f"Unknown {kind} {name!r}.{hint} Available: {', '.join(names)}.")
