# SPDX-License-Identifier: Apache-2.0
"""pytest imports this module before the tests."""

import sys

from support import PATIENT

sys.path.insert(0, str(PATIENT))
import patience  # noqa: E402, F401
