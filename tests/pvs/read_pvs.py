#!/usr/bin/env python3
"""An independent reader of .pvs files, written from docs/format.md alone.

usage: read_pvs.py FILE [X,Y,Z ..]
Prints one line for each cell, `cell C: ids` or `cell C: everything`, then one `eye X,Y,Z: ..` for each point.
"""
import struct
import sys

EVERYTHING = (0xFFFFFFFF, 0xFFFFFFFE)


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
        assert offset == (end + 15) // 16 * 16 and not any(file[end:offset]), "place"
        end = offset + size
        assert crc32c(file[offset:end]) == crc, "CRC of " + name.decode()
        sections[name.decode()] = sections.get(name.decode(), b"") + file[offset:end]
        assert name.decode() in ("META", "OPTS", "OBJS", "NAME", "CELL", "RIDX", "ROWS") or not flags & 1, "chunk"
    assert end == length, "end"
    return sections


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
    return out


def decode_gaps(coded):
    ids, last, value, shift = set(), -1, 0, 0
    for byte in coded:
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            last += value + 1
            ids.add(last)
            value = shift = 0
    return ids


def decode_row(coded):
    rest = coded[1:]
    return [bits_of, lambda data: bits_of(decode_runs(data)), decode_gaps][coded[0]](rest)


def slab(low, high, count, x):
    return max(i for i in range(count) if min(high, low + (high - low) * i / count) <= x)


def main(path, eyes):
    with open(path, "rb") as stream:
        sections = read_sections(stream.read())
    meta = sections["META"]
    coding, objects, rows = struct.unpack_from("<III", meta, 4)
    low, high = struct.unpack_from("<3d", meta, 64), struct.unpack_from("<3d", meta, 88)
    counts = struct.unpack_from("<3I", meta, 112)
    assert coding == 1
    always = {o for o in range(objects) if struct.unpack_from("<I", sections["OBJS"], 48 * o + 12)[0] & 4}
    ends = (0,) + struct.unpack(f"<{rows}I", sections["RIDX"])
    sets = [decode_row(sections["ROWS"][ends[r]:ends[r + 1]]) | always for r in range(rows)]
    cells = struct.unpack(f"<{counts[0] * counts[1] * counts[2]}I", sections["CELL"])

    def text(row):
        return "everything" if row in EVERYTHING else " ".join(map(str, sorted(sets[row])))

    for number, row in enumerate(cells):
        print(f"cell {number}: {text(row)}")
    for eye in eyes:
        point = [float(x) for x in eye.split(",")]
        row = EVERYTHING[0]
        if all(counts) and all(a <= p <= b for a, p, b in zip(low, point, high)):
            i, j, k = (slab(low[n], high[n], counts[n], point[n]) for n in range(3))
            row = cells[i + counts[0] * (j + counts[1] * k)]
        print(f"eye {eye}: {text(row)}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
