"""The swarms once more, written as plainly as they can be: one number at a time, in the words of the facts.

Each function makes ``T`` generations from the start ``x`` and returns the batches it evaluated, (N, d) each. ``f`` maps
one point to its value, ``confine`` brings a whole batch back (clip, then repair), ``rng`` is drawn from in the order
in which the optimizers draw. Nothing here is shared with the code under test.
"""

from collections import Counter
from math import exp, gamma, pi, sin, sqrt

import numpy as np


def gwo(f, confine, lower, upper, x, T, rng, variant="code"):
    N, d = x.shape
    batches = []
    score = {"alpha": np.inf, "beta": np.inf, "delta": np.inf}
    leader = {name: np.zeros(d) for name in score}
    for l in range(T):  # noqa: E741
        batches.append(x.copy())
        for i in range(N):
            value = f(x[i])
            if value < score["alpha"]:
                if variant == "cascade":
                    score["delta"], leader["delta"] = score["beta"], leader["beta"]
                    score["beta"], leader["beta"] = score["alpha"], leader["alpha"]
                score["alpha"], leader["alpha"] = value, x[i].copy()
            if score["alpha"] < value < score["beta"]:
                if variant == "cascade":
                    score["delta"], leader["delta"] = score["beta"], leader["beta"]
                score["beta"], leader["beta"] = value, x[i].copy()
            if value > score["alpha"] and value > score["beta"] and value < score["delta"]:
                score["delta"], leader["delta"] = value, x[i].copy()
        a = 2 - 2 * l / T
        moved = np.zeros((N, d))
        for i in range(N):
            for j in range(d):
                candidates = []
                for name in ("alpha", "beta", "delta"):
                    r1, r2 = rng.random(), rng.random()
                    A, C = 2 * a * r1 - a, 2 * r2
                    candidates.append(leader[name][j] - A * abs(C * leader[name][j] - x[i, j]))
                moved[i, j] = sum(candidates) / 3
        x = confine(moved)
    return batches


def alo(f, confine, lower, upper, x, T, rng, variant="code"):
    N, d = x.shape
    batches = [x.copy()]
    initial = sorted(((f(p), n) for n, p in enumerate(x)), key=lambda pair: pair[0])  # Python's sort is stable
    antlions = [x[n].copy() for _, n in initial]
    sorted_fitness = [value for value, _ in initial]
    elite, elite_fitness = antlions[0], sorted_fitness[0]
    for t in range(2, T + 1):
        u = [[rng.random() for _ in range(5)] for _ in range(N)]
        per_walk = (T + 63) // 64
        bits = [[[_bits(rng, per_walk) for _ in range(d)] for _ in range(2)] for _ in range(N)]
        ants = np.zeros((N, d))
        for i in range(N):
            around = antlions[_roulette(sorted_fitness, u[i][0])]
            RA = _walk(around, lower, upper, t, T, u[i][1], u[i][2], bits[i][0])
            RE = _walk(elite, lower, upper, t, T, u[i][3], u[i][4], bits[i][1])
            ants[i] = (RA + RE) / 2
        ants = confine(ants)
        batches.append(ants.copy())
        fitness = [f(p) for p in ants]
        both = list(zip(sorted_fitness + fitness, antlions + list(ants), strict=True))
        both = sorted(both, key=lambda pair: pair[0])[:N]
        antlions, antlions_fitness = [p.copy() for _, p in both], [value for value, _ in both]
        if antlions_fitness[0] < elite_fitness:
            elite, elite_fitness = antlions[0], antlions_fitness[0]
        antlions[0], antlions_fitness[0] = elite, elite_fitness
        if variant == "paper":
            sorted_fitness = antlions_fitness
    return batches


def _bits(rng, words):
    """The random bits of one walk, the lowest of each word first."""
    drawn = [int(rng.integers(2**64, dtype=np.uint64)) for _ in range(words)]
    return [word >> bit & 1 for word in drawn for bit in range(64)]


def _roulette(fitness, u):
    with np.errstate(all="ignore"):
        running, total = [], np.float64(0.0)
        for value in fitness:
            total = total + np.float64(1.0) / np.float64(value)
            running.append(total)
        for index, entry in enumerate(running):
            if entry > u * total:
                return index
    return 0


def _walk(antlion, lower, upper, t, T, coin_lower, coin_upper, bits):
    """Element t of the normalised random walk around an antlion, in every dimension."""
    if t <= 0.1 * T:
        ratio = 1
    elif t <= 0.5 * T:
        ratio = 1 + 100 * t / T
    elif t <= 0.75 * T:
        ratio = 1 + 1000 * t / T
    elif t <= 0.9 * T:
        ratio = 1 + 10000 * t / T
    elif t <= 0.95 * T:
        ratio = 1 + 100000 * t / T
    else:
        ratio = 1 + 1000000 * t / T
    point = np.zeros(len(antlion))
    for k in range(len(antlion)):
        low = antlion[k] + (lower[k] / ratio if coin_lower < 0.5 else -lower[k] / ratio)
        high = antlion[k] + (upper[k] / ratio if coin_upper < 0.5 else -upper[k] / ratio)
        X = [0]
        for step in range(T):
            X.append(X[-1] + (1 if bits[k][step] else -1))
        a, b = min(X), max(X)
        point[k] = (X[t - 1] - a) * (high - low) / (b - a) + low
    return point


def goa(f, confine, lower, upper, x, T, rng, variant="code"):
    N, d = x.shape
    if variant == "code" and d % 2 == 1:
        dummy = [-100 + 200 * rng.random() for _ in range(N)]
        x = np.array([[*x[i], dummy[i]] for i in range(N)])
        lower, upper = np.array([*lower, -100.0]), np.array([*upper, 100.0])
    D = len(lower)
    groups = [list(range(D))] if variant == "full-distance" else [[k, k + 1] for k in range(0, D, 2)]
    batches = [x[:, :d].copy()]
    target, best = None, np.inf
    for i in range(N):
        if target is None or f(x[i, :d]) < best:
            target, best = x[i].copy(), f(x[i, :d])
    for l in range(2, T + 1):  # noqa: E741
        c = 1 - l * (1 - 0.00004) / T
        moved = np.zeros((N, D))
        for i in range(N):
            for group in groups:
                S = dict.fromkeys(group, 0.0)
                for j in range(N):
                    if j == i:
                        continue
                    distance = sqrt(sum((x[j, k] - x[i, k]) ** 2 for k in group))
                    r = 2 + distance % 2
                    s = 0.5 * exp(-r / 1.5) - exp(-r)
                    for k in group:
                        S[k] += (upper[k] - lower[k]) * c / 2 * s * (x[j, k] - x[i, k]) / (distance + 2**-52)
                for k in group:
                    moved[i, k] = c * S[k] + target[k]
        for i in range(N):
            for k in range(d, D):
                moved[i, k] = min(max(moved[i, k], lower[k]), upper[k])
        moved[:, :d] = confine(moved[:, :d].copy())
        x = moved
        batches.append(x[:, :d].copy())
        for i in range(N):
            if f(x[i, :d]) < best:
                target, best = x[i].copy(), f(x[i, :d])
    return batches


def da(f, confine, lower, upper, x, T, rng, seen: Counter | None = None):
    """As the others; ``seen`` counts the branches that were taken."""
    seen = Counter() if seen is None else seen
    N, d = x.shape
    span = upper - lower
    batches = []
    V = np.array([[lower[k] + span[k] * rng.random() for k in range(d)] for _ in range(N)])
    food, food_value = np.zeros(d), np.inf
    enemy, enemy_value = np.zeros(d), -np.inf
    sigma = (gamma(2.5) * sin(pi * 0.75) / (gamma(1.25) * 1.5 * 2**0.25)) ** (1 / 1.5)
    for t in range(1, T + 1):
        batches.append(x.copy())
        for i in range(N):
            value = f(x[i])
            if value < food_value:
                food, food_value = x[i].copy(), value
            if value > enemy_value:
                if all(lower[k] < x[i, k] < upper[k] for k in range(d)):
                    enemy, enemy_value = x[i].copy(), value
                else:
                    seen["enemy on the bounds"] += 1
        r = span / 4 + 2 * span * t / T
        w = 0.9 - 0.5 * t / T
        m = max(0, 0.1 - 0.1 * t / (T / 2))
        s, a, c = (2 * rng.random() * m for _ in range(3))
        weight_food, e = 2 * rng.random(), m
        rand = [[[rng.random() for _ in range(3)] for _ in range(d)] for _ in range(N)]
        normal = [[[rng.standard_normal() for _ in range(2)] for _ in range(d)] for _ in range(N)]
        x = x.copy()
        for i in range(N):
            near = []
            for j in range(N):
                gaps = [abs(x[i, k] - x[j, k]) for k in range(d)]
                if all(gaps[k] <= r[k] for k in range(d)) and all(gap != 0 for gap in gaps):
                    near.append(j)
                elif j != i and any(gap == 0 for gap in gaps):
                    seen["equal in a component"] += 1
            if len(near) >= 2:
                S = [-sum(x[j, k] - x[i, k] for j in near) for k in range(d)]
                A = [sum(V[j, k] for j in near) / len(near) for k in range(d)]
                C = [sum(x[j, k] for j in near) / len(near) - x[i, k] for k in range(d)]
            else:
                S, A, C = [0.0] * d, list(V[i]), [0.0] * d
            F = [food[k] - x[i, k] for k in range(d)]
            threatened = all(abs(x[i, k] - enemy[k]) <= r[k] for k in range(d))
            E = [enemy[k] + x[i, k] if threatened else 0.0 for k in range(d)]
            far = any(abs(x[i, k] - food[k]) > r[k] for k in range(d))
            branch = ("far" if far else "close") + (", swarm" if len(near) >= 2 else ", alone")
            seen[branch] += 1
            seen["threatened" if threatened else "safe"] += 1
            for k in range(d):
                if far and len(near) < 2:
                    u, v = normal[i][k]
                    x[i, k] += 0.01 * u * sigma / abs(v) ** (1 / 1.5) * x[i, k]
                    V[i, k] = 0.0
                    continue
                if far:
                    V[i, k] = w * V[i, k] + rand[i][k][0] * A[k] + rand[i][k][1] * C[k] + rand[i][k][2] * S[k]
                else:
                    V[i, k] = s * S[k] + a * A[k] + c * C[k] + weight_food * F[k] + e * E[k] + w * V[i, k]
                V[i, k] = min(max(V[i, k], -span[k] / 10), span[k] / 10)
                x[i, k] += V[i, k]
            for k in range(d):
                x[i, k] = min(max(x[i, k], lower[k]), upper[k])
        x = confine(x)
    return batches
