# SPDX-License-Identifier: Apache-2.0
"""Agents for REVE worlds: perceive and act over TCP.

>>> import reve
>>> with reve.connect("127.0.0.1", 7777, name="ada") as agent:
...     print([item.name for item in agent.perceive().items])
"""

from .client import Agent, Control, cluster, connect, control
from .errors import Disconnected, ProtocolError, ReveError
from .protocol import (
    Act,
    Bye,
    Event,
    Heard,
    Image,
    Item,
    Limits,
    LockStep,
    Parameter,
    Perception,
    Reading,
    Report,
    Result,
    Ticket,
    Update,
    Value,
    Welcome,
)
from .server import experiment, pack, serve

__version__ = "1.0.0"

__all__ = [
    "Act",
    "Agent",
    "Bye",
    "Control",
    "Disconnected",
    "Event",
    "Heard",
    "Image",
    "Item",
    "Limits",
    "LockStep",
    "Parameter",
    "Perception",
    "Reading",
    "Report",
    "ProtocolError",
    "Result",
    "ReveError",
    "Ticket",
    "Update",
    "Value",
    "Welcome",
    "cluster",
    "connect",
    "control",
    "experiment",
    "pack",
    "serve",
]
