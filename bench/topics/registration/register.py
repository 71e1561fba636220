"""The registration of a study: a dated text of what will be compared by which tests, and the data to hold it to.

The text ends with the hash of all that stands above it. So an edit is noticed; forgery is not prevented, as whoever can
write the text can write its hash. Only a copy elsewhere proves the date.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import tomli_w
from jinja2 import Environment, PackageLoader, StrictUndefined

from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.helpers.parsing import parse_toml, read_text
from bench.plugins.registry import own
from bench.report.prose import speaker
from bench.report.wording import count
from bench.storage.folder import REGISTRATION, Folder
from bench.storage.provenance import now
from bench.study import Fingerprints, Study
from bench.topics.trials.design import design, foreseen
from bench.topics.verdict.winner import winner_rule

SEAL = "\nSHA-256 of all lines above: "
FENCE = "```"


class Registered(NamedTuple):
    """A study as it was registered: when (UTC, ISO 8601), and with which data and code."""

    when: str
    study: Study
    found: Fingerprints

    @property
    def date(self) -> str:
        """The moment for readers, such as ``"2026-11-26 06:30 UTC"``."""
        return f"{self.when[:16].replace('T', ' ')} UTC"


def register(study: Study, found: Fingerprints, output: Path) -> Path:
    """Write the registration of a study into its folder, before the first trial, and return its path.

    Raises:
        BenchError: where the folder holds trials or a registration already, or cannot be written.
    """
    folder, path = Folder(output), output / REGISTRATION
    if folder.store.exists and any(folder.store.trials().values()):
        raise BenchError(f"{output} holds trials already, and what is registered after them may follow the results")
    if path.exists():
        raise BenchError(
            f"{path} is there already, and a registration is never replaced; give another --output, or remove it and "
            "say so"
        )
    try:
        output.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            temporary.write_text(text_of(Registered(now(), study, found)), encoding="utf-8")
    except OSError as error:
        raise BenchError(f"{path} cannot be written: {error.strerror}") from error
    return path


def text_of(registered: Registered) -> str:
    """Return the text of a registration, as Markdown."""
    when, study, found = registered
    tests = design(study)
    about = {"subject": study.subject, "levels": tests.levels}
    data = {"registered": when, "study": parse_toml(study.to_toml())} | found._asdict()
    environment = Environment(
        loader=PackageLoader(__package__, ""), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = environment.get_template("words.md.j2").render(
        study=study,
        design=tests,
        date=registered.date,
        version=own().version,
        count=count,
        who=f"{study.subject} against each other optimizer" if tests.alone else "every pair of optimizers",
        rule=speaker("bench.topics.subject", it=about)("rule") if study.subject else winner_rule(bool(study.looks)),
        sweeps=[sweep.name for sweep in study.sweeps],
        power=foreseen(study) if tests.pairs else (),
        data=tomli_w.dumps(data),
    )
    return f"{text.rstrip()}\n{SEAL}{_hash(text)}\n"


def read(path: Path) -> Registered:
    """Return the registration in a file.

    Raises:
        FileNotFoundError: where there is none.
        BenchError: where it was edited, or cannot be read.
    """
    try:
        text, _, seal = read_text(path).rpartition(SEAL)
        if _hash(text) != seal.strip():
            raise BenchError(f"{path} was edited after it was written: it does not fit its hash")
        data = parse_toml(text.split(f"{FENCE}toml\n")[-1].rstrip().removesuffix(FENCE))
        found = Fingerprints(**{name: data[name] for name in Fingerprints._fields})
        return Registered(data["registered"], Study.from_dict(data["study"], f"in {path}"), found)
    except (FileNotFoundError, BenchError):
        raise
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BenchError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error


def _hash(text: str) -> str:
    return hashlib.sha256(text.rstrip().encode()).hexdigest()
