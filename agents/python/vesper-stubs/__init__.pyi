# SPDX-License-Identifier: Apache-2.0
# Types of the module `vesper`, which laws in Python import; see docs/laws-in-python.md. Within laws,
# vesper-native/python/src/vesper_module.py defines the module.

from typing import Any, Callable, Iterable, Literal, TypeVar

_Claim = Literal["momentum", "angular momentum", "translation", "rotation", "energy"]
_Function = TypeVar("_Function", bound=Callable[..., Any])

class _Column:
    def __init__(self, kind: str, unit: str = "1") -> None: ...

class Read(_Column): ...
class Write(_Column): ...
class ReadWrite(_Column): ...
class Accumulate(_Column): ...
class Field(_Column): ...

class Scratch(_Column):
    def __init__(self, kind: str, unit: str = "1", components: int = 1) -> None: ...

class Parameter:
    def __init__(
        self,
        unit: str = "1",
        *,
        default: float,
        least: float = ...,
        most: float = ...,
        doc: str = "",
    ) -> None: ...

def law(
    phase: Literal["force", "integrate", "constrain", "observe"],
    *,
    claims: _Claim | Iterable[_Claim] = (),
    version: str = "1.0.0",
) -> Callable[[_Function], _Function]: ...
def field(unit: str = "1", *, version: str = "1.0.0") -> Callable[[_Function], _Function]: ...
def energy(law: Callable[..., Any]) -> Callable[[_Function], _Function]: ...
