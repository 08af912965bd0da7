"""Pictures of the hand-written controllers."""

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
