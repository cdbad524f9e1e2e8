"""The house as a whole: layers, documentation, and what must never be committed."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.repository import PACKAGES, ROOT, committed_files, imports_of, parsed

STOREY = {"shading_model": 0, "datasets": 1, "evaluation": 2, "studies": 2, "reports": 3}
FILES_AND_CLOCKS = {
    "datetime",
    "io",
    "logging",
    "os",
    "pathlib",
    "random",
    "shutil",
    "subprocess",
    "sys",
    "tempfile",
    "time",
}
FILE_CALLS = {"fromfile", "load", "loadtxt", "memmap", "save", "savetxt", "savez"}
LARGEST_FILE = 1_000_000
NUMPYDOC_SECTION = re.compile(
    r"^(Parameters|Returns|Yields|Raises|Notes|Examples|References|See Also)\n-{4,}$", re.MULTILINE
)
# Home folders and roots of one machine, as the start of a path.
MACHINE_PATH = re.compile(rb"(?<![\w.$}~-])/(?:work|root|home|Users|workspace)/\w")


def functions(tree: ast.AST, path: str = "") -> Iterator[tuple[str, ast.FunctionDef, bool]]:
    """Yield the functions of modules and classes: dotted name, node, whether a method."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield path + node.name, node, isinstance(tree, ast.ClassDef)
        elif isinstance(node, ast.ClassDef):
            yield from functions(node, f"{path}{node.name}.")


def is_public(dotted: str) -> bool:
    """Return whether no part of a dotted name starts with an underscore."""
    return not any(part.startswith("_") for part in dotted.split("."))


def raises_own_error(function: ast.FunctionDef) -> bool:
    """Return whether a function's own body raises an error meant for the user."""
    names = {
        node.exc.func.id
        for node in ast.walk(function)
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and isinstance(node.exc.func, ast.Name)
    }
    return bool(names & {"RelightlabError", "unknown_name"})


def is_command(function: ast.FunctionDef) -> bool:
    """Return whether a function is a command or a main, whose docstring is its --help."""
    commands = [ast.unparse(decorator) for decorator in function.decorator_list]
    return function.name == "main" or any("command" in text for text in commands)


def test_imports_point_down() -> None:
    """A package imports only packages below it: never above, never across the two wings."""
    wrong = [
        f"{path} imports {name}"
        for path, tree in parsed(*PACKAGES)
        for name in sorted(imports_of(tree))
        if (package := name.split(".")[0]) in STOREY
        and package != path.parts[0]
        and STOREY[package] >= STOREY[path.parts[0]]
    ]
    assert not wrong, "\n".join(wrong)


def test_packages_do_not_import_their_tests() -> None:
    """What is installed does not need the tests, which are not."""
    imports = {path: imports_of(tree) for path, tree in parsed(*PACKAGES)}
    found = [path for path, names in imports.items() for name in names if name.startswith("tests")]
    assert found == []


def test_ground_floor_has_no_files_and_no_clock() -> None:
    """The shading model imports nothing that reads files, tells the time or draws lots."""
    wrong = [
        f"{path} imports {name}"
        for path, tree in parsed("shading_model")
        for name in sorted(imports_of(tree))
        if name.split(".")[0] in FILES_AND_CLOCKS or name == "importlib.resources"
    ]
    assert not wrong, "\n".join(wrong)


def test_ground_floor_does_not_read_write_or_print() -> None:
    """The shading model calls no open, no print, no NumPy file function, and sets no global."""
    wrong = []
    for path, tree in parsed("shading_model"):
        for node in ast.walk(tree):
            call = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
            on_files = call.startswith("np.") and call.removeprefix("np.") in FILE_CALLS
            if call in {"open", "print", "input"} or on_files or isinstance(node, ast.Global):
                wrong.append(f"{path}:{node.lineno}: {ast.unparse(node)}")
    assert not wrong, "\n".join(wrong)


def test_modules_say_what_they_hold() -> None:
    """Every module that has any code has a docstring."""
    silent = [
        str(path)
        for path, tree in parsed(*PACKAGES, "tests")
        if tree.body and not ast.get_docstring(tree)
    ]
    assert silent == []


def test_public_functions_are_documented() -> None:
    """A public function has a summary and a numpydoc section; a method a summary."""
    wrong = []
    for path, tree in parsed(*PACKAGES):
        for name, node, is_method in functions(tree):
            text = ast.get_docstring(node) or ""
            summary = text.split("\n\n")[0]
            sections = bool(NUMPYDOC_SECTION.search(text)) or is_method or is_command(node)
            if is_public(name) and not (summary.endswith((".", "?")) and sections):
                wrong.append(f"{path}:{node.lineno}: {name}")
    assert not wrong, "\n".join(wrong)


def test_errors_are_documented() -> None:
    """A public function that raises the project's own error says when, under Raises."""
    wrong = [
        f"{path}:{node.lineno}: {name}"
        for path, tree in parsed(*PACKAGES)
        for name, node, _ in functions(tree)
        if is_public(name)
        and raises_own_error(node)
        and not is_command(node)
        and "Raises\n------" not in (ast.get_docstring(node) or "")
    ]
    assert not wrong, "\n".join(wrong)


def test_tests_are_sentences() -> None:
    """Every test says in one sentence what it holds."""
    wrong = [
        f"{path}:{node.lineno}: {name}"
        for path, tree in parsed("tests")
        for name, node, _ in functions(tree)
        if name.split(".")[-1].startswith("test_")
        and not (ast.get_docstring(node) or "").rstrip().endswith(".")
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("text", "is_machine_path"),
    [
        (b"read " + b"/".join([b"", b"root", b"data"]), True),
        (b"open('" + b"/".join([b"", b"home", b"someone"]) + b"')", True),
        (b"../shared/data, a/home/b, ~/work/x", False),
    ],
)
def test_machine_paths_are_recognised(text: bytes, is_machine_path: bool) -> None:
    """The pattern finds absolute paths of one machine and leaves relative ones alone."""
    assert bool(MACHINE_PATH.search(text)) is is_machine_path


def test_no_path_of_one_machine() -> None:
    """No committed file names a folder that only one machine has."""
    found = [
        f"{path.relative_to(ROOT)}: {match.group().decode()}"
        for path in committed_files()
        if (match := MACHINE_PATH.search(path.read_bytes()))
    ]
    assert found == []


def test_no_large_file() -> None:
    """No committed file is so large that every clone would pay for it."""
    sizes = {str(path.relative_to(ROOT)): path.stat().st_size for path in committed_files()}
    assert {name: size for name, size in sizes.items() if size > LARGEST_FILE} == {}


@pytest.mark.real_data
def test_no_file_of_the_measured_set(mit_berkeley_root: Path) -> None:
    """No committed file has the content of a file of the MIT-Berkeley set."""
    sums = (mit_berkeley_root / "SHA256SUMS").read_text(encoding="utf-8")
    theirs = set(re.findall(r"^[0-9a-f]{64}", sums, re.MULTILINE))
    ours = {hashlib.sha256(path.read_bytes()).hexdigest(): path for path in committed_files()}
    assert len(theirs) > 100
    assert [str(ours[digest]) for digest in theirs & set(ours)] == []
