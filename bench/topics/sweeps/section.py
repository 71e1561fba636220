"""Estimate the contribution of each component: main effects and interactions of the parameters of a sweep."""

from __future__ import annotations

import pandas as pd

from bench.analysis.direction import ALPHA
from bench.analysis.factors import HIGHER, TRIALS, Contributions, contributions, mean_shares
from bench.plots import style
from bench.plots.factors import main_effect, share_map
from bench.report.parts import Figure, Part, Section, Table
from bench.report.wording import MISSING, count, listing, p_text
from bench.study.sweep import Sweep
from bench.topics.findings import Findings
from bench.topics.topic import Topic

TITLE = "What each component contributes"
SMALL = 0.01  # a share below it is none that a sentence names
LARGE = 0.05  # a share from which on an interaction changes how main effects are read
MEANING = (
    "The chance of a value is the probability that a trial with it ends lower than a trial of a random combination of "
    "the sweep on the same problem: 0.5 is neither better nor worse. Shares divide the variance of these chances among "
    "the parameters, their interactions and the randomness of trials; in expectation, the share of a parameter "
    "without any effect is 0."
)


def by_sweep(findings: Findings) -> dict[str, Contributions]:
    """Return the contributions of each sweep's parameters, by its name; one that lacks a combination has no entry."""
    frame = findings.trials.frame
    return {sweep.name: contributions(frame, sweep) for sweep in findings.study.sweeps if not sweep.missing}


def section(findings: Findings) -> Section | None:
    """Return the section on the contributions of each sweep's parameters; None where the study has no sweep."""
    if not findings.study.sweeps:
        return None
    parts = [_of(sweep, findings.of(by_sweep).get(sweep.name)) for sweep in findings.study.sweeps]
    if len(parts) == 1:
        return Section(TITLE, (MEANING, *parts[0].text), parts[0].items, parts[0].warnings)
    return Section(TITLE, (MEANING,), sections=tuple(parts))


def _of(sweep: Sweep, result: Contributions | None) -> Section:
    """Return the subsection on one sweep."""
    if result is None:
        lacking = (
            f"The study lacks {count(len(sweep.missing), 'combination')} of the parameters of {sweep.name}, such as "
            f"{sweep.missing[0]}. The parameters then do not vary independently, and their effects cannot be separated."
        )
        return Section(sweep.name, warnings=(lacking,))
    warnings = []
    if result.left_out:
        warnings.append(f"Left out, as a combination of {sweep.name} has no trial: {listing(result.left_out)}.")
    if result.levels.empty:
        return Section(
            sweep.name, (f"No problem has trials of every combination of {sweep.name}.",), (), tuple(warnings)
        )
    tests, shares = result.tests, mean_shares(result.effects).clip(lower=0)
    problems = result.levels["problem"].nunique()
    text = [_size(sweep, problems), _matter(tests, problems), _ranking(sweep, result, shares)]
    text += [*_values(tests, problems), *_pairs(tests, shares)]
    items: list[Part] = [_parameters(sweep, result, shares), _main_effects(sweep, result)]
    factors = list(tests["factor"])
    if len(factors) > 1 and len(shares):
        items.append(_share_map(sweep, shares, factors))
    items += [_levels(sweep, result), _effects(sweep, result)]
    return Section(sweep.name, tuple(filter(None, text)), tuple(items), tuple(warnings))


def _size(sweep: Sweep, problems: int) -> str:
    values = [f"{name} ({', '.join(levels)})" for name, levels in sweep.factors.items()]
    return (
        f"{sweep.name} ran with {count(len(sweep.labels), 'combination')} of {listing(values)}, on "
        f"{count(problems, 'problem')}."
    )


def _ranking(sweep: Sweep, result: Contributions, shares: pd.Series[float]) -> str:
    """Return a sentence on the share of the variance that each parameter explains."""
    if shares.empty:
        return "Shares of the variance are not known: a combination has a single trial, or all trials tie."
    with_shares = result.effects.dropna(subset="share")
    problems = with_shares["problem"].nunique()
    mains = shares[[name for name in shares.index if name in sweep.factors]].sort_values(ascending=False, kind="stable")
    parts = [f"{name} {_percent(share)}" for name, share in [*mains.items(), (TRIALS, float(shares[TRIALS]))]]
    mean = "" if problems == 1 else f", in the mean over {count(problems, 'problem')}"
    sentence = f"Shares of the variance among trials{mean}: {listing(parts, at_most=12)}."
    if len(mains) > 1 and mains.iloc[0] >= SMALL:
        table = with_shares[with_shares["component"].isin(mains.index)].pivot(
            index="problem", columns="component", values="share"
        )
        first = int((table[mains.index[0]] >= table.max(axis=1)).sum())
        sentence += f" {mains.index[0]} has the largest share of its own on {first} of {count(problems, 'problem')}."
    return sentence


def _matter(tests: pd.DataFrame, problems: int) -> str:
    """Return which parameters change the results on these problems, by themselves or together with others."""
    shown, open_ = list[str](), list[str]()
    for name, p in zip(tests["factor"], tests["p_here"], strict=True):
        (shown if p <= ALPHA else open_).append(f"{name} ({p_text(p)})")
    on = " on this problem" if problems == 1 else f" on these {problems} problems"
    parts = [f"{listing(shown, 12)} {'matters' if len(shown) == 1 else 'matter'}{on}"] if shown else []
    if open_:
        parts.append(f"{'of' if shown else 'Of'} {listing(open_, 12)} no effect is shown{'' if shown else on}")
    return f"{'; '.join(parts)}: permutation tests, adjusted over the parameters."


def _values(tests: pd.DataFrame, problems: int) -> list[str]:
    """Return for each parameter which value is best, as far as problems and trials allow a statement."""
    sentences = []
    for row in tests.to_dict("records"):
        name, best = row["factor"], row["best"]
        clear = row["p_holm"] <= ALPHA and not row["note"]
        top, low = f"{row['chance']:.2f}", f"{row['lowest']:.2f}"
        worse = (
            f"is shown to be better than {listing(row['worse'], 12)}"
            if row["worse"]
            else "no value is shown to be worse"
        )
        value = f"{best} has the highest mean chance ({top}; the lowest is {low}), and {worse}"
        if not best or (top == low and not clear):
            value = f"no value stands out, as the mean chance of each is {top}"
        if problems == 1:
            outcome = "this describes one problem only"
        elif clear:
            outcome = f"the values differ across problems ({p_text(row['p_holm'])}, adjusted)"
        elif row["note"] in ("untestable", "too few problems"):
            outcome = f"{count(problems, 'problem')} are too few to test it across problems"
        else:
            outcome = f"no difference across problems is shown ({p_text(row['p_holm'])}, adjusted)"
        sentences.append(f"{name}: {value}; {outcome}.")
    return sentences


def _pairs(tests: pd.DataFrame, shares: pd.Series[float]) -> list[str]:
    """Explain what interactions mean for reading the main effects."""
    pairs = shares[[name for name in shares.index if " × " in str(name) or name == HIGHER]]
    if pairs.empty:
        return []
    largest, share = str(pairs.idxmax()), float(pairs.max())
    if share < SMALL:
        return ["No interaction explains 1% or more: the effects of the parameters add up."]
    mains = shares[[name for name in tests["factor"] if name in shares.index]]
    caution = (
        " That is more than a parameter has on its own, so the best value of one depends on the other."
        if largest != HIGHER and share >= LARGE and share > min(mains[name] for name in largest.split(" × "))
        else ""
    )
    return [f"The largest interaction is that of {largest}, with {_percent(share)}.{caution}"]


def _percent(share: float) -> str:
    return "less than 1%" if share < SMALL else f"{share:.0%}"


def _main_effects(sweep: Sweep, result: Contributions) -> Figure:
    factors = list(dict.fromkeys(result.levels["factor"]))
    width = min(0.7 + 2.4 * len(factors), style.page_width())
    figure, axes = style.grid(
        len(factors), width=width, height=1.7, left=0.5, across=0.3, down=0.55, top=0.25, bottom=0.4
    )
    tables = [result.levels[result.levels["factor"] == name] for name in factors]
    low, high = result.levels["chance"].min(), result.levels["chance"].max()
    margin = 0.05 * max(high - low, 0.02)
    for number, (ax, name, levels) in enumerate(zip(axes, factors, tables, strict=True)):
        main_effect(levels, ax=ax)
        ax.set_ylim(min(low, 0.5) - margin, max(high, 0.5) + margin)
        style.title(ax, name)
        if number % 3:
            ax.tick_params(labelleft=False)
        else:
            ax.set_ylabel("chance to end lower")
    several = "A thin line is a problem, the thick one their mean." if result.levels["problem"].nunique() > 1 else ""
    caption = f"The chance of each value of the parameters of {sweep.name} to end lower; higher is better. {several}"
    return Figure(f"main-effects-{sweep.name}", caption.strip(), figure, result.levels)


def _share_map(sweep: Sweep, shares: pd.Series[float], factors: list[str]) -> Figure:
    height = max(0.3 * len(factors), 0.6) + 0.1
    left = 0.25 + style.text_width(style.names(factors, at_most=14).values())
    width = min(left + 0.9 * len(factors) + 0.3, style.page_width())
    figure, (ax,) = style.grid(1, columns=1, width=width, height=height, left=left, top=0.1, bottom=0.3)
    share_map(shares, factors, ax=ax)
    caption = (
        f"The share of the variance among trials that each parameter of {sweep.name} explains by itself (diagonal), "
        "and each pair by its interaction, in the mean over problems."
    )
    data = shares.rename("share").rename_axis("component").reset_index()
    return Figure(f"interactions-{sweep.name}", caption, figure, data)


def _parameters(sweep: Sweep, result: Contributions, shares: pd.Series[float]) -> Table:
    """Return a row a parameter: whether it matters, and which of its values are best."""
    tests = result.tests.set_index(pd.Index(result.tests["factor"], name="parameter"))
    across = [MISSING if note else _p(p) for p, note in zip(tests["p_holm"], tests["note"], strict=True)]
    shown = pd.DataFrame(
        {
            "matters (p)": [_p(p) for p in tests["p_here"]],
            "share": shares.reindex(tests.index),
            "best value": tests["best"].replace("", MISSING),
            "shown to be worse": [", ".join(worse) or MISSING for worse in tests["worse"]],
            "across problems (p)": across,
        }
    )
    return Table(
        f"parameters-{sweep.name}",
        f"Which parameters of {sweep.name} matter, and which values of them.",
        shown,
        decimals={"share": 2},
        note="Matters: whether the results on these problems depend on the parameter, by itself or with others "
        "(permutation test); share: of the variance, by itself; shown to be worse: than the best value, in the mean "
        "over problems and the other parameters; across problems: whether the values differ on further problems, of "
        "which these would be a sample. All three are tested at 5% for all parameters together, the last two only "
        "where the first shows something.",
        data=result.tests.assign(worse=[", ".join(worse) for worse in result.tests["worse"]]),
    )


def _p(p: float) -> str:
    return p_text(p).removeprefix("p ").removeprefix("= ")


def _levels(sweep: Sweep, result: Contributions) -> Table:
    chances = result.levels.groupby(["factor", "level"], sort=False)["chance"]
    shown = chances.mean().rename("mean chance").reset_index()
    highest = result.levels.groupby(["problem", "factor"])["chance"].transform("max")
    first = result.levels[result.levels["chance"] >= highest - 1e-9].groupby(["factor", "level"]).size()
    keys = pd.MultiIndex.from_frame(shown[["factor", "level"]])
    shown["best on problems"] = first.reindex(keys, fill_value=0).to_numpy()
    return Table(
        f"levels-{sweep.name}",
        f"The values of the parameters of {sweep.name}, over {count(result.levels['problem'].nunique(), 'problem')}.",
        shown.rename(columns={"factor": "parameter", "level": "value"}),
        decimals={"mean chance": 3},
        note="The file has every problem.",
        data=result.levels,
    )


def _effects(sweep: Sweep, result: Contributions) -> Table:
    shown = result.effects.pivot(index="problem", columns="component", values="share")
    components, problems = (list(dict.fromkeys(result.effects[name])) for name in ("component", "problem"))
    shown = shown.reindex(index=problems, columns=components).clip(0, 1)
    return Table(
        f"components-{sweep.name}",
        f"Shares of the variance among trials of {sweep.name}, problem by problem.",
        shown.rename_axis("problem").rename_axis(columns=None),
        decimals=2,
        note="0: no more than the randomness of trials explains; the file has the estimates, which may be below 0. "
        "–: a combination has a single trial, or all trials tie.",
        data=result.effects,
    )


TOPIC = Topic(TITLE, section, place=610)
