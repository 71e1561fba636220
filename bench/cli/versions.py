"""The versions that a bug report needs. No plug-in is loaded for them, so that one that is broken hides none."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from bench.plugins import registry

LIBRARIES = ("numpy", "scipy", "numba", "cma", "pandas")


def versions() -> dict[str, str]:
    """Return the versions of this program, Python, libraries, platform, BLAS and the extras' packages, by name."""
    from packaging.requirements import Requirement  # it takes as long as all else that --version needs

    own = registry.own()
    found = {registry.DISTRIBUTION: own.version, "Python": platform.python_version()}
    found |= {name: _installed(name) for name in LIBRARIES}
    found |= {"platform": platform.platform(), "BLAS": _blas()}
    optional = [each for each in map(Requirement, own.requires or ()) if each.marker]
    for extra in own.metadata.get_all("Provides-Extra") or ():
        names = [each.name for each in optional if each.marker and each.marker.evaluate({"extra": extra})]
        found[f"extra {extra}"] = ", ".join(f"{name} {_installed(name)}" for name in names)
    return found


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _blas() -> str:
    try:
        import scipy.linalg  # noqa: F401 - loads the BLAS

        from bench.storage.provenance import blas

        return ", ".join(f"{each['library']} {each['version']}, {each['threads']} threads" for each in blas())
    except ImportError as error:
        return str(error)
