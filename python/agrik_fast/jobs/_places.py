"""Which store a path or a URL means."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any

from ._folder_store import FolderStore
from ._object_store import ObjectStore
from ._store import Store


def is_url(place: str) -> bool:
    """Return whether a place is no path of the file system."""
    return "://" in place


def open_store(
    place: str | PathLike[str], storage_options: Mapping[str, Any] | None = None
) -> Store:
    """Return the store at a path or a URL.

    Parameters
    ----------
    place : str or path
        A folder, or a URL that fsspec knows (``s3://bucket/results``; extra `objects`).
    storage_options : mapping, optional
        What fsspec's file system is made with: endpoint, keys.

    Raises
    ------
    JobError
        fsspec, or what it needs for the URL, is missing.

    Examples
    --------
    >>> from agrik_fast.jobs import open_store
    >>> from pathlib import Path
    >>> store = open_store("stored")
    >>> type(store).__name__
    'FolderStore'
    """
    text = fspath(place)
    if text.startswith("file://"):
        text = text.removeprefix("file://")
    if not is_url(text):
        return FolderStore(text)
    return ObjectStore(text.rstrip("/"), tuple(sorted((storage_options or {}).items())))
