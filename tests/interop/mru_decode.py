#!/usr/bin/env python3
"""A second decoder of everything that a motion reference unit sends, in Python's standard library.

Written from the makers' layouts, not from the product's C++: other code, other order of operations, other tables.
Compares what the simulated unit measured with what its datagrams say, value by value.

    mru_decode.py MRU_STREAM    the program that prints both (mru_stream.cpp)
"""

import json
import math
import struct
import subprocess
import sys

FORMATS = ["mrubin", "km_binary", "em3000", "em1000", "tss1", "psxn", "prdid", "bin23", "nmeap"]

# The laboratory's 24 variables (MRU configuration, December 2017), in the order of the datagram.
LABORATORY = """SystemTime SensorTemp AngRate_D Roll Pitch Yaw AngRate_R AngRate_P AngRate_Y VelMru_R VelMru_P VelMru_Y
AccMru_R AccMru_P AccMru_Y PosCg_F PosCg_S PosCg_D VelCg_F VelCg_S VelCg_D AccCg_F AccCg_S AccCg_D""".split()


def wrapped(degrees):
    return (degrees + 180.0) % 360.0 - 180.0


def ones_complement(data):
    """8-bit sum with end-around carry, inverted; the closed form of it."""
    return 255 - sum(data) % 255


def nmea_fields(line):
    assert line[0] == "$" and line[-3] == "*", line
    body = line[1:-3]
    checksum = 0
    for character in body:
        checksum ^= ord(character)
    assert checksum == int(line[-2:], 16), line
    return body.split(",")


def crc_x25(data):
    """CRC-16/X-25 by table, not bit by bit over the data."""
    table = []
    for index in range(256):
        value = index
        for _ in range(8):
            value = (value >> 1) ^ (0x8408 if value & 1 else 0)
        table.append(value)
    crc = 0xFFFF
    for byte in data:
        crc = (crc >> 8) ^ table[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFF


def mrubin(data):
    header, length, token = data[0], data[1], data[2]
    assert len(data) == length + 3 == 100 and token == 11
    assert data[-1] % 255 == ones_complement(data[2:-1]) % 255
    values = dict(zip(LABORATORY, struct.unpack(">i23f", data[3:-1])))
    return by_name(values) | {"stable": {0x71: True, 0x51: False}[header]}


def by_name(values):
    """The laboratory's variables in the words that are compared."""
    return {
        "system_time_ms": values["SystemTime"],
        "temperature": values["SensorTemp"],
        "omega_down": values["AngRate_D"],
        "roll": math.degrees(values["Roll"]),
        "pitch": math.degrees(values["Pitch"]),
        "heading": math.degrees(values["Yaw"]),
        "rates": [math.degrees(values["AngRate_" + a]) for a in "RPY"],
        "v_unit": [values["VelMru_" + a] for a in "RPY"],
        "a_unit": [values["AccMru_" + a] for a in "RPY"],
        "p_heading": [values["PosCg_" + a] for a in "FSD"],
        "v_heading": [values["VelCg_" + a] for a in "FSD"],
        "a_heading": [values["AccCg_" + a] for a in "FSD"],
    }


def nmeap(data):
    assert data[-2:] == b"\r\n"
    name, settled, token, *fields = nmea_fields(data[:-2].decode("ascii"))
    assert name == "PSXN" and token == "011" and len(fields) == len(LABORATORY)
    assert all(-math.pi <= float(fields[LABORATORY.index(angle)]) <= math.pi for angle in ("Roll", "Pitch", "Yaw"))
    values = dict(zip(LABORATORY, map(float, fields)))
    return by_name(values) | {"stable": {"10": True, "11": False}[settled]}


def km_binary(data):
    assert len(data) == 132
    (name, length, version, utc_s, utc_ns, status) = struct.unpack_from("<4sHHIII", data, 0)
    assert (name, length, version) == (b"#KMB", 132, 1)
    roll, pitch, heading, heave = struct.unpack_from("<4f", data, 40)
    return {
        "stable": status & 0b1010 == 0,
        "utc_ns": utc_s * 10**9 + utc_ns,
        "roll": roll,
        "pitch": pitch,
        "heading": heading,
        "heave_down": heave,
        "rates": struct.unpack_from("<3f", data, 56),
        "v_ned": struct.unpack_from("<3f", data, 68),
        "a_ned": struct.unpack_from("<3f", data, 108),
    }


def em_attitude(data):
    status, mark, roll, pitch, heave_up, heading = struct.unpack("<BBhhhH", data)
    assert mark == 0x90
    return status, {"pitch": pitch / 100, "heave_down": -heave_up / 100, "heading": heading / 100}, roll / 100


def em3000(data):
    status, values, roll = em_attitude(data)
    assert 0x90 <= status <= 0xAF
    return values | {"stable": status <= 0x99, "roll": roll}


def em1000(data):
    status, values, roll = em_attitude(data)
    assert status == 0
    return values | {"hippy_roll": roll}


def tss1(data):
    line = data.decode("ascii")
    assert len(line) == 27 and line[0] == ":" and line[7] == line[19] == " " and line[25:] == "\r\n"
    vertical = int(line[3:7], 16)
    return {
        "stable": {"U": True, "u": False}[line[13]],
        "a_down": -0.000625 * (vertical - 65536 if vertical >= 32768 else vertical),
        "heave_down": -int(line[8:13].replace(" ", "")) / 100,
        "hippy_roll": int(line[14:19].replace(" ", "")) / 100,
        "pitch": int(line[20:25].replace(" ", "")) / 100,
    }


def psxn(data):
    text = data.decode("ascii")
    assert text.endswith("\r\n")
    values = {}
    for line in text[:-2].split("\r\n"):
        name, number, *fields = nmea_fields(line)
        assert name == "PSXN"
        if number == "20":
            values["stable"] = fields[3] != "2"
        elif number == "23":
            values["roll"], values["pitch"], values["heading"], values["heave_down"] = map(float, fields)
        elif number == "24":
            *values["rates"], values["v_down"] = map(float, fields)
    return values


def prdid(data):
    assert data[-2:] == b"\r\n"
    name, pitch, roll, heading = nmea_fields(data[:-2].decode("ascii"))
    assert name == "PRDID"
    return {"pitch": float(pitch), "roll": float(roll), "heading": float(heading)}


def bin23(data):
    assert len(data) == 44 and data[:2] == b"\xaa\x51"
    assert struct.unpack("<H", data[42:])[0] == crc_x25(data[2:42])
    (utc_s, tenths, _, _, _, heave, north, east, down, roll, pitch, heading, *rates, status) = struct.unpack(
        ">iHiiihhhhhhHhhhH", data[2:42]
    )
    scale = 90 / 2**14
    return {
        "stable": status & 0b101000 == 0,
        "utc_ns": utc_s * 10**9 + tenths * 10**5,
        "heave_down": heave / 100,
        "v_ned": [north / 100, east / 100, down / 100],
        "roll": roll * scale,
        "pitch": pitch * scale,
        "heading": heading * scale,
        "rates": [rate * scale for rate in rates],
    }


DECODERS = dict(zip(FORMATS, [mrubin, km_binary, em3000, em1000, tss1, psxn, prdid, bin23, nmeap]))


def expected(truth):
    """What was measured, in the words that the decoders use."""
    roll, pitch, yaw = truth["euler_rad"]
    forward, starboard, down = truth["v_heading_mps"]
    a_forward, a_starboard, a_down = truth["a_heading_mps2"]

    def ned(f, s, d):
        turned = complex(f, s) * complex(math.cos(yaw), math.sin(yaw))
        return [turned.real, turned.imag, d]

    return {
        "stable": truth["stable"],
        "utc_ns": truth["t_ns"],
        "system_time_ms": 123456 + truth["since_start_ms"],
        "temperature": truth["temperature_degc"],
        "omega_down": truth["omega_down_radps"],
        "roll": math.degrees(roll),
        "hippy_roll": math.degrees(math.asin(math.sin(roll) * math.cos(pitch))),
        "pitch": math.degrees(pitch),
        "heading": math.degrees(yaw),
        "rates": [math.degrees(rate) for rate in truth["omega_radps"]],
        "v_unit": truth["v_unit_mps"],
        "a_unit": truth["a_unit_mps2"],
        "p_heading": truth["p_heading_m"],
        "v_heading": truth["v_heading_mps"],
        "a_heading": truth["a_heading_mps2"],
        "heave_down": truth["p_heading_m"][2],
        "v_ned": ned(forward, starboard, down),
        "v_down": down,
        "a_ned": ned(a_forward, a_starboard, a_down),
        "a_down": a_down,
    }


def tolerance(name, quantity):
    """Half of the last digit, and a little for rounding."""
    if name in ("mrubin", "km_binary", "nmeap"):
        return 1e-4 if quantity == "heading" else 3e-5
    if quantity == "a_down":
        return 0.0004
    return 0.0051


def compare(name, got, want):
    count = 0
    for quantity, value in got.items():
        wanted = want[quantity]
        if quantity in ("stable", "utc_ns", "system_time_ms"):
            assert value == wanted, f"{name} {quantity}: {value}, measured {wanted}"
            count += 1
            continue
        pairs = zip(value, wanted) if isinstance(wanted, list) else [(value, wanted)]
        for a, b in pairs:
            error = wrapped(a - b) if quantity == "heading" else a - b
            assert abs(error) <= tolerance(name, quantity), f"{name} {quantity}: {a}, measured {b}"
            count += 1
    return count


def pairs_of(stream):
    while line := stream.readline():
        size = int(stream.readline())
        data = stream.read(size)
        assert len(data) == size
        yield json.loads(line), data


def published():
    """The decoder itself against published datagrams, so that it is not only as right as the simulator."""
    assert ones_complement(bytes.fromhex("2F3D50E560BD50E560BE50E5603F9DF3B6")) == 0xCB  # Reson SeaBat 8160 manual
    assert crc_x25(b"123456789") == 0x906E
    healy = tss1(b":000064 -0003U 0007 -0056\r\n")  # Seatex MRU on USCGC Healy
    assert healy["pitch"] == -0.56 and healy["hippy_roll"] == 0.07 and healy["heave_down"] == 0.03
    seapath = psxn(b"$PSXN,23,1.28,1.93,104.68,-0.24*18\r\n")
    assert seapath == {"roll": 1.28, "pitch": 1.93, "heading": 104.68, "heave_down": -0.24}


def main():
    published()
    for name in FORMATS:
        with subprocess.Popen([sys.argv[1], name], stdout=subprocess.PIPE) as process:
            datagrams = values = 0
            for truth, data in pairs_of(process.stdout):
                values += compare(name, DECODERS[name](data), expected(truth))
                datagrams += 1
        assert process.returncode == 0 and datagrams == 100, f"{name}: {datagrams} datagrams"
        print(f"{name:10} {datagrams} datagrams, {values} values agree")


if __name__ == "__main__":
    main()
