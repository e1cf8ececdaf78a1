"""URDF texts of small arms."""

from __future__ import annotations

from collections.abc import Iterable


def joint(
    name: str,
    parent: str,
    child: str,
    *,
    kind: str = "revolute",
    xyz: str = "0 0 0",
    axis: str = "0 0 1",
    limit: tuple[float, float] = (-2, 2),
    more: str = "",
) -> str:
    bounds = f'<limit lower="{limit[0]}" upper="{limit[1]}"/>' if kind != "fixed" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{bounds}{more}</joint>'
    )


def urdf(links: Iterable[str], joints: Iterable[str], name: str = "r") -> str:
    declared = "".join(f'<link name="{link}"/>' for link in links)
    return f'<robot name="{name}">{declared}{"".join(joints)}</robot>'
