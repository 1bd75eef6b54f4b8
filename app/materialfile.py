"""A material of the user's own, from a small YAML or JSON file: {name: S355, E: 210000, NU: 0.3, RHO: 7.85e-9}.

Elastic modulus and density are in the model's unit set, as MATERIAL has them in the model's text.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from kernel.csg.limits import check_material
from kernel.errors import InputError, OptionError

if TYPE_CHECKING:
    from kernel.csg.tree import CsgModel

ENDINGS = (".yaml", ".yml", ".json")
MAX_BYTES = 10_000
EXPECTED = "expected {name: S355, E: 210000, NU: 0.3, RHO: 7.85e-9}"


def with_material(csg: CsgModel, option: str | None) -> tuple[CsgModel, str | None]:
    """The model knowing the material that `option` (a name, or a file) means, and that material's name.

    OptionError: the file cannot be read or describes no material.
    """
    name, materials = asked_material(option)
    return replace(csg, materials={**csg.materials, **materials}) if materials else csg, name


def asked_material(option: str | None) -> tuple[str | None, dict[str, dict[str, float]]]:
    """The name of the material that `option` (a name, or a file) means, and the file's values by that name."""
    if option is None or not option.lower().endswith(ENDINGS):
        return option, {}
    name, values = read_material(option)
    return name, {name: values}


def read_material(path: str) -> tuple[str, dict[str, float]]:
    """(name, {"E", "NU", "RHO"}) of the file at `path`."""
    import yaml

    try:
        with Path(path).open(encoding="utf-8") as stream:
            given = yaml.safe_load(stream.read(MAX_BYTES))
    except OSError as error:
        raise OptionError(f"{path}: cannot be read, {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise OptionError(f"{path}: no YAML, {EXPECTED}: {error}") from error
    if not isinstance(given, dict) or not isinstance(given.get("name", ""), str):
        raise OptionError(f"{path}: describes no material, {EXPECTED}")
    values = {str(key).upper(): value for key, value in given.items() if key != "name"}
    if set(values) != {"E", "NU", "RHO"}:
        raise OptionError(f"{path}: gives {', '.join(sorted(values)) or 'nothing'}, {EXPECTED}")
    try:
        # YAML 1.1 takes 7.85e-9 for a number and 7.85E-9 for a text
        numbers = {key: float(value) for key, value in values.items()}
        check_material(numbers, None)
    except (TypeError, ValueError) as error:
        raise OptionError(f"{path}: {error}, {EXPECTED}") from error
    except InputError as error:
        raise OptionError(f"{path}: {error}") from error
    return given.get("name") or Path(path).stem, numbers
