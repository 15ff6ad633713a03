#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes handle.glb and crate.png of this world: python3 make_assets.py"""

import json
import math
import struct
import zlib

BAR = (0.30, 0.04, 0.04)  # [m] along x, y, z
STEM_RADIUS, STEM_LENGTH = 0.02, 0.12  # [m]; down along -y from the bar's underside
STEM_SIDES = 32


def box(low, high):
    """Triangles of a box as (corner, corner, corner, normal), counter-clockwise from outside."""
    triangles = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            corners = []
            turn = ((0, 0), (1, 0), (1, 1), (0, 1)) if side else ((0, 0), (0, 1), (1, 1), (1, 0))
            for a, b in turn:
                corner = [0.0, 0.0, 0.0]
                corner[axis] = (low, high)[side][axis]
                corner[u] = (low, high)[a][u]
                corner[v] = (low, high)[b][v]
                corners.append(tuple(corner))
            normal = tuple((1.0 if side else -1.0) if i == axis else 0.0 for i in range(3))
            triangles += [
                (corners[0], corners[1], corners[2], [normal] * 3),
                (corners[0], corners[2], corners[3], [normal] * 3),
            ]
    return triangles


def cylinder(radius, top, bottom, sides):
    """A closed cylinder around y; its side is smooth."""

    def rim(i, y):
        angle = 2 * math.pi * (i % sides) / sides
        return (radius * math.sin(angle), y, radius * math.cos(angle))

    def out(i):
        angle = 2 * math.pi * (i % sides) / sides
        return (math.sin(angle), 0.0, math.cos(angle))

    triangles = []
    for i in range(sides):
        a, b, c, d = rim(i, bottom), rim(i + 1, bottom), rim(i + 1, top), rim(i, top)
        triangles += [
            (a, b, c, [out(i), out(i + 1), out(i + 1)]),
            (a, c, d, [out(i), out(i + 1), out(i)]),
            (d, c, (0.0, top, 0.0), [(0.0, 1.0, 0.0)] * 3),
            (b, a, (0.0, bottom, 0.0), [(0.0, -1.0, 0.0)] * 3),
        ]
    return triangles


def polygon_area(radius, sides):
    return sides / 2 * radius**2 * math.sin(2 * math.pi / sides)


def main():
    bar_volume = BAR[0] * BAR[1] * BAR[2]
    stem_volume = polygon_area(STEM_RADIUS, STEM_SIDES) * STEM_LENGTH
    stem_middle = -(BAR[1] + STEM_LENGTH) / 2
    # Of mass, from the bar's middle.
    centre = stem_volume * stem_middle / (bar_volume + stem_volume)
    half = [side / 2 for side in BAR]
    top = half[1] - centre
    bottom = -half[1] - centre
    bar = box((-half[0], bottom, -half[2]), (half[0], top, half[2]))
    stem = cylinder(STEM_RADIUS, bottom, bottom - STEM_LENGTH, STEM_SIDES)
    write_glb(
        "handle.glb",
        [("steel", [0.56, 0.57, 0.6], 0.35, bar), ("brass", [0.85, 0.55, 0.2], 0.25, stem)],
    )
    write_png("crate.png", 128, crate)


def write_glb(name, pieces):
    """One mesh with a primitive for each piece, all metal."""
    binary, views, accessors, primitives, materials = b"", [], [], [], []

    def accessor(values):
        nonlocal binary
        data = b"".join(struct.pack("<3f", *value) for value in values)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        bounds = {
            "min": [min(v[i] for v in values) for i in range(3)],
            "max": [max(v[i] for v in values) for i in range(3)],
        }
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": 5126,
                "count": len(values),
                "type": "VEC3",
                **bounds,
            }
        )
        binary += data
        return len(accessors) - 1

    for material, colour, roughness, triangles in pieces:
        materials.append(
            {
                "name": material,
                "pbrMetallicRoughness": {
                    "baseColorFactor": colour + [1],
                    "metallicFactor": 1,
                    "roughnessFactor": roughness,
                },
            }
        )
        positions = [single(corner) for triangle in triangles for corner in triangle[:3]]
        normals = [normal for triangle in triangles for normal in triangle[3]]
        primitives.append(
            {
                "attributes": {"POSITION": accessor(positions), "NORMAL": accessor(normals)},
                "material": len(materials) - 1,
            }
        )
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "handle"}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(name, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def single(point):
    """Rounded to single precision, which both neighbours of an edge then share."""
    return struct.unpack("<3f", struct.pack("<3f", *point))


def crate(x, y, size):
    """Boards of wood with a frame and a diagonal, as r, g, b."""
    border = size // 8
    framed = min(x, y, size - 1 - x, size - 1 - y) < border or abs(x - (size - 1 - y)) < border // 2
    grain = 10 * math.sin((y if framed else x) * 1.7 + 3 * math.sin((x if framed else y) / 19))
    gap = not framed and x % (size // 4) < 2
    base = 60 if gap else 150 if framed else 178
    return tuple(max(0, min(255, int((base + grain) * part))) for part in (1, 0.74, 0.45))


def write_png(name, size, colour):
    rows = b"".join(
        b"\0" + bytes(c for x in range(size) for c in colour(x, y, size)) for y in range(size)
    )

    def chunk(kind, data):
        check = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)

    header = struct.pack(">2I5B", size, size, 8, 2, 0, 0, 0)
    with open(name, "wb") as file:
        file.write(
            b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", header)
            + chunk(b"IDAT", zlib.compress(rows, 9))
            + chunk(b"IEND", b"")
        )


if __name__ == "__main__":
    main()
