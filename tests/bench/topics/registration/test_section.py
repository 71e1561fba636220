"""The report says whether a registration was followed, or each point that differs."""

from dataclasses import replace

import pytest

from bench import Results
from bench.storage.folder import REGISTRATION, Folder
from bench.study import Entry, Fingerprints
from bench.topics.findings import Findings
from bench.topics.methods.methods import methods
from bench.topics.registration.register import Registered, text_of
from bench.topics.registration.section import section

WHEN = "2026-01-02T03:04:05+00:00"
FOUND = Fingerprints({}, {}, {})


@pytest.fixture
def findings(make, tmp_path):
    """Return a function that writes a study, registered with changes, and returns its findings."""

    def build(changes=None, found=FOUND, began="2026-02-02T00:00:00+00:00", asked=None, **made):
        place = make(tmp_path / "s", record={"started": began}, **made)
        study = replace(Folder(place).study(), **changes or {})
        (place / REGISTRATION).write_text(text_of(Registered(WHEN, study, found)), encoding="utf-8")
        return Findings(Results(place), **asked or {})

    return build


def warnings(findings):
    return section(findings).warnings


def test_a_folder_without_a_registration_has_no_section(make, tmp_path):
    assert section(Findings(Results(make(tmp_path / "s")))) is None


def test_it_was_followed(findings):
    made = findings()
    assert warnings(made) == ()
    assert section(made).text[0] == "The study was registered on 2026-01-02 03:04 UTC. It was made as registered."
    assert section(made).text[0] in " ".join(methods(made).text)


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        ({"changes": {"trials": 9}}, "The field trials is 8; 9 was registered."),
        ({"changes": {"rope": "1%"}}, "The field rope is not set; 1% was registered."),
        ({"asked": {"asked_rope": "2%"}}, "The field rope is 2%; not set was registered."),
        ({"asked": {"asked_subject": "a"}}, "The field subject is a; not set was registered."),
        ({"changes": {"problems": (Entry("any", "p", {}),)}}, "Not registered among the problems: q."),
        (
            {"changes": {"optimizers": tuple(Entry("any", label, {}) for label in "abcd")}},
            "Registered among the optimizers, and not there: d.",
        ),
        (
            {"options": {"b": {"agents": 5}}, "changes": {"optimizers": tuple(Entry("any", on, {}) for on in "abc")}},
            "b is another one than registered: agents = 5, not the default.",
        ),
        (
            {"began": "2026-01-01T00:00:00+00:00"},
            "Trials were made before the registration, in a run that began on 2026-01-01T00:00:00+00:00.",
        ),
        ({"skip": [("p", "a", 7)]}, "1 trial of those registered is missing."),
    ],
)
def test_what_differs_is_named(findings, made, expected):
    built = findings(**made)
    assert warnings(built) == (expected,)
    assert section(built).text[0].endswith("What was run, or is shown here, differs from this in 1 point.")


def test_code_that_changed_after_the_registration_is_named(findings, tmp_path):
    code = {"a": {"a.py": "one"}, "b": {}, "c": {}}
    made = findings()
    study, place = Folder(tmp_path / "s").study(), Folder(tmp_path / "s")
    (place.path / REGISTRATION).write_text(
        text_of(Registered(WHEN, study, FOUND._replace(code=code))), encoding="utf-8"
    )
    assert [each for each in warnings(Findings(made.results)) if "a is another one" in each and "a.py" in each]


def test_nothing_follows_from_an_edited_registration(findings):
    made = findings()
    path = made.results.paths[0] / REGISTRATION
    path.write_text(path.read_text(encoding="utf-8").replace("Seed: 0", "Seed: 1"), encoding="utf-8")
    (sentence,) = warnings(made)
    assert sentence.startswith("Nothing follows from the registration: ")
    assert "was edited after it was written" in sentence


def test_a_selection_was_not_registered(findings):
    results = findings().results.select(problems="p")
    assert warnings(Findings(results)) == ("This page shows a selection, which was not registered.",)
