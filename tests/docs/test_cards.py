"""Cards of environments: what a reader is told of a scenario, its numbers and its policies."""

import re

import card_tables
import cards


def test_a_card_says_first_what_the_scenario_is():
    assert cards._scenario_card("near").startswith("# near\n\nQuick to learn: few robots")
    assert cards._about("es1-clean").startswith("es1 without"), "the name of a scenario stays small"


def test_numbers_have_six_digits_and_are_written_as_in_a_file():
    table = card_tables.numbers("es1")
    assert "| `radio.bearing_noise` | 0.349066 |" in table
    assert "| `task.duration` | 1800 |" in table
    assert "| `faults.liar.own_p` | false |" in table
    values = [line.split("|")[2] for line in table.splitlines()]
    assert not [each for each in values if re.search(r"\.\d{7}", each)]


def test_a_table_of_a_policy_has_no_empty_column_and_one_row_for_words_and_a_choice():
    everything = card_tables.policy("es1", "everything")
    assert "| to | noise | meaning |" in everything
    rows = everything.partition("### Action")[2].splitlines()
    words = [row for row in rows if "words" in row]
    assert words == ["| 3 to 14 | `words` 0 to 11 | as sent | -1 | 1 |"]
    head = "| numbers | name | unit and scale | from | to | meaning |"
    assert head in card_tables.policy("waypoints-05", "motion")
    assert "in one-hot form: nest, prey, none" in card_tables.policy("es1", "motion")
    weighting = card_tables.policy("waypoints-05", "weighting")
    assert 'Action of `learn="weighting"`, 1 number {' in weighting


def test_the_replay_of_a_square_world_has_a_taller_frame():
    assert 'class="replay tall"' in cards._scenario_card("mg1-hexagon")
    assert 'class="replay tall"' in cards._scenario_card("waypoints-05")
    assert 'class="replay"' in cards._scenario_card("es1")
