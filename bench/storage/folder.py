"""A study's output folder: the frozen study, the environments that ran it, and the refusal of a foreign one."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from time import sleep
from typing import Any

import psutil
from filelock import FileLock, Timeout

from bench.atomic import replacing
from bench.errors import BenchError
from bench.storage import provenance
from bench.storage.store import Store
from bench.study import Fingerprints, Study

STUDY = "study.toml"
ENVIRONMENT = "environment.json"
DATA = "data.json"
CODE = "code.json"
CHECKS = "checks.json"
VERIFICATION = "verification.json"
RUNNING = ".running.json"

_CHANGED = (("data of problem", "data sets"), ("code of optimizer", "versions"))
_REMOVED = dict.fromkeys((DATA, CODE), ": the store, too, notes what its trials were made with")
_CLOCKS = 2.0  # seconds by which two ways of telling the time of one moment may differ


class Folder:
    """The folder that a run writes and that reports read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.store = Store(self.path)

    def study(self) -> Study:
        """Return the frozen study; raises BenchError where the folder holds none."""
        if not self._begun:
            raise BenchError(f"{self.path} holds no {STUDY}; give the folder that 'bench run' wrote")
        return Study.load(self.path / STUDY)

    @property
    def _begun(self) -> bool:
        return os.path.exists(self.path / STUDY)  # noqa: PTH110 - unlike Path.exists, it never raises

    def environments(self) -> list[dict[str, Any]]:
        """Return the environments that the store's rows come from, in the order of their numbers from 1 on."""
        return list(self.store.environments().values())

    def write_environments(self) -> None:
        """Write the store's environments where people look for them."""
        self._write(ENVIRONMENT, json.dumps(self.environments(), indent=1))

    def differences(self, machine: Mapping[str, Any]) -> list[str]:
        """Return how this machine and its versions differ from what last made trials here, in short phrases."""
        noted = self.environments()
        return provenance.differences(noted[-1], machine) if noted else []

    def extended(self, study: Study) -> Study:
        """Return the study as it is to be frozen here: with as many trials as it had before, or more.

        Raises:
            BenchError: when the folder holds another study.
        """
        if not self._begun:
            return study
        present = self.study()
        if present.identity() != study.identity():
            raise BenchError(
                f"{self.path} holds another study ({present.name!r}, budget {present.budget}, seed {present.seed}, "
                f"or other problems or options); give another --output"
            )
        return study.override(trials=max(study.trials, present.trials))

    def claim(self, study: Study) -> Study:
        """Freeze ``study`` in the folder, which is locked, and return it as frozen there.

        A folder of the same study is continued; more trials than before extend it, fewer leave it as it is.

        Raises:
            BenchError: when the folder holds another study or cannot be written.
        """
        study = self.extended(study)
        self._write(STUDY, study.to_toml())
        return study

    def fingerprints(self) -> Fingerprints:
        """Return what the folder notes of its problems' data and its optimizers' files.

        Raises:
            BenchError: where the notes are damaged.
        """
        return Fingerprints(self._fingerprints(DATA), self._fingerprints(CODE))

    def note_fingerprints(self, found: Fingerprints) -> None:
        """Note the fingerprints of data and code; refuse changed ones as :meth:`refuse_changes` does."""
        noted = self.refuse_changes(found)
        for file, before, now in zip((DATA, CODE), noted, found, strict=True):
            if now:
                self._write(file, json.dumps(before | now, indent=1))

    def refuse_changes(self, found: Fingerprints) -> Fingerprints:
        """Return the noted fingerprints; refuse data and code that differ from what made the folder's trials.

        Raises:
            BenchError: for a problem or an optimizer that changed.
        """
        noted = self.fingerprints()
        for (what, kinds), before, now in zip(_CHANGED, noted, found, strict=True):
            for label, fingerprint in now.items():
                if before.get(label, fingerprint) != fingerprint:
                    raise BenchError(
                        f"the {what} {label!r} changed since {self.path} was begun, and its trials would mix two "
                        f"{kinds}; put it back or give another --output"
                    )
        return noted

    def _fingerprints(self, file: str) -> dict[str, str]:
        """Return what a file notes by label; where it is missing, what the store's environments say instead."""
        if (self.path / file).exists():
            noted = self._noted(file)
            if not all(isinstance(each, str) for each in noted.values()):
                raise self._damaged(file)
            return noted
        key = Path(file).stem
        records = [each for record in self.environments() if isinstance(each := record.get(key), dict)]
        return {label: fingerprint for each in records for label, fingerprint in each.items() if fingerprint}

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

    def verification(self) -> dict[str, Any]:
        """Return what ``bench verify`` noted last; empty where it did not."""
        return self._noted(VERIFICATION)

    def note_verification(self, found: dict[str, Any]) -> None:
        """Note what ``bench verify`` found."""
        self._write(VERIFICATION, json.dumps(found, indent=1))

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Hold the folder, made where it is missing, for one run; a killed run's hold ends with it.

        Raises:
            BenchError: when another run is writing here, or the folder cannot be written or holds something else.
        """
        hold = FileLock(self.path / ".lock", timeout=0)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            if any(not item.name.startswith(".") for item in self.path.iterdir()) and not self._begun:
                raise BenchError(f"{self.path} is not empty and holds no study; give another --output")
            hold.acquire()
        except Timeout as error:
            holder = self._holder()
            who = f"(process {holder['pid']} on {holder['host']}, since {holder['started']}) " if holder else ""
            raise BenchError(
                f"another run {who}is writing to {self.path}; wait for its end or give another --output"
            ) from error
        except (OSError, NotImplementedError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise BenchError(f"the output folder {self.path} cannot be written: {reason}") from error
        try:
            holder = {"pid": os.getpid(), "host": provenance.host(), "started": provenance.now()}
            self._write(RUNNING, json.dumps(holder))
            yield
        finally:
            with suppress(OSError):
                (self.path / RUNNING).unlink(missing_ok=True)
            hold.release()

    def running(self) -> dict[str, Any] | None:
        """Return pid, host and start of the run that is writing here, as far as can be seen from this machine."""
        try:
            noted = self._noted(RUNNING)
            began = datetime.fromisoformat(noted["started"]).timestamp()
            here = noted["host"] == provenance.host()
            if here and psutil.Process(noted["pid"]).create_time() > began + _CLOCKS:
                return None  # a killed run's number is another process's by now
        except (BenchError, KeyError, TypeError, ValueError, OverflowError, psutil.NoSuchProcess):
            return None
        except psutil.Error:  # it is there, and somebody else's
            pass
        return noted

    def _holder(self) -> dict[str, Any] | None:
        """Return :meth:`running`; a run that has only just taken hold of the folder is about to say who it is."""
        for _ in range(20):
            if holder := self.running():
                return holder
            sleep(0.05)
        return None

    def _noted(self, name: str) -> dict[str, Any]:
        """Return what a JSON file notes, nothing where it is missing; raises BenchError where it is damaged."""
        try:
            noted = json.loads((self.path / name).read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise BenchError(f"{self.path / name} cannot be read: {error.strerror}") from error
        except (ValueError, RecursionError) as error:
            raise self._damaged(name) from error
        if not isinstance(noted, dict):
            raise self._damaged(name)
        return noted

    def _damaged(self, name: str) -> BenchError:
        file, why = self.path / name, _REMOVED.get(name, "")
        return BenchError(f"{file} is damaged; restore it from a copy, or remove it{why}")

    def _write(self, name: str, text: str) -> None:
        with replacing(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def _verdict(noted: dict[str, Any]) -> dict[str, Any]:
    """Return a verdict as noted with all its keys, or nothing for what is none."""
    whole = {"check": None, "kind": "bias", "passed": None, "finding": "", "mend": "", "figure": None} | noted
    sound = (
        all(isinstance(whole[key], str) for key in ("check", "kind", "finding", "mend"))
        and isinstance(whole["passed"], bool)
        and isinstance(whole["figure"], (int, float, type(None)))
    )
    return whole if sound else {}
