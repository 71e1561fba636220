"""The keys that a study's file may be expected to have and has not: what does their work."""

from __future__ import annotations

from collections.abc import Iterable

from bench.helpers.errors import nearest

ELSEWHERE = {
    "blocks": "reports make claims on these problems alone",
    "controls": "write one study for each set of conditions, with the same options for all [[optimizers]] in each",
    "looks": "'trials' is fixed before the first one; 'bench plan' says how many a difference needs",
    "registered": "a study file in git has a date; docs/how-to/publish.md says how to archive one",
    "rope": "'bench gate' has a margin, --not-worse-than",
    "tuning": "docs/how-to/tune.md says how to tune on other problems than those of the study",
}
"""By key, what exists in its place."""


def advice(key: str, known: Iterable[str]) -> str:
    """Return the rest of the sentence on an unknown key: what does its work, or the nearest of the known keys."""
    return f"; {ELSEWHERE[key]}" if key in ELSEWHERE else nearest(key, known)
