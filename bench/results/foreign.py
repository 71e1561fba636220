"""Recognise the results of other tools in plain tables: what each column is, and how rows and columns hold the runs.

A table is long, with a column for the value, or wide: its columns are optimizers, problems, runs or iterations. What no
column says is in the names of the file, the sheet and the folder. What is recognised is said, so that it can be mended.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.helpers.errors import BenchError, nearest
from bench.helpers.text import count, listed

SYNONYMS = {
    "problem": "problem function problemname functionname func funcname fname objfname testfunction testproblem "
    "benchmark benchmarkfunction fid funcid functionid problemid task objective fun f instance instancename dataset",
    "optimizer": "optimizer optimiser algorithm algo alg method solver metaheuristic heuristic optimizername "
    "optimisername algorithmname algoname algname methodname solvername algid algorithmid approach technique variant "
    "strategy model config configuration name",
    "run": "run trial runid trialid runno trialno runnumber trialnumber runindex repetition rep repeat replicate "
    "replication execution executionid iterationofrun experiment id nr no idx index",
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
_GENERIC = re.compile("|results?|best|fit|fitness|runs?|data|all|final|values|errors")
_AMBIGUOUS = {"fun", "f", "objective", "model", "name", "config"}  # of numbers, they are no names
_NAMES = ("problem", "optimizer", "indicator", "run")  # may hold any text
_FAILED = {"nan", "na", "n/a", "none", "null", "-", "failed", "fail", "error", "timeout"}
_NUMBER = r"[-+]?[\d.,]+(e[-+]?\d+)?"
_SUMMARY = re.compile(rf"\s*{_NUMBER}\s*(±|\+/-|\+-|\\pm|\(\s*{_NUMBER}\s*\)).*", re.IGNORECASE)
_THOUSANDS = "(?i)[-+]?[0-9]{1,3}(,[0-9]{3})+([.][0-9]*)?(e[-+]?[0-9]+)?"
NO_TEST = (
    "a summary of runs, which cannot be tested: give a row for each run, or compare the printed numbers with "
    "'bench reproduce'"
)


@dataclass(frozen=True)
class Table:
    """A table of a file or sheet: its cells, its name, that of its folder, and how messages call it."""

    cells: pd.DataFrame
    name: str = ""
    folder: str = ""
    where: str = "the table"


def recognised(
    tables: Sequence[Table], columns: Mapping[str, str] | None = None, *, maximise: bool = False
) -> tuple[pd.DataFrame, list[str]]:
    """Return the rows of the runs of tables, and sentences on what was taken for what.

    The rows have ``problem``, ``optimizer``, ``run`` (from 0), ``value``, +inf for failed runs, and ``more``, whether
    it is negated; and ``evaluations`` and ``seed`` where all have them.

    Args:
        tables: of one experiment.
        columns: the names of columns by what they are, a key of :data:`SYNONYMS`, for those that are not recognised.
        maximise: whether higher values are better; they are then negated.

    Raises:
        BenchError: for summaries, for tables without values, optimizers or problems, for columns of which it is unclear
            what they are, and where several rows are of one run and none says in which order.
    """
    given = columns or {}
    if unknown := [role for role in given if role not in SYNONYMS]:
        raise BenchError(f"a column is no {unknown[0]!r}{nearest(unknown[0], SYNONYMS)}; it is {', '.join(SYNONYMS)}")
    heads = {_plain(name) for table in tables for name in table.cells}
    if absent := [name for name in given.values() if _plain(name) not in heads]:
        raise BenchError(f"{tables[0].where} has no column {absent[0]!r}")
    names = _distinct([table.name for table in tables])
    parts = [_long(table, name, given) for table, name in zip(tables, names, strict=True)]
    rows = pd.concat([part for part, _ in parts], ignore_index=True)
    said = [*dict.fromkeys(sentence for _, sentence in parts)][:5]
    if empty := int(rows["value"].isna().sum()):
        said.append(f"{count(empty, 'empty cell')} left out")
        rows = rows.dropna(subset="value")
    if rows.empty:
        raise BenchError(f"{tables[0].where} holds no value")
    for name in ("problem", "optimizer"):
        rows[name] = rows[name].astype(str).str.strip()
    more = rows["more"] = rows["more"] | maximise
    rows["value"] = rows["value"].mask(more, (-rows["value"]).replace(-np.inf, np.inf))
    way = "higher is better: values are negated" if more.any() else "lower is better"
    if more.any() and not more.all():
        way += f" on {listed(sorted(rows['problem'][more].unique()))}, and lower on the others"
    rows, about = _by_run(rows)
    best = rows.groupby(["problem", "optimizer", "run"])["value"].min()
    trials = best.groupby(["problem", "optimizer"]).size()
    least = f"{trials.min()} to " if trials.min() < trials.max() else ""
    optimizers, problems = (count(rows[name].nunique(), name) for name in ("optimizer", "problem"))
    said.append(f"{least}{count(trials.max(), 'run')} of {optimizers} on {problems}; {way}")
    if failed := int(np.isposinf(best).sum()):
        said.append(f"{count(failed, 'run')} failed, and {'count' if failed > 1 else 'counts'} as the worst")
    return rows.reset_index(drop=True), [*said, *about]


def are_problems(names: Iterable[object]) -> bool:
    """Return whether at least half of the names are those of test functions."""
    found = [_PROBLEM.fullmatch(_plain(name)) is not None for name in dict.fromkeys(names)]
    return sum(found) * 2 >= len(found) > 0


def _plain(name: object) -> str:
    return re.sub(r"[^a-z0-9]", "", re.sub(r"[\[(].*?[\])]", "", str(name)).lower())


def _numbers(cells: pd.Series[str], where: str) -> tuple[pd.Series[float], pd.Series[str]]:
    """Return the numbers of a column, missing where a cell is empty, +inf where it failed; and the cells that are none.

    Raises:
        BenchError: for a mean with its deviation.
    """
    if pd.api.types.is_numeric_dtype(cells) and not pd.api.types.is_bool_dtype(cells):
        return cells.astype(float), cells.iloc[:0]
    texts = cells.fillna("").astype(str).str.strip().str.replace("−", "-")
    failed = texts.str.lower().isin(_FAILED)
    texts = texts.mask(failed, "")
    if (summaries := texts[texts.str.fullmatch(_SUMMARY)]).size:
        raise BenchError(f"{where} has {summaries.iloc[0]!r}, {NO_TEST}")
    turned = texts.str.translate({ord(","): ".", ord("."): ","})
    if texts.str.contains(",").any() and turned[turned.str.contains(",")].str.fullmatch(_THOUSANDS).all():
        texts = turned  # 1.234,5 or 0,5
    texts = texts.mask(texts.str.fullmatch(_THOUSANDS), texts.str.replace(",", "")).str.replace(",", ".")
    found = pd.to_numeric(texts, errors="coerce").astype(float)
    return found.mask(failed, np.inf), cells[found.isna() & (texts != "")]


def _counts(found: pd.Series[float]) -> bool:
    """Return whether a column counts from 0 or 1, each number as often: it numbers something, and holds no values."""
    levels = found.value_counts().sort_index()
    return levels.nunique() == 1 < len(levels) and levels.index[0] in (0, 1) and set(np.diff(levels.index)) == {1}


def _roles(heads: Sequence[str], given: Mapping[str, str], figures: Container[str]) -> dict[str, str]:
    """Return the names of columns by what they are; ``figures`` are those that hold numbers."""
    plain = {_plain(name): name for name in reversed(heads)}
    roles = {role: plain[_plain(name)] for role, name in given.items() if _plain(name) in plain}
    for role, synonyms in SYNONYMS.items():
        for synonym in filter(plain.__contains__, synonyms.split()):
            name = plain[synonym]
            text = name not in figures or synonym not in _AMBIGUOUS
            if (text if role in _NAMES else name in figures) and role not in roles and name not in roles.values():
                roles[role] = name
    return roles


def _long(table: Table, name: str, given: Mapping[str, str]) -> tuple[pd.DataFrame, str]:
    """Return the rows of a table, and what its columns were taken for."""
    cells = table.cells.set_axis([str(each).strip() for each in table.cells], axis=1)
    cells = cells.loc[:, ~cells.columns.duplicated()].reset_index(drop=True)
    heads: list[str] = [*cells]
    read = {each: _numbers(cells[each], f"{table.where}, column {each!r},") for each in heads}
    figures = pd.DataFrame({each: found for each, (found, odd) in read.items() if odd.empty}, cells.index)
    names = {_plain(each) for each in heads}
    if names & _MEANS and names & _SPREADS:
        raise BenchError(f"{table.where} has the columns {listed(heads, 8)}: {NO_TEST}")
    roles = _roles(heads, given, figures)
    unknown = [each for each in heads if each not in roles.values() and not _EXTRA.fullmatch(_plain(each))]
    for each in [*unknown, *(of for role, of in roles.items() if role not in _NAMES)]:
        found, odd = read[each]
        if len(odd) and (each not in unknown or len(odd) < found.count()):
            where = f"{table.where}, column {each!r}, data row {odd.index[0] + 1}"
            raise BenchError(f"{where}, has {odd.iloc[0]!r}, which is no number")
    wide = [each for each in unknown if each in figures]
    if "value" not in roles and len(wide) == 1 and {"problem", "optimizer"} <= {*roles}:
        roles["value"] = wide[0]
    elif _plain(roles.get("value", "")) in _SHORT and "optimizer" not in roles and wide:
        wide.append(roles.pop("value"))  # an optimizer may be called GD
    texts = [each for each in unknown if each not in figures]
    by = [roles[role] for role in ("problem", "optimizer") if role in roles] or texts[: "value" not in roles]
    words = cells.astype(dict.fromkeys(texts, str))
    few = [each for each in texts if len(by) < 2 and words[each].nunique() <= len(cells) / 2]
    unclear = [each for each in few if words.groupby(by or (lambda _: 0))[each].nunique().max() > 1]
    if "value" not in roles and not any(form.fullmatch(_plain(each)) for form in (_RUNS, _ITERATIONS) for each in wide):
        unclear += [each for each in wide if len(by) > 1 or _counts(figures[each])]
    if unclear:
        raise BenchError(
            f"{table.where} has columns that may be names, numbers of runs or values: {listed(unknown, 8)}; say which "
            "by --column problem=NAME, optimizer=NAME, run=NAME or value=NAME, or leave out those that are none"
        )
    kept = pd.DataFrame({role: (cells if role in _NAMES else figures)[of] for role, of in roles.items()}, cells.index)
    spread = ""
    if "value" not in roles:
        if not wide:
            raise BenchError(
                f"{table.where} has no column of values among {listed(heads, 12)}; name it by --column value=NAME"
            )
        kept, spread, wide = _melted(figures[wide], cells[texts[0]] if texts else None, roles, kept)
    by_name = _named(name, table, kept)
    kept = kept.assign(**by_name)
    measured = kept["indicator"] if "indicator" in kept else pd.Series(roles.get("value", ""), kept.index)
    kept["more"] = measured.map(_plain).isin(_MORE_IS_BETTER)
    if measured.nunique() > 1:
        kept["problem"] = kept["problem"].astype(str) + " " + measured.astype(str)
    for role, letter in (("dimension", "d"), ("instance", "i")):
        if role in kept and kept[role].notna().all() and roles.get("problem") != roles[role]:
            kept["problem"] = kept["problem"].astype(str) + f"-{letter}" + kept[role].map("{:g}".format)
    unused = [each for each in heads if each not in {*roles.values(), *wide}]
    said = [f"{of} = {role}" for role, of in roles.items() if role in kept]
    said += [spread] if spread else []
    said += [f"{'file or folder names' if table.name else 'none'} = {role}" for role in by_name]
    said += [f"not used: {listed(unused, 8)}"] if unused else []
    wanted = ["problem", "optimizer", "run", "seed", "evaluations", "iteration", "value", "more"]
    return kept[[each for each in wanted if each in kept]], "columns: " + "; ".join(said)


def _melted(
    wide: pd.DataFrame, texts: pd.Series[str] | None, roles: dict[str, str], kept: pd.DataFrame
) -> tuple[pd.DataFrame, str, list[str]]:
    """Return a row for each value of a table with several columns of them, what these columns are, and their names.

    Args:
        wide: the columns of values.
        texts: a column that names problems or optimizers where no other is known to.
        roles: the names of columns by what they are, which get that of ``texts``.
        kept: the columns of these roles.
    """
    heads, named = [*map(str, wide)], {"problem", "optimizer"} & {*roles}
    steps, runs = ([each for each in heads if form.fullmatch(_plain(each))] for form in (_ITERATIONS, _RUNS))
    if steps:
        role, heads = "iteration", steps
    elif len(runs) >= max(2, len(heads) / 2):
        role, heads = "run", runs
    else:
        role = "problem" if "optimizer" in named or (not named and are_problems(heads)) else "optimizer"
    said = f"{listed(heads, 6)} = {role}s"
    if texts is not None and not named:
        other = "problem" if role == "optimizer" or (role == "run" and are_problems(texts)) else "optimizer"
        roles[other], kept[other], named = str(texts.name), texts, {other}
    if role == "run" and not named and len(wide) > 1:  # a matrix
        counts = len(wide) > 2 and bool((wide[heads].iloc[-1] > wide[heads].iloc[-2]).all())
        if (wide[heads].iloc[: -1 if counts else None].diff().iloc[1:] <= 0).all(axis=None):
            wide, kept = (each.iloc[:-1] if counts else each for each in (wide, kept))
            said += ", rows = iterations" + "; the last row, of evaluations, is left out" * counts
            kept = kept.assign(iteration=range(len(wide)))
        else:
            said += f", rows = problems f1 to f{len(wide)}"
            kept["problem"] = [f"f{place}" for place in range(1, len(wide) + 1)]
    elif role == "iteration" and not {*roles} & {"run", "seed"}:
        kept["run"] = kept.groupby([*named], sort=False).cumcount() if named else range(len(wide))
    parts = [
        kept.assign(value=wide[each], **{role: place if role == "iteration" else each})
        for place, each in enumerate(heads)
    ]
    return pd.concat(parts, ignore_index=True), said, heads


def _distinct(names: Sequence[str]) -> list[str]:
    """Return the names of files without the words that all have, or that name no problem and no optimizer."""
    parts = [re.split(r"[_\s]+|-(?=best|convergence|results?)", name) for name in names]
    shared = set(parts[0]).intersection(*parts[1:]) if len(set(names)) > 1 else set()
    return [
        "_".join(part for part in of if part not in shared and not _GENERIC.fullmatch(part.lower())) or name
        for of, name in zip(parts, names, strict=True)
    ]


def _named(name: str, table: Table, kept: pd.DataFrame) -> dict[str, str]:
    """Return the problem and the optimizer that names of file and folder give where no column does."""
    missing = [role for role in ("optimizer", "problem") if role not in kept]
    if len(missing) < 2:
        return {role: name or role for role in missing}
    if cec := re.fullmatch(r"(.+?)[_-][fF]?(\d+)[_-][dD]?(\d+)", table.name):
        return {"optimizer": cec[1], "problem": f"f{int(cec[2])}-d{cec[3]}"}
    for form in (r"(?P<optimizer>.+?)[_-](?P<problem>.+)", r"(?P<problem>.+)[_-](?P<optimizer>.+?)"):
        pair = re.fullmatch(form, table.name)
        if pair and are_problems([pair["problem"]]) and not are_problems([pair["optimizer"]]):
            return pair.groupdict()
    if are_problems([table.folder]) and not are_problems([name]):
        return {"optimizer": name or "optimizer", "problem": table.folder}
    return {"optimizer": table.folder or "optimizer", "problem": name or "problem"}


def _by_run(rows: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return rows with runs as numbers from 0, those of a run in order of evaluations; and what is to be said."""
    cell, notes = ["problem", "optimizer"], []
    partly = [name for name in ("run", "seed", "evaluations", "iteration") if name in rows and rows[name].isna().any()]
    rows = rows.drop(columns=partly)
    key, step = (next(filter(rows.__contains__, of), "") for of in (("run", "seed"), ("evaluations", "iteration")))
    numbered = rows[key] if key else rows.groupby(cell, sort=False).cumcount()
    if not key and step and (rows.groupby(cell)[step].diff().dropna() > 0).all():
        numbered = numbered * 0  # the course of one run
    if "seed" in rows:
        seeds = rows["seed"]
        whole = (seeds % 1 == 0) & (seeds >= 0) & (seeds < 2**53)
        rows = rows.assign(seed=seeds.astype("int64")) if whole.all() else rows.drop(columns="seed")
    order = pd.to_numeric(numbered, errors="coerce")
    numbered = order if order.notna().all() else numbered.astype(str)
    rows = rows.assign(run=pd.factorize(numbered, sort=True)[0])
    one = [*cell, "run"]
    if key and rows["problem"].nunique() > 1:
        shared = key == "seed" and rows.groupby("run")["problem"].nunique().max() > 1
        what = "seeds: they" if shared else "numbers: where these are seeds, they"
        notes.append(f"runs on different problems share {what} may depend on each other")
    if rows.duplicated(one).any():
        if step == "iteration":
            notes.append("the best of the iterations of a run counts")
            rows = rows.sort_values("value", kind="stable").drop_duplicates(one).sort_index()
        elif rows.duplicated(within := [*one, step] if step else one).any():
            twice = rows[rows.duplicated(within)].iloc[0]
            raise BenchError(
                f"several rows are of one run of {twice['optimizer']} on {twice['problem']}; name the column that "
                "separates runs by --column run=NAME, or that of the evaluations of a course by --column "
                "evaluations=NAME"
            )
        else:
            rows = rows.sort_values(within, kind="stable")
    return rows.drop(columns="iteration", errors="ignore"), notes
