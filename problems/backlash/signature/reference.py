"""Find the reference fit, the best signature of a recording, by an exhaustive search instead of sampling.

For a window and a pair (tau, omega) the best fit is solved for (:mod:`~problems.backlash.signature.projection`). Over
those four, the window's first and last sample, tau and omega, the folded sums of
:mod:`~problems.backlash.signature.kernel` make a whole grid affordable:

1. *scan*: every start, every length, 6 values of tau and 79 of omega. The main lobe of the spectrum of a window of
   at most 0.2 s is at least 10 Hz wide and the grid has a line each 0.5 Hz; two neighbours in tau differ by a factor of
   1.4. So at most 2% of the explained energy is missed between two lines. A start is skipped only if no waveform at
   all, repeated from there, could explain as much, and a window is looked at more closely only if its best sine and
   cosine of any phase come near the best energy so far.
2. *polish*: every pair of start and omega near the best is refined by compass search over (tau, omega), all lengths
   at each point.
3. *settle*: the ends of the window become times. Where T_d is no whole number of samples (the scan then
   interpolates), they are refined on the signal itself; only in this case the result is merely the best of many
   searches.

A window longer than T_d overlaps the next one; the sums then include the products of the overlapping samples.

Nothing here is random. It is not an optimizer plug-in: those see only the objective, and this uses the formula.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numba import njit

from bench.contract.typing import Floats
from problems.backlash.signature.kernel import Folded
from problems.backlash.signature.model import EDGE, T0
from problems.backlash.signature.projection import (
    CLEARANCE,
    SINGULAR,
    Limits,
    Sums,
    explained,
    fold_sums,
    largest_phase,
    largest_t1,
    limits,
    overlap,
    profile,
    solve_cell,
)

TAUS, OMEGAS = 6, 79  # lines of the scan's grid
COARSE = 8  # one line of omega in so many is scanned before the others
MARGIN, SETTLED = 0.03, 12  # pairs within this share of the best energy are polished, and this number is settled
MARGIN_BETWEEN, SETTLED_BETWEEN = 0.1, 40  # the same if T_d lies between samples, where the scan is not exact
POLISHED = 400  # the largest number of pairs that are polished
ROUGH, FINEST = 1e-3, 1e-7  # the step that ends a compass search, in units of its first: for all pairs, for the best
ROUNDS = 60  # the largest number of rounds, of eight points each, of the last search, on the signal itself
SWEPT, SWEEPS = 16, 6  # that search's windows, and the most sweeps over the ends of each; a refinement follows a sweep
NEAR = 2  # the samples to both sides over which a sweep moves an end
PLACES = 24  # the most places a sample in a sweep
SHORT = (
    10_000  # samples of a recording up to which these numbers of windows hold; longer ones have proportionally fewer
)
ROUNDING = 1e-13  # a relative gain up to this is rounding


def best_fit(recording: Folded, lower: Floats, upper: Floats, *, constrained: bool) -> Floats:
    """Return the (7,) point of the lowest RMSE within the (7,) bounds and, if asked for, the constraints of 7.2.2.

    Where t0 may not lie anywhere in the recording, the first window begins within t0's bounds, too.
    """
    limit, length, sums = prepare(recording, lower, upper, constrained=constrained)
    taus, omegas = np.geomspace(*limit.tau, TAUS), np.linspace(*limit.omega, OMEGAS)
    ceiling = _ceiling(recording.signal, sums, length)
    share = min(SHORT / sums.n, 1.0)
    margin, most = (MARGIN, SETTLED) if recording.shift else (MARGIN_BETWEEN, math.ceil(share * SETTLED_BETWEEN))
    grid, most_yet = np.zeros((sums.n, OMEGAS, 2)), 0.0
    starts = min(limit.last, math.floor((upper[T0] - recording.start) / recording.dt + EDGE)) + 1
    for base in range(1, starts, 2 * length):
        count = min(2 * length, starts - base)
        if (ceiling[base : base + count] > most_yet).any():
            scanned = _scan(base, count, taus, omegas, sums, limit, length, 1 - margin - ROUNDING, most_yet)
            grid[base : base + count], most_yet = scanned, max(most_yet, scanned[..., 0].max())
    energy = grid[..., 0]
    near = np.argwhere(energy >= (1 - margin) * energy.max())
    near = near[np.argsort(-energy[tuple(near.T)], kind="stable")][:POLISHED]
    steps = np.array([1.0, (omegas[1] - omegas[0]) / 2])
    windows = [
        _polish(np.array([grid[start, column, 1], omegas[column]]), steps, start, sums, limit, length, ROUGH)
        for start, column in near
    ]
    windows = _distinct(windows)[:most]
    windows = [
        _polish(np.array([window.tau, window.omega]), 10 * ROUGH * steps, window.start, sums, limit, length, FINEST)
        for window in windows
    ]
    if not recording.shift:
        windows = sorted(windows, key=lambda window: -settle(window, recording, sums, limit, sweeps=0)[0])
        windows = windows[: math.ceil(share * SWEPT)]
    settled = [settle(window, recording, sums, limit, sweeps=SWEEPS) for window in windows]
    return np.clip(max(settled, key=lambda fit: fit[0])[1], lower, upper)


def _distinct(windows: Iterable[Window]) -> list[Window]:
    """Return the windows by falling energy, without those that a search has brought to the place of a better one."""
    places: dict[tuple[float, ...], Window] = {}
    for window in sorted(windows, key=lambda window: -window.energy):
        places.setdefault((window.start, window.samples, round(window.tau, 1), round(window.omega, 1)), window)
    return list(places.values())


def prepare(recording: Folded, lower: Floats, upper: Floats, *, constrained: bool) -> tuple[Limits, int, Sums]:
    """Return the limits of a fit, the samples of its longest window, and the sums folded for it."""
    limit = limits(recording, lower, upper, constrained=constrained)
    length = min(math.ceil(limit.t2 / recording.dt), len(recording.signal))
    return limit, length, fold_sums(recording, length)


class Window(NamedTuple):
    """The best of a scan or a polish: the energy explained, tau, omega, the first sample, the number of samples."""

    energy: float
    tau: float
    omega: float
    start: int
    samples: int
    sine: float
    cosine: float


def _ceiling(signal: Floats, sums: Sums, length: int) -> Floats:
    """Return for each start (N,) the energy that the best of all waveforms of that many samples would explain.

    Each sample of a waveform of at most half a turn is independent of the others, in all half turns. The last samples
    of a longer waveform overlap the first samples of its next repetition: they change these samples' sums in all half
    turns but the first, and have no overlap after the last repetition.
    """
    if length > 2 * sums.lag:
        return np.full(sums.n, np.inf)
    laid = max(length - math.floor(sums.lag), 0)

    def window(apart: Floats, usual: Floats) -> Floats:
        apart_so_far, usual_so_far = (np.concatenate([[0.0], np.cumsum(energies)]) for energies in (apart, usual))
        start = np.arange(sums.n)
        overlapping = apart_so_far[start + laid] - apart_so_far[start]
        reached: Floats = overlapping + usual_so_far[start + length - laid] - usual_so_far[start + laid]
        return reached

    r, inside = np.zeros_like(sums.f), np.zeros_like(sums.f)
    r[: sums.n], inside[: sums.n] = signal, 1.0
    after, after_inside = np.zeros_like(r), np.zeros_like(r)
    if (end := math.floor(sums.replicas * sums.lag)) < sums.n:
        after[: len(r) - end], after_inside[: len(r) - end] = r[end:], inside[end:]
    terms, later_terms = np.maximum(sums.terms, 1.0), np.maximum(sums.terms - 1.0, 1.0)
    f, g = sums.f - r, sums.g - inside
    ff = window(r**2 + f**2 / later_terms + after**2, sums.f**2 / terms)
    fg = window(r + f * g / later_terms + after, sums.f * sums.g / terms)
    gg = window(inside + g**2 / later_terms + after_inside, sums.g**2 / terms)
    ceiling: Floats = ff + (sums.s1 - fg) ** 2 / np.maximum(sums.n - gg, 1e-9 * sums.n)
    return ceiling


@njit(cache=True, error_model="numpy")
def _scan(
    base: int, count: int, taus: Floats, omegas: Floats, sums: Sums, limit: Limits, length: int, share: float,
    top: float,
) -> Floats:  # fmt: skip
    """Return (count, omegas, 2): the most energy that a window from each start explains over tau and length, and tau.

    Both are 0 where the energy is less than ``share`` of the best one, which is at least ``top``. One omega in
    ``COARSE`` is scanned first: the best energy is then soon known nearly, and few cells come near it.

    Starts ``base`` and up are the inner loop, which vectorises; a cell's phase is checked only if the best of all
    phases would be a new best.
    """
    n, s1 = sums.n, sums.s1
    best = np.zeros((count, len(omegas), 2))
    cell = np.empty(7)
    free, most = np.empty(count), np.empty(count)
    for w in np.argsort(np.arange(len(omegas)) % COARSE):
        most[:] = share * top
        for tau in taus:
            q = math.exp(-tau * sums.dt)
            re, im, q_re, q_im = 1.0, 0.0, q * math.cos(omegas[w] * sums.dt), q * math.sin(omegas[w] * sums.dt)
            m_ss, m_sc, m_cc = np.zeros(count), np.zeros(count), np.zeros(count)
            m_gs, m_gc, m_fs, m_fc = np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count)
            for j in range(min(length, limit.last - base + 1)):
                f, g, terms = sums.f[base + j :], sums.g[base + j :], sums.terms[base + j :]
                for turns in range(1, math.floor(j / sums.lag) + 1):
                    ss, sc, cc = overlap(tau, omegas[w], im, re, j, turns, sums)
                    for k in range(np.uintp(count)):
                        pairs = min(terms[k], float(sums.replicas - turns))
                        m_ss[k] += pairs * ss
                        m_sc[k] += pairs * sc
                        m_cc[k] += pairs * cc
                better = 0
                for k in range(np.uintp(count)):
                    m_ss[k] += terms[k] * (im * im)
                    m_sc[k] += terms[k] * (im * re)
                    m_cc[k] += terms[k] * (re * re)
                    m_gs[k] += g[k] * im
                    m_gc[k] += g[k] * re
                    m_fs[k] += f[k] * im
                    m_fc[k] += f[k] * re
                    gs, gc = m_gs[k] / n, m_gc[k] / n
                    ss, sc, cc = m_ss[k] - m_gs[k] * gs, m_sc[k] - m_gs[k] * gc, m_cc[k] - m_gc[k] * gc
                    s, c = m_fs[k] - gs * s1, m_fc[k] - gc * s1
                    det = ss * cc - sc * sc
                    free[k] = (cc * s * s - 2 * sc * s * c + ss * c * c) / det if det > SINGULAR * ss * cc else np.inf
                    better += free[k] > most[k]
                for k in range(min(count, limit.last + 1 - base - j) if better else 0):
                    if free[k] > most[k]:
                        phase = largest_phase(omegas[w], base + k, j, sums, limit)
                        if phase > 0.0:
                            cell[:] = m_ss[k], m_sc[k], m_cc[k], m_gs[k], m_gc[k], m_fs[k], m_fc[k]
                            energy = solve_cell(cell, sums, phase, limit.reach, most[k])[0]
                            if energy > most[k]:
                                most[k] = best[k, w, 0] = energy
                                best[k, w, 1] = tau
                                top = max(top, energy)
                re, im = re * q_re - im * q_im, re * q_im + im * q_re
    return best


@njit(cache=True, error_model="numpy")
def _search(at: Floats, steps: Floats, start: int, sums: Sums, limit: Limits, length: int, finest: float) -> Floats:
    """Return the (2,) tau and omega of a local maximum, by compass search from ``at``, diagonals included."""
    low, high = (limit.tau[0], limit.omega[0]), (limit.tau[1], limit.omega[1])
    best = profile(at[0], at[1], start, sums, limit, length)[0]
    at, step, scale = at.copy(), steps.copy(), 1.0
    while scale > finest:
        centre, moved = at.copy(), False
        for turn in (0, 1, 2, 3, 5, 6, 7, 8):  # 4 is the centre
            tau = min(max(centre[0] + (turn // 3 - 1) * scale * step[0], low[0]), high[0])
            omega = min(max(centre[1] + (turn % 3 - 1) * scale * step[1], low[1]), high[1])
            energy = profile(tau, omega, start, sums, limit, length)[0]
            if energy > best:
                best, at[0], at[1], moved = energy, tau, omega, True
        if not moved:
            scale /= 2
        elif scale < 1:
            scale *= 2  # else the steps would stay short along a narrow ridge
    return at


def _polish(at: Floats, steps: Floats, start: int, sums: Sums, limit: Limits, length: int, finest: float) -> Window:
    tau, omega = _search(at, steps, start, sums, limit, length, finest)
    energy, samples, sine, cosine = profile(tau, omega, start, sums, limit, length)
    return Window(energy, tau, omega, int(start), samples, sine, cosine)


def settle(window: Window, recording: Folded, sums: Sums, limit: Limits, *, sweeps: int | None) -> tuple[float, Floats]:
    """Return the energy that a window explains and its (7,) point, with the window's ends as times.

    If T_d lies between samples, the point is searched for on the signal itself, unless ``sweeps`` is None. All begins
    between the same two samples give the same fit, and so do all ends; the middle of the allowed range is taken.
    """
    dt, omega = sums.dt, window.omega
    since = math.atan2(window.cosine, window.sine) % math.pi / omega  # of the first sample since t0
    start, samples = window.start, window.samples
    if since < CLEARANCE:  # the first sample is at t0, where the oscillation is 0: it may be outside
        since, start, samples = since + dt, start + 1, samples - 1
    latest = min(since - CLEARANCE, largest_t1(omega, limit))
    growth = math.log(max(limit.reach / math.hypot(window.sine, window.cosine), 1.0)) / window.tau  # A's own bound
    t1 = (min(max(since - min(dt, growth), 0.0), latest) + latest) / 2
    last = since + (samples - 1) * dt
    t2 = min(last + dt / 2, limit.t2)
    first = recording.start + start * dt
    at = np.array([window.tau, omega, first - since + t1, first - since + t2])
    if not recording.shift and sweeps is not None:
        at = _search_signal(at, _places(recording), recording, limit, sweeps)
    energy, sine, cosine, offset = explained(at, recording, limit)
    angle, size = math.atan2(cosine, sine), math.hypot(sine, cosine)
    phase, a = (angle, size) if angle >= 0.0 else (angle + math.pi, -size)
    t1, t0 = phase / at[1], at[2] - phase / at[1]
    return energy, np.array([a, t0, at[0], at[1], offset, t1, at[3] - t0])


def _places(recording: Folded) -> Floats:
    """Return the places between two samples, in s, where the end of a window crosses a sample of some half turn.

    A long recording, where one sample has little weight, has ``PLACES`` evenly spaced places.
    """
    dt = recording.dt
    turns = min(recording.replicas, int(len(recording.signal) * dt / recording.delay) + 1)
    places = np.unique(np.round(-np.arange(turns) * recording.delay / dt % 1.0, 9) % 1.0)
    return dt * (places if len(places) <= PLACES else np.arange(PLACES) / PLACES)


@njit(cache=True, error_model="numpy")
def _search_signal(at: Floats, places: Floats, recording: Folded, limit: Limits, sweeps: int) -> Floats:
    """Return the (4,) tau, omega, begin and end of a local maximum on the signal itself.

    As begin or end moves, samples enter and leave in one half turn after the other; all such places nearby are tried.
    """
    steps = np.array([1.0, 1.0, recording.dt, recording.dt])
    at = _refine(at, steps, recording, limit)
    energy = explained(at, recording, limit)[0]
    for _ in range(sweeps):
        for end in (2, 3):
            at = _sweep(at, end, places, recording, limit)
        at = _refine(at, steps, recording, limit)
        before, energy = energy, explained(at, recording, limit)[0]
        if energy <= before * (1 + ROUNDING):
            break
    return at


@njit(cache=True, error_model="numpy")
def _sweep(at: Floats, which: int, places: Floats, recording: Folded, limit: Limits) -> Floats:
    """Return the (4,) point with the best begin (2) or end (3) within ``NEAR`` samples, the other values unchanged."""
    best, dt = explained(at, recording, limit)[0], recording.dt
    sample = recording.start + math.floor((at[which] - recording.start) / dt) * dt
    best_at = at.copy()
    for i in range(-NEAR, NEAR + 1):
        for place in places:
            for side in (-2 * CLEARANCE, 2 * CLEARANCE):
                trial = at.copy()
                trial[which] = sample + i * dt + place + side
                energy = explained(trial, recording, limit)[0]
                if energy > best * (1 + ROUNDING):
                    best, best_at = energy, trial
    return best_at


@njit(cache=True, error_model="numpy")
def _refine(at: Floats, steps: Floats, recording: Folded, limit: Limits) -> Floats:
    """Return the (4,) tau, omega, begin and end of a local maximum, by compass search from ``at``."""
    low, high = (limit.tau[0], limit.omega[0]), (limit.tau[1], limit.omega[1])
    best, scale = explained(at, recording, limit)[0], 1.0
    for _ in range(ROUNDS):
        moved = False
        for turn in range(8):
            trial = at.copy()
            trial[turn // 2] += (2 * (turn % 2) - 1) * scale * steps[turn // 2]
            trial[0], trial[1] = min(max(trial[0], low[0]), high[0]), min(max(trial[1], low[1]), high[1])
            energy = explained(trial, recording, limit)[0]
            if energy > best * (1 + ROUNDING):
                best, at, moved = energy, trial, True
        if not moved:
            scale /= 2
        if scale < FINEST:
            break
    return at
