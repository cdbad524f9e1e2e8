"""The secret key of a database: what ids are hashed with and completion codes are made with."""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
from dataclasses import dataclass, field
from pathlib import Path

from shading_model.errors import RelightlabError

BYTES = 32


@dataclass(frozen=True)
class SecretKey:
    """A key, and the two things it is for.

    Parameters
    ----------
    secret : bytes
        32 random bytes; never shown.

    Examples
    --------
    >>> key = SecretKey(bytes(32))
    >>> key
    SecretKey()
    >>> key.digest("worker", "5f3a") == key.digest("worker", "5f3b")
    False
    >>> len(key.digest("worker", "5f3a")), len(key.fingerprint)
    (64, 16)
    """

    secret: bytes = field(repr=False)

    def digest(self, purpose: str, *parts: str) -> str:
        """Return the HMAC-SHA-256 of the parts for one purpose, 64 hexadecimal digits."""
        message = "".join(f"{len(part.encode())}:{part}" for part in (purpose, *parts))
        return hmac.new(self.secret, message.encode(), hashlib.sha256).hexdigest()

    @property
    def fingerprint(self) -> str:
        """What tells keys apart without giving them away."""
        return self.digest("fingerprint")[:16]


def read_or_make_key(path: Path, *, may_make: bool = True) -> SecretKey:
    """Return the key kept in a file, made at the first use and readable by its owner alone.

    Parameters
    ----------
    path : Path
    may_make : bool
        Whether a missing file is made.

    Returns
    -------
    SecretKey

    Raises
    ------
    RelightlabError
        If there is no file and none may be made, or the file does not hold a key.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "answers.key"
    >>> read_or_make_key(path) == read_or_make_key(path)
    True
    """
    if may_make:
        _make(path)
    try:
        secret = bytes.fromhex(path.read_text(encoding="ascii").strip())
    except FileNotFoundError as error:
        raise RelightlabError(
            f"expected the key of the database in {path}, which is not there: put the key back"
            " beside the database, or name it with --key"
        ) from error
    except ValueError as error:
        raise RelightlabError(
            f"{path} does not hold a key: expected 64 hexadecimal digits"
        ) from error
    if len(secret) != BYTES:
        raise RelightlabError(f"{path} does not hold a key: expected 64 hexadecimal digits")
    return SecretKey(secret)


def _make(path: Path) -> None:
    # Written aside and linked: whole or absent, and of two processes one wins.
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.name}-{secrets.token_hex(8)}")
    handle = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(handle, "w", encoding="ascii") as stream:
            stream.write(secrets.token_hex(BYTES) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
        os.link(aside, path)
    except FileExistsError:
        return
    finally:
        aside.unlink()
