"""The claims, the table and the figure on boids where robots forage."""

from baselines.papers.boids_foraging import boids_foraging, table
from baselines.papers.experiments import round_trips

FORAGING = """\
subsumption above boids-goal, social odometry
subsumption above boids-static, social odometry
subsumption above boids-adaptive, social odometry
social odometry above covariance intersection, subsumption
social odometry above decentralised EKF, subsumption
social odometry above dead reckoning, subsumption
adaptive above static boids, social odometry
"""
PAIRS = [
    *(("subsumption:estimator=social_odometry", f"boids-{rule}:estimator=social_odometry")
      for rule in ("goal", "static", "adaptive")),
    *(("subsumption:estimator=social_odometry", f"subsumption:estimator={name}")
      for name in ("covariance_intersection", "decentralised_ekf", "dead_reckoning")),
    ("boids-adaptive:estimator=social_odometry", "boids-static:estimator=social_odometry"),
]  # fmt: skip


def test_each_layer_is_held_against_the_others_in_every_arena():
    paper = boids_foraging()
    found = {
        each.text: ([(one.controller, other.controller) for one, other in each.pairs],
                    {side.scenario for pair in each.pairs for side in pair}, each.metric)
        for each in paper.claims
    }  # fmt: skip
    assert found == {
        f"{arena}: {line}": ([pair], {arena}, round_trips)
        for arena in ("es1", "es2", "es3")
        for line, pair in zip(FORAGING.splitlines(), PAIRS, strict=True)
    }
    assert paper.replications == 30
    assert len(paper.experiments) == 3 * 4 * 4


def test_the_table_of_motions_holds_every_mean_and_the_best_of_an_arena_bold(episodes):
    paper = boids_foraging()
    results = {}
    for experiment in paper.experiments:
        motion, _, name = experiment.controller.partition(":estimator=")
        number = 100 * ("subsumption", "boids-goal", "boids-static", "boids-adaptive").index(motion)
        number += 10 * ("social_odometry", "covariance_intersection", "decentralised_ekf",
                        "dead_reckoning").index(name)  # fmt: skip
        results[experiment] = episodes(experiment, [number + int(experiment.scenario[-1])] * 3)
    varied = next(each for each in paper.experiments if each.scenario == "es2")
    results[varied] = episodes(varied, [500, 510, 520, 530])
    lines = table(results).splitlines()
    assert lines[:6] == [
        "| arena | motion | social odometry | covariance intersection | decentralised EKF"
        " | dead reckoning |",
        "| --- | --- | --- | --- | --- | --- |",
        "| es1 | subsumption | 1 | 11 | 21 | 31 |",
        "| es1 | boids-goal | 101 | 111 | 121 | 131 |",
        "| es1 | boids-static | 201 | 211 | 221 | 231 |",
        "| es1 | boids-adaptive | 301 | 311 | 321 | **331** |",
    ]
    assert len(lines) == 2 + 3 * 4
    bold = [line for line in lines if "**" in line]
    assert len(bold) == 3
    (best,) = (line for line in bold if line.startswith("| es2 "))
    assert "**515 (50" in best
    assert "to 52" in best


def test_the_box_plot_of_motions_has_a_panel_for_each_arena():
    (figure,) = boids_foraging().figures
    assert list(figure.panels) == ["es1", "es2", "es3"]
    for arena, panel in figure.panels.items():
        assert list(panel) == ["social\nodometry", "covariance\nintersection",
                               "decentralised\nEKF", "dead\nreckoning"]  # fmt: skip
        for series in panel.values():
            assert list(series) == ["subsumption", "boids-goal", "boids-static", "boids-adaptive"]
            assert {each.scenario for each in series.values()} == {arena}
    assert (figure.axes, figure.metric) == (("", "round trips"), round_trips)
