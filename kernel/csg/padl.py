"""The csgmesh language in the manner of PADL-2: statements evaluated in order, then one tree."""

from __future__ import annotations

import math
from dataclasses import replace

from kernel.csg import padl_syntax as syntax
from kernel.csg.limits import check_material, check_tree, missing_of_material
from kernel.csg.padl_numbers import CONSTANTS, FUNCTIONS, combine
from kernel.csg.padl_solids import MOVES, SHAPES, PadlSolid, boolean
from kernel.csg.source import MAX_NODES, MAX_TREE_DEPTH, either, wrong_number
from kernel.csg.tree import IDENTITY, CsgModel
from kernel.errors import Place, ReadError
from kernel.materials import MATERIAL_NAMES, named_material
from kernel.units import UNIT_SETS, unit_set
from kernel.words import did_you_mean

KEYWORDS = ("UNITS", "MATERIAL", "OUT", "UN", "DIF", "INT", "AT")
_OPERATIONS = {"UN": "union", "DIF": "difference", "INT": "intersection"}
_RESERVED = {*KEYWORDS, *SHAPES, *FUNCTIONS, *CONSTANTS}

Value = float | PadlSolid


def read_padl(text: str, source: str) -> CsgModel:
    """The model of a PADL-2-like file. ReadError: what cannot be read, with its place."""
    reader = _Reader(source)
    for statement in syntax.parse_padl(text, source):
        reader.run(statement)
    root = reader.model().as_tree()
    reader.fill_materials()
    check_tree(root)
    return CsgModel(root=root, source=source, language="padl", units=reader.units, materials=reader.materials)


class _Reader:
    """What the statements so far have given: names (by upper case), units, materials, the model's name."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.values: dict[str, Value] = {}
        self.defined_on: dict[str, int] = {}
        self.units: str | None = None
        self.materials: dict[str, dict[str, float]] = {}
        self.material_places: dict[str, syntax.Here] = {}
        self.last: PadlSolid | None = None
        self.out: PadlSolid | None = None

    def run(self, statement: syntax.Statement) -> None:
        """One statement."""
        getattr(self, f"_run_{statement.kind}")(statement)

    def model(self) -> PadlSolid:
        """The solid that OUT names, else the last one."""
        solid = self.out or self.last
        if solid is None:
            raise ReadError(f"{self.source}: there is no solid in the file, expected one such as A = BLO(1, 1, 1)")
        return solid

    def fill_materials(self) -> None:
        """Give each `MATERIAL name` without numbers the values of the named material, in the file's own UNITS."""
        for name, values in self.materials.items():
            if values:
                continue
            here = self.material_places[name]
            if self.units is None:
                raise self._error(
                    here, f"the material {name!r} has no numbers, expected them, or UNITS to look it up in"
                )
            if name.lower() not in MATERIAL_NAMES:
                raise self._error(
                    here,
                    f"unknown material {name!r}, expected {either(list(MATERIAL_NAMES))}, or its E, NU and RHO"
                    f"{did_you_mean(name, MATERIAL_NAMES)}",
                )
            known = named_material(name, unit_set(self.units))
            values.update(E=known.elastic_modulus, NU=known.poisson_ratio, RHO=known.density)

    def _run_units(self, statement: syntax.Statement) -> None:
        name = statement.name.lower()
        if name not in UNIT_SETS:
            raise self._error(
                statement.here,
                f"unknown units {statement.name!r}, expected {either(list(UNIT_SETS))}{did_you_mean(name, UNIT_SETS)}",
            )
        if self.units is not None:
            raise self._error(statement.here, "UNITS stands twice, expected it once")
        self.units = name

    def _run_material(self, statement: syntax.Statement) -> None:
        name, given = statement.name, {}
        if name.upper() in (other.upper() for other in self.materials):
            raise self._error(statement.here, f"the material {name!r} stands twice, expected it once")
        for argument in statement.value:
            if argument.key is None:
                raise self._error(argument.here, "a material's number has no key, expected E=, NU= or RHO=")
            if argument.key in given:
                raise self._error(argument.here, f"{argument.key} stands twice, expected it once")
            given[argument.key] = self._number(argument.value)
            check_material({argument.key: given[argument.key]}, self._place(argument.here))
        lacks = missing_of_material(given)
        if given and lacks:
            raise self._error(statement.here, f"the material {name!r} lacks {lacks}, expected E, NU and RHO")
        self.materials[name] = given
        self.material_places[name] = statement.here

    def _run_definition(self, statement: syntax.Statement) -> None:
        name, key = statement.name, statement.name.upper()
        if key in _RESERVED:
            raise self._error(statement.here, f"{name!r} is a word of the language, expected another name")
        if key in self.values:
            raise self._error(
                statement.here,
                f"the name {name!r} is already given on line {self.defined_on[key]}, expected another name",
            )
        value = self._evaluate(statement.value)
        if isinstance(value, PadlSolid):
            value = self.last = replace(value, name=name, place=self._place(statement.here))
        self.values[key] = value
        self.defined_on[key] = statement.here.line

    def _run_out(self, statement: syntax.Statement) -> None:
        if self.out is not None:
            raise self._error(statement.here, "OUT stands twice, expected it once")
        value = self._evaluate(syntax.Name(statement.here, statement.name))
        if not isinstance(value, PadlSolid):
            raise self._error(statement.here, f"OUT names the number {statement.name!r}, expected a solid")
        self.out = value

    def _evaluate(self, expression: syntax.Expression) -> Value:
        match expression:
            case syntax.Number():
                if not math.isfinite(expression.value):
                    raise self._error(expression.here, "the number is too large, expected one under 1.8e308")
                return expression.value
            case syntax.Name():
                return self._named(expression)
            case syntax.Call():
                return self._primitive(expression) if expression.name.upper() in SHAPES else self._function(expression)
            case syntax.Signed():
                return -self._number(expression.operand)
            case syntax.Placed():
                return self._placed(expression)
            case _:
                return self._chain(expression)

    def _named(self, use: syntax.Name) -> Value:
        key = use.name.upper()
        if key in CONSTANTS:
            return CONSTANTS[key]
        if key in self.values:
            return self.values[key]
        if key in SHAPES:
            raise self._error(use.here, f"{key} stands alone, expected {key}({', '.join(SHAPES[key].keys)})")
        known = list(self.values)
        raise self._error(
            use.here, f"unknown name {use.name!r}, expected one that is given before its use{did_you_mean(key, known)}"
        )

    def _number(self, expression: syntax.Expression) -> float:
        value = self._evaluate(expression)
        if isinstance(value, PadlSolid):
            raise self._error(expression.here, "found a solid, expected a number")
        return value

    def _solid(self, expression: syntax.Expression) -> PadlSolid:
        value = self._evaluate(expression)
        if not isinstance(value, PadlSolid):
            raise self._error(expression.here, f"found the number {value:g}, expected a solid")
        return value

    def _chain(self, chain: syntax.Chain) -> Value:
        words = [word for word, _ in chain.operators]
        if words[0] in _OPERATIONS:
            for word, here in chain.operators:
                if word != words[0]:
                    raise self._error(
                        here, f"{words[0]} and {word} are mixed, expected parentheses that say which comes first"
                    )
            return self._bounded(
                boolean(
                    _OPERATIONS[words[0]], tuple(map(self._solid, chain.operands)), self._place(chain.operators[0][1])
                )
            )
        numbers = [self._number(operand) for operand in chain.operands]
        steps = list(zip(chain.operators, numbers[1:]))
        if words[0] == "**":  # from the right
            result = numbers[-1]
            for (word, here), left in zip(reversed(chain.operators), reversed(numbers[:-1])):
                result = self._arithmetic(here, left, word, result)
            return result
        result = numbers[0]
        for (word, here), right in steps:
            result = self._arithmetic(here, result, word, right)
        return result

    def _arithmetic(self, here: syntax.Here, left: float, word: str, right: float) -> float:
        try:
            return combine(left, word, right)
        except ArithmeticError as error:
            raise self._error(here, str(error)) from None

    def _function(self, call: syntax.Call) -> float:
        name = call.name.upper()
        if name not in FUNCTIONS:
            raise self._error(
                call.here,
                f"unknown primitive {call.name!r}, expected {either(list(SHAPES))}"
                f"{did_you_mean(name, [*SHAPES, *FUNCTIONS])}",
            )
        if len(call.arguments) != 1 or call.arguments[0].key is not None:
            raise self._error(call.here, f"{name} has {len(call.arguments)} arguments, expected one number")
        try:
            return FUNCTIONS[name](self._number(call.arguments[0].value))
        except ArithmeticError as error:
            raise self._error(call.here, str(error)) from None

    def _primitive(self, call: syntax.Call) -> PadlSolid:
        name = call.name.upper()
        shape = SHAPES[name]
        values: dict[str, float] = {}
        places: dict[str, syntax.Here] = {}
        for position, argument in enumerate(call.arguments):
            key = argument.key
            if key is None:
                if position >= len(shape.keys):
                    raise self._error(
                        argument.here, f"{name} has more numbers than it takes, expected {', '.join(shape.keys)}"
                    )
                key = shape.keys[position]
            elif key not in shape.keys:
                raise self._error(
                    argument.here,
                    f"{name} has no parameter {key!r}, expected {either(list(shape.keys))}"
                    f"{did_you_mean(key, shape.keys)}",
                )
            if key in values:
                raise self._error(argument.here, f"{name} has its parameter {key!r} twice, expected it once")
            value = self._number(argument.value)
            may_be_zero = key in shape.may_be_zero
            expected = wrong_number(value, positive=not (may_be_zero and value == 0))
            if expected:
                expected = "a number of 0 or more" if may_be_zero and value < 0 else expected
                raise self._error(argument.here, f"{name}'s {key} is {value:g}, expected {expected}")
            values[key], places[key] = value, argument.here
        missing = [key for key in shape.keys if key not in values]
        if missing:
            raise self._error(call.here, f"{name} lacks {', '.join(missing)}, expected {', '.join(shape.keys)}")
        if name == "CON" and values["R1"] == values["R2"] == 0:
            raise self._error(places["R1"], "CON's R1 and R2 are both 0, expected one of them over 0")
        if name == "TOR" and values["RMIN"] >= values["RMAJ"]:
            raise self._error(
                places["RMIN"], f"TOR's RMIN is {values['RMIN']:g}, expected less than RMAJ ({values['RMAJ']:g})"
            )
        where = self._place(call.here)
        return PadlSolid(shape.make(values, where), where, IDENTITY)

    def _placed(self, placed: syntax.Placed) -> PadlSolid:
        value = self._evaluate(placed.operand)
        if not isinstance(value, PadlSolid):
            raise self._error(placed.here, f"AT follows the number {value:g}, expected a solid before it")
        for move in placed.moves:
            if move.key is None or move.key not in MOVES:
                found = "a number without a key" if move.key is None else repr(move.key)
                raise self._error(
                    move.here,
                    f"AT has {found}, expected {either([f'{key}=' for key in MOVES])}"
                    f"{did_you_mean(move.key or '', MOVES)}",
                )
            amount = self._number(move.value)
            expected = wrong_number(amount)
            if expected:
                raise self._error(move.here, f"{move.key} is {amount:g}, expected {expected}")
            value = value.moved(MOVES[move.key](amount))
        return value

    def _bounded(self, solid: PadlSolid) -> PadlSolid:
        if solid.n_node > MAX_NODES:
            raise ReadError(f"too many nodes in the tree, expected at most {MAX_NODES}", place=solid.place)
        if solid.depth > MAX_TREE_DEPTH:
            raise ReadError(
                f"Booleans nested too deeply, expected at most {MAX_TREE_DEPTH} inside each other", place=solid.place
            )
        return solid

    def _place(self, here: syntax.Here) -> Place:
        return Place(self.source, here.line, here.column)

    def _error(self, here: syntax.Here, message: str) -> ReadError:
        return ReadError(message, place=self._place(here))
