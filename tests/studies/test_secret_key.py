"""The key of a database: made once, kept private, and never two for one file."""

from __future__ import annotations

import hashlib
import hmac
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.secret_key import SecretKey, read_or_make_key


def test_digests_are_hmacs_of_unmistakable_parts() -> None:
    """The digest is HMAC-SHA-256 over parts with their lengths, so that no two lists agree."""
    key = SecretKey(bytes(32))
    expected = hmac.new(bytes(32), b"6:worker1:a2:bc", hashlib.sha256).hexdigest()
    assert key.digest("worker", "a", "bc") == expected
    assert key.digest("worker", "ab", "c") != expected
    assert key.digest("worker", "a", "b", "c") != expected


def test_the_secret_is_not_shown() -> None:
    """Neither the key's text nor its fingerprint has the secret in it."""
    key = SecretKey(bytes([171] * 32))
    assert "ab" * 4 not in repr(key) + key.fingerprint
    assert str(bytes([171] * 4)) not in repr(key)


def test_a_key_is_made_once_and_for_the_owner_alone(tmp_path: Path) -> None:
    """Many who want the same new key at once get the same one, readable by nobody else."""
    path = tmp_path / "folder" / "a.key"
    with ThreadPoolExecutor(8) as pool:
        keys = set(pool.map(lambda _: read_or_make_key(path).secret, range(16)))
    assert len(keys) == 1
    assert path.stat().st_mode & 0o777 == 0o600
    assert [one.name for one in path.parent.iterdir()] == ["a.key"]


@pytest.mark.parametrize("text", ["", "xyz", "ab" * 31, "ab" * 33, "\xff"])
def test_what_is_no_key_is_told(tmp_path: Path, text: str) -> None:
    """A file with anything but 64 hexadecimal digits is no key."""
    path = tmp_path / "a.key"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(RelightlabError, match="expected 64 hexadecimal digits"):
        read_or_make_key(path)


def test_a_missing_key_is_not_made_up(tmp_path: Path) -> None:
    """Where a key must be there, a missing one is told and none is made."""
    with pytest.raises(RelightlabError, match="which is not there"):
        read_or_make_key(tmp_path / "a.key", may_make=False)
    assert list(tmp_path.iterdir()) == []
