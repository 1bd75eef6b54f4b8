"""A small orthographic renderer: triangles and lines through a depth buffer, to a PNG.

    eye looks along -w          screen x = p . u        u, v, w right-handed, w towards the eye
        v                       screen y = -p . v
        |                       depth    = p . w        larger is nearer
        +-- u

Everything is drawn `SUPERSAMPLING` times too large and averaged down: that is the anti-aliasing.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

SUPERSAMPLING = 2
LINE_LIFT = 2e-3
"""Lines are drawn this share of the scene's size nearer, so that the face they lie on does not hide them."""

AMBIENT, DIFFUSE = 0.55, 0.45
BACKGROUND = (255, 255, 255)
ISOMETRIC = (1.0, -1.55, 0.95)
"""Direction from the model to the eye: right, front, above. Not the true isometric: cubes would hide an edge."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """triangles: (n, 3, 3) model units, colours: (n, 3) uint8; lines: (m, 2, 3), line_colours: (m, 3) uint8.

    marks: (k, 2, 3) lines that nothing hides, mark_colours: (k, 3) uint8.
    """

    triangles: NDArray[np.float64]
    colours: NDArray[np.uint8]
    lines: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2, 3)))
    line_colours: NDArray[np.uint8] = field(default_factory=lambda: np.empty((0, 3), np.uint8))
    marks: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2, 3)))
    mark_colours: NDArray[np.uint8] = field(default_factory=lambda: np.empty((0, 3), np.uint8))


def render(
    scene: Scene,
    width: int = 900,
    height: int = 640,
    eye: tuple[float, float, float] = ISOMETRIC,
    line_width: float = 1.0,
) -> NDArray[np.uint8]:
    """The scene filling a picture: (height, width, 3) uint8. line_width in pixels."""
    u, v, w = _camera(eye)
    basis = np.column_stack([u, -v, w])
    triangles, lines, marks = scene.triangles @ basis, scene.lines @ basis, scene.marks @ basis
    points = np.concatenate([triangles.reshape(-1, 3), lines.reshape(-1, 3), marks.reshape(-1, 3)])
    wide, high = width * SUPERSAMPLING, height * SUPERSAMPLING
    image = np.empty((high, wide, 3))
    image[:] = BACKGROUND
    if len(points):
        low, top = points.min(axis=0), points.max(axis=0)
        extent = np.maximum(top - low, 1e-12 * max(float(np.abs(points).max()), 1e-300))
        scale = 0.92 * min(wide / extent[0], high / extent[1])
        shift = np.array([wide / 2, high / 2, 0.0]) - scale * np.append((low + top)[:2] / 2, low[2])
        lit = _shade(scene.triangles, scene.colours, u, v, w)
        depth = np.full((high, wide), -np.inf)
        fill_triangles(np.ascontiguousarray(triangles * scale + shift), lit, image, depth)
        lift = LINE_LIFT * scale * float(np.linalg.norm(extent))
        for drawn, colours, nearer in ((lines, scene.line_colours, lift), (marks, scene.mark_colours, np.inf)):
            ends = np.ascontiguousarray(drawn * scale + shift)
            draw_lines(ends, colours.astype(np.float64), line_width * SUPERSAMPLING, nearer, image, depth)
    small = image.reshape(height, SUPERSAMPLING, width, SUPERSAMPLING, 3).mean(axis=(1, 3))
    return np.clip(np.rint(small), 0, 255).astype(np.uint8)


def png(image: NDArray[np.uint8]) -> bytes:
    """A (height, width, 3) uint8 picture as a PNG file (ISO/IEC 15948): truecolour, filter "up" on every row."""
    height, width, _ = image.shape
    flat = image.reshape(height, width * 3)
    rows = np.empty((height, 1 + width * 3), np.uint8)
    rows[:, 0] = 2
    rows[0, 1:] = flat[0]
    rows[1:, 1:] = flat[1:] - flat[:-1]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 9)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _camera(eye: tuple[float, float, float]) -> tuple[NDArray, NDArray, NDArray]:
    w = np.asarray(eye, float) / np.linalg.norm(eye)
    up = np.array([0.0, 0.0, 1.0]) if abs(w[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    u = np.cross(up, w)
    u /= np.linalg.norm(u)
    return u, np.cross(w, u), w


def _shade(triangles: NDArray, colours: NDArray, u: NDArray, v: NDArray, w: NDArray) -> NDArray[np.float64]:
    """Lambert's law by flat normals turned to the eye; the light stands above the eye's left shoulder."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    normals *= np.where(normals @ w < 0, -1.0, 1.0)[:, None]
    light = 0.75 * w + 0.6 * v - 0.3 * u
    light /= np.linalg.norm(light)
    strength = AMBIENT + DIFFUSE * np.maximum(normals @ light, 0.0)
    return colours * strength[:, None]


@njit(cache=True)
def fill_triangles(triangles, colours, image, depth):  # type: ignore[no-untyped-def]
    """Fill (n, 3, 3) triangles (pixels, depth) with (n, 3) colours where they are nearer than `depth`; in place."""
    height, width = depth.shape
    for t in range(len(triangles)):
        ax, ay, az = triangles[t, 0]
        bx, by, bz = triangles[t, 1]
        cx, cy, cz = triangles[t, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        x0 = max(int(np.floor(min(ax, bx, cx) - 0.5)), 0)
        x1 = min(int(np.ceil(max(ax, bx, cx) - 0.5)), width - 1)
        y0 = max(int(np.floor(min(ay, by, cy) - 0.5)), 0)
        y1 = min(int(np.ceil(max(ay, by, cy) - 0.5)), height - 1)
        for y in range(y0, y1 + 1):
            py = y + 0.5
            for x in range(x0, x1 + 1):
                px = x + 0.5
                # barycentric weights: the share of the triangle on the far side of each corner's opposite edge
                wa = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area
                wb = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area
                wc = 1.0 - wa - wb
                if wa < 0.0 or wb < 0.0 or wc < 0.0:
                    continue
                z = wa * az + wb * bz + wc * cz
                if z > depth[y, x]:
                    depth[y, x] = z
                    image[y, x, 0] = colours[t, 0]
                    image[y, x, 1] = colours[t, 1]
                    image[y, x, 2] = colours[t, 2]


@njit(cache=True)
def draw_lines(lines, colours, line_width, lift, image, depth):  # type: ignore[no-untyped-def]
    """Draw (m, 2, 3) lines (pixels, depth), `lift` nearer than they are, where nothing nearer hides them; in place."""
    height, width = depth.shape
    reach = line_width / 2.0
    for k in range(len(lines)):
        ax, ay, az = lines[k, 0]
        bx, by, bz = lines[k, 1]
        dx, dy = bx - ax, by - ay
        length_squared = dx * dx + dy * dy
        steep = abs(dy) > abs(dx)
        # walk along the longer direction, and at each step across it only as far as the line is wide there
        along = max(abs(dx), abs(dy))
        across = reach if along == 0.0 else reach * np.sqrt(length_squared) / along
        first = min(ay, by) if steep else min(ax, bx)
        last = max(ay, by) if steep else max(ax, bx)
        for major in range(int(np.floor(first - reach)), int(np.ceil(last + reach)) + 1):
            if along == 0.0:
                middle = ax if steep else ay
            else:
                s = (major + 0.5 - ay) / dy if steep else (major + 0.5 - ax) / dx
                s = min(max(s, 0.0), 1.0)
                middle = ax + s * dx if steep else ay + s * dy
            for minor in range(int(np.floor(middle - across - 1.0)), int(np.ceil(middle + across + 1.0)) + 1):
                x = minor if steep else major
                y = major if steep else minor
                if x < 0 or y < 0 or x >= width or y >= height:
                    continue
                px, py = x + 0.5, y + 0.5
                share = 0.0
                if length_squared > 0.0:
                    share = min(max(((px - ax) * dx + (py - ay) * dy) / length_squared, 0.0), 1.0)
                qx, qy = ax + share * dx - px, ay + share * dy - py
                if qx * qx + qy * qy > reach * reach:
                    continue
                z = az + share * (bz - az) + lift
                if z >= depth[y, x]:
                    image[y, x, 0] = colours[k, 0]
                    image[y, x, 1] = colours[k, 1]
                    image[y, x, 2] = colours[k, 2]
