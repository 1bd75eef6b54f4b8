"""Facts: what the kernel measured about one CSG node or piece, in words that a rule can use.

A fact that has not been measured (its tier was not asked for) is absent, never 0 or None: rules are three-valued.
The vocabulary is a table, printed by `csgmesh rules docs`; rules that use another name are refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

Value = float | int | bool | str

TIERS = ("intent", "extents", "prism", "walls", "members", "necks")
"""Cheap before dear: a node is asked tier by tier and stops where the rules conclude."""


@dataclass(frozen=True, slots=True)
class FactSpec:
    """One word of the vocabulary.

    dimension: "length", "area", "volume", "ratio", "count", "text" or "boolean". tier: one of TIERS.
    choices: the values that a text may take.
    """

    name: str
    tier: str
    dimension: str
    meaning: str
    choices: tuple[str, ...] = ()


KINDS = (
    "block", "cylinder", "cone", "wedge", "sphere", "torus", "extrusion", "revolution", "polyhedron", "hull",
    "union", "difference", "intersection", "piece",
)  # fmt: skip

VOCABULARY: tuple[FactSpec, ...] = (
    # intent: from the tree alone
    FactSpec(
        "kind",
        "intent",
        "text",
        "primitive or operation; `piece` where a solid has no tree of its own",
        KINDS,
    ),
    FactSpec(
        "role",
        "intent",
        "text",
        "what the node is to its parent",
        ("root", "operand", "remainder", "piece", "cluster"),
    ),
    FactSpec("is_named", "intent", "boolean", "the input gives the node a name"),
    FactSpec("depth", "intent", "count", "steps from the root"),
    FactSpec(
        "operand_count",
        "intent",
        "count",
        "solids the node splits into, those of unions among them too; differences and intersections reach into a union",
    ),
    FactSpec("tool_count", "intent", "count", "operands that a difference takes away"),
    FactSpec("leaf_count", "intent", "count", "primitives in the sub-tree"),
    FactSpec("diameter", "intent", "length", "of a cylinder, a sphere, or a cone at its wider end, as the tree says"),
    FactSpec(
        "is_through",
        "intent",
        "boolean",
        "of a tool: along an axis of its own it reaches right through what it is taken from",
    ),
    FactSpec("is_coaxial", "intent", "boolean", "of a tool: it and what it is taken from are round about one line"),
    FactSpec(
        "is_concentric",
        "intent",
        "boolean",
        "of a tool: its axis, or its middle where it has none, is at the middle of what it is taken from",
    ),
    # extents: cheap measures of the evaluated solid
    FactSpec("volume", "extents", "volume", "volume of the solid"),
    FactSpec("component_count", "extents", "count", "pieces that do not touch one another"),
    FactSpec("extent_long", "extents", "length", "longest side of the box along the solid's own axes"),
    FactSpec("extent_middle", "extents", "length", "middle side of that box"),
    FactSpec("extent_short", "extents", "length", "shortest side of that box"),
    FactSpec("fill", "extents", "ratio", "share of that box that the solid fills"),
    FactSpec("round_hole_count", "extents", "count", "round holes, a pipe's own bore among them"),
    FactSpec("through_hole_count", "extents", "count", "round holes that are open at both ends"),
    FactSpec("smallest_hole", "extents", "length", "diameter of the narrowest round hole"),
    FactSpec("largest_hole", "extents", "length", "diameter of the widest round hole"),
    # prism: is it swept, along what, with which section
    FactSpec("is_prismatic", "prism", "boolean", "every section along the best axis is the same, exactly"),
    FactSpec("prism_length", "prism", "length", "length along the best axis"),
    FactSpec("free_length", "prism", "length", "longest length along the best axis between contacts with others"),
    FactSpec("contact_count", "prism", "count", "neighbours that reach into the node's box along the best axis"),
    FactSpec("section_long", "prism", "length", "longer side of the median section's smallest rectangle"),
    FactSpec("section_short", "prism", "length", "shorter side of that rectangle"),
    FactSpec("section_area", "prism", "area", "area of the median section"),
    FactSpec("slenderness", "prism", "ratio", "prism_length / section_long"),
    FactSpec("flatness", "prism", "ratio", "section_long / section_short"),
    FactSpec("volume_deviation", "prism", "ratio", "|volume / (section_area x prism_length) - 1|"),
    FactSpec("sections_off", "prism", "count", "of nine sections, those that differ from the median by over 2 %"),
    FactSpec("worst_section_off", "prism", "ratio", "largest difference of a section from the median, of its area"),
    # walls: pairs of parallel planes and coaxial cylinders at wall distance
    FactSpec("wall_count", "walls", "count", "walls found by the thin-wall decomposition"),
    FactSpec("plane_wall_count", "walls", "count", "walls that are flat"),
    FactSpec("cylinder_wall_count", "walls", "count", "walls that are cylindrical"),
    FactSpec("wall_share", "walls", "ratio", "share of the volume that the walls enclose"),
    FactSpec("wall_thickness", "walls", "length", "thickness of the thickest wall"),
    FactSpec("thinnest_wall", "walls", "length", "thickness of the thinnest wall"),
    FactSpec("wall_slenderness", "walls", "ratio", "least width of a wall / its thickness, worst wall"),
    FactSpec(
        "outline_fill", "walls", "ratio", "share of its outer outline that a flat wall fills, holes out; emptiest wall"
    ),
    FactSpec(
        "strip_ratio",
        "walls",
        "ratio",
        "mean width of the strips between that wall's edges, 2 area / perimeter, / its thickness",
    ),
    FactSpec("radius_ratio", "walls", "ratio", "mean radius / thickness of the worst cylindrical wall"),
    FactSpec("hole_count", "walls", "count", "inner boundary loops of all walls"),
    # members: what the operands would be, each deciding for itself
    FactSpec("beam_share", "members", "ratio", "share of the volume that operands hold which are beams by themselves"),
    FactSpec("cut_beam_count", "members", "count", "those of them that other operands cut in pieces"),
    FactSpec("beam_fill", "members", "ratio", "share of their sections' boxes that these beams fill, mean by volume"),
    # necks: what cuts at concave edges would give
    FactSpec("neck_count", "necks", "count", "pieces after cuts at necks"),
    FactSpec("neck_share", "necks", "ratio", "share of the volume that is not brick after cuts at necks"),
)

SPECS: Mapping[str, FactSpec] = MappingProxyType({spec.name: spec for spec in VOCABULARY})


@dataclass(frozen=True, slots=True)
class RelatedSpec:
    """Things around a node that a rule may ask about, each with facts of its own: `some tool: [...]`."""

    name: str
    singular: str
    tier: str
    meaning: str


RELATED: Mapping[str, RelatedSpec] = MappingProxyType(
    {
        spec.name: spec
        for spec in (
            RelatedSpec("tools", "tool", "intent", "operands that a difference takes away from the node"),
            RelatedSpec("children", "child", "intent", "operands of a Boolean"),
            RelatedSpec("neighbours", "neighbour", "prism", "what the node touches"),
        )
    }
)


class Facts(Mapping[str, Value]):
    """The facts known about one node, frozen. `facts.tier` is the dearest tier measured so far.

    related: facts of the things around it, by the names of RELATED; a name that is absent has not been looked at.
    """

    __slots__ = ("_key", "_values", "related", "tier")

    def __init__(
        self, values: Mapping[str, Value], tier: str, related: Mapping[str, tuple[Facts, ...]] | None = None
    ) -> None:
        unknown = [name for name in values if name not in SPECS]
        unknown += [name for name in related or () if name not in RELATED]
        if unknown:
            raise KeyError(f"facts outside the vocabulary: {', '.join(unknown)}")
        self._values = MappingProxyType(dict(values))
        self.related: Mapping[str, tuple[Facts, ...]] = MappingProxyType(dict(related or {}))
        self.tier = tier
        self._key: tuple | None = None

    def __getitem__(self, name: str) -> Value:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    @property
    def key(self) -> tuple:
        """Equal for equal facts, whatever their order; hashable."""
        if self._key is None:
            self._key = self._make_key()
        return self._key

    def _make_key(self) -> tuple:
        related = (
            (name, tuple(sorted((item.key for item in items), key=repr))) for name, items in self.related.items()
        )
        return (self.tier, tuple(sorted(self._values.items())), tuple(sorted(related, key=lambda pair: pair[0])))

    def __reduce__(self) -> tuple:
        return Facts, (dict(self._values), self.tier, dict(self.related))

    def with_tier(
        self, tier: str, values: Mapping[str, Value], related: Mapping[str, tuple[Facts, ...]] | None = None
    ) -> Facts:
        """These facts and those of a dearer tier."""
        return Facts({**self._values, **values}, tier, {**self.related, **(related or {})})
