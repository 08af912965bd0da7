"""BenchMARL's command line with these tasks: `python -m training.benchmarl_tasks task=...`."""

import hydra
from benchmarl.hydra_config import load_experiment_from_hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from training.benchmarl_tasks import EpisodeMetrics, KeepsPolicy


@hydra.main(version_base=None, config_path="conf", config_name="config")  # type: ignore[untyped-decorator]
def main(config: DictConfig) -> None:
    """Run one experiment; results go to Hydra's folder of outputs."""
    task = HydraConfig.get().runtime.choices.task
    callbacks = [EpisodeMetrics(), KeepsPolicy()]
    load_experiment_from_hydra(config, task_name=task, callbacks=callbacks).run()


if __name__ == "__main__":
    main()
