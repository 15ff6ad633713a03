# SPDX-License-Identifier: Apache-2.0
"""Lets the clients of tests wait 5 minutes for an answer by default, because other tests may occupy
the machine. A call with a `timeout` of its own keeps it.

This module imports nothing of `reve`. It changes the default when a program imports `reve`.
"""

import importlib.machinery
import sys

TIMEOUT = 300.0  # seconds
MODULES = ("reve.client", "reve.aio")


class PatientClients:
    """Finds the modules of the clients as Python does, and changes them once they are executed."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if name not in MODULES:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None:
            execute = spec.loader.exec_module

            def execute_and_change(module):
                execute(module)
                for join in (module.connect, module.control, module.cluster):
                    join.__kwdefaults__["timeout"] = TIMEOUT

            spec.loader.exec_module = execute_and_change
        return spec


sys.meta_path.insert(0, PatientClients)
