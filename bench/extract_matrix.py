#!/usr/bin/env python3
"""Takes the visibility matrix out of a map's .pvs.npz (a zip of .npy files) for bench_coding. Plain python.

usage: extract_matrix.py MAP.pvs.npz OUT.matrix
"""
import ast
import struct
import sys
import zipfile


def main(source, target):
    with zipfile.ZipFile(source) as archive:
        npy = archive.read("pvs_bits.npy")
    header_length = struct.unpack_from("<H", npy, 8)[0]
    header = ast.literal_eval(npy[10:10 + header_length].decode())
    rows, row_bytes = header["shape"]
    assert header["descr"] == "|u1" and not header["fortran_order"]
    with open(target, "wb") as stream:
        # Clusters see clusters: as many objects as rows, in whole bytes.
        stream.write(struct.pack("<II", rows, rows))
        data = npy[10 + header_length:]
        width = (rows + 7) // 8
        for row in range(rows):
            stream.write(data[row * row_bytes:row * row_bytes + width])


if __name__ == "__main__":
    main(*sys.argv[1:])
