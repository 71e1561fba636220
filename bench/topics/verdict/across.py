"""Sentences on pairs that the tests over all problems leave open."""

from __future__ import annotations

from bench.report.wording import count, listing
from bench.topics.findings import Findings


def across(findings: Findings) -> str:
    """Return a sentence on what the tests across problems do not show."""
    tests, subject = findings.final.tested_overall, findings.final.subject
    if not findings.final.levels.across:
        few = f"{findings.trials.per_cell[0]:,} trials and {count(len(tests), 'pair')} of optimizers"
        return f"Nothing is tested over all problems: {few} leave no test that could be significant."
    apart = tests[~tests["significant"]]
    if apart.empty:
        whose = f"Every rival differs from {subject}" if subject else "Every pair of optimizers differs"
        return f"{whose} significantly over these problems{_on_each(findings)}."
    if len(apart) == len(tests) > 1:
        none = f"no rival from {subject}" if subject else "no two optimizers"
        return f"On these problems the tests distinguish {none} (Holm)."
    open_pairs = [f"{first} from {second}" for first, second in zip(apart["first"], apart["second"], strict=True)]
    return f"On these problems the tests do not distinguish {listing(open_pairs, at_most=4)} (Holm)."


def _on_each(findings: Findings) -> str:
    """Return a clause on which of the tested pairs differ significantly on each problem, too."""
    final = findings.final
    if not final.levels.problems:
        return "; on single problems none is tested"
    pairs = final.tested_pairs
    pairs = pairs[pairs["problem"].isin(list(final.medians.index))].astype({"first": object, "second": object})
    each = pairs.groupby(["first", "second"], sort=False)["significant"].all()
    if each.all() or not each.any():
        return ", and on each of them" if each.all() else ", but none on each of them"
    if not final.subject:
        return f", but only {int(each.sum()):,} of {len(each):,} on each of them"
    rivals = [second if first == final.subject else first for first, second in each.index[each]]
    return f", but only {listing(rivals, at_most=4)} on each of them"
