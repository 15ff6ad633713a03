# SPDX-License-Identifier: Apache-2.0
"""The module `vesper`, which laws in Python import; see docs/laws-in-python.md."""

import ast
import contextlib
import difflib
import importlib.metadata
import inspect
import math
import sys
import traceback
import types
import typing

import _vesper
import numpy

_READ, _WRITE, _READ_WRITE, _ACCUMULATE, _SCRATCH = 1, 2, 3, 4, 8
_TYPES = {1: numpy.float32, 2: numpy.float64, 3: numpy.int32, 4: numpy.uint32}
_FIELD = 5
_PHASES = {"force": 1, "integrate": 2, "constrain": 3, "observe": 4}
_CLAIMS = {"momentum": 1, "angular momentum": 2, "translation": 4, "rotation": 8, "energy": 16}
_STEP = ("dt", "time")
_PROVIDES = "field"  # what stands for a phase in the declaration of a field
_SHORT_NAMES = {"force": "externalForce"}
_LARGEST = sys.float_info.max

_PYTHON = f"Python {sys.version.split()[0]}"
_declared = []  # the laws that the running file has declared so far
_energies = []  # (law, energy): functions of the running file so far


class _Refused(Exception):
    """A mistake in the law's file. Messages do not contain the name of this exception's type."""


def _unit(text):
    if not isinstance(text, str):
        raise _Refused(f"the unit is {text!r}, expected a text such as 'm/s'")
    try:
        return _vesper.parse_unit(text)
    except ValueError as wrong:
        raise _Refused(str(wrong)) from None


def _symbol(unit):
    return unit[16:].split(b"\0")[0].decode() or "1"


def _number(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise _Refused(f"{name} is {value!r}, expected a finite number")
    return float(value)


class _Column:
    access = 0
    needed = 0  # access bits that the property must permit

    def __init__(self, kind, unit="1"):
        if not isinstance(kind, str):
            raise _Refused(f"the kind is {kind!r}, expected a text such as 'body'")
        self.kind = kind
        self.unit = _unit(unit)
        self.components = 0


class Read(_Column):
    """A column that the law reads: Read("body", "m/s")."""

    access = needed = _READ


class Write(_Column):
    """A column of which the law writes every row in each call, and reads none."""

    access = needed = _WRITE


class ReadWrite(_Column):
    """A column that the law reads and changes in place."""

    access = needed = _READ_WRITE


class Accumulate(_Column):
    """A column of zeros to which the law adds; the engine sums over all laws. Only in phase
    "force"."""

    access = needed = _ACCUMULATE


class Field(_Column):
    """A function of position that the law reads: Field("world", "m/s"). The argument of the law is
    a function. It takes an array of positions (rows, 3) in m, and returns the values there."""

    access = needed = _READ


class Scratch(_Column):
    """Private memory of the law: one row for each row of the kind, initially zero. The engine saves
    it and rolls it back together with the world."""

    access = _SCRATCH

    def __init__(self, kind, unit="1", components=1):
        super().__init__(kind, unit)
        if not isinstance(components, int) or not 1 <= components <= 64:
            raise _Refused(f"components is {components!r}, expected 1 to 64")
        self.components = components


class Parameter:
    """A number that is given when the law is loaded: Parameter("kg/s", default=2, least=0)."""

    def __init__(self, unit="1", *, default, least=-_LARGEST, most=_LARGEST, doc=""):
        self.unit = _unit(unit)
        self.default = _number("default", default)
        self.least = _number("least", least)
        self.most = _number("most", most)
        self.doc = str(doc)
        if not self.least <= self.default <= self.most:
            raise _Refused(
                f"default is {self.default}, expected {self.least} to {self.most}, which are least"
                " and most"
            )


def law(phase, *, claims=(), version="1.0.0"):
    """Declares the function below as a law of a phase: @vesper.law(phase="force")."""
    if phase not in _PHASES:
        found = "@vesper.law without brackets" if callable(phase) else f"phase={phase!r}"
        raise _Refused(
            f'found {found}, expected @vesper.law(phase="force") or one of the phases '
            + ", ".join(_PHASES)
        )
    bits = 0
    for claim in (claims,) if isinstance(claims, str) else claims:
        if claim not in _CLAIMS:
            raise _Refused(f"found the claim {claim!r}, expected " + ", ".join(_CLAIMS))
        bits |= _CLAIMS[claim]

    def declare(function):
        if not isinstance(function, types.FunctionType):
            raise _Refused(f"found {function!r} behind @vesper.law, expected a function (def)")
        _declared.append((function, phase, bits, version, None))
        return function

    return declare


def field(unit="1", *, version="1.0.0"):
    """Declares the function below as a field that the file provides: @vesper.field("m/s"). Its
    first argument are positions (rows, 3) in m, and it returns the values there."""
    if callable(unit):
        raise _Refused('found @vesper.field without brackets, expected @vesper.field("m/s")')
    parsed = _unit(unit)

    def declare(function):
        if not isinstance(function, types.FunctionType):
            raise _Refused(f"found {function!r} behind @vesper.field, expected a function (def)")
        _declared.append((function, _PROVIDES, 0, version, parsed))
        return function

    return declare


def energy(law):
    """Declares the function below as the potential energy [J] of a law above it:
    @vesper.energy(spring)."""
    if not any(law is declared[0] and declared[1] != _PROVIDES for declared in _declared):
        raise _Refused(f"found @vesper.energy({law!r}), expected a function with @vesper.law above")
    if any(law is other for other, _ in _energies):
        raise _Refused(f"{law.__name__} has a second energy, expected one")

    def declare(function):
        if not isinstance(function, types.FunctionType):
            raise _Refused(f"found {function!r} behind @vesper.energy, expected a function (def)")
        _energies.append((law, function))
        return function

    return declare


class _File:
    """The text of the law's file, to find the lines of problems."""

    def __init__(self, source, text):
        self.source = source
        self.definitions = {}
        for node in ast.walk(ast.parse(text, source)):
            if isinstance(node, ast.FunctionDef):
                first = node.decorator_list[0].lineno if node.decorator_list else node.lineno
                self.definitions[node.name, first] = node

    def of(self, function):
        node = self.definitions.get((function.__name__, function.__code__.co_firstlineno))
        if node is None or function.__code__.co_filename != self.source:
            raise _Refused(f"the function {function.__name__} is not defined (def) in this file")
        return node

    def refuse(self, node, problem):
        raise _Refused(f"{self.source}:{node.lineno}: {problem}")


def _near(name, names):
    near = difflib.get_close_matches(name, sorted(names), 1)
    return f"; did you mean {near[0]}?" if near else "; it has " + ", ".join(sorted(names))


def _uses(function):
    """Returns the annotations of a function. The annotation `Annotated[TYPE, use]` counts as the
    use. Other annotations are types for type checkers."""
    uses = {}
    for name, use in inspect.get_annotations(function, eval_str=True).items():
        if typing.get_origin(use) is typing.Annotated:
            found = [each for each in use.__metadata__ if isinstance(each, (_Column, Parameter))]
            use = found[0] if len(found) == 1 else use
        uses[name] = use
    return uses


class _Law:
    """A law: a function with its declarations, checked against the properties of the world."""

    def __init__(self, declared, file, real_type, properties):
        self.function, self.phase, self.claims, self.version, self.unit = declared
        self.name = self.function.__name__
        self.uses = []  # (name of the argument, use, type, components)
        self.parameters = []  # (name, Parameter)
        self.step = []
        self.node = file.of(self.function)
        self.file = file
        self.real_type = real_type
        self.properties = {(entry[1], entry[0]): entry for entry in properties}
        self.examine()
        self.energy = next((e for law, e in _energies if law is self.function), None)
        self.energy_arguments = self.examined_energy() if self.energy else []

    def examine(self):
        node, arguments = self.node, self.node.args
        if arguments.vararg or arguments.kwarg or arguments.posonlyargs:
            self.file.refuse(node, "found *, ** or / among the arguments, expected names only")
        annotations = _uses(self.function)
        for argument in [*arguments.args, *arguments.kwonlyargs]:
            name, use = argument.arg, annotations.get(argument.arg)
            if (use is None or use is float) and name in _STEP:
                self.step.append(name)
            elif isinstance(use, Parameter):
                self.parameters.append((name, use))
            elif isinstance(use, _Column):
                self.uses.append(self.matched(argument, name, use))
            else:
                found = "no annotation" if use is None else f"the annotation {use!r}"
                self.file.refuse(
                    argument,
                    f"{name} has {found}, expected a column such as vesper.Read('body', 'm/s'), "
                    "vesper.Parameter(…), or one of the names dt and time",
                )
        self.forbid_rebinding()

    def matched(self, argument, name, use):
        if isinstance(use, Scratch):
            return name, (name, use.kind, self.real_type, use.components, use.access, use.unit)
        properties = self.properties
        if (use.kind, name) not in properties:
            name = _SHORT_NAMES.get(name, name)
        found = properties.get((use.kind, name))
        if found is None:
            field = properties.get(("world", name))
            if field is not None and field[2] == _FIELD:
                self.file.refuse(
                    argument,
                    f"'{name}' is a field of kind world, the annotation says '{use.kind}'; write "
                    f"vesper.Field('world', '{_symbol(field[5])}')",
                )
            kinds = {kind for kind, _ in properties}
            if use.kind not in kinds:
                self.file.refuse(
                    argument,
                    f"there is no kind '{use.kind}' in this world" + _near(use.kind, kinds),
                )
            own = {other for kind, other in properties if kind == use.kind}
            self.file.refuse(argument, f"{use.kind} has no property '{name}'" + _near(name, own))
        _, _, scalar_type, components, permitted, unit = found
        if (scalar_type == _FIELD) != isinstance(use, Field):
            found, right = ("field", "Field") if scalar_type == _FIELD else ("column", "Read")
            self.file.refuse(
                argument,
                f"'{name}' is a {found}, the annotation is vesper.{type(use).__name__}; "
                f"write vesper.{right}('{use.kind}', '{_symbol(unit)}')",
            )
        if use.unit[:7] != unit[:7]:
            self.file.refuse(
                argument,
                f"the unit of '{name}' is {_symbol(unit)}, the annotation says {_symbol(use.unit)}",
            )
        if use.needed & ~permitted:
            possible = [
                each.__name__
                for each in (Read, Write, ReadWrite, Accumulate)
                if not each.needed & ~permitted
            ]
            self.file.refuse(
                argument,
                f"the annotation of '{name}' is vesper.{type(use).__name__}, and laws may use it as "
                + " or ".join(possible),
            )
        if use.access == _ACCUMULATE and self.phase != "force":
            self.file.refuse(
                argument, f"vesper.Accumulate is for laws of phase force, this one is {self.phase}"
            )
        return argument.arg, (name, use.kind, scalar_type, components, use.access, use.unit)

    def examined_energy(self):
        """Returns the names of the arguments of the energy."""
        node = self.file.of(self.energy)
        if self.phase != "force":
            self.file.refuse(node, f"a law of phase {self.phase} has no energy, only force has one")
        if node.args.vararg or node.args.kwarg or node.args.posonlyargs:
            self.file.refuse(node, "found *, ** or / among the arguments, expected names only")
        names = {name for name, use in self.uses if use[4] & _READ or use[4] == _SCRATCH}
        names.update(name for name, _ in self.parameters)
        for argument in [*node.args.args, *node.args.kwonlyargs]:
            if argument.arg not in names:
                self.file.refuse(
                    argument,
                    f"an energy depends on what its law reads; {self.name} reads no"
                    f" '{argument.arg}'" + (_near(argument.arg, names) if names else ""),
                )
        return [argument.arg for argument in [*node.args.args, *node.args.kwonlyargs]]

    def forbid_rebinding(self):
        """Refuses an assignment such as `force = …`, because it would make a new array and not
        change the column."""
        columns = {name for name, use in self.uses if use[2] != _FIELD}
        for node in ast.walk(self.node):
            targets = node.targets if isinstance(node, ast.Assign) else []
            for target in targets:
                if isinstance(target, ast.Name) and target.id in columns:
                    self.file.refuse(
                        node,
                        f"'{target.id} = …' makes another array and leaves the column unchanged; "
                        f"write '{target.id}[:] = …' or '{target.id} += …'",
                    )

    def description(self):
        doc = (self.function.__doc__ or "").strip().split("\n")[0]
        stages = 1 if self.phase == "integrate" else 0
        return (
            self.name,
            self.version,
            doc,
            _PHASES.get(self.phase, _PHASES["observe"]),
            self.claims,
            stages,
            stages,
            [use for _, use in self.uses],
            [(n, p.doc, p.unit, p.default, p.least, p.most) for n, p in self.parameters],
            self,
            self.energy is not None,
            None,
        )

    def rehearse(self):
        """Calls the function with one row of zeros, so that Numba compiles it before the first
        frame."""
        arguments = {name: parameter.default for name, parameter in self.parameters}
        arguments.update((name, 0.0) for name in self.step)
        for name, (_, _, scalar_type, components, access, _) in self.uses:
            if scalar_type == _FIELD:
                continue  # Numba compiles no calls of fields
            shape = (1,) if components == 1 else (1, components)
            arguments[name] = numpy.zeros(shape, _TYPES[scalar_type])
            arguments[name].flags.writeable = access != _READ  # Numba distinguishes the types
        with numpy.errstate(all="ignore"):
            with contextlib.suppress(Exception):
                self.function(**arguments)
            if self.energy:
                with contextlib.suppress(Exception):
                    self.energy(**{name: arguments[name] for name in self.energy_arguments})

    def create(self, values):
        return _Instance(self, values)


class _ProvidedField(_Law):
    """A field that a file provides. For the engine, it is a law that does nothing, with the
    parameters of the field."""

    def examine(self):
        node = self.node
        if node.args.vararg or node.args.kwarg or node.args.posonlyargs:
            self.file.refuse(node, "found *, ** or / among the arguments, expected names only")
        annotations = _uses(self.function)
        arguments = [*node.args.args, *node.args.kwonlyargs]
        first = node.args.args[0].arg if node.args.args else "dt"
        if first in _STEP or isinstance(annotations.get(first), (_Column, Parameter)):
            self.file.refuse(
                node,
                f"the first argument of the field {self.name} are the positions; expected a name"
                " without annotation or with a type, such as place",
            )
        for argument in arguments[1:]:
            name, use = argument.arg, annotations.get(argument.arg)
            if (use is None or use is float) and name == "time":
                self.step.append(name)
            elif isinstance(use, Parameter):
                self.parameters.append((name, use))
            else:
                self.file.refuse(
                    argument,
                    f"a field depends on positions, time and parameters; {name} is none of them:"
                    " expected vesper.Parameter(…) or the name time",
                )
        self.components = self.matched_field()

    def matched_field(self):
        fields = {name: use for (_, name), use in self.properties.items() if use[2] == _FIELD}
        found = fields.get(self.name)
        if found is None:
            near = _near(self.name, fields) if fields else "; it has none"
            self.file.refuse(self.node, f"the world has no field '{self.name}'" + near)
        if self.unit[:7] != found[5][:7]:
            self.file.refuse(
                self.node,
                f"the unit of '{self.name}' is {_symbol(found[5])}, @vesper.field says"
                f" {_symbol(self.unit)}",
            )
        return found[3]

    def description(self):
        (*law, _, _) = super().description()
        return (*law, False, (self.unit, self.components))

    def rehearse(self):
        arguments = {name: parameter.default for name, parameter in self.parameters}
        arguments.update((name, 0.0) for name in self.step)
        with numpy.errstate(all="ignore"), contextlib.suppress(Exception):
            self.function(numpy.zeros((1, 3)), **arguments)

    def create(self, values):
        return _Provider(self, values)


class _Provider:
    """A loaded field: its function with the parameters as arguments."""

    def __init__(self, law, values):
        self.law = law
        self.arguments = {name: value for (name, _), value in zip(law.parameters, values)}

    def bind(self, columns):
        pass

    def advance(self, dt, time, stage):
        pass

    def evaluate(self, positions, values, time):
        """Writes the values at positions (rows x 3) to the memory of `values`."""
        at = numpy.frombuffer(positions, numpy.float64).reshape(-1, 3)
        components = self.law.components
        shape = (len(at),) if components == 1 else (len(at), components)
        given = {"time": time} if self.law.step else {}
        result = numpy.asarray(self.law.function(at, **given, **self.arguments), numpy.float64)
        if result.shape not in (shape, shape[1:]):
            raise _Refused(
                f"{self.law.name} returned the shape {result.shape} for {len(at)} positions,"
                f" expected {shape}"
            )
        numpy.frombuffer(values, numpy.float64).reshape(shape)[...] = result


class _Call:
    """Whether the function of a law runs."""

    inside = False


class _FieldOf:
    """The argument of a law for a field."""

    def __init__(self, name, field, components, call):
        self.name = name
        self.field = field
        self.components = components
        self.call = call

    def __call__(self, positions):
        if not self.call.inside:
            raise RuntimeError(f"the field '{self.name}' is valid during the call of the law only")
        at = numpy.ascontiguousarray(positions, numpy.float64)
        if at.ndim not in (1, 2) or at.shape[-1] != 3:
            raise ValueError(
                f"the positions for '{self.name}' have the shape {numpy.shape(positions)}, expected"
                " (rows, 3) or (3,)"
            )
        values = numpy.empty(at.shape[:-1] + ((self.components,) if self.components > 1 else ()))
        _vesper.evaluate_field(self.field, at, values)
        return values[()]


class _Instance:
    """A loaded law: its function, with the columns, fields and parameters as arguments."""

    def __init__(self, law, values):
        self.law = law
        self.function = law.function
        self.arguments = {name: value for (name, _), value in zip(law.parameters, values)}
        self.has_dt, self.has_time = (name in law.step for name in _STEP)
        self.call = _Call()
        names = law.energy_arguments
        self.of_energy = {name: self.arguments[name] for name in names if name in self.arguments}

    def bind(self, columns):
        for (name, use), (memory, rows, components) in zip(self.law.uses, columns):
            if use[2] == _FIELD:
                self.arguments[name] = _FieldOf(use[0], memory, components, self.call)
                continue
            shape = (rows,) if components == 1 else (rows, components)
            self.arguments[name] = numpy.ndarray(shape, _TYPES[use[2]], memory)
        for name in self.law.energy_arguments:
            self.of_energy[name] = value = self.arguments[name]
            if isinstance(value, numpy.ndarray):
                self.of_energy[name] = value = value.view()
                value.flags.writeable = False

    def potential_energy(self):
        self.call.inside = True
        try:
            result = self.law.energy(**self.of_energy)
        finally:
            self.call.inside = False
        if isinstance(result, bool) or not isinstance(result, (int, float, numpy.number)):
            raise _Refused(
                f"{self.law.energy.__name__} returned {type(result).__name__}, expected a number,"
                " the potential energy in J"
            )
        return float(result)

    def advance(self, dt, time, stage):
        arguments = self.arguments
        if self.has_dt:
            arguments["dt"] = dt
        if self.has_time:
            arguments["time"] = time
        self.call.inside = True
        try:
            result = self.function(**arguments)
        finally:
            self.call.inside = False
        if result is not None:
            raise _Refused(
                f"{self.law.name} returned {type(result).__name__}, expected nothing: a law writes "
                "to its columns in place"
            )


def _top(module):
    return module.partition(".")[0]


def _imports(text):
    """Returns the packages that a file names in `import`, also inside functions."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (_top(each.name) for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield _top(node.module)


def _versions(text, before):
    """Returns the versions on which the results of a file depend: those of Python, of NumPy, and of
    the distributions that the file imports. These are the imports in its text, and the modules that
    were not in `before`."""
    found = {*_imports(text), *(_top(name) for name in set(sys.modules) - before)}
    found -= {"vesper", "_vesper", "numpy", *sys.stdlib_module_names}
    owners = importlib.metadata.packages_distributions() if found else {}
    names = {owner for package in found for owner in owners.get(package, ())}
    versions = [f"{name} {importlib.metadata.version(name)}" for name in sorted(names)]
    return ", ".join([_PYTHON, f"NumPy {numpy.__version__}", *versions])


def _remedy():
    """Returns the end of the message for a missing package: the interpreter that has searched for
    it, and what to do. The text is short, because the length of messages is limited."""
    if sys.prefix == sys.base_prefix:
        return (
            f"; used {sys.executable} ({_PYTHON}): install it as python3-…, or name a virtual"
            " environment with --python DIR"
        )
    return f"; used {sys.executable} ({_PYTHON}): add it there with -m pip install"


def _open(source, text, real_type, properties, most):
    """Runs a law file; returns the descriptions of its laws, and the versions that it uses."""
    _declared.clear()
    _energies.clear()
    before = set(sys.modules)
    module = types.ModuleType(source.removesuffix(".py"))
    module.__file__ = source
    try:
        exec(compile(text, source, "exec", dont_inherit=True), module.__dict__)
        if not 1 <= len(_declared) <= most:
            raise _Refused(
                f"{source}: has {len(_declared)} functions with @vesper.law or @vesper.field,"
                f" expected 1 to {most}"
            )
        file = _File(source, text)
        laws = [
            (_ProvidedField if declared[1] == _PROVIDES else _Law)(
                declared, file, real_type, properties
            )
            for declared in _declared
        ]
        if "numba" in _imports(text):
            for law in laws:
                law.rehearse()
    finally:
        _declared.clear()
        _energies.clear()
    return [law.description() for law in laws], _versions(text, before)


def _describe(exception, source):
    """Describes an exception in one line: the line of the file at which it was raised, and its
    message."""
    if isinstance(exception, SyntaxError) and exception.filename == source:
        return f"{source}:{exception.lineno}:{exception.offset}: {exception.msg}"
    text = str(exception)
    if not isinstance(exception, _Refused):
        text = f"{type(exception).__name__}: {text}" if text else type(exception).__name__
    if isinstance(exception, ModuleNotFoundError):
        text += _remedy()
    lines = [
        line
        for frame, line in traceback.walk_tb(exception.__traceback__)
        if frame.f_code.co_filename == source
    ]
    if not text.startswith(source + ":"):
        text = f"{source}:{lines[-1]}: {text}" if lines else f"{source}: {text}"
    return " ".join(text.split())
