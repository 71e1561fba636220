"""The look that all plots share, whose axes they draw on, and which problems they refuse."""

import numpy as np

from bench.plots import style


def test_a_title_has_as_many_letters_as_its_panel_has_room_for():
    _, panels = style.grid(3, width=4.8, height=1.0, left=0.6, across=0.3)
    style.title(panels[0], "a-problem-with-a-long-name-d10")
    assert panels[0].get_title(loc="left") == "a-problem-wit…me-d10"


def test_long_labels_stay_apart():
    labels = [f"mealpy:Original{i:02d}Optimizer" for i in range(12)] + ["gwo", "x" * 500]
    names = style.names(labels, 20)
    assert len(set(names.values())) == len(labels)
    assert max(map(len, names.values())) <= 20
    assert names["gwo"] == "gwo"
    assert style.names(labels[3:5] + labels[:3] + labels[5:], 20) == names  # whatever their order


def pens_of(labels, **options):
    return {label: (each.color, each.marker, str(each.line)) for label, each in style.pens(labels, **options).items()}


class TestLooks:
    def test_all_differ_and_the_first_colours_are_taken_once(self):
        assert len(set(pens_of([str(i) for i in range(280)]).values())) == 280
        assert len({color for color, _, _ in pens_of([f"o{i}" for i in range(8)]).values()}) == 8

    def test_they_are_the_same_in_every_process_and_version(self):
        known = {"cma-es": "#009E73", "gwo": "#000000", "random-search": "#8C6D31"}
        assert {label: color for label, (color, _, _) in pens_of(list(known)).items()} == known

    def test_every_colour_is_seen_on_white_and_on_a_dark_page(self):
        def luminance(color):
            parts = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
            linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
            return linear @ [0.2126, 0.7152, 0.0722]

        for color in set(style.PALETTE) - {"#000000"}:  # the page has its own ink for black
            for page in ("#ffffff", "#14171b"):
                low, high = sorted([luminance(color), luminance(page)])
                assert (high + 0.05) / (low + 0.05) > 2, (color, page)
