# SPDX-License-Identifier: Apache-2.0
"""Learning environments: `Environment` for Gymnasium, `reve.gym.parallel.ParallelEnvironment` for
PettingZoo.

Needs the package's extra `gym`: `pip install 'agents/python[gym]'`.
"""

from .environment import Environment
from .task import Edit, Task

__all__ = ["Edit", "Environment", "Task"]
