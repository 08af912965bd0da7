"""Curves of a training run: what TensorBoard reads, and where they cannot be written."""

import pytest

from tests.training.conftest import POINT
from training.training_loop import FOLDER, ProgressLogger


def test_tensorboard_reads_the_curves(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    with ProgressLogger(tmp_path, "round", lambda _: None) as progress:
        progress.start(10, 0)
        progress.log_scalars(2, {"loss": 0.25, "speed/worlds a second": 4.0})
        progress.log_evaluation(POINT)
    curves = EventAccumulator(str(tmp_path / FOLDER)).Reload()
    found = {
        name: [(each.step, each.value) for each in curves.Scalars(name)]
        for name in curves.Tags()["scalars"]
    }
    assert found == {
        "loss": [(2, 0.25)],
        "speed/worlds a second": [(2, 4.0)],
        "held_back/value": [(3, 0.5)],
        "held_back/es1": [(3, 2.0)],
    }


def test_a_full_disk_is_an_error_of_the_training_that_names_the_file(tmp_path, full_disk):
    def log():
        with ProgressLogger(tmp_path, "round", lambda _: None) as progress:
            for step in range(1_000):
                progress.log_scalars(step, {"loss": 0.25})

    with full_disk(1_000), pytest.raises(OSError, match=r"File too large: .*tfevents"):
        log()


def test_a_folder_is_made_with_those_above_it_and_more_steps_than_asked_leave_none(tmp_path):
    said = []
    out = tmp_path / "a" / "b"
    with ProgressLogger(out, "round", said.append) as progress:
        progress.start(10, 12)
    assert said == ["12 of 10 rounds found, 0 to run"]
    assert len(list((out / FOLDER).iterdir())) == 1
