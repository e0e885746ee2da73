#!/usr/bin/env python3
"""A second decoder of the PLC's remote interface, written from its published structs and not from our C++.

    plc_reply_decode.py STREAM          STREAM is the program interop_plc_reply_stream

Request of 136 bytes and reply of 304, little-endian without padding. Exits with 1 and a sentence on the first thing
that does not fit.
"""

import math
import struct
import subprocess
import sys

REPLY = [
    ("mode", "I", 1), ("t", "f", 1), ("q", "f", 6), ("qd", "f", 6), ("wire", "f", 2),
    ("em8000", "f", 18), ("mru1", "f", 12), ("em1500", "f", 18), ("mru2", "f", 12),
]  # fmt: skip
OFFSETS = {"t": 4, "q": 8, "qd": 32, "wire": 56, "em8000": 64, "mru1": 136, "em1500": 184, "mru2": 256}


class Misfit(Exception):
    pass


def require(holds, sentence):
    if not holds:
        raise Misfit(sentence)


def decode_reply(data):
    require(len(data) == 304, f"a reply has 304 bytes, this has {len(data)}")
    values, offset = {}, 0
    for name, kind, count in REPLY:
        require(OFFSETS.get(name, 0) == offset, f"{name} lies at {offset}")
        values[name] = list(struct.unpack_from(f"<{count}{kind}", data, offset))
        offset += 4 * count
    return values


def as_float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def turned(roll, pitch, yaw):
    """Rx(roll) Ry(pitch) Rz(yaw), as the laboratory's code builds its platforms' rotation."""
    c, s = math.cos, math.sin
    about_x = [[1, 0, 0], [0, c(roll), -s(roll)], [0, s(roll), c(roll)]]
    about_y = [[c(pitch), 0, s(pitch)], [0, 1, 0], [-s(pitch), 0, c(pitch)]]
    about_z = [[c(yaw), -s(yaw), 0], [s(yaw), c(yaw), 0], [0, 0, 1]]
    return product(product(about_x, about_y), about_z)


def matrix_of(w, x, y, z):
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def check_vector():
    """Constructed: mode 0x01020304, then 1/64, -2/64, 3/64 … 75/64; tests/plc_reply/plc_reply_frames.hpp has the bytes."""
    data = bytes.fromhex("04030201" "0000803c" "000000bd" "0000403d") + b"".join(
        struct.pack("<f", (-1) ** i * (i + 1) / 64) for i in range(3, 75)
    )
    reply = decode_reply(data)
    require(reply["mode"] == [0x01020304] and reply["t"] == [1 / 64], "mode and time of the vector")
    require(reply["q"][0] == -2 / 64 and reply["mru1"][0] == -34 / 64, "the first joint, the first of MRU1")
    require(reply["em1500"][0] == -46 / 64 and reply["mru2"][11] == 75 / 64, "the first of EM1500, the last of all")


def check_platform(reply, body, words):
    eta = reply[body][:6]
    values = [float(word) for word in words]
    require(values[:3] == eta[:3], f"{body}: the driver's place is not the reply's")
    expected, understood = turned(*eta[3:]), matrix_of(*values[3:])
    worst = max(abs(a - b) for row, other in zip(expected, understood) for a, b in zip(row, other))
    require(worst < 1e-12, f"{body}: the driver's rotation is off by {worst}")


def check_stream(program):
    text = subprocess.run([program], check=True, capture_output=True, text=True, timeout=60).stdout
    requests, replies, platforms, units, reply = 0, 0, 0, 0, None
    for line in text.splitlines():
        mark, first, *rest = line.split()
        if mark == ">":
            require(bytes.fromhex(first) == bytes(136), f"{line}: a request is 136 zeros")
            requests += 1
        elif mark == "<":
            reply = decode_reply(bytes.fromhex(first))
            replies += 1
            require(reply["mode"] == [0] and not any(reply["q"] + reply["qd"] + reply["wire"]), f"{line}: not zero")
            said = reply["em8000"] + reply["mru1"] + reply["em1500"] + reply["mru2"]
            require(said == [as_float32(float(word)) for word in rest], f"{line}: a value")
            require(reply["t"] == [as_float32(0.005 * replies)], f"{line}: 5 ms a cycle, a reply in each")
        elif mark == "=":
            check_platform(reply, first, rest)
            platforms += 1
        else:
            require([float(word) for word in rest] == reply[first.removeprefix("plc_")], f"{line}: a value of the unit")
            units += 1
    require(replies > 390 and requests - replies in (0, 1), f"{requests} requests, {replies} replies")
    require(platforms == units and platforms in (2 * replies, 2 * replies - 2), "each reply is two platforms and two units")
    print(f"{requests} requests of zeros, {replies} replies, every number agrees")


if __name__ == "__main__":
    try:
        check_vector()
        check_stream(sys.argv[1])
    except Misfit as misfit:
        print(misfit, file=sys.stderr)
        sys.exit(1)
