"""A study's output folder: the frozen study, the environments that ran it, and the refusal of a foreign one."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from bench import environment
from bench.errors import BenchError
from bench.store import Store
from bench.study import Study

STUDY = "study.toml"
ENVIRONMENT = "environment.json"
DATA = "data.json"
CODE = "code.json"
CHECKS = "checks.json"


class Folder:
    """The folder that a run writes and that reports read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.store = Store(self.path)

    def study(self) -> Study:
        """Return the frozen study; raises BenchError where the folder holds none."""
        if not (self.path / STUDY).exists():
            raise BenchError(f"{self.path} holds no {STUDY}; give the folder that 'bench run' wrote")
        return Study.load(self.path / STUDY)

    def environments(self) -> list[dict[str, Any]]:
        """Return what each run that wrote here noted of its environment, oldest first."""
        records = self._json(ENVIRONMENT)
        return [record for record in records if isinstance(record, dict)] if isinstance(records, list) else []

    def claim(self, study: Study) -> Study:
        """Prepare the folder for ``study`` and return the study as frozen there.

        A folder of the same study is continued; more trials than before extend it, fewer leave it as it is.

        Raises:
            BenchError: when the folder cannot be written, or holds another study or other files.
        """
        if (self.path / STUDY).exists():
            present = self.study()
            if present.identity() != study.identity():
                raise BenchError(
                    f"{self.path} holds another study ({present.name!r}, budget {present.budget}, seed {present.seed}, "
                    f"or other problems or options); give another --output"
                )
            study = study.override(trials=max(study.trials, present.trials))
        elif self.path.is_dir() and any(not item.name.startswith(".") for item in self.path.iterdir()):
            raise BenchError(f"{self.path} is not empty and holds no study; give another --output")
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._write(STUDY, study.to_toml())
        except OSError as error:
            raise BenchError(f"the output folder {self.path} cannot be written: {error.strerror}") from error
        return study

    def fingerprints(self) -> dict[str, str]:
        """Return the noted fingerprints of the problems' data, by label."""
        return self._noted(DATA)

    def check_data(self, fingerprints: dict[str, str]) -> None:
        """Note the fingerprints of the problems' data, by label, and refuse data that changed under a study.

        Raises:
            BenchError: when a problem's data is not what the folder's trials were made with.
        """
        self._check(DATA, fingerprints, "data of problem", "data sets")

    def check_code(self, fingerprints: dict[str, str]) -> None:
        """Note the fingerprints of optimizers that come from a file, by label, and refuse an edited one.

        Raises:
            BenchError: when an optimizer's code is not what the folder's trials were made with.
        """
        if known := {label: fingerprint for label, fingerprint in fingerprints.items() if fingerprint}:
            self._check(CODE, known, "code of optimizer", "versions")

    def _check(self, file: str, fingerprints: dict[str, str], what: str, kinds: str) -> None:
        before = self._noted(file)
        for label, fingerprint in fingerprints.items():
            if before.get(label, fingerprint) != fingerprint:
                raise BenchError(
                    f"the {what} {label!r} changed since {self.path} was begun, and its trials would mix two {kinds}; "
                    "put it back or give another --output"
                )
        self._write(file, json.dumps(before | fingerprints, indent=1))

    def checks(self) -> dict[str, list[dict[str, Any]]]:
        """Return the verdicts that ``bench check`` noted of the study's optimizers, by label; empty where none did.

        Each has all keys of :class:`bench.check.verdict.Verdict`; what an older file lacks is filled in.
        """
        return {
            label: [whole for each in those if (whole := _verdict(each))]
            for label, those in self._noted(CHECKS).items()
            if isinstance(those, list) and all(isinstance(each, dict) for each in those)
        }

    def note_checks(self, checks: dict[str, list[dict[str, Any]]]) -> None:
        """Note the verdicts on the study's optimizers, by label."""
        self._write(CHECKS, json.dumps(checks, indent=1))

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Hold the folder for one run; a killed run's hold ends with it.

        Raises:
            BenchError: when another run is writing here.
        """
        try:
            with FileLock(self.path / ".lock", timeout=0):
                yield
        except Timeout as error:
            raise BenchError(
                f"another run is writing to {self.path}; wait for its end or give another --output"
            ) from error

    def note_environment(self, jobs: int) -> None:
        """Append this run's environment, with its start time and number of workers."""
        now = datetime.now(UTC).isoformat(timespec="seconds")
        record = {"started": now, "jobs": jobs, **environment.describe()}
        self._write(ENVIRONMENT, json.dumps([*self.environments(), record], indent=1))

    def _noted(self, name: str) -> dict[str, Any]:
        """Return what a JSON file notes by label, nothing where it is missing or damaged."""
        noted = self._json(name)
        return noted if isinstance(noted, dict) else {}

    def _json(self, name: str) -> Any:
        """Return a JSON file's content, or None where it is missing or damaged: notes never stand in a run's way."""
        try:
            return json.loads((self.path / name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def _write(self, name: str, text: str) -> None:
        """Replace a file at once, so that a kill leaves the old or the new one."""
        temporary = self.path / f".{name}.tmp"
        try:
            temporary.write_text(text, encoding="utf-8")
            temporary.replace(self.path / name)
        except OSError as error:
            raise BenchError(f"{self.path / name} cannot be written: {error.strerror}") from error


def _verdict(noted: dict[str, Any]) -> dict[str, Any]:
    """Return a verdict as noted with all its keys, or nothing for what is none."""
    whole = {"check": None, "kind": "bias", "passed": None, "finding": "", "mend": "", "figure": None} | noted
    sound = (
        all(isinstance(whole[key], str) for key in ("check", "kind", "finding", "mend"))
        and isinstance(whole["passed"], bool)
        and isinstance(whole["figure"], (int, float, type(None)))
    )
    return whole if sound else {}
