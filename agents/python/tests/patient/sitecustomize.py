# SPDX-License-Identifier: Apache-2.0
"""Python imports this module when it starts, if `PYTHONPATH` contains its folder."""

import patience  # noqa: F401
