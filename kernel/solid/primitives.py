"""Each primitive of the CSG tree as a tracked manifold, its faces on canonical surfaces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
from manifold3d import Manifold

from kernel.csg.tree import Block, Cone, Cylinder, Extrusion, Polyhedron, Primitive, Revolution, Sphere, Torus, Wedge
from kernel.solid.round import build_cone, build_cylinder, build_revolution, build_sphere, build_torus
from kernel.solid.setting import FLAT, Setting
from kernel.solid.square import build_block, build_extrusion, build_polyhedron, build_wedge
from kernel.solid.tracked import NotSolidError


def check_numbers(primitive: Primitive) -> None:
    """NotSolidError where a size or the placement is not finite, or the placement flattens the primitive."""
    if not np.isfinite(primitive.placement).all():
        raise NotSolidError("its placement is not finite")
    linear = primitive.placement[:3, :3]
    if abs(float(np.linalg.det(linear))) <= FLAT * float(np.prod(np.linalg.norm(linear, axis=0))):
        raise NotSolidError("its placement flattens it")
    for item in fields(primitive):
        value = getattr(primitive, item.name)
        numbers = value if isinstance(value, tuple) else (value,)
        for number in numbers:
            if isinstance(number, float | int | np.ndarray) and not np.isfinite(number).all():
                raise NotSolidError(f"its {item.name.replace('_', ' ')} is {value}, expected finite numbers")


def build(primitive: Primitive, setting: Setting) -> Manifold:
    """The primitive as a tracked manifold. NotSolidError: it has no volume, or its faces do not close."""
    builder = _BUILDERS.get(type(primitive))
    if builder is None:
        raise NotSolidError(f"a {primitive.kind} cannot be built from a placement alone")
    return builder(primitive, setting)


_BUILDERS: dict[type, Callable[..., Manifold]] = {
    Block: build_block,
    Wedge: build_wedge,
    Extrusion: build_extrusion,
    Polyhedron: build_polyhedron,
    Cylinder: build_cylinder,
    Cone: build_cone,
    Revolution: build_revolution,
    Sphere: build_sphere,
    Torus: build_torus,
}
