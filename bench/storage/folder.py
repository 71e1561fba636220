"""A study's folder: the study that was run there last, its cells, environments, notes and lock."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import psutil
from filelock import FileLock, Timeout

from bench.helpers.atomic import replacing
from bench.helpers.errors import BenchError, explained, reason
from bench.helpers.parsing import JsonObject, parse_json
from bench.helpers.text import count, listed
from bench.plugins.inputs import Inputs, Present
from bench.storage import committed, provenance, under_way
from bench.storage.reading import StoreCheck
from bench.storage.selection import Selection, select
from bench.storage.store import Store
from bench.storage.under_way import UnderWay
from bench.study import Study
from bench.trial.trial import Trial

LOCK = ".lock"  # the file that a run locks
STUDY = "study.toml"
ENVIRONMENT = "environment.json"
CHECKS = "checks.json"
VERIFICATION = "verification.json"
AT_ENDS = "at_ends"  # its part on the trials that runs make again at their ends
DESCRIPTIONS = "optimizers.json"
ANSWER = "answer.json"  # of the report
SUMS = "SHA256SUMS"  # of the archive that a folder was unpacked from

_CLOCKS = 2.0  # seconds by which two clocks may differ at the same moment


def default_path(study: Study) -> Path:
    """Return the folder into which a study is run where no other is given."""
    return Path("results") / "runs" / study.name


class Folder:
    """A folder that a run writes and reports read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.store = Store(self.path)

    def study(self) -> Study:
        """Return the study that was run here last.

        Raises:
            BenchError: where the folder holds none, or another one than the store's trials are selected by.
        """
        if not self._begun:
            raise BenchError(f"{self.path} holds no {STUDY}; give the folder that 'bench run' wrote")
        study = Study.load(self.path / STUDY)
        if (ran := self.store.held().study) not in ("", study.identity()):
            raise BenchError(
                f"{self.path / STUDY} was changed: the trials beside it were made with the study of hash {ran}, and "
                f"its hash is {study.identity()} now; put back the {STUDY} that the run wrote, or run the changed one: "
                f"bench run {self.path / STUDY} --output {self.path}"
            )
        return study

    @property
    def untrusted(self) -> bool:
        """Whether an archive brought the folder here, or its trials were made of code that nobody trusts."""
        return (self.path / SUMS).exists() or any(record.get("sandbox") for record in self.environments())

    @property
    def _begun(self) -> bool:
        return os.path.exists(self.path / STUDY)  # noqa: PTH110 - Path.exists raises without permission

    def environments(self) -> list[JsonObject]:
        """Return the environments that made the store's rows, in the order of their numbers from 1 on."""
        return list(self.store.records("environments").values())

    def write_environments(self) -> None:
        """Write a copy of the store's environments to environment.json, for people."""
        self._write(ENVIRONMENT, json.dumps(self.environments(), indent=1))

    def differences(self, machine: JsonObject) -> list[str]:
        """Return in short phrases how this machine and its versions differ from those of the last run here."""
        noted = self.environments()
        return provenance.differences(noted[-1], machine) if noted else []

    def select(self, study: Study, dimensions: Mapping[str, int], present: Present) -> tuple[Study, Selection]:
        """Return a study as it is to be run here, and its cells, of which the folder may hold some; write nothing.

        Fewer trials than before do not shrink a folder.
        """
        held, asked = self.store.held(), study.trials
        with suppress(BenchError):
            study = study.override(trials=max(asked, Study.load(self.path / STUDY).trials))
        selection = select(study.cells(dimensions), study.trials, held, present)
        if asked < study.trials:
            selection.notes.append(
                f"{self.path} was asked for {study.trials} trials before, so {study.trials} and not {asked} are made "
                "of each cell; another --output holds fewer"
            )
        return study, selection

    def require_unchanged(self, study: Study, dimensions: Mapping[str, int], present: Present) -> None:
        """Raise BenchError where code or data are others now than those that trials here were made with."""
        _, selection = self.select(study, dimensions, present)
        if selection.cells != self.store.held().by_labels:
            raise BenchError(
                f"trials in {self.path} are not of what would be made now: {listed(selection.notes, between='; ')}; "
                "'bench run' makes the present ones, or put back what was changed"
            )

    def claim(self, study: Study, selection: Selection | None = None) -> None:
        """Make a study the one of this folder, which must be locked: note in the store the cells that it selects.

        Cells that it does not select keep their trials. Without a selection, the first cells of each are meant.

        Raises:
            BenchError: when the folder cannot be written.
        """
        with replacing(self.path / STUDY) as temporary:
            temporary.write_text(study.to_toml(), encoding="utf-8")
            with self.store.writer() as writer:
                chosen = selection or Selection(study.cells({}))
                writer.select(study.identity(), chosen.cells)

    def note_selected(self, study: Study) -> None:
        """Add what a run selects to the history of this folder, which must be locked."""
        with self.store.writer() as writer:
            writer.record(
                "history",
                {
                    "when": provenance.now(),
                    "study": study.identity(),
                    "seed": study.seed,
                    "trials": study.trials,
                    "budget": study.budget.plain,
                    "subject": study.subject,
                    "problems": [entry.label for entry in study.problems],
                    "optimizers": [entry.label for entry in study.optimizers],
                },
            )

    def save(self, path: Path) -> Path:
        """Copy the folder, with its store as it is at one moment, to a new or empty one, and return that.

        Raises:
            BenchError: where the new one cannot be written, or is not empty.
        """
        left_out = shutil.ignore_patterns(f"{self.store.path.name}*", committed.FILE, LOCK, under_way.FILE)
        with explained(f"the results cannot be saved in {path}"):
            if path.exists() and any(path.iterdir()):
                raise BenchError(f"{path} is not empty; give a new folder")
            shutil.copytree(self.path, path, ignore=left_out, dirs_exist_ok=True)
        self.store.copy(path / self.store.path.name)
        return path

    def made(self) -> dict[str, Inputs]:
        """Return what the shown trials of each problem and optimizer were made from, by the label shown."""
        held = self.store.held()
        shown = (pair for labels, cell in held.by_labels.items() for pair in zip(labels, cell.records, strict=True))
        return {label: held.made.get(text, {}) for label, text in shown}

    def changed(self) -> dict[str, list[str]]:
        """Return what of :meth:`made` is another by now, by label.

        What is missing here is left out, as are folders that an archive brought: they may have been made elsewhere.
        """
        noted = self.environments()
        folder = str(noted[-1].get("working_folder") or "") if noted else ""
        if self.untrusted or (folder and not Path(folder).is_dir()):
            return {}
        present = Present(folder=folder, strict=False)
        found = {label: present.changed(inputs) for label, inputs in sorted(self.made().items())}
        return {label: names for label, names in found.items() if names}

    def history(self) -> list[JsonObject]:
        """Return what runs selected here, and in the folders that trials were taken from, oldest first.

        Looks of a gate are no runs (:meth:`looks`).

        Each record has ``when``, ``study`` (its identity), ``seed``, ``trials``, ``budget``, ``subject``, the labels of
        ``problems`` and ``optimizers``, and ``reused``, the name of the folder where it was another one.
        """
        runs = [record for record in self.store.records("history").values() if "look" not in record]
        return sorted(runs, key=lambda record: str(record.get("when", "")))

    def looks(self) -> list[JsonObject]:
        """Return what was noted of comparisons of trials that are here, or in folders that they were taken from."""
        return [record["look"] for record in self.store.records("history").values() if "look" in record]

    def note_look(self, look: JsonObject) -> None:
        """Add a comparison and its outcome to the history; raises BenchError where a run holds the folder."""
        with self.lock(), self.store.writer() as writer:
            writer.record("history", {"look": look})

    def noted(self, name: str) -> JsonObject:
        """Return the content of a note, by the name of its JSON file such as ``CHECKS``; empty where it is missing.

        Raises:
            BenchError: where it is damaged.
        """
        path, noted = self.path / name, None
        with explained(f"{path} cannot be read"):
            content = path.read_bytes() if path.exists() else b"{}"
        with suppress(ValueError):
            noted = parse_json(content)
        if not isinstance(noted, dict):
            raise BenchError(f"{path} is damaged; restore it from a copy, or remove it")
        return noted

    def note(self, name: str, content: JsonObject) -> None:
        """Replace a note (:meth:`noted`)."""
        self._write(name, json.dumps(content, indent=1))

    def note_repeated(self, compared: Mapping[Trial, str]) -> None:
        """Note trials that a run made again at its end, and how each differs, "" where it does not."""
        numbers = {labels: number for number, labels in self.store.held().selected.items()}
        found = [[numbers[trial.key[:2]], difference_line(trial, what)] for trial, what in compared.items()]
        if found:
            noted = self.noted(VERIFICATION)
            before = noted.get(AT_ENDS)
            self.note(VERIFICATION, noted | {AT_ENDS: [*(before if isinstance(before, list) else []), *found]})

    def verification(self) -> JsonObject:
        """Return what ``bench verify`` noted, and of the trials that runs made again those of the selected cells.

        Trials of earlier versions say nothing of those that are shown.
        """
        noted, selected, lines = self.noted(VERIFICATION), self.store.held().selected, list[str]()
        with suppress(TypeError, ValueError):  # of a note that was edited
            lines = [str(line) for number, line in noted.pop(AT_ENDS, ()) if number in selected]
        different = [*dict.fromkeys(filter(None, lines))]
        if lines:
            sentence = (
                f"{lines.count(''):,} of {count(len(lines), 'trial')} that runs made again at their ends, one of each "
                f"optimizer in a fresh process, {'is' if len(lines) == 1 else 'are'} the same bit by bit"
            )
            noted[AT_ENDS] = {"trials": len(lines), "sentence": sentence, "different": different}
        return noted

    def checks(self) -> dict[str, list[JsonObject]]:
        """Return the verdicts that ``bench check`` noted, by optimizer label; empty where it has not run.

        Each has the keys of :class:`bench.check.verdict.Verdict`, and ``code``, a hash of the code and the parameters
        that it is true of.
        """
        noted = self.noted(CHECKS).items()
        return {label: [*filter(_is_verdict, those)] for label, those in noted if isinstance(those, list)}

    def require_sound(self) -> StoreCheck:
        """Check the store; raise BenchError where any row is not as it was written: nothing reads it or adds to it."""
        return self.require(self.store.check(structure=True))

    def require(self, found: StoreCheck) -> StoreCheck:
        """Return the outcome of a check of the store; raise BenchError where it is not sound."""
        if not found.sound:
            raise BenchError(
                f"{self.path}: {found.sentence}; restore {self.store.path.name} from a copy, or run the study into "
                f"another folder with --reuse {self.path}, which takes the trials that are as they were written"
            )
        return found

    @contextmanager
    def lock(self) -> Iterator[UnderWay]:
        """Lock the folder for one run, and create it where it is missing; the lock of a killed run ends with it.

        The trials that are under way can be noted in what is yielded.

        Raises:
            BenchError: when another run is writing here, or the folder cannot be written or holds other files.
        """
        hold = FileLock(self.path / LOCK, timeout=0)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            if any(not item.name.startswith(".") for item in self.path.iterdir()) and not self._begun:
                if holder := self.running():  # which has just begun
                    raise self._taken(holder)
                raise BenchError(f"{self.path} is not empty and holds no study; give another --output")
            hold.acquire()
        except Timeout as error:
            raise self._taken(self.running()) from error
        except (OSError, NotImplementedError) as error:
            raise BenchError(f"the output folder {self.path} cannot be written: {reason(error)}") from error
        try:
            if (holder := self.running()) and holder["host"] == provenance.host():  # whose lock was removed
                raise self._taken(holder)
            holder = {"pid": os.getpid(), "host": provenance.host(), "started": provenance.now()}
            with under_way.noting(self.path, holder) as noted:
                yield noted
        finally:
            hold.release()

    def killed(self) -> JsonObject:
        """Return when the last run began a trial and the trials then under way, where it was killed; else empty."""
        last = under_way.left(self.path)
        return last if last["trials"] else {}

    def running(self) -> JsonObject | None:
        """Return pid, host and start of the run that is writing here, None where this machine detects none."""
        noted = under_way.holder(self.path)
        try:
            began = datetime.fromisoformat(noted["started"]).timestamp()
            here = noted["host"] == provenance.host()
            if here and psutil.Process(noted["pid"]).create_time() > began + _CLOCKS:
                return None  # another process has the number of a killed run by now
        except (KeyError, TypeError, ValueError, OverflowError, psutil.NoSuchProcess):
            return None
        except psutil.Error:  # the process exists and belongs to another user
            pass
        return noted

    def _taken(self, holder: JsonObject | None) -> BenchError:
        who = f"(process {holder['pid']} on {holder['host']}, since {holder['started']}) " if holder else ""
        return BenchError(f"another run {who}is writing to {self.path}; wait for its end or give another --output")

    def _write(self, name: str, text: str) -> None:
        with replacing(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def difference_line(trial: Trial, what: str) -> str:
    """Return the line on a trial that differs, "" for one that does not."""
    return what and f"different: {trial.optimizer} on {trial.problem}, trial {trial.number}: {what}"


_VERDICT: dict[str, Any] = dict.fromkeys(("check", "kind", "finding", "remedy", "code"), str)
_VERDICT |= {"passed": bool, "figure": (int, float, type(None))}


def _is_verdict(noted: Any) -> bool:
    return isinstance(noted, dict) and all(isinstance(noted.get(key, ...), kind) for key, kind in _VERDICT.items())
