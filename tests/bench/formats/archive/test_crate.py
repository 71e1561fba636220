"""The description of an archive against RO-Crate 1.1, https://www.researchobject.org/ro-crate/specification/1.1/."""

import hashlib
import json
from datetime import date, datetime
from importlib.metadata import version
from urllib.parse import unquote

import pytest

from bench import BenchError, Study
from bench.formats.archive.contents import PackedFile
from bench.formats.archive.crate import UNSTATED, describe, stated

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
TERMS = {
    "CreativeWork", "Dataset", "File", "Person", "Organization", "SoftwareApplication", "CreateAction",
    "about", "agent", "author", "conformsTo", "contentSize", "dateCreated", "dateModified", "datePublished",
    "description", "encodingFormat", "endTime", "hasPart", "identifier", "instrument", "license", "mentions", "name",
    "object", "result", "startTime", "url", "version",
}  # fmt: skip
"""The terms of the context of RO-Crate 1.1 that an archive may use."""


@pytest.fixture(scope="module")
def crate(content):
    return json.loads(content["ro-crate-metadata.json"])


@pytest.fixture(scope="module")
def graph(crate):
    return {entity["@id"]: entity for entity in crate["@graph"]}


def made(environments=(), **credits):
    study = Study.from_dict(
        {"name": "s", "trials": 1, "budget": 9, "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "early"}]}
    )
    files = [PackedFile("trials.sqlite", 3, "0" * 64)]
    found = describe(study, files, environments, trials=1, fallback_date="2026-01-02T03:04:05+00:00", **credits)
    return {entity["@id"]: entity for entity in found["@graph"]}


def values(entity):
    """Yield every single value of an entity's properties."""
    for key, value in entity.items():
        if not key.startswith("@"):
            yield from value if isinstance(value, list) else [value]


# what the specification calls MUST


def test_the_graph_is_flat_json_ld(crate):
    """Appendix RO-Crate JSON-LD: all entities in @graph; a property refers by an object with @id as its only key."""
    assert set(crate) == {"@context", "@graph"}
    identifiers = [entity["@id"] for entity in crate["@graph"]]
    assert len(set(identifiers)) == len(identifiers)
    for entity in crate["@graph"]:
        assert isinstance(entity["@type"], str)
        for value in values(entity):
            assert isinstance(value, str) or list(value) == ["@id"]


def test_the_descriptor_refers_to_the_root(graph):
    """Root Data Entity: a descriptor of this @id and of type CreativeWork, whose about is the root."""
    descriptor = graph["ro-crate-metadata.json"]
    assert descriptor["@type"] == "CreativeWork"
    assert descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}


def test_the_root_has_the_properties_that_it_must_have(graph):
    root = graph["./"]
    assert root["@type"] == "Dataset"
    assert root["name"] == "A small study"
    assert "120 trials of 2 optimizers on 2 problems, 60 evaluations a trial" in root["description"]
    assert date.fromisoformat(root["datePublished"])
    assert root["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}


def test_files_are_linked_from_the_root_and_are_in_the_archive(graph, content):
    """Data Entities: linked by hasPart, of type File, with a URI path relative to the root."""
    files = {name for name, entity in graph.items() if entity["@type"] == "File"}
    assert files == {each["@id"] for each in graph["./"]["hasPart"]}
    assert {unquote(name) for name in files} == content.keys() - {"ro-crate-metadata.json"}


# what it recommends, and what this harness adds


def test_terms_are_those_of_the_context_or_are_defined(crate):
    context, own = crate["@context"]
    assert context == CONTEXT
    used = {key for entity in crate["@graph"] for key in entity if not key.startswith("@")}
    assert used | {entity["@type"] for entity in crate["@graph"]} <= TERMS | own.keys()


def test_lists_have_more_than_one_value(crate):
    assert all(len(value) > 1 for entity in crate["@graph"] for value in entity.values() if isinstance(value, list))


def test_what_is_referred_to_is_described(graph):
    referred = {value["@id"] for entity in graph.values() for value in values(entity) if isinstance(value, dict)}
    assert referred - graph.keys() == {"https://w3id.org/ro/crate/1.1"}


def test_files_have_size_hash_and_format(graph, content):
    for name in content.keys() - {"ro-crate-metadata.json", "SHA256SUMS"}:
        assert graph[name]["contentSize"] == str(len(content[name]))
        assert graph[name]["sha256"] == hashlib.sha256(content[name]).hexdigest()
    assert graph["trials.sqlite"]["encodingFormat"] == "application/vnd.sqlite3"


def test_a_run_is_described_with_its_software_and_times():
    record = {"started": "2026-01-01T00:00:00+00:00", "ended": "2026-01-03T00:00:00+00:00", "command": "bench run s"}
    graph = made(environments=[record | {"packages": {"cma": version("cma"), "nowhere": "9"}}])
    assert graph["#run-1"]["instrument"] == [{"@id": f"#cma-{version('cma')}"}, {"@id": "#nowhere-9"}]
    assert datetime.fromisoformat(graph["#run-1"]["endTime"]).day == 3
    assert graph["./"]["dateCreated"] == record["started"]
    assert graph["./"]["datePublished"] == "2026-01-03"
    assert "BSD-3-Clause" in json.dumps(graph[f"#cma-{version('cma')}"]["license"])
    assert graph["#nowhere-9"].keys() == {"@id", "@type", "name", "version"}


@pytest.mark.parametrize("record", [{}, {"started": "yesterday", "ended": None, "packages": [1]}])
def test_a_record_without_dates_leaves_that_of_the_study(record):
    assert made(environments=[record])["./"]["datePublished"] == "2026-01-02"


@pytest.mark.parametrize(
    ("text", "licence"),
    [
        ("", UNSTATED),
        ("MIT", {"@id": "https://spdx.org/licenses/MIT"}),
        ("MIT OR Apache-2.0", "MIT OR Apache-2.0"),
        ("LicenseRef-1", "LicenseRef-1"),
        ("https://example.org/terms", {"@id": "https://example.org/terms"}),
        ("Ask us before you use it.", "Ask us before you use it."),
    ],
)
def test_a_licence_is_an_address_where_it_has_one(text, licence):
    graph = made(licence=text)
    assert graph["./"]["license"] == licence
    assert isinstance(licence, str) or graph[licence["@id"]]["name"] == text


@pytest.mark.parametrize(
    ("text", "licence"),
    [
        ("", ""),
        ("cc-by-4.0", "CC-BY-4.0"),
        (" MIT or apache-2.0 ", "MIT OR Apache-2.0"),
        ("https://example.org/terms", "https://example.org/terms"),
    ],
)
def test_a_licence_is_stated_in_the_letters_of_spdx(text, licence):
    assert stated(text) == licence


def test_an_author_may_have_an_orcid():
    graph = made(authors=("Ada Lovelace (https://orcid.org/0000-0002-1825-0097)", "A. N. Other"))
    assert graph["https://orcid.org/0000-0002-1825-0097"]["name"] == "Ada Lovelace"
    assert graph["#A.%20N.%20Other"]["@type"] == "Person"
    with pytest.raises(BenchError, match="names no author"):
        made(authors=("0000-0002-1825-0097",))
