"""The swarms once more, written as plainly as they can be: one number at a time, in the words of the facts.

Each algorithm makes ``T`` generations from the (N, d) start ``x`` and returns the (N, d) batches it evaluated. ``f``
maps one point to its value, ``confine`` brings a whole batch back (clip, then repair), ``rng`` is drawn from in the
order in which the optimizers draw. Nothing here is shared with the code under test.
"""

from collections import Counter
from math import exp, gamma, pi, sin, sqrt

import numpy as np

EPS = 2.0**-52


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
                total = 0.0
                for name in ("alpha", "beta", "delta"):
                    r1, r2 = rng.random(), rng.random()
                    A, C = 2 * a * r1 - a, 2 * r2
                    total += leader[name][j] - A * abs(C * leader[name][j] - x[i, j])
                moved[i, j] = total / 3
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
        u = rng.random((N, 5))
        words = rng.integers(2**64, size=(N, 2, d, (T + 63) // 64), dtype=np.uint64)
        coins = np.unpackbits(words.astype("<u8").view(np.uint8), axis=-1, bitorder="little")[..., :T]
        running = running_sum_of_weights(sorted_fitness)
        ants = np.zeros((N, d))
        for i in range(N):
            around = antlions[roulette(running, u[i, 0])]
            RA = walk(around, lower, upper, t, T, u[i, 1], u[i, 2], coins[i, 0])
            RE = walk(elite, lower, upper, t, T, u[i, 3], u[i, 4], coins[i, 1])
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


def running_sum_of_weights(fitness):
    with np.errstate(all="ignore"):
        running, total = [], np.float64(0.0)
        for value in fitness:
            total = total + np.float64(1.0) / np.float64(value)
            running.append(total)
    return running


def roulette(running, u):
    for index, entry in enumerate(running):
        if entry > u * running[-1]:
            return index
    return 0


def walk(antlion, lower, upper, t, T, coin_lower, coin_upper, coins):
    """Element t of the normalised random walks around an antlion, one of T coins in every dimension."""
    if t <= 0.1 * T:
        ratio = 1.0
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
        X = np.zeros(T + 1)
        X[1:] = np.cumsum(2.0 * coins[k] - 1)
        a, b = X.min(), X.max()
        point[k] = (X[t - 1] - a) * (high - low) / (b - a) + low
    return point


def goa(f, confine, lower, upper, x, T, rng, variant="code"):
    N, d = x.shape
    if variant == "code" and d % 2 == 1:
        dummy = [-100 + 200 * rng.random() for _ in range(N)]
        x = np.array([[*x[i], dummy[i]] for i in range(N)])
        lower, upper = np.array([*lower, -100.0]), np.array([*upper, 100.0])
    D = len(lower)
    groups = np.arange(D).reshape(-1, D if variant == "full-distance" else 2)
    batches = [x[:, :d].copy()]
    target, best = None, np.inf
    for i in range(N):
        value = f(x[i, :d])
        if target is None or value < best:
            target, best = x[i].copy(), value
    for l in range(2, T + 1):  # noqa: E741
        c = 1 - l * (1 - 0.00004) / T
        moved = grasshoppers(x, target, groups, lower, upper, c)
        for i in range(N):
            for k in range(d, D):
                moved[i, k] = min(max(moved[i, k], lower[k]), upper[k])
        moved[:, :d] = confine(moved[:, :d].copy())
        x = moved
        batches.append(x[:, :d].copy())
        for i in range(N):
            value = f(x[i, :d])
            if value < best:
                target, best = x[i].copy(), value
    return batches


def grasshoppers(x, target, groups, lower, upper, c):
    """Where all grasshoppers go from x, with distances taken within each group of coordinates."""
    moved = np.zeros(x.shape)
    for i in range(len(x)):
        for group in groups:
            S = np.zeros(x.shape[1])
            for j in range(len(x)):
                if j == i:
                    continue
                square = 0.0
                for k in group:
                    square += (x[j, k] - x[i, k]) * (x[j, k] - x[i, k])
                distance = sqrt(square)
                r = 2 + distance % 2
                s = 0.5 * exp(-r / 1.5) - exp(-r)
                for k in group:
                    S[k] += (upper[k] - lower[k]) * c / 2 * s * (x[j, k] - x[i, k]) / (distance + EPS)
            for k in group:
                moved[i, k] = c * S[k] + target[k]
    return moved


def da(f, confine, lower, upper, x, T, rng, seen=None):
    """As the others; ``seen``, a Counter, counts the branches that were taken."""
    seen = Counter() if seen is None else seen
    N, d = x.shape
    span = upper - lower
    batches = []
    V = np.array([[lower[k] + span[k] * rng.random() for k in range(d)] for _ in range(N)])
    food, food_value = np.zeros(d), np.inf
    enemy, enemy_value = np.zeros(d), -np.inf
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
        m = max(0.0, 0.1 - 0.1 * t / (T / 2))
        s, a, c = (2 * rng.random() * m for _ in range(3))
        weights = s, a, c, 2 * rng.random(), m, w
        rand = rng.random((N, d, 3))
        normal = rng.standard_normal((N, d, 2))
        x = x.copy()
        for i in range(N):
            if (x == x[i]).any(axis=1).sum() > 1:
                seen["equal in a component"] += 1
            far, swarm, threatened = dragonfly(x, V, i, food, enemy, r, weights, lower, upper, rand[i], normal[i])
            seen[("far" if far else "close") + (", swarm" if swarm else ", alone")] += 1
            seen["threatened" if threatened else "safe"] += 1
        x = confine(x)
    return batches


def dragonfly(x, V, i, food, enemy, r, weights, lower, upper, rand, normal):
    """Move dragonfly i, and say whether it was far from the food, in a swarm, and near the enemy."""
    N, d = x.shape
    s, a, c, weight_food, e, w = weights
    near = [j for j in range(N) if is_neighbour(x[i], x[j], r)]
    S, A, C, F, E = np.zeros(d), V[i].copy(), np.zeros(d), np.zeros(d), np.zeros(d)
    if len(near) >= 2:
        for k in range(d):
            apart, along, centre = 0.0, 0.0, 0.0
            for j in near:
                apart += x[j, k] - x[i, k]
                along += V[j, k]
                centre += x[j, k]
            S[k], A[k], C[k] = -apart, along / len(near), centre / len(near) - x[i, k]
    far, threatened = False, True
    for k in range(d):
        F[k] = food[k] - x[i, k]
        far = far or abs(x[i, k] - food[k]) > r[k]
        threatened = threatened and abs(x[i, k] - enemy[k]) <= r[k]
    if threatened:
        for k in range(d):
            E[k] = enemy[k] + x[i, k]
    sigma = (gamma(2.5) * sin(pi * 0.75) / (gamma(1.25) * 1.5 * 2**0.25)) ** (1 / 1.5)
    for k in range(d):
        if far and len(near) < 2:
            u, v = normal[k, 0], normal[k, 1]
            x[i, k] += 0.01 * u * sigma / abs(v) ** (1 / 1.5) * x[i, k]
            V[i, k] = 0.0
            continue
        if far:
            V[i, k] = w * V[i, k] + rand[k, 0] * A[k] + rand[k, 1] * C[k] + rand[k, 2] * S[k]
        else:
            V[i, k] = s * S[k] + a * A[k] + c * C[k] + weight_food * F[k] + e * E[k] + w * V[i, k]
        longest = (upper[k] - lower[k]) / 10
        V[i, k] = min(max(V[i, k], -longest), longest)
        x[i, k] += V[i, k]
    for k in range(d):
        x[i, k] = min(max(x[i, k], lower[k]), upper[k])
    return far, len(near) >= 2, threatened


def is_neighbour(p, q, r):
    """Whether q is within r of p, and different from it, in every component."""
    for k in range(len(p)):
        gap = abs(p[k] - q[k])
        if gap > r[k] or gap == 0:
            return False
    return True
