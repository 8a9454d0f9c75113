#!/usr/bin/env python3
"""An independent reader of .pvs files, written from docs/format.md alone.

usage: read_pvs.py FILE [X,Y,Z ..]
Prints `cell C: ids` or `cell C: everything` for each cell (of a view tree: for each leaf, by its place among the leaves),
then `eye X,Y,Z: ..` for each point. The ids of occludee volumes follow those of the objects, those of clusters follow these. Files that tell the triangles of clusters begin with
`triangles N: clusters` for each object.
"""
import struct
import sys

EVERYTHING = (0xFFFFFFFF, 0xFFFFFFFE)
KNOWN = ("META", "OPTS", "OBJS", "NAME", "CELL", "TREE", "VOLS", "CLUS", "CTRI", "RIDX", "ROWS")


# ---- sections 1 and 2

def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def read_sections(file):
    assert file[:8] == b"\x89PVS\r\n\x1a\n", "magic"
    major, _, lowest_minor, _, length, count, header_crc = struct.unpack_from("<HHHHQII", file, 8)
    assert major == 1 and lowest_minor <= 0, "version"
    assert length == len(file), "length"
    table_end = 32 + 32 * count
    assert crc32c(file[:28] + bytes(4) + file[32:table_end]) == header_crc, "header CRC"
    sections, end = {}, table_end
    for i in range(count):
        name, flags, crc, _, offset, size = struct.unpack_from("<4sIIIQQ", file, 32 + 32 * i)
        name = name.decode()
        assert offset == (end + 15) // 16 * 16 and not any(file[end:offset]), "place"
        end = offset + size
        assert crc32c(file[offset:end]) == crc, "CRC of " + name
        sections[name] = sections.get(name, b"") + file[offset:end]
        assert name in KNOWN or not flags & 1, "chunk"
    assert end == length, "end"
    return sections


def read_nodes(tree):
    """The nodes in preorder: (axis, step) or (None, row)."""
    nodes, at, next_row = [], 64, 0
    for _ in range(struct.unpack_from("<I", tree, 48)[0]):
        kind = tree[at]
        if kind < 5:
            nodes.append((kind, struct.unpack_from("<H", tree, at + 1)[0]))
            at += 3
        elif kind == 5:
            nodes.append((None, next_row))
            next_row += 1
            at += 1
        else:
            nodes.append((None, struct.unpack_from("<I", tree, at + 1)[0]))
            at += 5
    assert at == len(tree), "TREE"
    return nodes


# ---- section 4: each decoder gives a list of sets of ids

def bits_of(data):
    return {8 * i + bit for i, byte in enumerate(data) for bit in range(8) if byte >> bit & 1}


def decode_runs(coded):
    out, at = b"", 0
    while at < len(coded):
        count, kind = (coded[at] & 63) + 1, coded[at] >> 6
        at += 1
        if kind == 0:
            out += coded[at:at + count]
            at += count
        else:
            out += {2: b"\0", 3: b"\xff"}[kind] * count
    return bits_of(out)


def read_number(data, at):
    value = shift = 0
    while True:
        value |= (data[at] & 127) << shift
        shift += 7
        at += 1
        if data[at - 1] < 128:
            return value, at


def decode_gaps(coded):
    ids, last, at = set(), -1, 0
    while at < len(coded):
        gap, at = read_number(coded, at)
        last += gap + 1
        ids.add(last)
    return ids


def decode_cheapest(sections, rows, _):
    ends = (0,) + struct.unpack(f"<{rows}I", sections["RIDX"])
    ways = (bits_of, decode_runs, decode_gaps)
    return [ways[sections["ROWS"][a]](sections["ROWS"][a + 1:b]) for a, b in zip(ends, ends[1:])]


def decode_tree(sections, shape, rows, bits, coding):
    """`shape` is a row or a pair of shapes."""
    data, place = sections["ROWS"], [0]
    sets = [None] * rows

    def bit():
        place[0] += 1
        return data[(place[0] - 1) // 8] >> (place[0] - 1) % 8 & 1

    def read(within):
        return {o for o in sorted(within) if bit()}

    def children(shape, own):
        if not isinstance(shape, tuple):
            sets[shape] = read(range(bits)) if coding == 2 else own
            return
        below = above = None
        if coding == 3:
            below, above = read(own), read(own)
        elif coding == 4:
            above_is_lighter = bit()
            lighter = read(own)
            heavier = read(lighter) | (own - lighter)
            below, above = (heavier, lighter) if above_is_lighter else (lighter, heavier)
        children(shape[0], below)
        children(shape[1], above)

    if shape is not None:
        children(shape, None if coding == 2 else read(range(bits)))
    assert (place[0] + 7) // 8 == len(data), "ROWS"
    return sets


class Arithmetic:
    def __init__(self, data):
        self.low, self.high, self.at, self.data, self.value = 0, 0xFFFFFFFF, 0, data, 0
        for _ in range(4):
            self.value = self.value << 8 | self.next()

    def next(self):
        self.at += 1
        return self.data[self.at - 1] if self.at <= len(self.data) else 0

    def bit(self, p):
        middle = self.low + ((self.high - self.low) * p >> 16)
        bit = self.value <= middle
        if bit:
            self.high = middle
        else:
            self.low = middle + 1
        while (self.low ^ self.high) >> 24 == 0:
            self.low = self.low << 8 & 0xFFFFFFFF
            self.high = self.high << 8 & 0xFFFFFFFF | 0xFF
            self.value = self.value << 8 & 0xFFFFFFFF | self.next()
        return int(bit)


def reference_of(row, code):
    return None if code == 0 else row - (code + 1) // 2 if code % 2 else row + code // 2


def decode_references(sections, rows, bits):
    data, records, at = sections["ROWS"], [], 704
    for row in range(rows):
        assert row % 32 or struct.unpack_from("<I", sections["RIDX"], row // 32 * 4)[0] == at, "RIDX"
        code, at = read_number(data, at)
        size, at = read_number(data, at)
        records.append((reference_of(row, code), data[at:at + size]))
        at += size
    sets = [None] * rows

    def decode(row):
        if sets[row] is None:
            reference, coded = records[row]
            sets[row] = relative(decode(reference) if reference is not None else set(), coded)
        return sets[row]

    def relative(old, coded):
        coder, new, told = Arithmetic(coded), set(), 0
        count = (bits + 7) // 8
        byte = lambda s, i: sum(((8 * i + j) in s) << j for j in range(8))
        for i in range(count):
            r, before, after = byte(old, i), byte(old, i - 1), byte(old, i + 1)
            ones = bin(r).count("1")
            look = 4 * (4 if ones == 8 else min(ones, 3)) + min(bin((r ^ r >> 1) & 127).count("1"), 3)
            differs = coder.bit(256 * data[16 * look + 4 * told + 2 * (after != 0) + (before != 0)] + 128)
            told = (told << 1 | differs) & 3
            if not differs:
                new |= {o for o in old if o // 8 == i}
                continue
            width, some = min(8, bits - 8 * i), 0
            for j in range(width):
                o = 8 * i + j
                flip = lambda k: (k in old) != (k in new)
                if j == width - 1 and not some:
                    bit = o not in old
                else:
                    near = (o - 1 in old) + 2 * (o in old) + 4 * (o + 1 in old)
                    bit = coder.bit(256 * data[320 + 128 * min((width - 1 - j) // 2, 2) + near + 8 * (o - 1 in new) +
                                               16 * flip(o - 1) + 32 * flip(o - 2) + 64 * some] + 128)
                if bit:
                    new.add(o)
                some |= flip(o)
        return new

    return [decode(row) for row in range(rows)]


def decode_archive(sections, rows, bits):
    data, references, at = sections["ROWS"], [], 0
    for row in range(rows):
        code, at = read_number(data, at)
        references.append(reference_of(row, code))
    coder, sets = Arithmetic(data[at:]), [set() for _ in range(rows)]
    order = [row for row in range(rows) if references[row] is None]
    for row in order:
        order += [other for other in range(rows) if references[other] == row]
    small, large = [[32768, 0] for _ in range(4096)], [[32768, 0] for _ in range(65536)]
    for row in order:
        reference = references[row]
        near = sets[reference] if reference is not None else set()
        further = references[reference] if reference is not None else None
        far = sets[further] if further is not None else set()
        left = 0
        window = lambda s, o, low, high: sum((o + k in s) << k - low for k in range(low, high + 1))
        for o in range(bits):
            contexts = (small[left & 15 | window(near, o, -2, 3) << 4 | window(far, o, -1, 0) << 10],
                        large[left & 63 | window(near, o, -3, 4) << 6 | window(far, o, -1, 0) << 14])
            q = contexts[0][0] if contexts[1][1] < 3 else contexts[1][0]
            bit = coder.bit(min(max(q, 32), 65503))
            for context in contexts:
                context[0] += int(((65535 if bit else 0) - context[0]) * 2 / (2 * context[1] + 3))
                context[1] = min(context[1] + 1, 127)
            if bit:
                sets[row].add(o)
            left = left << 1 | bit
    return sets


# ---- the tree of rows that codings 2 to 4 follow

def tree_of_rows(leaf_or_pair, used):
    """Leaves out what is no row or was there before; a pair of one is that one; nothing is None."""
    if not isinstance(leaf_or_pair, tuple):
        if leaf_or_pair in EVERYTHING or leaf_or_pair in used:
            return None
        used.add(leaf_or_pair)
        return leaf_or_pair
    below = tree_of_rows(leaf_or_pair[0], used)
    above = tree_of_rows(leaf_or_pair[1], used)
    return above if below is None else below if above is None else (below, above)


def halve(cells, counts, low, high):
    widths = [b - a for a, b in zip(low, high)]
    axis = widths.index(max(widths))
    if widths[axis] == 1:
        return cells[low[0] + counts[0] * (low[1] + counts[1] * low[2])]
    middle = low[axis] + widths[axis] // 2
    cut = lambda corner: corner[:axis] + [middle] + corner[axis + 1:]
    return halve(cells, counts, low, cut(high)), halve(cells, counts, cut(low), high)


def nest(nodes, at=0):
    """The subtree at `at` as pairs, and where it ends."""
    if nodes[at][0] is None:
        return nodes[at][1], at + 1
    below, at = nest(nodes, at + 1)
    above, at = nest(nodes, at)
    return (below, above), at


# ---- clusters

def read_triangles(sections, objects):
    """For each object: how many triangles the file has of it, and the cluster of each, those behind included."""
    counts = [struct.unpack_from("<I", sections["OBJS"], 48 * o + 16)[0] for o in range(objects)]
    ends = struct.unpack(f"<{len(sections['CLUS']) // 4}I", sections["CLUS"])
    data, at, end, first = sections["CTRI"], 0, 0, 0
    for count in counts:
        in_file, at = read_number(data, at)
        behind, at = read_number(data, at)
        clusters, last = [], first - 1
        while len(clusters) < in_file + behind:
            head, at = read_number(data, at)
            number, kind = head >> 2, head & 3
            if kind == 0:
                step, at = read_number(data, at)
                last += step >> 1 if step % 2 == 0 else -(step + 1 >> 1)
                clusters += [last] * number
            elif kind == 1:
                clusters += range(last + 1, last + 1 + number)
                last += number
            else:
                clusters += [None] * number
        assert len(clusters) == in_file + behind, "CTRI"
        yield in_file, clusters
        end += count
        while first < len(ends) and ends[first] < end:
            first += 1
    assert at == len(data), "CTRI"


# ---- section 5

def position(low, high, count, i):
    return high if i >= count else min(high, low + (high - low) * i / count)


def slab(low, high, count, x):
    return max(i for i in range(count) if position(low, high, count, i) <= x)


def rows_at(nodes, low, high, point, at=0):
    """Rows of all leaves that hold the point, whichever way one looks, and where the subtree ends."""
    axis, value = nodes[at]
    if axis is None:
        return [value], at + 1
    below, middle = rows_at(nodes, low, high, point, at + 1)
    above, end = rows_at(nodes, low, high, point, middle)
    if axis > 2:
        return below + above, end
    return (above if point[axis] >= position(low[axis], high[axis], 65536, value) else below), end


def main(path, eyes):
    with open(path, "rb") as stream:
        sections = read_sections(stream.read())
    meta = sections["META"]
    coding, objects, rows = struct.unpack_from("<III", meta, 4)
    low, high = struct.unpack_from("<3d", meta, 64), struct.unpack_from("<3d", meta, 88)
    counts = struct.unpack_from("<3I", meta, 112)
    bits = objects
    if "VOLS" in sections:
        a, b, c = struct.unpack_from("<3I", sections["VOLS"], 48)
        bits += a * b * c
    if "CLUS" in sections:
        bits += len(sections["CLUS"]) // 4 - 1
    cells = struct.unpack(f"<{counts[0] * counts[1] * counts[2]}I", sections["CELL"])
    nodes = None
    if "TREE" in sections:
        low, high = struct.unpack_from("<3d", sections["TREE"], 0), struct.unpack_from("<3d", sections["TREE"], 24)
        nodes = read_nodes(sections["TREE"])
        cells = [row for axis, row in nodes if axis is None]
    if coding in (2, 3, 4):
        pairs = nest(nodes)[0] if nodes else halve(cells, counts, [0, 0, 0], list(counts)) if cells else None
        shape = None if pairs is None else tree_of_rows(pairs, set())
        sets = decode_tree(sections, shape, rows, bits, coding)
    else:
        sets = {1: decode_cheapest, 5: decode_references, 6: decode_archive}[coding](sections, rows, bits)
    always = {o for o in range(objects) if struct.unpack_from("<I", sections["OBJS"], 48 * o + 12)[0] & 4}

    def text(given):
        if any(row in EVERYTHING for row in given):
            return "everything"
        return " ".join(map(str, sorted(set().union(always, *(sets[row] for row in given)))))

    if "CTRI" in sections:
        for in_file, clusters in read_triangles(sections, objects):
            print(f"triangles {in_file}:", *("-" if c is None else c for c in clusters))
    for number, row in enumerate(cells):
        print(f"cell {number}: {text([row])}")
    for eye in eyes:
        point = [float(x) for x in eye.split(",")]
        given = [EVERYTHING[0]]
        if cells and all(a <= p <= b for a, p, b in zip(low, point, high)):
            if nodes:
                given = rows_at(nodes, low, high, point)[0]
            else:
                i, j, k = (slab(low[n], high[n], counts[n], point[n]) for n in range(3))
                given = [cells[i + counts[0] * (j + counts[1] * k)]]
        print(f"eye {eye}: {text(given)}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
