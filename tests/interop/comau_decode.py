#!/usr/bin/env python3
"""A second decoder of the arm's exchange, written from the published structs and not from our C++.

    comau_decode.py STREAM          STREAM is the program interop_comau_stream

Layouts, little-endian without padding: the command of 32 bytes and the answer of 52 as in the laboratory's robot
program (October 2019), the answer of 124 bytes as in its PLC project (November 2019). Exits with 1 and a sentence on
the first thing that does not fit.
"""

import struct
import subprocess
import sys

KEY = 32
CYCLE_S = 0.0004
PERIOD_NS = 5_000_000


class Misfit(Exception):
    pass


def require(holds, sentence):
    if not holds:
        raise Misfit(sentence)


def floats(data, offset, count=6):
    return [struct.unpack_from("<f", data, offset + 4 * i)[0] for i in range(count)]


def decode_command(data):
    require(len(data) == 32, f"a command has 32 bytes, this has {len(data)}")
    key, mode = struct.unpack_from("<ii", data, 0)
    require(key == KEY, f"the key is 32, this is {key}")
    return {"mode": mode, "values": floats(data, 8)}


def decode_answer(data):
    require(len(data) in (52, 124), f"an answer has 52 or 124 bytes, this has {len(data)}")
    (counter,) = struct.unpack_from("<i", data, 0)
    offsets = [4, 28] + ([52, 76, 100] if len(data) == 124 else [])
    return {"counter": counter, "values": [v for offset in offsets for v in floats(data, offset)]}


def as_float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def same(decoded, said):
    return len(decoded) == len(said) and all(d == as_float32(s) for d, s in zip(decoded, said))


def check_vectors():
    """Constructed by hand: 0.5 is 3F000000, -0.25 BE800000, 1 3F800000, -2 C0000000."""
    command = bytes.fromhex("2000000001000000" "0000003f000080be" "0000000000000000" "0000803f000000c0")
    require(decode_command(command) == {"mode": 1, "values": [0.5, -0.25, 0.0, 0.0, 1.0, -2.0]}, "the command vector")
    joints = "0000003f" + "000080be" * 5
    answer = bytes.fromhex("04030201" + joints + "0000803f" * 6)
    require(decode_answer(answer)["counter"] == 0x01020304, "the counter of the answer vector")
    require(decode_answer(answer)["values"] == [0.5] + [-0.25] * 5 + [1.0] * 6, "the answer vector")
    longer = answer + bytes.fromhex("000000c0" * 6 + "0000803f" * 6 + "0000003f" * 6)
    require(decode_answer(longer)["values"][12:] == [-2.0] * 6 + [1.0] * 6 + [0.5] * 6, "the long answer vector")


def check_stream(program, size):
    text = subprocess.run([program, str(size)], check=True, capture_output=True, text=True, timeout=60).stdout
    commands, answers, understood, answer = [], [], 0, None
    for line in text.splitlines():
        mark, t_ns, *rest = line.split()
        t_ns = int(t_ns)
        if mark == ">":
            command = decode_command(bytes.fromhex(rest[0]))
            require(command["mode"] == int(rest[1]), f"{line}: the mode")
            require(same(command["values"], [float(v) for v in rest[2:]]), f"{line}: a velocity")
            commands.append((t_ns, command))
        elif mark == "<":
            data = bytes.fromhex(rest[0])
            require(len(data) == size, f"{line}: not {size} bytes")
            answer = decode_answer(data)
            require(answer["counter"] == int(rest[1]), f"{line}: the counter")
            require(same(answer["values"], [float(v) for v in rest[2:]]), f"{line}: a value")
            answers.append((t_ns, answer))
        else:
            require(answer is not None, f"{line}: understood before anything was said")
            require(answer["counter"] == int(rest[0]), f"{line}: the driver's counter")
            require(answer["values"] == [float(v) for v in rest[1:]], f"{line}: a value of the driver's")
            understood += 1

    require(len(commands) > 500, "too few commands to judge")
    require(len(commands) - len(answers) in (0, 1), "each command has one answer")
    require(understood == len(answers) or understood == len(answers) - 1, "the driver understood every answer")
    require(commands[0][1] == {"mode": 0, "values": [0.0] * 6}, "the first command is mode 0 at rest")
    require(all(c == {"mode": 0, "values": [0.0] * 6} for _, c in commands[-20:]), "20 farewells of mode 0 at rest")
    moving = [c for _, c in commands if any(c["values"])]
    require(len(moving) > 300 and all(c["mode"] == 1 for c in moving), "motion is asked for in mode 1, and it is")
    for (t0, before), (t1, after) in zip(commands, commands[1:]):
        require(t1 - t0 == PERIOD_NS, f"{t1}: commands are 5 ms apart")
        require(before["mode"] == 0 or after["mode"] == 1 or not any(before["values"]), f"{t1}: mode 0 only from rest")
        require(before["mode"] == 1 or not any(after["values"]), f"{t1}: mode 1 begins at rest")
    for (t0, before), (t1, after) in zip(answers, answers[1:]):
        frames = after["counter"] - before["counter"]
        require(frames in (12, 13), f"{t1}: {frames} frames in 5 ms, not 12 or 13")
    frames = answers[-1][1]["counter"] - answers[0][1]["counter"]
    passed_s = 1e-9 * (answers[-1][0] - answers[0][0])
    require(abs(frames * CYCLE_S - passed_s) < 2 * CYCLE_S, "the counter runs at 2500 per second")
    print(f"{size} bytes: {len(commands)} commands, {len(answers)} answers, every number agrees")


def main():
    check_vectors()
    for size in (52, 124):
        check_stream(sys.argv[1], size)


if __name__ == "__main__":
    try:
        main()
    except Misfit as misfit:
        print(misfit, file=sys.stderr)
        sys.exit(1)
