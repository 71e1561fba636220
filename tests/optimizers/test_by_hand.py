"""One generation at a time against numbers worked out by hand from the rules, with the random numbers given.

No expected number here comes from the code under test or from reference.py: each is arithmetic that can be followed
with a pencil. Where a test can be fooled by a plausible mistake, its comment says what the mistake would give.
"""

from math import exp, gamma, pi, sin, sqrt

import numpy as np
import pytest

from optimizers.alo import ALO, random_walks, ratio, walk_ants, wheel
from optimizers.da import DA, fly
from optimizers.goa import GOA, social_forces
from optimizers.gwo import GWO, hunt, promote
from tests.optimizers.dealt import Dealt, Watched, watch

near = pytest.approx


# --- GWO ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cascade", "scores", "leaders"),
    [
        # 5 leads; 3 leads and 5 is forgotten; 7 is beta; 4 is beta and 7 is forgotten; the second 3 equals alpha and
        # changes nothing; 6 is delta; 2 leads and 3 is forgotten.
        (False, [2, 4, 6], [16, 13, 15]),
        # 3 demotes 5 to beta; 7 is delta; 4 demotes 5 to delta, 7 falls out; 6 is too late; 2 demotes 3 and 4.
        (True, [2, 3, 4], [16, 11, 13]),
    ],
)
def test_gwo_a_beaten_leader_is_forgotten_and_only_the_cascade_demotes_it(cascade, scores, leaders):
    found, best = np.zeros((3, 1)), np.full(3, np.inf)
    wolves = np.array([[10.0], [11], [12], [13], [14], [15], [16]])
    promote(found, best, wolves, np.array([5.0, 3, 7, 4, 3, 6, 2]), cascade)
    assert best.tolist() == scores
    assert found[:, 0].tolist() == leaders
    promote(found, best, np.array([[20.0], [21]]), np.array([9.0, 8]), cascade)  # leaders outlive their generation
    assert best.tolist() == scores
    assert found[:, 0].tolist() == leaders


def test_gwo_a_wolf_as_good_as_beta_becomes_no_delta():
    found, best = np.zeros((3, 1)), np.full(3, np.inf)
    promote(found, best, np.array([[1.0], [2], [3]]), np.array([1.0, 2, 2]), False)
    assert best.tolist() == [1, 2, np.inf]


def test_gwo_each_leader_and_dimension_uses_its_own_two_random_numbers():
    leaders = np.array([[1.0, -2.0], [3.0, 4.0], [-1.0, 0.5]])
    wolf = np.array([[2.0, -1.0]])
    r = np.array([[[[0.25, 0.75], [0.5, 0.1], [1.0, 0.5]], [[0.75, 0.25], [0.0, 0.5], [0.6, 1.0]]]])
    # a = 1.5: A = 2 * 1.5 * r1 - 1.5 and C = 2 * r2; first dimension, x = 2
    X1 = 1 - (2 * 1.5 * 0.25 - 1.5) * abs(2 * 0.75 * 1 - 2)  # A = -0.75, C = 1.5
    X2 = 3 - (2 * 1.5 * 0.5 - 1.5) * abs(2 * 0.1 * 3 - 2)  # A = 0: at the leader
    X3 = -1 - (2 * 1.5 * 1.0 - 1.5) * abs(2 * 0.5 * -1 - 2)  # A = 1.5, C = 1
    assert near((1.375, 3, -5.5)) == (X1, X2, X3)
    # second dimension, x = -1
    Y1 = -2 - (2 * 1.5 * 0.75 - 1.5) * abs(2 * 0.25 * -2 + 1)  # A = 0.75, D = |-1 + 1| = 0
    Y2 = 4 - (2 * 1.5 * 0.0 - 1.5) * abs(2 * 0.5 * 4 + 1)  # A = -1.5, D = 5
    Y3 = 0.5 - (2 * 1.5 * 0.6 - 1.5) * abs(2 * 1.0 * 0.5 + 1)  # A = 0.3, D = 2
    assert near((-2, 11.5, -0.1)) == (Y1, Y2, Y3)
    assert hunt(wolf, leaders, 1.5, r)[0] == near([(X1 + X2 + X3) / 3, (Y1 + Y2 + Y3) / 3])


def test_gwo_a_falls_from_two_and_the_missing_leaders_stand_at_the_origin():
    # r1 = 3/4 and r2 = 1/2 throughout: A = 2 a 3/4 - a = a / 2 and C = 1, so X_k = L_k - a/2 |L_k - x|. T = 4.
    r = np.broadcast_to([0.75, 0.5], (3, 1, 3, 2))
    objective = Watched(lambda x: x[0] ** 2, [[4], [1], [-3]], bound=10.0, generations=4, batches=4)
    batches = watch(GWO(agents=3), objective, Dealt(random=[r] * 4))
    # Start, values 16, 1, 9: 4 leads, 1 leads (4 is forgotten), -3 is beta, delta is still the origin. a = 2 - 0.
    first = [
        ((1 - 3) + (-3 - 7) + (0 - 4)) / 3,  # x = 4
        ((1 - 0) + (-3 - 4) + (0 - 1)) / 3,  # x = 1
        ((1 - 4) + (-3 - 0) + (0 - 3)) / 3,  # x = -3: it stays there, the worse for it or not
    ]
    assert first == near([-16 / 3, -7 / 3, -3])
    assert batches[1][:, 0] == near(first)
    # Values 28.4, 5.4, 9: -16/3 is delta; -7/3 is beta, -3 is forgotten as beta but then beats delta. a = 2 - 2/4.
    second = [
        ((1 - 0.75 * 19 / 3) + (-7 / 3 - 0.75 * 3) + (-3 - 0.75 * 7 / 3)) / 3,  # x = -16/3
        ((1 - 0.75 * 10 / 3) + (-7 / 3 - 0) + (-3 - 0.75 * 2 / 3)) / 3,  # x = -7/3
        ((1 - 0.75 * 4) + (-7 / 3 - 0.75 * 2 / 3) + (-3 - 0)) / 3,  # x = -3
    ]
    assert second == near([-157 / 36, -22 / 9, -47 / 18])
    assert batches[2][:, 0] == near(second)
    # Values 19.0, 6.0, 6.8: -157/36 is nothing; -22/9 (6.0) beats delta (9) but not beta (5.4); -47/18 is nothing.
    # a = 2 - 2 * 2/4 = 1, A = 1/2.
    third = [
        ((1 - 0.5 * (1 + 157 / 36)) + (-7 / 3 - 0.5 * (157 / 36 - 7 / 3)) + (-22 / 9 - 0.5 * (157 / 36 - 22 / 9))) / 3,
        ((1 - 0.5 * (1 + 22 / 9)) + (-7 / 3 - 0.5 * (22 / 9 - 7 / 3)) + (-22 / 9 - 0)) / 3,
        ((1 - 0.5 * (1 + 47 / 18)) + (-7 / 3 - 0.5 * (47 / 18 - 7 / 3)) + (-22 / 9 - 0.5 * (47 / 18 - 22 / 9))) / 3,
    ]
    assert batches[3][:, 0] == near(third)


def test_gwo_clips_the_wolves_before_it_evaluates_them():
    r = np.broadcast_to([1.0, 0.5], (3, 1, 3, 2))  # A = a, C = 1
    objective = Watched(lambda x: x[0] ** 2, [[4], [1], [-3]], bound=5.0, generations=4, batches=2)
    # x = 4: ((1 - 2 * 3) + (-3 - 2 * 7) + (0 - 2 * 4)) / 3 = -10, out of the box
    assert watch(GWO(agents=3), objective, Dealt(random=[r] * 4))[1][0, 0] == -5


# --- ALO ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("t", "expected"),
    [
        (2, 1),
        (20, 1),  # t <= 0.1 T
        (21, 1 + 100 * 21 / 200),  # 11.5: the paper, without its "1 +", has 10.5
        (100, 1 + 100 * 100 / 200),
        (101, 1 + 1000 * 101 / 200),
        (150, 1 + 1000 * 150 / 200),
        (151, 1 + 10000 * 151 / 200),
        (180, 1 + 10000 * 180 / 200),
        (181, 1 + 100000 * 181 / 200),
        (190, 1 + 100000 * 190 / 200),
        (191, 1 + 1000000 * 191 / 200),
        (200, 1 + 1000000),
    ],
)
def test_alo_the_ratio_steps_up_after_each_share_of_the_generations(t, expected):
    assert ratio(t, 200) == near(expected, rel=1e-15)


def test_alo_the_roulette_weighs_with_one_over_f():
    assert wheel(np.array([0.5, 1.0, 4.0])).tolist() == [2, 2 + 1, 2 + 1 + 0.25]


def byte(steps):
    """The random byte whose bits, the lowest first, are the given steps."""
    return sum(1 << n for n, step in enumerate(steps) if step == "+")


def test_alo_a_walk_is_normalised_by_its_whole_course():
    steps = np.array([[byte("++---+++")]], dtype=np.uint8)  # 0 1 2 1 0 -1 0 1 2

    def above_and_width(t, T):
        return tuple(float(of_walks[0]) for of_walks in random_walks(steps, t, T))

    assert above_and_width(1, 8) == (0 - -1, 2 - -1)  # element 1 of the walk is its start
    assert above_and_width(4, 8) == (1 - -1, 2 - -1)  # up to there the lowest is 0
    assert above_and_width(8, 8) == (1 - -1, 2 - -1)
    # Of T steps, not of those that the bytes hold: without the last three the walk is 0 1 2 1 0 -1.
    assert above_and_width(2, 5) == (1 - -1, 2 - -1)
    assert above_and_width(2, 4) == (1 - 0, 2 - 0)


def test_alo_an_ant_is_the_mean_of_two_scaled_walks():
    # Two ants in two dimensions, t = 4 of T = 8; the bounds are over I already.
    antlions, elite = np.array([[3.0, 10.0], [-1.0, 20.0]]), np.array([5.0, -6.0])
    lower, upper = np.array([-2.0, -1.0]), np.array([4.0, 3.0])
    uniforms = np.array(
        [
            # the roulette, then the coins of the walk around the antlion (lower, upper) and around the elite
            [0.6, 0.4, 0.6, 0.5, 0.2],  # a coin of exactly 0.5 mirrors
            [0.7, 0.9, 0.1, 0.0, 0.5],
        ]
    )
    up, down = byte("++---+++"), byte("-+--+-+-")  # 0 1 2 1 0 -1 0 1 2 and 0 -1 0 -1 -2 -1 -2 -1 -2
    steps = np.array([[[[up], [down]], [[down], [up]]], [[[up], [up]], [[down], [down]]]], dtype=np.uint8)
    ants = walk_ants(antlions, elite, np.array([2.0, 3.0]), lower, upper, 4, 8, uniforms, steps)
    # up at t = 4 is at 1, in -1 … 2, so at 2/3 of the interval; down is at -1, in -2 … 0, so at 1/2.
    # Ant 1: 0.6 * 3 = 1.8 < 2, antlion 1; its lower end is kept and its upper one mirrored.
    RA1 = (1 - -1) * ((3 - 4) - (3 - 2)) / (2 - -1) + (3 - 2)  # up in [1, -1], an interval upside down
    RA2 = (-1 - -2) * ((10 - 3) - (10 - 1)) / (0 - -2) + (10 - 1)  # down in [9, 7]
    # The elite's lower end is mirrored and its upper one kept, in both dimensions.
    RE1 = (-1 - -2) * ((5 + 4) - (5 + 2)) / (0 - -2) + (5 + 2)  # down in [7, 9]
    RE2 = (1 - -1) * ((-6 + 3) - (-6 + 1)) / (2 - -1) + (-6 + 1)  # up in [-5, -3]
    assert near((-1 / 3, 8, 8, -5 + 4 / 3)) == (RA1, RA2, RE1, RE2)
    assert ants[0] == near([(RA1 + RE1) / 2, (RA2 + RE2) / 2])
    # Ant 2: 0.7 * 3 = 2.1 > 2, antlion 2; lower mirrored, upper kept; elite: lower kept, upper mirrored.
    RA1 = (1 - -1) * ((-1 + 4) - (-1 + 2)) / (2 - -1) + (-1 + 2)  # up in [1, 3]
    RA2 = (1 - -1) * ((20 + 3) - (20 + 1)) / (2 - -1) + (20 + 1)  # up in [21, 23]
    RE1 = (-1 - -2) * ((5 - 4) - (5 - 2)) / (0 - -2) + (5 - 2)  # down in [3, 1]
    RE2 = (-1 - -2) * ((-6 - 3) - (-6 - 1)) / (0 - -2) + (-6 - 1)  # down in [-7, -9]
    assert ants[1] == near([(RA1 + RE1) / 2, (RA2 + RE2) / 2])


def test_alo_the_roulette_takes_the_first_entry_above_its_draw_or_else_the_first():
    # With bounds of 0 a walk stays at its antlion: an ant is the mean of the chosen antlion and the elite at 0.
    antlions, nothing = np.array([[2.0], [4.0], [6.0], [8.0]]), np.zeros(1)
    steps = np.full((4, 2, 1, 1), byte("+-"), dtype=np.uint8)
    uniforms = np.array([[0.0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0], [0.501, 0, 0, 0, 0], [0.99, 0, 0, 0, 0]])

    def chosen(sums):
        ants = walk_ants(antlions, nothing, np.array(sums), nothing, nothing, 2, 2, uniforms, steps)
        return [int(ant) for ant in ants[:, 0]]  # (2 n + 0) / 2

    assert chosen([1.0, 2.0, 3.0, 4.0]) == [1, 3, 3, 4]  # 2 is not above 0.5 * 4
    assert chosen([1.0, 2.0, 2.0, 4.0]) == [1, 4, 4, 4]  # an antlion without weight is never chosen
    assert chosen([-1.0, -2.0, -3.0, -4.0]) == [1, 1, 1, 1]  # -1 is not above 0, nothing is: the first
    assert chosen([-3.0, -1.0, -2.0, -2.0]) == [1, 1, 2, 2]  # draws 0, -1, -1.002 and -1.98


@pytest.mark.parametrize(
    ("variant", "third", "fourth"),
    [("code", [3.5, 2.5, 2.5], [2.75, 2.75, 3]), ("paper", [3.5, 2.5, 3], [3.25, 3, 3])],
)
def test_alo_the_code_forgets_what_its_antlions_are_worth(variant, third, fourth):
    # The coins let both ends of an interval coincide: the antlion's at -10 / I, the elite's at +10 / I, wherever the
    # walk is. So every ant is the mean of its antlion and the elite. f = |x - 3| + 1, T = 20, N = 3.
    def uniforms(*draws):
        return [[draw, 0.0, 1.0, 1.0, 0.0] for draw in draws]

    words = np.full((3, 2, 1, 1), byte("+-"), dtype=np.uint64)
    rng = Dealt(
        random=[uniforms(0.95, 0.5, 0.2), uniforms(0.95, 0.6, 0.45), uniforms(0.99, 0.6, 0.3)], integers=[words] * 3
    )
    objective = Watched(lambda x: abs(x[0] - 3) + 1, [[8], [2], [4]], bound=10.0, generations=20, batches=4)
    # t = 1: antlions 2, 4, 8 worth 2, 2, 6 (a stable sort keeps 2 before 4); elite 2; wheel 1/2, 1, 7/6.
    # t = 2: 0.95 * 7/6 = 1.11 picks 8, 0.5 * 7/6 = 0.58 picks 4, 0.2 * 7/6 = 0.23 picks 2:
    second = [(8 + 2) / 2, (4 + 2) / 2, (2 + 2) / 2]
    #   worth 3, 1, 2. Merged and sorted: 3 (1), 2 (2), 4 (2). Elite 3, worth 1.
    # t = 3, code:  the wheel is still 1/2, 1, 7/6: 1.11 picks 4, 0.70 picks 2, 0.53 picks 2 -> 3.5, 2.5, 2.5.
    #        paper: the wheel is 1, 3/2, 2:         1.90 picks 4, 1.20 picks 2, 0.90 picks 3 -> 3.5, 2.5, 3.
    #   Code merges 3 (2), 2 (2), 4 (6) with 3.5, 2.5, 2.5 (1.5 each): 3.5, 2.5, 2.5 are left, the elite 3 is put first.
    #   Paper merges 3 (1), 2 (2), 4 (2) with 3.5 (1.5), 2.5 (1.5), 3 (1): 3, 3, 3.5 are left, worth 1, 1, 1.5.
    # t = 4, code:  antlions 3, 2.5, 2.5, wheel 1/2, 1, 7/6: 1.16 picks 2.5, 0.70 picks 2.5, 0.35 picks 3.
    #        paper: antlions 3, 3, 3.5, wheel 1, 2, 8/3:     2.64 picks 3.5, 1.60 picks 3, 0.80 picks 3.
    batches = watch(ALO(agents=3, variant=variant), objective, rng)
    assert [batch[:, 0].tolist() for batch in batches[:2]] == [[8, 2, 4], second]
    assert batches[2][:, 0] == near(third)
    assert batches[3][:, 0] == near(fourth)


def test_alo_the_walks_interval_is_the_box_over_the_ratio():
    # Bits "+-": the walk is 0 1 0; at t = 2 it is at its highest, so at the upper end: the antlion + 10 / I.
    words = np.full((2, 2, 1, 1), byte("+-"), dtype=np.uint64)
    objective = Watched(lambda x: x[0] ** 2 + 1, [[2], [1]], bound=10.0, generations=2, batches=2)
    rng = Dealt(random=[[[0.0, 0, 0, 0, 0], [0.9, 0, 1, 0, 1]]], integers=[words])
    # t = T = 2: I = 1 + 10^6 * 2/2. The antlions are 1 (weight 1/2) and 2 (1/5); 0.9 * 0.7 = 0.63 picks the second.
    batches = watch(ALO(agents=2), objective, rng)
    assert batches[1][0, 0] == near((1 + 10 / 1000001 + 1 + 10 / 1000001) / 2, rel=1e-15)
    assert batches[1][1, 0] == near((2 - 10 / 1000001 + 1 - 10 / 1000001) / 2, rel=1e-15)


# --- GOA ----------------------------------------------------------------------------------------------------------


def test_goa_each_grasshopper_feels_all_others_and_the_target():
    # Three at (0, 0), (3, 4), (0, 2): distances 5, 2, sqrt(13); T = 4, box +-10, target (0, 2), the best.
    objective = Watched(lambda x: x[0] ** 2 + (x[1] - 2) ** 2, [[0, 0], [3, 4], [0, 2]], 10.0, generations=4, batches=2)
    found = watch(GOA(agents=3), objective, Dealt())[1]
    c = 1 - 2 * (1 - 0.00004) / 4  # l = 2
    s5 = 0.5 * exp(-3 / 1.5) - exp(-3)  # 5 mod 2 = 1, r = 3
    s2 = 0.5 * exp(-2 / 1.5) - exp(-2)  # 2 mod 2 = 0, r = 2
    s13 = 0.5 * exp(-(sqrt(13)) / 1.5) - exp(-(sqrt(13)))  # 3.6 mod 2 = sqrt(13) - 2, r = sqrt(13)
    reach = 20 * c / 2
    assert found[0] == near([c * (reach * s5 * 3 / 5 + 0) + 0, c * (reach * s5 * 4 / 5 + reach * s2 * 2 / 2) + 2])
    assert found[1] == near(
        [
            c * (reach * s5 * -3 / 5 + reach * s13 * -3 / sqrt(13)) + 0,
            c * (reach * s5 * -4 / 5 + reach * s13 * -2 / sqrt(13)) + 2,
        ]
    )
    assert found[2] == near(
        [c * (0 + reach * s13 * 3 / sqrt(13)) + 0, c * (reach * s2 * -2 / 2 + reach * s13 * 2 / sqrt(13)) + 2]
    )


def test_goa_c_falls_and_a_better_point_becomes_the_target():
    # Two in one pair of coordinates move to target +- c S: their distance is 2 c |S|, along (3, 4) / 5. T = 4.
    def f(x):
        return abs(x[0] - 10)

    objective = Watched(f, [[0, 0], [3, 4]], bound=10.0, generations=4, batches=4)
    batches = watch(GOA(agents=2), objective, Dealt())
    c2, c3, c4 = 1 - 2 * (1 - 0.00004) / 4, 1 - 3 * (1 - 0.00004) / 4, 1 - 4 * (1 - 0.00004) / 4
    assert (c2, c3, c4) == near((0.50002, 0.25003, 0.00004))
    s = 0.5 * exp(-3 / 1.5) - exp(-3)  # D = 5, r = 3
    move = c2 * (20 * c2 / 2) * s  # the target is (3, 4), the lower f
    assert batches[1] == near(np.array([[3 + move * 3 / 5, 4 + move * 4 / 5], [3 - move * 3 / 5, 4 - move * 4 / 5]]))
    # The first is nearer to x = 10: the new target. They have changed sides. D = 2 * move = 0.09 < 2.
    target = [3 + move * 3 / 5, 4 + move * 4 / 5]
    s = 0.5 * exp(-(2 + 2 * move) / 1.5) - exp(-(2 + 2 * move))
    move = c3 * (20 * c3 / 2) * s
    expected = [
        [target[0] - move * 3 / 5, target[1] - move * 4 / 5],
        [target[0] + move * 3 / 5, target[1] + move * 4 / 5],
    ]
    assert batches[2] == near(np.array(expected))
    # The second is nearer now; once more, with c = 0.00004 they all but coincide with the target.
    assert batches[3] == near(np.array([expected[1]] * 2), abs=1e-9)


def test_goa_a_worse_generation_leaves_the_target_where_it_is():
    # As above, but the first target, (3, 4), is the optimum.
    objective = Watched(lambda x: (x[0] - 3) ** 2 + (x[1] - 4) ** 2, [[0, 0], [3, 4]], 10.0, generations=4, batches=3)
    batches = watch(GOA(agents=2), objective, Dealt())
    c2, c3 = 0.50002, 0.25003
    D = 2 * c2 * (20 * c2 / 2) * (0.5 * exp(-3 / 1.5) - exp(-3))
    move = c3 * (20 * c3 / 2) * (0.5 * exp(-(2 + D) / 1.5) - exp(-(2 + D)))
    assert batches[2] == near(np.array([[3 - move * 0.6, 4 - move * 0.8], [3 + move * 0.6, 4 + move * 0.8]]))


def test_goa_distances_are_taken_within_pairs_of_coordinates():
    x = np.array([[0.0, 3.0], [0.0, 4.0], [0.0, 0.0], [0.0, 1.5]])  # (d, N): (0, 0, 0, 0) and (3, 4, 0, 1.5)
    s5 = 0.5 * exp(-3 / 1.5) - exp(-3)  # the first pair is 5 apart, r = 2 + 1
    s15 = 0.5 * exp(-3.5 / 1.5) - exp(-3.5)  # the second is 1.5 apart, r = 2 + 1.5
    half = [s5 * 3 / 5, s5 * 4 / 5, 0, s15 * 1.5 / 1.5]
    assert social_forces(x, 2) == near(np.array([[pull, -pull] for pull in half]))
    D = sqrt(3**2 + 4**2 + 1.5**2)  # 5.22, r = 3.22
    s = 0.5 * exp(-(D - 2) / 1.5) - exp(-(D - 2))  # 2 + D mod 2 = 2 + D - 4
    half = [s * 3 / D, s * 4 / D, 0, s * 1.5 / D]
    assert social_forces(x, 4) == near(np.array([[pull, -pull] for pull in half]))


def test_goa_an_odd_dimension_gets_a_dummy_variable_that_moves_with_the_others():
    # (0, dummy 0) and (3, dummy 4): 5 apart. Box +-10 and +-100, so the dummy is pulled ten times as far. T = 4.
    objective = Watched(lambda x: abs(x[0] - 10), [[0], [3]], bound=10.0, generations=4, batches=3)
    rng = Dealt(uniform=[[0.0, 4.0]])
    batches = watch(GOA(agents=2), objective, rng)
    assert rng.asked == (-100, 100)
    assert [batch.shape for batch in batches] == [(2, 1)] * 3
    c2, c3 = 0.50002, 0.25003
    s = 0.5 * exp(-3 / 1.5) - exp(-3)  # with the distance 3 alone, r would be 3 too, but the pull 3 / 3, not 3 / 5
    move, dummy = c2 * (20 * c2 / 2) * s * 3 / 5, c2 * (200 * c2 / 2) * s * 4 / 5
    assert batches[1][:, 0] == near([3 + move, 3 - move])
    # Both are now 2 (move, dummy) apart; the first is the new target.
    D = 2 * sqrt(move**2 + dummy**2)
    s = 0.5 * exp(-(2 + D) / 1.5) - exp(-(2 + D))
    assert 0 < D < 2
    again = c3 * (20 * c3 / 2) * s * (2 * move / D)
    assert batches[2][:, 0] == near([3 + move - again, 3 + move + again])


def test_goa_is_clipped_before_it_is_evaluated():
    # Two 1 apart at the upper corner: the pull is c^2 * 20 / 2 * s(3) beyond the target (10, 10) for the first.
    objective = Watched(lambda x: -x[0], [[9, 10], [10, 10]], bound=10.0, generations=4, batches=2)
    c, s = 0.50002, 0.5 * exp(-3 / 1.5) - exp(-3)
    assert watch(GOA(agents=2), objective, Dealt())[1] == near(np.array([[10, 10], [10 - c * (20 * c / 2) * s, 10]]))


# --- DA -----------------------------------------------------------------------------------------------------------

S, A, C, F, E, W = 0.1, 0.2, 0.3, 0.4, 0.05, 0.5  # the weights of separation, alignment, cohesion, food, enemy, inertia


def flown(x, v, food, enemy, r, uniforms=None, normals=None, bound=10.0):
    """Return positions and steps, (N, d) each, after one generation with the weights above."""
    x, v = np.array(x, dtype=float).T.copy(), np.array(v, dtype=float).T.copy()
    d, N = x.shape
    uniforms = np.full((N, d, 3), np.nan) if uniforms is None else np.array(uniforms)
    normals = np.full((N, d, 2), np.nan) if normals is None else np.array(normals)
    food, enemy, r = (np.array(vector, dtype=float) for vector in (food, enemy, r))
    weights, upper = np.array([S, A, C, F, E, W]), np.full(d, bound)
    fly(x, v, food, enemy, r, weights, -upper, upper, uniforms, normals)
    return x.T, v.T


def test_da_close_to_the_food_all_five_terms_act_and_later_ones_see_moved_neighbours():
    # At 0, 1, 3 with steps 0.1, 0.2, 0.3; all within 5 of each other, of the food at 2 and of the enemy at -1.
    x, v = flown([[0], [1], [3]], [[0.1], [0.2], [0.3]], food=[2], enemy=[-1], r=[5])
    # i = 0: S = -(1 + 3), A = (0.2 + 0.3) / 2, C = (1 + 3) / 2 - 0, F = 2 - 0, E = -1 + 0
    v0 = S * -4 + A * 0.25 + C * 2 + F * 2 + E * -1 + W * 0.1
    assert v0 == near(1.05)
    # i = 1 sees the first at 0 + 1.05 with the step 1.05: S = -(0.05 + 2), C = (1.05 + 3) / 2 - 1, E = -1 + 1
    v1 = S * -2.05 + A * (1.05 + 0.3) / 2 + C * 1.025 + F * (2 - 1) + E * 0 + W * 0.2
    assert v1 == near(0.7375)
    # i = 2 sees them at 1.05 and 1.7375: S = 1.95 + 1.2625, E = -1 + 3
    v2 = S * 3.2125 + A * (1.05 + 0.7375) / 2 + C * ((1.05 + 1.7375) / 2 - 3) + F * (2 - 3) + E * 2 + W * 0.3
    assert v[:, 0] == near([v0, v1, v2])
    assert x[:, 0] == near([0 + v0, 1 + v1, 3 + v2])


def test_da_close_to_the_food_and_alone_it_keeps_its_own_step():
    # 0 and 1 are neighbours, but one neighbour is no swarm; 8 is on its own, and it alone is near the enemy at 9.
    x, v = flown([[0], [1], [8]], [[0.1], [0.2], [0.3]], food=[4], enemy=[9], r=[5])
    v0 = S * 0 + A * 0.1 + C * 0 + F * (4 - 0) + E * 0 + W * 0.1
    v1 = S * 0 + A * 0.2 + C * 0 + F * (4 - 1) + E * 0 + W * 0.2  # the first, at 1.67, is its one neighbour
    v2 = S * 0 + A * 0.3 + C * 0 + F * (4 - 8) + E * (9 + 8) + W * 0.3
    assert v[:, 0] == near([v0, v1, v2])
    assert x[:, 0] == near([v0, 1 + v1, 8 + v2])


def test_da_far_from_the_food_a_swarm_weighs_alignment_cohesion_and_separation_at_random():
    # Food is beyond 2 in the first dimension and near in the second: that is far, in both. Enemy and food do not act.
    uniforms = np.full((3, 2, 3), 0.0)
    uniforms[0] = [[0.5, 0.25, 0.125], [0.25, 0.75, 0.5]]  # alignment, cohesion, separation, for each dimension
    x, v = flown([[0, 0], [1, 0.5], [0.5, 1.5]], [[0.1, 0.2], [0.3, 0.4], [0.5, 0.8]], [9, 0], [0, 1], [2, 2], uniforms)
    # A = the mean of (0.3, 0.4) and (0.5, 0.8), C = the mean of (1, 0.5) and (0.5, 1.5), S = -their sum
    v00 = W * 0.1 + 0.5 * 0.4 + 0.25 * 0.75 + 0.125 * -1.5
    v01 = W * 0.2 + 0.25 * 0.6 + 0.75 * 1.0 + 0.5 * -2.0
    assert v[0] == near([v00, v01])
    assert x[0] == near([v00, v01])
    assert v[1:] == near(np.array([[W * 0.3, W * 0.4], [W * 0.5, W * 0.8]]))  # their random weights are 0


def test_da_far_and_alone_it_flies_a_levy_flight_and_stops():
    normals = np.ones((3, 2, 2))
    normals[0] = [[2.0, -8.0], [-1.0, 1.0]]
    x, v = flown([[4, -3], [-9, 0], [-9, 9]], np.full((3, 2), 0.7), [-9, 9], [-9, 9], [2, 2], None, normals)
    sigma = (gamma(2.5) * sin(pi * 1.5 / 2) / (gamma(1.25) * 1.5 * 2**0.25)) ** (1 / 1.5)
    assert sigma == near(0.6965745026, rel=1e-9)
    # |-8|^(1 / 1.5) = 4, |1|^(1 / 1.5) = 1; the step is relative to the position
    assert x[0] == near([4 + 0.01 * 2 * sigma / 4 * 4, -3 + 0.01 * -1 * sigma / 1 * -3])
    assert v[0].tolist() == [0, 0]
    assert x[1] == near([-9 + 0.01 * sigma * -9, 0])
    assert v[2] == near([min(A * 0.7 + W * 0.7 + E * -18, 2), min(A * 0.7 + W * 0.7 + E * 18, 2)])  # at the food


def test_da_a_neighbour_is_within_the_radius_and_different_in_every_coordinate():
    # For the first: (1, 1) and (2, 2) are neighbours (the radius counts in itself), (0, 1) is equal in one coordinate,
    # (1, 2.1) is too far in one, though sqrt(1 + 4.41) < 2 sqrt(2).
    positions = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2.1]]
    x, v = flown(positions, [[0.0, 0], [1, 1], [0, 1], [9, 9], [9, 9]], food=[0, 0], enemy=[3, 0], r=[2, 2])
    # S = -(1 + 2), A = (0.5, 1), C = 1.5, food at its own place; the enemy is near in one dimension only
    assert v[0] == near([S * -3 + A * 0.5 + C * 1.5, S * -3 + A * 1 + C * 1.5])
    assert x[0] == near(v[0])


def test_da_steps_are_clamped_to_a_tenth_of_the_box_and_positions_to_the_box():
    # All close to the food and to each other (radius 30), the enemy far. The first: S = 18.5 + 6.5, C = -3 - 9.5.
    x, v = flown([[9.5], [-9.0], [3.0]], [[1.0], [-8.0], [9.0]], food=[10], enemy=[40], r=[30])
    assert v[0, 0] == near(S * 25 + A * 0.5 + C * -12.5 + F * 0.5 + W * 1)  # -0.45, unclamped
    assert v[1, 0] == near(2)  # S * -30.05 + A * 4.275 + C * 15.025 + F * 19 + W * -8 = 5.96, a tenth of 20 is left
    x, v = flown([[9.5], [-9.5], [0.0]], [[9.0], [-9.0], [0.0]], food=[0], enemy=[40], r=[12])
    assert v[0, 0] == near(2)  # alone: A * 9 + F * -9.5 + W * 9 = 2.5
    assert x[0, 0] == 10  # 9.5 + 2 is out
    assert v[1, 0] == near(-2)
    assert x[1, 0] == -10


def test_da_radius_and_weights_follow_their_schedules_and_food_and_enemy_their_rules():
    # Each generation is the flight that the tests above follow, with the radius and the weights that the paper and DA.m
    # give it. One dragonfly is on the bound, where no enemy is; T = 4, the box is +-10.
    uniforms = np.linspace(0.1, 0.9, 9).reshape(3, 1, 3)
    normals = np.linspace(-2, 3, 6).reshape(3, 1, 2)
    scalars = [[0.3, 0.6, 0.9], [0.1, 0.2, 0.4], [0.5, 0.5, 0.5]]
    draws = [each for three in scalars for each in (three, 0.7, uniforms)]
    rng = Dealt(random=[[[0.25], [0.5], [1.0]], *draws], standard_normal=[normals] * 3)  # the first steps, in the box
    objective = Watched(lambda x: x[0] ** 2, [[-10], [4], [9]], bound=10.0, generations=4, batches=4)
    batches = watch(DA(agents=3), objective, rng)
    x, v = np.array([[-10.0, 4, 9]]), np.array([[-10 + 20 * 0.25, 0, 10]])
    m = [0.1 - 0.1 * 1 / (4 / 2), 0.1 - 0.1 * 2 / (4 / 2), 0.0]  # 0.05, 0 and no less than that
    seen = []
    for t, (three, weight) in enumerate(zip(scalars, m, strict=True), 1):
        assert batches[t - 1][:, 0] == near(x[0])
        seen += x[0].tolist()
        food = min(seen, key=abs)
        enemy = max((place for place in seen if abs(place) < 10), key=abs)
        assert (food, enemy) == (4, 9) or t > 1
        weights = [*(2 * each * weight for each in three), 2 * 0.7, weight, 0.9 - 0.5 * t / 4]
        box, r = np.array([10.0]), 20 / 4 + 2 * 20 * t / 4
        fly(x, v, np.array([food]), np.array([enemy]), np.array([r]), np.array(weights), -box, box, uniforms, normals)
    assert batches[3][:, 0] == near(x[0])
