"""Bodies that touch while their meshes lie half a thickness apart: the ties that meshing both together would make.

    lap          o---o---o---o      nodes of a shell, or of a solid, over another's faces follow these, arm included
               x-----x-----x-----x
    end of a beam, edge of a shell against a solid    a node moves as the average of the faces that its section covers
    beam along a face                                 its nodes follow the faces, arm included
    rim beside a rim, beam on a beam's side           a node follows the edge, or the element, beside it, arm included

Distances follow from the properties: half a shell's thickness, a beam's section, nothing for solids. Segments that
have common nodes or are coupled already are left alone; of two solids those nodes that have no partner are tied.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.lines import AXIS, Line, line_of
from kernel.connect.model import Property
from kernel.connect.skins import Foot, Skin
from kernel.mesh.assembly import Tie
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.patches import SurfaceFaces, faces_on, node_areas
from kernel.solid.boxes import BoxIndex
from kernel.solid.charts import flatten
from kernel.solid.surfaces import Plane, plane_frame

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PARALLEL = np.cos(np.radians(30.0))
"""Faces that lap lean on each other by less: a round one's chords by half of what an element turns."""

LEANING = np.sin(np.radians(20.0))
"""A beam whose axis rises from a face by more ends on it; by less it lies along it."""

ENTERING = 1e-3
"""So far, in radii of the circle about a beam's section, a shell's edge is carried on to see whether it enters it."""

FEWEST = 3
"""Nodes of a solid that hold it on a face; a shell's turn too, and two do."""


def facing_ties(
    mesh: Mesh,
    properties: Sequence[Property],
    reach: float,
    segments: Collection[str],
    bound: Collection[int],
    coupled: Collection[frozenset[str]],
) -> tuple[Tie, ...]:
    """Ties of the segments named, where they touch within `reach`. properties: of all segments.

    bound: nodes that depend on something already. coupled: pairs of segments that are connected already.
    """
    finder = _Finder(mesh, properties, reach, segments, set(bound))
    return tuple(finder.ties(coupled))


class _Finder:
    """The segments' skins and lines, and which nodes are dependent by now."""

    def __init__(
        self, mesh: Mesh, properties: Sequence[Property], reach: float, segments: Collection[str], bound: set[int]
    ) -> None:
        self.points = mesh.nodes
        self.reach = reach
        self.bound = bound
        blocks: dict[str, list[ElementBlock]] = {}
        for block in mesh.blocks:
            if len(block.connectivity) and block.segment in segments:
                blocks.setdefault(block.segment, []).append(block)
        self.skins: dict[str, Skin] = {}
        self.lines: dict[str, Line] = {}
        for element in properties:
            own = blocks.get(element.segment)
            if own is None:
                continue
            if element.section is not None and element.kind == "beam":
                self.lines[element.segment] = line_of(element.segment, own, element.section, mesh.nodes)
            elif element.kind != "beam":
                self.skins[element.segment] = Skin.of(element.segment, own, element.thickness, mesh.nodes)

    def ties(self, coupled: Collection[frozenset[str]]) -> Iterator[Tie]:
        """Skins on skins, then beams on skins, then beams on beams, each in the order of the properties."""
        pairs = [pair for pair in self._near_pairs() if frozenset(part.segment for part in pair) not in coupled]
        for first, second in pairs:
            if isinstance(first, Skin) and isinstance(second, Skin):
                yield from self._noted(self._skins(first, second))
        hosts: dict[str, list[Skin]] = {}
        for skin, beam in pairs:
            if isinstance(beam, Line) and isinstance(skin, Skin) and not self._share(beam, skin):
                hosts.setdefault(beam.segment, []).append(skin)
        for name, skins in hosts.items():
            yield from self._noted(self._ends(self.lines[name], skins))
            for skin in skins:
                line = self.lines[name]
                ties = self._along(line, skin)
                if not ties and not skin.is_solid:
                    ties = self._rim_on_side(skin, line)
                yield from self._noted(ties)
        for one, other in pairs:
            if isinstance(one, Line) and isinstance(other, Line) and not self._share(one, other):
                yield from self._noted(self._on_side(one, other) or self._on_side(other, one))

    def _near_pairs(self) -> list[tuple[Skin | Line, Skin | Line]]:
        """Segments whose bodies' boxes meet, skins before lines."""
        parts: list[Skin | Line] = [*self.skins.values(), *self.lines.values()]
        if not parts:
            return []
        around = np.array([part.reach + self.reach for part in parts])[:, None]
        boxes = np.array([(part.box[0], part.box[1]) for part in parts])
        boxes = np.stack([boxes[:, 0] - around, boxes[:, 1] + around], axis=1)
        return [(parts[one], parts[other]) for one, other in BoxIndex(boxes).pairs(boxes) if one < other]

    @staticmethod
    def _share(one: Skin | Line, other: Skin | Line) -> bool:
        return bool(np.intersect1d(one.nodes, other.nodes).size)

    def _skins(self, first: Skin, second: Skin) -> Sequence[Tie]:
        if first.is_solid and second.is_solid:
            return self._solids(first, second)
        if self._share(first, second):
            return []
        if first.is_solid or second.is_solid:
            solid, shell = (first, second) if first.is_solid else (second, first)
            return self._over(solid, shell) or self._edge(shell, solid)
        by_area = sorted((first, second), key=lambda skin: skin.area)
        return self._shells(*by_area) or self._shells(*by_area[::-1])

    def _noted(self, ties: Sequence[Tie]) -> Sequence[Tie]:
        for tie in ties:
            self.bound.update(tie.dependent.tolist())
        return ties

    def _standing(self, follower: Skin, host: Skin) -> tuple[list[int], list[Foot]]:
        """Nodes of the follower whose faces lie on the host's, and their feet there."""
        away = follower.half + host.half
        nodes, feet = [], []
        for node in host.those_near(np.setdiff1d(follower.nodes, host.nodes), self.points, away + self.reach):
            if node in self.bound:
                continue

            def is_against(normal: Array, node: int = node) -> bool:
                return follower.looks(node, -normal, PARALLEL)

            foot = host.foot(self.points[node], self.reach, away, is_against)
            if foot is not None:
                nodes.append(node)
                feet.append(foot)
        return nodes, feet

    def _over(self, follower: Skin, host: Skin) -> list[Tie]:
        nodes, feet = self._standing(follower, host)
        if len(nodes) < (FEWEST if follower.is_solid else 2):
            return []
        return [_interpolated(nodes, feet, has_rotations=not follower.is_solid)]

    def _shells(self, follower: Skin, host: Skin) -> list[Tie]:
        return self._over(follower, host) or self._step(follower, host)

    def _step(self, follower: Skin, host: Skin) -> list[Tie]:
        """Nodes of a rim beside another's, where shells of unlike thickness butt: nearer to it than laps are."""
        outs: dict[frozenset[int], list[Array]] = {}
        for edge in host.rim():
            for key in ((edge.start, edge.end), (edge.start,), (edge.end,)):
                outs.setdefault(frozenset(key), []).append(edge.out)
        feet: dict[int, Foot] = {}
        most = follower.half + host.half - self.reach
        for edge, node in ((side, end) for side in follower.rim() for end in (side.start, side.end)):
            if node in self.bound or node in feet:
                continue

            def is_against(normal: Array, node: int = node) -> bool:
                return follower.looks(node, -normal, PARALLEL)

            foot = host.foot(self.points[node], self.reach, 2 * self.reach, is_against, up_to=most)
            if foot is None:
                continue
            beside = outs.get(frozenset(foot.nodes[foot.weights > 0].tolist()), [])
            if any(float(out @ edge.out) < -PARALLEL for out in beside):
                feet[node] = foot
        nodes = sorted(feet)
        return [_interpolated(nodes, [feet[n] for n in nodes], has_rotations=True)] if len(nodes) > 1 else []

    def _solids(self, first: Skin, second: Skin) -> list[Tie]:
        """Of two solids that with more nodes between the other's follows."""
        ahead, back = self._standing(first, second), self._standing(second, first)
        nodes, feet = ahead if len(ahead[0]) > len(back[0]) else back
        shared = np.intersect1d(first.nodes, second.nodes).size
        if not nodes or len(nodes) + shared < FEWEST:
            return []
        return [_interpolated(nodes, feet, has_rotations=False)]

    # ------------------------------------------------------------ averages

    def _edge(self, shell: Skin, solid: Skin) -> list[Tie]:
        """Each node of a shell's rim that stands on a solid follows the strip of its thickness about it."""
        feet: dict[int, Foot] = {}
        strips: dict[int, list[Array]] = {}
        low, high = solid.box[0] - self.reach - solid.bulge, solid.box[1] + self.reach + solid.bulge
        for edge in shell.rim():
            pair = (edge.start, edge.end)
            ends = self.points[[*pair]]
            if not self.bound.isdisjoint(pair) or (ends < low).any() or (ends > high).any():
                continue

            def is_ahead(face: Array, out: Array = edge.out) -> bool:
                return float(face @ out) < -LEANING

            standing = [foot for end in ends if (foot := solid.foot(end, self.reach, 0.0, is_ahead)) is not None]
            middle, arm = ends.mean(axis=0), shell.half * edge.normal
            if len(standing) < 2 or solid.foot(middle, self.reach + _rise(ends, standing), 0.0, is_ahead) is None:
                continue
            for node, at, foot in zip(pair, ends, standing):
                feet.setdefault(node, foot)
                strips.setdefault(node, []).append(np.array([at - arm, middle - arm, middle + arm, at + arm]))
        ties = []
        for node, quads in sorted(strips.items()):
            tie = self._average(node, feet[node], solid, quads)
            if tie is not None:
                ties.append(tie)
        return ties

    def _ends(self, line: Line, hosts: Sequence[Skin]) -> list[Tie]:
        """Each end of a beam follows what its section covers of the face on which it stands."""
        ties = []
        for end, out in line.ends.items():
            if end in self.bound:
                continue
            _, y, z = line.axes[end]
            rings = [self.points[end] + ring @ np.array([y, z]) for ring in line.outline]
            for host in hosts:

                def is_ahead(normal: Array, out: Array = out) -> bool:
                    return float(normal @ out) < -LEANING

                foot = host.foot(self.points[end], self.reach, host.half, is_ahead)
                if foot is None:
                    continue
                tie = self._average(end, foot, host, rings, along=out)
                if tie is not None:
                    ties.append(tie)
                    break
        return ties

    def _average(
        self, node: int, foot: Foot, host: Skin, rings: Sequence[Array], along: Array | None = None
    ) -> Tie | None:
        """A node on the faces that rings (n, 3) cover: together, or seen `along` a direction the first but the others.

        None where they cover nothing.
        """
        base = self.points[node] - foot.height * foot.normal
        frame = plane_frame(foot.normal)
        plane = Plane(frame.normal, float(base @ frame.normal), frame.u, frame.v)
        way = foot.normal if along is None else along
        seen = [ring - np.outer((ring - base) @ foot.normal / float(way @ foot.normal), way) for ring in rings]
        outlines = [shapely.Polygon(flatten(plane, ring)) for ring in seen]
        patch = shapely.union_all(outlines)
        if along is not None:
            patch = shapely.difference(outlines[0], shapely.union_all(outlines[1:]))
        radius = max(float(np.linalg.norm(ring - base, axis=1).max()) for ring in seen)
        nodes, areas = node_areas(self._faces_about(plane, base, radius, host), patch)
        return Tie("beam_on_face", None, np.array([node]), nodes, areas) if len(nodes) else None

    def _faces_about(self, plane: Plane, base: Array, radius: float, host: Skin) -> SurfaceFaces:
        groups = []
        for part in host.faces:
            near = ((part.low <= base + radius) & (part.high >= base - radius)).all(axis=1)
            turn = part.middle_normals @ plane.normal
            groups.append(part.corners[near & ((turn if host.is_solid else np.abs(turn)) > PARALLEL)])
        return faces_on(plane, groups, self.points, self.reach + (radius if host.bulge > 0 else 0.0))

    # ------------------------------------------------------------ beams along faces

    def _along(self, line: Line, host: Skin) -> list[Tie]:
        """Nodes of a beam whose section touches the face beside it."""
        nodes: list[int] = []
        feet: list[Foot] = []
        for node in line.nodes.tolist():
            if node in self.bound:
                continue
            x, y, z = line.axes[node]

            def is_beside(normal: Array, x: Array = x) -> bool:
                return abs(float(normal @ x)) < LEANING

            foot = host.foot(self.points[node], self.reach, host.half, is_beside, up_to=host.half + line.radius)
            if foot is None:
                continue
            down = -foot.normal if foot.height > 0 else foot.normal
            depth = float((line.outline[0] @ np.array([y @ down, z @ down])).max())
            if abs(abs(foot.height) - host.half - depth) <= self.reach + host.bulge:
                nodes.append(node)
                feet.append(foot)
        return [_interpolated(nodes, feet, has_rotations=True)] if len(nodes) > 1 else []

    def _on_side(self, line: Line, host: Line) -> list[Tie]:
        """The ends of a beam that stand on another's side, and its nodes where both run side by side."""
        ties = []
        for node in line.nodes.tolist():
            if node in self.bound:
                continue
            found = host.foot(self.points, self.points[node])
            if found is None:
                continue
            pair, share, axes = found
            place = (self.points[node] - (1 - share) * self.points[pair[0]] - share * self.points[pair[1]]) @ axes[1:].T
            leaning = abs(float(line.axes[node][0] @ axes[0]))
            slack = self.reach + AXIS * host.radius
            if leaning > PARALLEL:
                side = line.polygon_in(node, axes, place)
                is_on = (
                    side.distance(host.polygon) <= slack and side.intersection(host.polygon).area <= slack * host.radius
                )
            else:
                is_on = node in line.ends and host.polygon.distance(shapely.Point(place)) <= slack
            if is_on:
                ties.append(_on_line(node, pair, share))
        return ties

    def _rim_on_side(self, skin: Skin, host: Line) -> list[Tie]:
        """Nodes of a shell's rim that stand on the side of a beam."""
        ties: dict[int, Tie] = {}
        for edge, node in ((side, end) for side in skin.rim() for end in (side.start, side.end)):
            found = None if node in self.bound or node in ties else host.foot(self.points, self.points[node])
            if found is None:
                continue
            pair, share, axes = found
            arm = self.points[node] - (1 - share) * self.points[pair[0]] - share * self.points[pair[1]]
            along = self.points[edge.start] + self.points[edge.end] - 2 * self.points[node]
            if self._enters(host, axes[1:] @ arm, axes[1:] @ along, axes[1:] @ edge.out):
                ties[node] = _on_line(node, pair, share)
        return [tie for _, tie in sorted(ties.items())] if len(ties) > 1 else []

    def _enters(self, host: Line, at: Array, along: Array, out: Array) -> bool:
        """Whether a place (2,) is on a section's boundary, and the edge from there `along` leads `out` (2,) into it."""
        slack = self.reach + AXIS * host.radius
        step = max(ENTERING * host.radius, 10 * slack)
        aside = along * (step / max(float(np.linalg.norm(along)), step))
        ahead = shapely.Point(at + aside + step * out)
        boundary = host.polygon.boundary
        is_in = host.polygon.contains(ahead) and boundary.distance(ahead) > LEANING * step - slack
        return bool(is_in and boundary.distance(shapely.Point(at)) <= slack)


def _rise(ends: Array, feet: Sequence[Foot]) -> float:
    """How far an arc rises above its chord (2, 3), by how much a round skin turns from the one foot to the other."""
    turn = float(np.linalg.norm(feet[1].normal - feet[0].normal))
    return float(np.linalg.norm(ends[1] - ends[0])) * turn / 8


def _on_line(node: int, pair: tuple[int, int], share: float) -> Tie:
    """A node that follows the place `share` of the way along an element, or one of its nodes."""
    weights = np.array([1 - share, share])
    heavy = weights > AXIS
    nodes = np.array(pair, dtype=np.int64)[heavy]
    if len(nodes) == 1:
        return Tie("rigid", None, np.array([node]), nodes)
    return Tie("interpolated", None, np.array([node]), hosts=(nodes,), host_weights=(weights,))


def _interpolated(nodes: Sequence[int], feet: Sequence[Foot], has_rotations: bool) -> Tie:
    hosts, weights = tuple(foot.nodes for foot in feet), tuple(foot.weights for foot in feet)
    return Tie(
        "interpolated",
        None,
        np.array(nodes, dtype=np.int64),
        hosts=hosts,
        host_weights=weights,
        has_rotations=has_rotations,
    )
