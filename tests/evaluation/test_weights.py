"""The maps of weights: what they show is what the rule says."""

import numpy as np
import pytest

from baselines.evaluation.figures.base import FIGURES, PlotOptions
from baselines.evaluation.figures.weights import DISAGREEMENTS, LONGEST, STEPS


def drawn(*controllers):
    return FIGURES["weights"].draw(PlotOptions("weights", controllers))


def shown(figure):
    """The weights of each map, heard paths in rows and own paths in columns."""
    return [np.asarray(axes.images[0].get_array()) for axes in figure.axes if axes.images]


def test_a_map_is_the_weight_of_each_pair_of_paths():
    maps = shown(drawn("ssgikf"))
    assert len(maps) == len(DISAGREEMENTS)
    own, heard = 15, 5  # 3 m and 1 m
    assert (LONGEST, STEPS) == (12.0, 61)
    assert maps[0][heard, own] == pytest.approx(3.0 / (3.0 + 1.0))


def test_rules_stand_side_by_side_and_share_the_scale():
    figure = drawn("ssgikf", "ssgiff:beta=0.01")
    panels = [axes for axes in figure.axes if axes.images]
    assert len(panels) == 2 * len(DISAGREEMENTS)
    assert {axes.images[0].get_clim() for axes in panels} == {(0.0, 1.0)}
    own, heard = 20, 10
    assert shown(figure)[1][heard, own] == pytest.approx(1.0 / (1.0 + np.exp(-2.0)))


def test_what_a_message_costs_is_added_to_what_the_partner_went():
    plain, wary = (shown(drawn(name))[0] for name in ("ssgiff", "dsgiff-penalised"))
    np.testing.assert_allclose(wary[:-20], plain[20:])  # 4 m


def test_labels_of_contours_stand_within_their_map():
    figure = drawn("ssgikf", "ssgiff", "dsgiff-penalised", "learned-weighting")
    figure.canvas.draw()
    for axes in (each for each in figure.axes if each.images):
        frame = axes.get_window_extent()
        boxes = [label.get_window_extent() for label in axes.texts]
        assert boxes
        for box in boxes:
            assert frame.x0 <= box.x0 < box.x1 <= frame.x1
            assert frame.y0 <= box.y0 < box.y1 <= frame.y1
