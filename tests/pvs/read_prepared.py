#!/usr/bin/env python3
"""An independent reader of what `antumbra prepare` adds to a .pvs file, written from section 6 of docs/format.md alone.

usage: read_prepared.py FILE
Prints the content of OCCL, OGRP, CTRE, OSET and MOSD, one item a line, after checking what the format promises of it.
"""
import struct
import sys

from read_pvs import read_number, read_sections

NONE, SAME = 0x7FFFFFFF, 0x80000000


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def one(self, form):
        return self.take(form)[0]

    def number(self):
        value, self.at = read_number(self.data, self.at)
        return value

    def signed(self):
        value = self.number()
        return -(value >> 1) - 1 if value & 1 else value >> 1

    def done(self):
        return self.at == len(self.data)


def running(r, count):
    """Numbers, each stored as its distance from the one before."""
    values, value = [], 0
    for _ in range(count):
        value += r.signed()
        values.append(value)
    return values


def read_wide(r, vertices, corners, polygons):
    places = [r.take("3f") for _ in range(vertices)]
    loops = [r.take("2I") for _ in range(corners)]
    made, first = [], 0
    for p in range(polygons):
        count, of_object, flags, solid = r.take("4I")
        assert 3 <= count <= 1024 and flags < 4 and (flags & 2 or solid == NONE), "polygon"
        made.append((loops[first:first + count], of_object, flags, solid))
        first += count
    assert first == corners, "corners"
    return places, made


def read_compact(r, vertices, corners, polygons):
    step = r.one("f")
    places, place = [], (0, 0, 0)
    for _ in range(vertices):
        if step:
            place = tuple(before + r.signed() for before in place)
            places.append(tuple(step * number for number in place))
        else:
            places.append(r.take("3f"))
    heads, of_object, of_solid = [], 0, 0
    for _ in range(polygons):
        head = r.number()
        count, flags = head >> 2, head & 3
        of_object += r.signed()
        if flags & 2:
            of_solid += r.signed()
        assert 3 <= count <= 1024, "polygon"
        heads.append((count, of_object, flags, of_solid if flags & 2 else NONE))
    assert sum(head[0] for head in heads) == corners, "corners"
    made, vertex = [], 0
    for index, (count, of_object, flags, solid) in enumerate(heads):
        loop = []
        for _ in range(count):
            vertex += r.signed()
            coded, neighbour = r.number(), NONE
            if coded:
                distance = coded - 1 >> 1
                neighbour = index + (-(distance >> 1) - 1 if distance & 1 else distance >> 1) | (SAME if coded - 1 & 1 else 0)
            loop.append((vertex, neighbour))
        made.append((loop, of_object, flags, solid))
    return places, made


def read_occluders(data):
    r = Reader(data)
    vertices, corners, polygons, solids, patches, members, restrictions, form = r.take("8I")
    assert form in (0, 1)
    places, made = (read_compact if form else read_wide)(r, vertices, corners, polygons)
    shells = [r.take("6f") for _ in range(solids)]
    groups = [(r.number(), r.number()) if form else r.take("2I") for _ in range(patches)]
    assert sum(count for _, count in groups) == members and all(own <= count for own, count in groups), "patches"
    if form:
        listed = running(r, members)
    else:
        listed = r.take(f"{members}I")
    viewers = {}
    for _ in range(restrictions):
        solid = r.one("I")
        assert solid < solids, "restriction"
        viewers[solid] = r.take("6f")
    assert r.done(), "OCCL"
    for index, (loop, _, _, solid) in enumerate(made):
        assert all(v < vertices for v, _ in loop) and (solid == NONE or solid < solids)
        for i, (vertex, neighbour) in enumerate(loop):
            if neighbour & NONE == NONE:
                continue
            other = [v for v, _ in made[neighbour & NONE][0]]
            edge = (vertex, loop[(i + 1) % len(loop)][0])
            edge = edge if neighbour & SAME else edge[::-1]
            assert any((other[k], other[(k + 1) % len(other)]) == edge for k in range(len(other))), f"neighbour of {index}"
    owned, first = [], 0
    for own, count in groups:
        owned += listed[first:first + own]
        first += count
    assert all(p < polygons for p in listed) and len(set(owned)) == len(owned), "a polygon is owned twice"
    print(f"occluders: {vertices} vertices, {polygons} polygons, {solids} solids, {patches} patches")
    for loop, of_object, flags, solid in made:
        print("polygon", of_object, flags, solid, *(v for v, _ in loop))
    for solid in sorted(viewers):
        print("restricted", solid)
    return made, groups, shells


def read_groups(data, polygons):
    r = Reader(data)
    groups = []
    for _ in range(r.one("I")):
        count = r.one("I")
        assert 1 <= count <= 8, "group"
        groups.append(r.take(f"{count}I"))
        assert all(p < len(polygons) for p in groups[-1]), "group"
        print("group", *groups[-1])
    assert r.done(), "OGRP"
    return groups


def read_trees(data):
    r = Reader(data)
    for name in ("objects", "patches too"):
        count = r.one("I")
        order = r.take(f"{count}I")
        assert len(set(order)) == count, "CTRE"
        if count:
            size = (2 * count - 1 + 31) // 32 * 4
            bits = r.take(f"{size}B")
            open_nodes, leaves, deepest, stack = 1, 0, 0, [0]
            for i in range(2 * count - 1):
                depth = stack.pop()
                deepest = max(deepest, depth)
                if bits[i // 8] >> i % 8 & 1:
                    stack += [depth + 1, depth + 1]
                else:
                    leaves += 1
            assert leaves == count and not stack and deepest <= 96, "shape"
        print(f"tree over {name}:", *order)
    assert r.done(), "CTRE"


def read_cells(r):
    """How many cells the tree has."""
    kind = r.one("B")
    if kind == 3:
        return 1
    assert kind < 3, "cells"
    r.one("f")
    return read_cells(r) + read_cells(r)


def read_changes(r, before):
    """Members of a cell and the bits of their directions, from those of the cell before."""
    changes = [r.one("B") for _ in range((len(before) + 3) // 4)]
    now = {}
    for i, name in enumerate(sorted(before)):
        change = changes[i // 4] >> 2 * (i % 4) & 3
        assert change < 3, "change"
        if change:
            now[name] = before[name] if change == 1 else r.one("H")
    following = 0
    for _ in range(r.number()):
        name = following + r.number()
        assert name not in now, "named twice"
        now[name] = r.one("H")
        following = name + 1
    assert all(0 < bits < 1 << 14 for bits in now.values()), "directions"
    return now


def read_sets(data, polygons, groups):
    r = Reader(data)
    for _ in range(r.one("I")):
        kind = r.one("I")
        limit = len(groups) if kind in (3, 6) else len(polygons)
        space = r.take("6d")
        assert all(space[k] <= space[k + 3] for k in range(3)), "space"
        sets = []
        if kind <= 3:
            a, b, c = r.take("3I")
            members = r.one("I")
            ends = (0,) + r.take(f"{14 * a * b * c}I")
            listed = r.take(f"{members}I")
            sets = [listed[x:y] for x, y in zip(ends, ends[1:])]
            assert ends[-1] == members, "ends"
        else:
            size = r.one("I")
            coded = Reader(data[r.at:r.at + size])
            r.at += (size + 3) // 4 * 4
            before = {}
            for _ in range(read_cells(coded)):
                if kind == 7:
                    before = read_changes(coded, before)
                    sets += [[name for name in sorted(before) if before[name] >> d & 1] for d in range(14)]
                    continue
                names, following = [], 0
                for _ in range(coded.number()):
                    names.append(following + coded.number())
                    following = names[-1] + 1
                for _ in range(14):
                    count = coded.number()
                    sets.append([names[coded.one("B") if len(names) <= 256 else coded.number()] for _ in range(count)])
            assert coded.done(), "family"
        assert all(m < limit for one in sets for m in one), "member"
        for number, one in enumerate(sets):
            print(f"set {kind} {number}:", *one)
    assert r.done(), "OSET"


def read_minimum_sets(data, polygons):
    r = Reader(data)
    a, b, c, directions = r.take("4I")
    r.take("3d")
    assert directions == 6 and all(step > 0 for step in r.take("3d")), "MOSD"
    for number in range(a * b * c * 6):
        one = [r.number() for _ in range(r.number())]
        assert all(p < len(polygons) for p in one), "polygon"
        print(f"minimum set {number}:", *one)
    assert r.done(), "MOSD"


def main(path):
    with open(path, "rb") as stream:
        sections = read_sections(stream.read())
    polygons = read_occluders(sections["OCCL"])[0] if "OCCL" in sections else []
    groups = read_groups(sections["OGRP"], polygons) if "OGRP" in sections else []
    if "CTRE" in sections:
        read_trees(sections["CTRE"])
    if "OSET" in sections:
        read_sets(sections["OSET"], polygons, groups)
    if "MOSD" in sections:
        read_minimum_sets(sections["MOSD"], polygons)


if __name__ == "__main__":
    main(sys.argv[1])
