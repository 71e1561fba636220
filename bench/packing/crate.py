"""The description of an archive as an RO-Crate 1.1 (https://w3id.org/ro/crate/1.1), flattened JSON-LD."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import PackageNotFoundError, metadata
from typing import Any
from urllib.parse import quote

from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression

from bench.errors import BenchError
from bench.packing.contents import CRATE, SUMS, PackedFile
from bench.storage.folder import STUDY
from bench.storage.store import FILE as TRIALS
from bench.study import Study

PROFILE = "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{PROFILE}/context", {"sha256": "http://schema.org/sha256"}]  # a term younger than the context
UNSTATED = "No licence is stated; ask the authors before you use or share these results."

Entity = dict[str, Any]

_ORCID = re.compile(r"(.*?)[\s(<]*(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])[)>]*")


@dataclass(frozen=True)
class Credits:
    """Who made the results and how they may be used, as far as it is stated.

    Attributes:
        licence: as :func:`stated` returns it.
        authors: names, each with an ORCID behind it where there is one.
    """

    licence: str = ""
    authors: tuple[str, ...] = field(default=())


def describe(
    study: Study,
    files: Sequence[PackedFile],
    environments: Sequence[Mapping[str, Any]],
    *,
    trials: int,
    fallback_date: str,
    credits: Credits,
) -> Entity:
    """Return the description of an archive, to be written as JSON.

    Args:
        study: the frozen study.
        files: the payload.
        environments: the records of the runs that made the trials, oldest first.
        trials: the number of stored trials.
        fallback_date: the date, ISO 8601, where no record has one.
        credits: authors and licence.

    Raises:
        BenchError: where an author has no name.
    """
    authors = [_person(each) for each in credits.authors]
    licence, about_licence = _licence(credits.licence)
    dates = _dates(environments) or [fallback_date]
    found = list(_software(environments))
    software = [entity for entity, _ in found]
    actions = [_action(number, each, software, authors) for number, each in enumerate(environments, start=1)]
    controls = f" and {len(study.controls):,} controls" if study.controls else ""
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": study.title or study.name,
        "description": (
            f"Results of the study {study.name!r}: {trials:,} trials of {len(study.optimizers):,} optimizers{controls} "
            f"on {len(study.problems):,} problems, {study.budget_words} a trial."
        ),
        "identifier": study.identity(),
        "dateCreated": dates[0],
        "dateModified": dates[-1],
        "datePublished": dates[-1][:10],
        "license": licence,
        **({"author": _one_or_all(map(_link, authors))} if authors else {}),
        **({"mentions": _one_or_all(map(_link, actions))} if actions else {}),
        "hasPart": [{"@id": _identifier(each.name)} for each in files] + [{"@id": SUMS}],
    }
    sums = {
        "@id": SUMS,
        "@type": "File",
        "name": "Checksums",
        "description": "The SHA-256 of every other file; 'sha256sum --check' reads it.",
        "encodingFormat": "text/plain",
    }
    graph = [_descriptor(), root, *map(_file, files), sums, *about_licence, *authors]
    graph += [*actions, *software, *(each for _, others in found for each in others)]
    return {"@context": CONTEXT, "@graph": list({each["@id"]: each for each in graph}.values())}


def listed(crate: object) -> dict[str, str]:
    """Return the SHA-256 of every file that a description lists, by path; empty where it is malformed."""
    graph = crate.get("@graph") if isinstance(crate, dict) else None
    entities = [each for each in graph if isinstance(each, dict)] if isinstance(graph, list) else []
    files = [each for each in entities if each.get("@type") == "File" and "sha256" in each]
    return {str(each.get("@id")): str(each["sha256"]) for each in files}


def _dates(environments: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return when runs began and ended, as far as it is noted in ISO 8601, oldest first."""
    found = []
    for text in (record.get(key) for record in environments for key in ("started", "ended")):
        with suppress(TypeError, ValueError):
            datetime.fromisoformat(text)  # type: ignore[arg-type]  # records of other versions may hold anything
            found.append(str(text))
    return sorted(found)


def _descriptor() -> Entity:
    return {
        "@id": CRATE,
        "@type": "CreativeWork",
        "conformsTo": {"@id": PROFILE},
        "about": {"@id": "./"},
        "description": "Describes the files of this archive, and what made them.",
    }


def _file(each: PackedFile) -> Entity:
    name, description = each.about
    return {
        "@id": _identifier(each.name),
        "@type": "File",
        "name": name,
        "description": description,
        "contentSize": str(each.size),
        "encodingFormat": each.media_type,
        "sha256": each.sha256,
    }


def _identifier(name: str) -> str:
    return quote(name)


def _link(entity: Entity) -> Entity:
    return {"@id": entity["@id"]}


def _one_or_all(values: Any) -> Any:
    """Return the values as compacted JSON-LD has them: a single one stands without a list."""
    found = list(values)
    return found[0] if len(found) == 1 else found


# people and licences


def _person(text: str) -> Entity:
    found = _ORCID.fullmatch(text.strip())
    name = " ".join((found[1] if found else text).split())
    if not name:
        raise BenchError(f"{text!r} names no author; write as in --author 'Ada Lovelace 0000-0002-1825-0097'")
    return {"@id": f"https://orcid.org/{found[2]}" if found else f"#{quote(name)}", "@type": "Person", "name": name}


def stated(licence: str) -> str:
    """Return a licence as an archive states it, identifiers in SPDX's own letters; raises BenchError for another text.

    Args:
        licence: an expression of SPDX identifiers, a URL, or "" for none.
    """
    text = licence.strip()
    if not text or text.startswith(("https://", "http://")):
        return text
    if known := _spdx(text):
        return known
    raise BenchError(
        f"the licence {licence!r} is no SPDX identifier, such as CC-BY-4.0 or MIT; take one of "
        "https://spdx.org/licenses, or give the URL of your terms"
    )


def _spdx(text: str) -> str:
    """Return an expression of SPDX identifiers in SPDX's own letters, "" for another text."""
    try:
        return str(canonicalize_license_expression(text))
    except InvalidLicenseExpression:
        return ""


def _licence(text: str) -> tuple[Any, list[Entity]]:
    """Return the value of a licence, and the entity that describes it where it has an address."""
    if not text.strip():
        return UNSTATED, []
    if text.startswith(("https://", "http://")):
        address = text
    elif re.fullmatch(r"(?!LicenseRef-)\S+", known := _spdx(text)):  # neither an expression nor one's own
        address = f"https://spdx.org/licenses/{known}"
    else:
        return text, []
    about = f"The licence {text}; its text is at {address}"
    return {"@id": address}, [{"@id": address, "@type": "CreativeWork", "name": text, "description": about}]


# software and runs


def _software(environments: Sequence[Mapping[str, Any]]) -> Iterator[tuple[Entity, list[Entity]]]:
    """Yield an entity for each version of each package that the runs used, and those of its author and licence."""
    versions: dict[tuple[str, str], None] = {}
    for record in environments:
        python = {"Python": record["python"]} if record.get("python") else {}
        packages = record.get("packages")
        own = packages if isinstance(packages, Mapping) else {}
        versions |= dict.fromkeys((str(name), str(version)) for name, version in {**python, **own}.items())
    for name, version in versions:
        about = _installed(name, version)
        words, author = ((about.get(key) or "").strip() for key in ("license", "author"))
        short = words if len(words) <= 100 and "\n" not in words else ""  # older packages give the whole text there
        licence, known = _licence((about.get("license_expression") or short).strip())
        person = {"@id": f"#author-{quote(author)}", "@type": "Organization", "name": author}
        entity = {
            "@id": f"#{quote(f'{name}-{version}')}",
            "@type": "SoftwareApplication",
            "name": name,
            "version": version,
            **({"license": licence} if licence != UNSTATED else {}),
            **({"author": _link(person)} if author else {}),
        }
        yield entity, [*known, *([person] if author else [])]


def _installed(name: str, version: str) -> Mapping[str, Any]:
    """Return the metadata of a package, empty where this very version is not installed here."""
    try:
        found = metadata(name).json
    except (PackageNotFoundError, ValueError):
        return {}
    return found if found.get("version") == version else {}


def _action(number: int, record: Mapping[str, Any], software: Sequence[Entity], authors: Sequence[Entity]) -> Entity:
    """Return the entity of a run, which made trials with software from the study."""
    packages = record.get("packages")
    used = {"Python": record.get("python"), **(packages if isinstance(packages, Mapping) else {})}
    own = [entity for entity in software if str(used.get(entity["name"])) == entity["version"]]
    return {
        "@id": f"#run-{number}",
        "@type": "CreateAction",
        "name": f"Run {number}",
        **({"description": str(record["command"])} if record.get("command") else {}),
        **({"startTime": str(record["started"])} if _dates([{"started": record.get("started")}]) else {}),
        **({"endTime": str(record["ended"])} if _dates([{"ended": record.get("ended")}]) else {}),
        **({"instrument": _one_or_all(map(_link, own))} if own else {}),
        **({"agent": _one_or_all(map(_link, authors))} if authors else {}),
        "object": {"@id": STUDY},
        "result": {"@id": TRIALS},
    }
