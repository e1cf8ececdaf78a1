"""Where robots come from: names of the package, of other packages, and files."""

from __future__ import annotations

import codecs
import contextlib
import importlib
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._files import brief, decode, read_bytes, reading
from ..errors import AgrikError, ArgumentError, MissingExtraError, UnknownNameError, UrdfError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["Source", "find", "names", "urdf_text"]

BUNDLED = Path(__file__).resolve().parent / "bundled"
ENTRY_POINTS = "agrik_fast.robots"
"""Group of entry points by which packages name robots of theirs."""

# The core has the same limit for texts.
_URDF_BYTES = 16 << 20
_SUFFIXES = (".toml", ".urdf", ".xml", ".xacro")
# Names of the package robot_descriptions, which are names of modules.
_DESCRIPTION = re.compile(r"[a-z0-9_]+_description")
_DECLARED = re.compile(rb"""<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z][\w.:-]*)["']""")
_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


@dataclass(frozen=True)
class Source:
    """A robot's description before it is read.

    Attributes
    ----------
    path : path, optional
        A robot file in TOML.
    urdf : str, optional
        The text of a URDF, if it is none.
    name : str
        What messages call it; empty for a text.
    is_bundled : bool
        The file is the package's own.
    folder : path, optional
        Where meshes are looked for.
    """

    path: Path | None
    urdf: str | None
    name: str
    is_bundled: bool = False
    folder: Path | None = None


def bundled_names() -> tuple[str, ...]:
    """Return the names of the robots in the package, sorted."""
    return tuple(sorted(path.stem for path in BUNDLED.glob("*.toml")))


def _installed() -> dict[str, EntryPoint]:
    """Return the robots of other packages; a bundled robot's name stays the bundled one's."""
    # It takes a while to import, and bundled robots do not need it.
    from importlib.metadata import entry_points

    return {point.name: point for point in entry_points(group=ENTRY_POINTS)}


def names() -> tuple[str, ...]:
    """Return the names of all robots that are installed, sorted."""
    return tuple(sorted({*bundled_names(), *_installed()}))


def find(given: object) -> Source:
    """Return the description meant by a robot's name, a path or a URDF's text.

    Raises
    ------
    UnknownNameError
        No robot has that name.
    ArgumentError
        The path leads to no file of a known kind, or `given` is neither name nor path.
    UrdfError
        The URDF or xacro file cannot be read.
    """
    text = _text(given, "name_or_path", "a robot's name, a path or a URDF's text")
    if isinstance(text, Source):
        return text
    path = Path(text)
    if isinstance(given, PathLike) or path.suffix or path.name != text:
        return _of_path(path)
    return _of_name(text)


def find_urdf(given: object) -> Source:
    """Return the URDF meant by a path, whatever its suffix, or by its text.

    Raises
    ------
    ArgumentError
        The path leads to no file.
    UrdfError
        The file cannot be read.
    """
    expected = "the path of an existing URDF, or its text"
    text = _text(given, "path_or_text", expected)
    if isinstance(text, Source):
        return text
    path = Path(text)
    if not path.is_file():
        raise ArgumentError("path_or_text", f"{text!r}, which is no file", expected)
    return Source(None, urdf_text(path), path.name, folder=path.parent)


def _text(given: object, argument: str, expected: str) -> str | Source:
    """Return a name or path as text, or the URDF if that is what it holds."""
    if isinstance(given, bytes) and b"<" in given:
        return Source(None, _xml(given, UrdfError), "")
    if not isinstance(given, (str, bytes, PathLike)):
        raise ArgumentError(argument, _kind(given), expected)
    text = os.fsdecode(given)
    return Source(None, text, "") if "<" in text else text


def _kind(value: object) -> str:
    return f"a {type(value).__name__}"


def _of_name(name: str) -> Source:
    if name in bundled_names():
        return Source(BUNDLED / f"{name}.toml", None, f"{name}.toml", is_bundled=True)
    points = _installed()
    if name in points:
        return _of_path(_entry(points[name]))
    if _DESCRIPTION.fullmatch(name):
        return _of_description(name)
    raise UnknownNameError("robot", name, names())


def _entry(point: EntryPoint) -> Path:
    """Return the path that an entry point leads to: a path, or a function that returns one."""
    place = f"the entry point {point.name!r} ({point.value})"

    def refuse(reason: str) -> AgrikError:
        return ArgumentError("name_or_path", f"{place}, which {reason}", "one that leads to a file")

    # Whatever the other package does: it is named.
    try:
        value = point.load()
        value = value() if callable(value) else value
    except Exception as error:
        raise refuse(f"cannot be loaded: {brief(error)}") from error
    try:
        return Path(value)
    except TypeError:
        raise refuse(f"gives {_kind(value)}, no path") from None


def _of_path(path: Path) -> Source:
    suffix = path.suffix.lower()
    if suffix not in _SUFFIXES:
        known = ", ".join(_SUFFIXES)
        raise ArgumentError("name_or_path", repr(str(path)), f"a robot's name or a {known} file")
    if not path.is_file():
        raise ArgumentError("name_or_path", f"{str(path)!r}, which is no file", "an existing file")
    if suffix == ".toml":
        return Source(path, None, path.name)
    return Source(None, urdf_text(path), path.name, folder=path.parent)


def urdf_text(path: Path, arguments: dict[str, str] | None = None) -> str:
    """Return the text of a URDF file; a xacro file is expanded first.

    Raises
    ------
    UrdfError
        The file cannot be read, is not in the encoding that it declares, or its macros have
        faults.
    """

    def refuse(reason: str) -> UrdfError:
        return UrdfError(f"{path.name}: {reason}")

    if path.suffix.lower() == ".xacro":
        return _expanded(path, arguments or {}, refuse)
    return _xml(read_bytes(path, refuse, _URDF_BYTES), refuse)


def _xml(data: bytes, refuse: Callable[[str], AgrikError]) -> str:
    """Return an XML text by its own word on how it is encoded (XML 1.0, 4.3.3)."""
    encoding = next((name for mark, name in _BOMS if data.startswith(mark)), None)
    if encoding is None:
        encoding = _without_mark(data)
    if encoding is None:
        declared = _DECLARED.match(data.lstrip())
        encoding = declared[1].decode("ascii") if declared else "utf-8"
    try:
        if codecs.lookup(encoding).name == "utf-8":
            return decode(data, refuse)
        return data.decode(encoding)
    except (LookupError, UnicodeError) as error:
        raise refuse(f"is not text in {encoding}, which it says it is: {brief(error)}") from None


def _without_mark(data: bytes) -> str | None:
    """Return the wide encoding that a text without a byte order mark begins in."""
    for start, encoding in ((b"<\0", "utf-16-le"), (b"\0<", "utf-16-be")):
        if data.startswith(start):
            return encoding
    return None


def _expanded(path: Path, arguments: dict[str, str], refuse: Callable[[str], UrdfError]) -> str:
    try:
        from xacrodoc import XacroDoc
    except ImportError:
        raise MissingExtraError("xacro files", "xacro") from None
    with reading(refuse, "cannot be expanded"):
        # The folders above the file are searched for the packages that it names.
        document = XacroDoc.from_file(str(path), subargs=arguments, resolve_packages=False)
        text: str = document.to_urdf_string()
    return text


def _of_description(name: str) -> Source:
    try:
        importlib.import_module("robot_descriptions")
    except ImportError:
        raise MissingExtraError(f"the robot {name!r}", "descriptions") from None

    def refuse(reason: str) -> UrdfError:
        return UrdfError(f"{name}: {reason}")

    with _quiet(), reading(refuse, "cannot be had from robot_descriptions"):
        try:
            module: Any = importlib.import_module(f"robot_descriptions.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"robot_descriptions.{name}":
                raise
            known = importlib.import_module("robot_descriptions._descriptions").DESCRIPTIONS
            raise UnknownNameError("robot", name, sorted({*names(), *known})) from None
    for attribute in ("URDF_PATH", "XACRO_PATH"):
        path = getattr(module, attribute, None)
        if path is not None:
            text = urdf_text(Path(path), dict(getattr(module, "XACRO_ARGS", {})))
            return Source(None, text, name, folder=Path(path).parent)
    raise refuse("has no URDF, only other kinds of file")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what the package prints while it downloads from standard output."""
    with contextlib.redirect_stdout(None):
        yield
