"""Recognise the results of other tools in plain tables: what each column is, and how rows and columns hold the runs.

A table is long, with a column for the value, or wide: its columns are optimizers, problems, runs or iterations. What no
column says is in the names of the file, the sheet and the folder. What is recognised is said, so that it can be mended.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.errors import BenchError, nearest
from bench.helpers.text import count, listed

SYNONYMS = {
    "problem": "problem function problemname functionname func funcname fname objfname testfunction testproblem "
    "benchmark benchmarkfunction fid funcid functionid problemid task objective fun f instance instancename dataset",
    "optimizer": "optimizer optimiser algorithm algo alg method solver metaheuristic heuristic optimizername "
    "optimisername algorithmname algoname algname methodname solvername algid algorithmid approach technique variant "
    "strategy model config configuration name",
    "run": "run trial runid trialid runno trialno runnumber trialnumber runindex repetition rep repeat replicate "
    "replication execution executionid iterationofrun experiment id",
    "seed": "seed randomseed rngseed randomstate",
    "evaluations": "evaluations evaluation evals nfev nfe nfes fes fe funevals functionevaluations numevaluations "
    "nevals neval feval fevals maxfes",
    "iteration": "iteration iter iterations generation gen ngen epoch step nit",
    "value": "value bestvalue bestfitness fitness finalfitness finalvalue finalbest fun fx fval fbest bestf besty "
    "bestobjective objectivevalue objective obj finalerror besterror error gap bestcost cost bestscore score loss "
    "bestsofar bestfx globalbest globalbestfitness gbest best bestfound result indicatorvalue metricvalue igd igdplus "
    "gd regret makespan hv hypervolume f y",
    "dimension": "dimension dim dims dimensions ndim d n problemdimension",
    "instance": "instance instanceid iid",
    "indicator": "indicatorname indicator metric metricname",
}
"""The names of columns, in small letters and digits alone, the likelier first."""

_MEANS = {"mean", "avg", "average", "ave", "meanfitness", "avgfitness", "median", "meanvalue", "meanerror"}
_SPREADS = {"std", "sd", "stddev", "stdev", "standarddeviation", "stdfitness", "var", "variance", "iqr", "worst"}
_SHORT = {"gd", "hv", "y", "f", "fx"}
_MORE_IS_BETTER = {"hv", "hypervolume", "accuracy", "acc", "reward"}
_EXTRA = re.compile(
    r"(m|x\d*|.*(time|times|seconds|duration|cpu|wall|memory|hash|date|timestamp|status|budget|popsize|population"
    r"|optimum|fopt|bounds?|initialfitness|initialvalue|success|nit|calls|stop|size|cores|elapseds))(s|ms|sec)?|unnamed\d+"
)
_RUNS = re.compile(r"(?:run|trial|seed|rep|repetition|r|t|fitness|best|value|result|execution)?\d+")
_ITERATIONS = re.compile(r"(?:iter|iteration|gen|generation|epoch|step)\d+")
_PROBLEM = re.compile(
    r"(f|fn|fun|func|function|p|prob|problem|test|cec\w*?|bbob\w*?|zdt|dtlz|wfg|uf|lz|mop|tsp|mk|rc|g)\d+.*"
    r"|(shifted|rotated|generalized|inverted)?(sphere|ackley|rastrigin|rosenbrock|griewank|schwefel|levy|zakharov|"
    r"michalewicz|beale|booth|easom|branin|himmelblau|goldstein|shubert|schaffer|whitley|happycat|hgbat|katsuura|"
    r"weierstrass|quartic|step|bentcigar|discus|elliptic|dixonprice|styblinski|alpine|salomon|matyas|camel|hartman|"
    r"shekel|kowalik|foxholes|penalized|kursawe|bohachevsky|powell|perm|trid|eggholder|crossintray|sumsquares|cigar).*"
)
_GENERIC = {
    "",
    *["results", "result", "best", "fit", "fitness", "runs", "run", "data", "all", "final", "values", "errors"],
}
_NUMBER = r"[-+]?[\d.,]+(e[-+]?\d+)?"
_SUMMARY = re.compile(rf"\s*{_NUMBER}\s*(±|\+/-|\+-|\\pm|\(\s*{_NUMBER}\s*\)).*", re.IGNORECASE)
_NUMBER_ONLY = "(?i)[-+]?[0-9]{1,3}(,[0-9]{3})+[.][0-9]*(e[-+]?[0-9]+)?"
NO_TEST = (
    "a summary of runs, which cannot be tested: give a row a run, or compare the printed numbers with 'bench reproduce'"
)


@dataclass(frozen=True)
class Table:
    """A table of a file or sheet: its cells, its name, that of its folder, and how messages call it."""

    cells: pd.DataFrame
    name: str = ""
    folder: str = ""
    where: str = "the table"


@dataclass(frozen=True)
class Recognised:
    """The rows of all runs, and sentences on what was taken for what.

    ``rows`` has ``problem``, ``optimizer``, ``run`` (from 0) and ``value``, and ``evaluations`` and ``seed`` where all
    rows have them.
    """

    rows: pd.DataFrame
    said: tuple[str, ...]


def recognised(
    tables: Sequence[Table], columns: Mapping[str, str] | None = None, *, maximise: bool = False
) -> Recognised:
    """Return the runs of tables.

    Args:
        tables: of one experiment.
        columns: the names of columns by what they are, a key of :data:`SYNONYMS`, for those that are not recognised.
        maximise: whether higher values are better; they are then negated.

    Raises:
        BenchError: for summaries, for tables without values, optimizers or problems, and where several rows are of one
            run and none says in which order.
    """
    given = dict(columns or {})
    if unknown := [role for role in given if role not in SYNONYMS]:
        raise BenchError(f"a column is no {unknown[0]!r}{nearest(unknown[0], SYNONYMS)}; it is {', '.join(SYNONYMS)}")
    names = _distinct([table.name for table in tables])
    parts, said = [], dict[str, None]()
    for table, name in zip(tables, names, strict=True):
        rows, sentence = _long(table, name, given)
        parts.append(rows)
        said[sentence] = None
    heads = {_plain(name) for table in tables for name in table.cells}
    if absent := [name for name in given.values() if _plain(name) not in heads]:
        raise BenchError(f"{tables[0].where} has no column {absent[0]!r}")
    rows = pd.concat(parts, ignore_index=True)
    for name in ("problem", "optimizer"):
        rows[name] = rows[name].astype(str).str.strip()
    notes = list(said)[:5]
    if empty := int(rows["value"].isna().sum()):
        notes.append(f"{count(empty, 'empty cell')} left out")
        rows = rows[rows["value"].notna()]
    better = rows["more"].astype(bool) | maximise
    rows["value"] = rows["value"].where(~better, -rows["value"])
    rows, about = _by_run(rows.assign(more=better))
    better = rows.pop("more").astype(bool)
    if not len(rows):
        raise BenchError(f"{tables[0].where} holds no value")
    cells = rows.groupby(["problem", "optimizer"])["run"].nunique()
    least, most = int(cells.min()), int(cells.max())
    runs = str(least) if least == most else f"{least} to {most}"
    negated = sorted(rows["problem"][better].unique())
    way = "lower is better" if not negated else "higher is better: values are negated"
    if negated and not better.all():
        way = f"lower is better, but higher for {listed(negated)}, whose values are negated"
    notes.append(
        f"{runs} {'run' if most == 1 else 'runs'} of {count(rows['optimizer'].nunique(), 'optimizer')} on "
        f"{count(rows['problem'].nunique(), 'problem')}; {way}"
    )
    return Recognised(rows.reset_index(drop=True), (*notes, *about))


def _plain(name: object) -> str:
    return re.sub(r"[^a-z0-9]", "", re.sub(r"[\[(].*?[\])]", "", str(name)).lower())


def numbers(cells: pd.Series[str], where: str) -> pd.Series[float] | None:
    """Return the numbers of a column, missing where a cell is empty, +inf for NaN; None where a cell is none.

    Raises:
        BenchError: for a mean with its deviation.
    """
    if pd.api.types.is_bool_dtype(cells):
        return None
    if pd.api.types.is_numeric_dtype(cells):
        return cells.astype(float)
    texts = cells.fillna("").astype(str).str.strip()
    found = pd.to_numeric(texts.where(texts != ""), errors="coerce")
    lost = texts[found.isna() & (texts != "")]
    if len(lost) and (summary := lost[lost.str.fullmatch(_SUMMARY)]).size:
        raise BenchError(f"{where} has {summary.iloc[0]!r}, {NO_TEST}")
    if not len(lost):
        return found
    failed = lost.str.lower().isin(["nan", "na", "n/a", "none", "null", "-"])
    lost = lost[~failed]
    thousands = lost.str.fullmatch(_NUMBER_ONLY)
    mended = lost.where(~thousands, lost.str.replace(",", "")).str.replace(",", ".")
    found.loc[lost.index] = pd.to_numeric(mended.str.replace("−", "-"), errors="coerce")
    if found.loc[lost.index].isna().any():
        return None
    found.loc[failed[failed].index] = np.inf
    return found


def _roles(cells: pd.DataFrame, given: Mapping[str, str], figures: Mapping[str, pd.Series[float]]) -> dict[str, str]:
    """Return the names of columns by what they are."""
    plain = {_plain(name): str(name) for name in reversed(list(cells))}
    roles: dict[str, str] = {}
    for role, name in given.items():
        matches = [str(each) for each in cells if each == name or _plain(each) == _plain(name)]
        if matches:
            roles[role] = matches[0]
    for role, synonyms in SYNONYMS.items():
        for synonym in synonyms.split():
            name = plain.get(synonym, "")
            if role in roles or synonym not in plain or name in roles.values():
                continue
            if role in ("problem", "optimizer"):
                ambiguous = synonym in ("fun", "f", "objective", "model", "name", "config")
                fits = not ambiguous or name not in figures
            else:
                fits = role == "indicator" or name in figures or role == "run"
            if fits:
                roles[role] = name
    return roles


def _long(table: Table, name: str, given: Mapping[str, str]) -> tuple[pd.DataFrame, str]:
    """Return the rows of a table, and what its columns were taken for."""
    cells = table.cells.set_axis([str(each).strip() for each in table.cells], axis=1)
    cells = cells.loc[:, ~cells.columns.duplicated()]
    heads = list(map(str, cells))
    read = {each: numbers(cells[each], f"{table.where}, column {each!r},") for each in heads}
    figures = {each: found for each, found in read.items() if found is not None}
    roles = _roles(cells, given, figures)
    names = {_plain(each) for each in cells}
    if names & _MEANS and names & _SPREADS:
        raise BenchError(f"{table.where} has the columns {listed(heads, 8)}: {NO_TEST}")
    kept = pd.DataFrame(
        {
            role: figures.get(of, cells[of]) if role not in ("problem", "optimizer", "indicator", "run") else cells[of]
            for role, of in roles.items()
        },
        index=cells.index,
    )
    wide = [each for each in figures if each not in roles.values() and not _EXTRA.fullmatch(_plain(each))]
    runs_wide = [each for each in wide if _RUNS.fullmatch(_plain(each))]
    iterations = [each for each in wide if _ITERATIONS.fullmatch(_plain(each))]
    first = next((each for each in heads if each not in figures and each not in roles.values()), None)
    spread = ""
    if "value" not in roles and len(wide) == 1 and {"problem", "optimizer"} <= {*roles}:
        roles["value"] = wide[0]
    short = _plain(roles.get("value", "")) in _SHORT and "optimizer" not in roles and wide
    if short:
        wide.append(roles.pop("value"))  # an optimizer may be called GD
    if "value" in roles:
        kept["value"] = figures[roles["value"]]
    elif iterations:
        kept["value"] = pd.DataFrame({each: figures[each] for each in iterations}).min(axis=1)
        spread = f"{iterations[0]} to {iterations[-1]} = iterations, of which the best counts"
    elif not wide:
        raise BenchError(
            f"{table.where} has no column of values among {listed(heads, 12)}; name it by --column value=NAME"
        )
    else:
        kept = kept.drop(columns="value", errors="ignore")
        if len(runs_wide) >= max(2, len(wide) / 2):
            role, wide = "run", runs_wide
        elif "problem" in roles or "optimizer" in roles:
            role = "problem" if "optimizer" in roles else "optimizer"
        else:
            role = "problem" if are_problems(wide) else "optimizer"
        named = {"problem", "optimizer"} & {*roles}
        if first is not None and not named:
            is_problem = role == "optimizer" or (role == "run" and are_problems(cells[first]))
            other = "problem" if is_problem else "optimizer"
            roles[other], kept[other] = first, cells[first]
            named = {other}
        if role != "run" and not {*roles} & {"run", "seed"}:
            kept["run"] = kept.groupby(list(named), sort=False).cumcount() if named else np.arange(len(cells))
        shared = kept.drop(columns=role, errors="ignore")
        if role == "run" and not named and len(cells) > 1:
            kept, spread = _matrix(pd.DataFrame({each: figures[each] for each in wide}))
        else:
            parts = [shared.assign(value=figures[each]) for each in wide]
            kept = pd.concat(parts, keys=wide, names=[role]).reset_index(role).reset_index(drop=True)
            spread = f"columns {listed(wide, 6)} = {role}s"
    by_name = _named(name, table, kept)
    for role, text in by_name.items():
        kept[role] = text
    if "indicator" in kept:
        several = kept["indicator"].nunique() > 1
        kept["more"] = kept["indicator"].map(_plain).isin(_MORE_IS_BETTER)
        if several:
            kept["problem"] = kept["problem"].astype(str) + " " + kept["indicator"].astype(str)
    else:
        kept["more"] = _plain(roles.get("value", "")) in _MORE_IS_BETTER
    for role, letter in (("dimension", "d"), ("instance", "i")):
        if role in kept and kept[role].notna().all() and roles.get("problem") != roles[role]:
            kept["problem"] = kept["problem"].astype(str) + f"-{letter}" + kept[role].astype(float).map("{:g}".format)
    said = [f"{of} = {role}" for role, of in roles.items() if role in kept or role == "value"]
    said += [spread] if spread else []
    said += [f"{'file or folder names' if table.name else 'none'} = {role}" for role in by_name]
    unused = [each for each in heads if each not in {*roles.values(), *wide, *iterations}]
    said += [f"not used: {listed(unused, 8)}"] if unused else []
    wanted = ["problem", "optimizer", "run", "seed", "evaluations", "iteration", "value", "more"]
    return kept[[each for each in wanted if each in kept]], "columns: " + "; ".join(said)


def _matrix(cells: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Return the runs of a matrix with a run a column; its rows are their courses where values fall, else problems."""
    ended = cells.iloc[:-1] if len(cells) > 2 and (cells.iloc[-1] > cells.iloc[-2]).all() else cells
    said = f"{cells.columns[0]} to {cells.columns[-1]} = runs"
    if (ended.diff().iloc[1:] <= 0).all(axis=None):
        last = "" if ended is cells else "; the last row, of evaluations, is left out"
        best = ended.min()
        return pd.DataFrame({"run": best.index, "value": best.to_numpy()}), f"{said}, rows = their courses{last}"
    long = cells.set_axis([f"f{place}" for place in range(1, len(cells) + 1)], axis=0).rename_axis("problem")
    return long.reset_index().melt("problem", var_name="run"), f"{said}, rows = problems f1 to f{len(cells)}"


def are_problems(names: Iterable[object]) -> bool:
    """Return whether at least half of the names are those of test functions."""
    found = [_PROBLEM.fullmatch(_plain(name)) is not None for name in dict.fromkeys(names)]
    return sum(found) * 2 >= len(found) > 0


def _distinct(names: Sequence[str]) -> list[str]:
    """Return the names of files without the words that all have, or that name no problem and no optimizer."""
    parts = [re.split(r"[_\s]+|-(?=best|convergence|results?)", name) for name in names]
    shared = set(parts[0]).intersection(*parts[1:]) if len(set(names)) > 1 else set()
    return [
        "_".join(part for part in of if part not in shared and part.lower() not in _GENERIC) or name
        for of, name in zip(parts, names, strict=True)
    ]


def _named(name: str, table: Table, kept: pd.DataFrame) -> dict[str, str]:
    """Return the problem and the optimizer that names of file and folder give where no column does."""
    missing = [role for role in ("optimizer", "problem") if role not in kept]
    if len(missing) < 2:
        return {role: name or role for role in missing}
    if cec := re.fullmatch(r"(.+?)[_-][fF]?(\d+)[_-][dD]?(\d+)", table.name):
        return {"optimizer": cec[1], "problem": f"f{int(cec[2])}-d{cec[3]}"}
    for optimizer, problem in ((1, 2), (2, 1)):
        pair = re.fullmatch(r"(.+?)[_-](.+)" if optimizer == 1 else r"(.+)[_-](.+?)", table.name)
        if pair and are_problems([pair[problem]]) and not are_problems([pair[optimizer]]):
            return {"optimizer": pair[optimizer], "problem": pair[problem]}
    of_folder = "problem" if are_problems([table.folder]) and not are_problems([name]) else "optimizer"
    return {of_folder: table.folder or of_folder, ({"problem", "optimizer"} - {of_folder}).pop(): name or "problem"}


def _by_run(rows: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return rows with runs as numbers from 0, those of a run in order of evaluations; and what is to be said."""
    cell = ["problem", "optimizer"]
    notes: list[str] = []
    for name in ("run", "seed", "evaluations", "iteration"):
        if name in rows and rows[name].isna().any():
            rows = rows.drop(columns=name)
    key = next((name for name in ("run", "seed") if name in rows), "")
    texts = rows[key] if key else None
    if "seed" in rows:
        seeds = rows["seed"]
        whole = (seeds % 1 == 0) & (seeds >= 0) & (seeds < 2**53)
        rows = rows.assign(seed=seeds.astype("int64")) if whole.all() else rows.drop(columns="seed")
    if texts is None:
        rows = rows.assign(run=rows.groupby(cell, sort=False).cumcount())
        return rows.drop(columns="iteration", errors="ignore"), notes
    order = pd.to_numeric(texts, errors="coerce")
    codes = pd.factorize(order if order.notna().all() else texts.astype(str), sort=True)[0]
    rows = rows.assign(run=codes)
    if rows["problem"].nunique() > 1 and rows.groupby("run")["problem"].nunique().max() > 1 and key == "seed":
        notes.append("runs on different problems share seeds: they may depend on each other")
    elif rows["problem"].nunique() > 1:
        notes.append("runs on different problems share numbers: where these are seeds, they may depend on each other")
    if rows.duplicated([*cell, "run"]).any():
        if step := next((name for name in ("evaluations", "iteration") if name in rows), ""):
            rows = rows.sort_values([*cell, "run", step], kind="stable")
        if step == "iteration":
            notes.append("the best of the iterations of a run counts")
            rows = rows.groupby([*cell, "run"], sort=False, as_index=False).agg(
                {"value": "min"} | dict.fromkeys({"seed", "more"} & {*rows}, "first")
            )
        elif not step or rows.duplicated([*cell, "run", step]).any():
            twice = rows[rows.duplicated([*cell, "run"] + ([step] if step else []))].iloc[0]
            raise BenchError(
                f"several rows are of one run of {twice['optimizer']} on {twice['problem']}; name the column that "
                "separates runs by --column run=NAME, or that of the evaluations of a course by --column "
                "evaluations=NAME"
            )
    return rows.drop(columns="iteration", errors="ignore"), notes
