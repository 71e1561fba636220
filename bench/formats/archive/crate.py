"""The description of an archive as an RO-Crate 1.1 (https://w3id.org/ro/crate/1.1), flattened JSON-LD."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from importlib.metadata import PackageNotFoundError, metadata
from typing import Any
from urllib.parse import quote

from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression

from bench.errors import BenchError
from bench.formats.archive.contents import CRATE, SUMS, PackedFile
from bench.storage.folder import STUDY
from bench.storage.store import FILE as TRIALS
from bench.study import Study

PROFILE = "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{PROFILE}/context", {"sha256": "http://schema.org/sha256"}]  # a term younger than the context
UNSTATED = "No licence is stated; ask the authors before you use or share these results."

Entity = dict[str, Any]

DESCRIPTOR: Entity = {
    "@id": CRATE,
    "@type": "CreativeWork",
    "conformsTo": {"@id": PROFILE},
    "about": {"@id": "./"},
    "description": "Describes the files of this archive, and what made them.",
}

_ORCID = re.compile(r"(.*?)[\s(<]*(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])[)>]*")


def describe(
    study: Study,
    files: Sequence[PackedFile],
    environments: Sequence[Mapping[str, Any]],
    *,
    trials: int,
    fallback_date: str,
    licence: str = "",
    authors: Sequence[str] = (),
) -> Entity:
    """Return the description of an archive, to be written as JSON.

    Args:
        study: the frozen study.
        files: the payload.
        environments: the records of the runs that made the trials, oldest first.
        trials: the number of stored trials.
        fallback_date: the date, ISO 8601, where no record has one.
        licence: how the results may be used, as :func:`stated` returns it.
        authors: names of those who made them, each with an ORCID behind it where there is one.

    Raises:
        BenchError: where an author has no name.
    """
    people = [_person(author) for author in authors]
    terms, about_terms = _licence(licence)
    dates = _dates(environments) or [fallback_date]
    described = list(_software(environments))
    software = [entity for entity, _ in described]
    actions = [_action(number, record, software, people) for number, record in enumerate(environments, start=1)]
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": study.title or study.name,
        "description": (
            f"Results of the study {study.name!r}: {trials:,} trials of {len(study.optimizers):,} optimizers "
            f"on {len(study.problems):,} problems, {study.budget_words} a trial."
        ),
        "identifier": study.identity(),
        "dateCreated": dates[0],
        "dateModified": dates[-1],
        "datePublished": dates[-1][:10],
        "license": terms,
        **_links("author", people),
        **_links("mentions", actions),
        "hasPart": [{"@id": quote(file.name)} for file in files] + [{"@id": SUMS}],
    }
    sums = {
        "@id": SUMS,
        "@type": "File",
        "name": "Checksums",
        "description": "The SHA-256 of every other file; 'sha256sum --check' reads it.",
        "encodingFormat": "text/plain",
    }
    graph = [DESCRIPTOR, root, *map(_file, files), sums, *about_terms, *people]
    graph += [*actions, *software, *(entity for _, makers in described for entity in makers)]
    return {"@context": CONTEXT, "@graph": list({entity["@id"]: entity for entity in graph}.values())}


def listed(crate: object) -> dict[str, str]:
    """Return the SHA-256 of every file that a description lists, by path; empty where it is malformed."""
    graph = crate.get("@graph") if isinstance(crate, dict) else None
    entities = [entity for entity in graph if isinstance(entity, dict)] if isinstance(graph, list) else []
    files = [entity for entity in entities if entity.get("@type") == "File" and "sha256" in entity]
    return {str(file.get("@id")): str(file["sha256"]) for file in files}


def _dates(environments: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return when runs began and ended, as far as it is noted in ISO 8601, oldest first."""
    dates = []
    for text in (record.get(key) for record in environments for key in ("started", "ended")):
        with suppress(TypeError, ValueError):
            datetime.fromisoformat(text)  # type: ignore[arg-type]  # records of other versions may hold anything
            dates.append(str(text))
    return sorted(dates)


def _file(file: PackedFile) -> Entity:
    name, description = file.about
    return {
        "@id": quote(file.name),
        "@type": "File",
        "name": name,
        "description": description,
        "contentSize": str(file.size),
        "encodingFormat": file.media_type,
        "sha256": file.sha256,
    }


def _links(key: str, entities: Sequence[Entity]) -> Entity:
    """Return a key that refers to entities, none where there are none; a single one stands without a list."""
    links = [{"@id": entity["@id"]} for entity in entities]
    return {key: links[0] if len(links) == 1 else links} if links else {}


# people and licences


def _person(text: str) -> Entity:
    match = _ORCID.fullmatch(text.strip())
    name = " ".join((match[1] if match else text).split())
    if not name:
        raise BenchError(f"{text!r} names no author; write as in --author 'Ada Lovelace 0000-0002-1825-0097'")
    return {"@id": f"https://orcid.org/{match[2]}" if match else f"#{quote(name)}", "@type": "Person", "name": name}


def stated(licence: str) -> str:
    """Return a licence as an archive states it, identifiers in SPDX's own letters; raises BenchError for another text.

    Args:
        licence: an expression of SPDX identifiers, a URL, or "" for none.
    """
    text = licence.strip()
    if not text or text.startswith(("https://", "http://")):
        return text
    if expression := _spdx(text):
        return expression
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
    elif re.fullmatch(r"(?!LicenseRef-)\S+", identifier := _spdx(text)):  # neither an expression nor one's own
        address = f"https://spdx.org/licenses/{identifier}"
    else:
        return text, []
    about = f"The licence {text}; its text is at {address}"
    return {"@id": address}, [{"@id": address, "@type": "CreativeWork", "name": text, "description": about}]


# software and runs


def _software(environments: Sequence[Mapping[str, Any]]) -> Iterator[tuple[Entity, list[Entity]]]:
    """Yield an entity for each version of each package that the runs used, and those of its author and licence."""
    versions: dict[tuple[str, str], None] = {}
    for record in environments:
        versions |= dict.fromkeys(_used(record))
    for name, version in versions:
        about = _installed(name, version)
        words, author = ((about.get(key) or "").strip() for key in ("license", "author"))
        short = words if len(words) <= 100 and "\n" not in words else ""  # older packages give the whole text there
        licence, about_licence = _licence((about.get("license_expression") or short).strip())
        people = [{"@id": f"#author-{quote(author)}", "@type": "Organization", "name": author}] if author else []
        entity = {
            "@id": f"#{quote(f'{name}-{version}')}",
            "@type": "SoftwareApplication",
            "name": name,
            "version": version,
            **({"license": licence} if licence != UNSTATED else {}),
            **_links("author", people),
        }
        yield entity, [*about_licence, *people]


def _used(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return name and version of Python and of every package that a run used, as far as they are noted."""
    packages = record.get("packages")
    python = {"Python": record["python"]} if record.get("python") else {}
    versions = {**python, **(packages if isinstance(packages, Mapping) else {})}
    return [(str(name), str(version)) for name, version in versions.items()]


def _installed(name: str, version: str) -> Mapping[str, Any]:
    """Return the metadata of a package, empty where this very version is not installed here."""
    try:
        about = metadata(name).json
    except (PackageNotFoundError, ValueError):
        return {}
    return about if about.get("version") == version else {}


def _action(number: int, record: Mapping[str, Any], software: Sequence[Entity], authors: Sequence[Entity]) -> Entity:
    """Return the entity of a run, which made trials with software from the study."""
    used = _used(record)
    return {
        "@id": f"#run-{number}",
        "@type": "CreateAction",
        "name": f"Run {number}",
        **({"description": str(record["command"])} if record.get("command") else {}),
        **({"startTime": str(record["started"])} if _dates([{"started": record.get("started")}]) else {}),
        **({"endTime": str(record["ended"])} if _dates([{"ended": record.get("ended")}]) else {}),
        **_links("instrument", [entity for entity in software if (entity["name"], entity["version"]) in used]),
        **_links("agent", authors),
        "object": {"@id": STUDY},
        "result": {"@id": TRIALS},
    }
