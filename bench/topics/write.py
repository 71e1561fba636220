"""Write the report of a study's folder, or of several folders compared with each other."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from os import PathLike
from pathlib import Path

from threadpoolctl import threadpool_limits

from bench.helpers.console import OnStep
from bench.helpers.errors import BenchError, nearest, reason
from bench.helpers.text import file_name
from bench.report.drawing import Drawer
from bench.report.latex import LAYOUTS
from bench.report.wording import count
from bench.report.write import MANIFEST, Draft
from bench.results.results import StoredResults
from bench.study.selection import Dimensions, Patterns
from bench.study.study import UNKNOWN_BUDGET
from bench.study.targets import Targets
from bench.topics.answer.file import answer_file
from bench.topics.findings import Findings
from bench.topics.findings.replication import each_problem
from bench.topics.page import chapters

FEW = 4  # problems up to which other processes would take longer to start than to draw
COMPARISONS = Path("results") / "comparisons"


def write_report(
    path: str | PathLike[str],
    *others: str | PathLike[str],
    output: str | PathLike[str] | None = None,
    n_jobs: int = -1,
    targets: object = None,
    beside_best: bool = False,
    subject: str | None = None,
    optimizers: Patterns = None,
    problems: Patterns = None,
    dimensions: Dimensions = None,
    versions: Sequence[str] = (),
    columns: int = 1,
    on_progress: OnStep | None = None,
) -> Path:
    """Write ``report.html``, ``tables/``, ``figures/`` and the methods' text, and return the page's path.

    Several folders are compared as one study (:class:`bench.Results`). The same results give the same bytes. A
    plug-in's section that fails becomes a warning on the page. Files that only an earlier report had are removed.

    Args:
        path: a study's folder.
        others: further folders to compare with it.
        output: the folder to write into; by default the study's own, and ``results/comparisons/NAMES`` for several.
        n_jobs: processes that draw figures, -1 for one a core; the files do not depend on it.
        targets: what counts as reached, other than the study's own (:meth:`bench.study.targets.Targets.read`).
        beside_best: whether the running times of the best algorithms of 2009 stand beside those of the optimizers
            (:mod:`bench.formats.coco.best2009`; it needs the extra ``coco``).
        subject: the label of the optimizer that the report is about, other than the study's own: it alone is tested
            against each of the others. Where the first run did not name it, every pair counts as a test.
        optimizers: labels or patterns of the only optimizers to show (:meth:`bench.Results.select`). The page, the
            methods and the answer say what was left out, and a selection needs an ``output`` of its own.
        problems: likewise of problems.
        dimensions: the only dimensions of problems to show.
        versions: labels or patterns of optimizers whose earlier versions stand beside them, as ``label@1``.
        columns: of the text that the LaTeX tables and figures fit, 1 or 2.
        on_progress: called before every step.

    Raises:
        BenchError: when a folder holds no study or no store, the folders cannot be compared, ``targets`` are
            none, the best of 2009 is of other problems, the study has no optimizer ``subject``, nothing has a
            pattern or a dimension that is selected, ``columns`` is neither 1 nor 2, a selection has no ``output``, or
            that cannot be written or holds another study.
    """
    chosen = None if targets is None else Targets.read(targets, "the targets of a report")
    if columns not in LAYOUTS:
        raise BenchError(f"a text has 1 or 2 columns, not {columns!r}")
    results = StoredResults(path, *others, versions=versions)
    if (optimizers, problems, dimensions) != (None, None, None):
        results = results.select(optimizers=optimizers, problems=problems, dimensions=dimensions)
    findings = Findings(results, chosen, beside_best, subject)
    if subject is not None and subject not in findings.trials.optimizers:
        known = nearest(subject, findings.trials.optimizers)
        raise BenchError(f"the study has no optimizer {subject!r} for a subject{known}")
    findings.anytime.check_targets()
    folder = _folder(results, None if output is None else Path(output))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Threads of BLAS gain nothing on matrices as small as these, and wait for each other where cores are busy.
        with threadpool_limits(limits=1), Drawer(n_jobs if len(results.study.problems) > FEW else 1) as drawer:
            draft = Draft(
                folder,
                drawer,
                study=results.study.name,
                on_step=on_progress or (lambda *_: None),
                layout=LAYOUTS[columns],
            )
            title = findings.study.title or findings.study.name
            page = draft.write(title, lead(findings), chapters(findings), partial(answer_file, findings))
    except OSError as error:
        raise BenchError(f"the report cannot be written into {folder}: {reason(error)}") from error
    return page


def lead(findings: Findings) -> str:
    """Return the sentence below the title of the page: what was run how often, and what was selected of it."""
    study = findings.study
    trials = each_problem(findings.trials.replications)
    budget = f", {'at most ' * bool(study.imported)}{study.budget_words} a trial"
    budget = "" if study.budget_words == UNKNOWN_BUDGET else budget
    text = (
        f"Study {study.name}: {count(len(study.optimizers), 'optimizer')} on {count(len(study.problems), 'problem')}, "
        f"{trials}{budget}."
    )
    return f"{text} {findings.selection}".rstrip()


def _folder(results: StoredResults, output: Path | None) -> Path:
    paths = results.paths
    own = {path.resolve() for path in paths}
    if results.partial and (output is None or output.resolve() in own):
        raise BenchError(
            "a selection is another report than that of the whole folder, which it would replace; give it a folder of "
            "its own by --output"
        )
    if output is None:
        return paths[0] if len(paths) == 1 else COMPARISONS / "-".join(map(file_name, results.names))
    if len(paths) == 1 and output.resolve() == paths[0].resolve():
        return output
    if (output / "study.toml").exists():
        raise BenchError(f"{output} is the folder of a study, whose own report would be lost; give another --output")
    if output.is_dir() and any(output.iterdir()) and not (output / MANIFEST).exists():
        raise BenchError(f"{output} holds other files and no report of ours; give an --output of its own")
    return output
