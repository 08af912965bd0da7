"""Write the playground of each scenario of these names into a folder: PYTHON FILE FOLDER NAME...

All are written in one process, as scenarios share the machine code of a controller.
"""

import sys
from pathlib import Path

from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.play import write_playground

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[2:]:
        chosen = EvaluateOptions(name, ("ssgikf",), 1, 0, (), "kinematic")
        write_playground(chosen, folder / f"{name}.html")
