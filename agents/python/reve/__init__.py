"""Agents for REVE worlds: perceive and act over TCP.

>>> import reve
>>> with reve.connect("127.0.0.1", 7777, name="ada") as agent:
...     print([item.name for item in agent.perceive().items])
"""

from .client import Agent, connect
from .protocol import (
    Bye,
    Event,
    Item,
    Limits,
    Parameter,
    Perception,
    Result,
    Value,
    Welcome,
)
from .errors import Disconnected, ProtocolError, ReveError

__all__ = [
    "Agent",
    "Bye",
    "Disconnected",
    "Event",
    "Item",
    "Limits",
    "Parameter",
    "Perception",
    "ProtocolError",
    "Result",
    "ReveError",
    "Value",
    "Welcome",
    "connect",
]
