#!/usr/bin/env python3
"""An ADS client of its own, in Python's standard library, against the simulated winch controller.

    ads_decode.py PATH/TO/interop_winch_server            plays a session, checks every answer
    ads_decode.py PATH/TO/interop_winch_server CAPTURE    and writes it as a capture file for tshark

Written from Beckhoff's description of AMS/TCP and ADS (tc3_ads_intro 115845259, 115847307, 115880971), not from the
gateway's codec. Exits 0 when everything agrees.
"""
import socket
import struct
import subprocess
import sys
import time

PLC = (bytes([192, 168, 90, 150, 1, 1]), 851)
SYSTEM = (PLC[0], 10000)
US = (bytes([10, 0, 0, 1, 1, 1]), 32760)
FILETIME_1970 = 116444736000000000
STATUS = struct.Struct("<4IQ8d4I4H8?")
COMMAND = struct.Struct("<4I4dH3B3x2I")
STATUS_NAMES = (
    "layout cycle heartbeat sequence timestamp position velocity set_position following_error torque temperature "
    "minimum maximum axis_state axis_error diagnosis trips drive_status class_1 state reserved ready enabled error "
    "warning comm_ok homed at_min at_max").split()
assert STATUS.size == 120 and COMMAND.size == 64


class AdsError(Exception):
    pass


class Client:
    """One connection. Every byte of both directions is kept with its time."""

    def __init__(self, port):
        self.stream = socket.create_connection(("127.0.0.1", port), timeout=5)
        self.stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.port = port
        self.invoke = 0
        self.samples = []  # (handle, filetime, data)
        self.wire = []  # (time, from_us, bytes)

    def _take(self, count):
        data = b""
        while len(data) < count:
            part = self.stream.recv(count - len(data))
            if not part:
                raise ConnectionError("closed by the controller")
            data += part
        return data

    def frame(self):
        """(source, command, flags, error, invoke id, data) of the next frame."""
        head = self._take(6)
        reserved, length = struct.unpack("<HI", head)
        assert reserved == 0 and 32 <= length < 1 << 20, head.hex()
        body = self._take(length)
        self.wire.append((time.time(), False, head + body))
        target, target_port, source, source_port, command, flags, size, error, invoke = struct.unpack(
            "<6sH6sHHHIII", body[:32])
        assert (target, target_port) == US, "sent to somebody else"
        assert size == length - 32, "AMS length"
        return (source, source_port), command, flags, error, invoke, body[32:]

    def notification(self, data):
        size, stamps = struct.unpack_from("<II", data)
        assert size == len(data) - 4, "the stream's length does not count itself"
        at = 8
        for _ in range(stamps):
            filetime, count = struct.unpack_from("<QI", data, at)
            at += 12
            for _ in range(count):
                handle, length = struct.unpack_from("<II", data, at)
                at += 8
                self.samples.append((handle, filetime, data[at:at + length]))
                at += length
        assert at == len(data), "bytes behind the last sample"

    def pump(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.stream.settimeout(left)
            try:
                source, command, flags, _, invoke, data = self.frame()
            except TimeoutError:
                break
            assert (source, command, flags, invoke) == (PLC, 8, 4, 0)
            self.notification(data)
        self.stream.settimeout(5)

    def ask(self, command, data=b"", target=PLC):
        self.invoke += 1
        ams = struct.pack("<6sH6sHHHIII", *target, *US, command, 4, len(data), 0, self.invoke) + data
        sent = struct.pack("<HI", 0, len(ams)) + ams
        self.wire.append((time.time(), True, sent))
        self.stream.sendall(sent)
        while True:
            source, got, flags, error, invoke, answer = self.frame()
            if got == 8:
                assert (source, flags) == (PLC, 4), "notifications are no responses"
                self.notification(answer)
                continue
            assert (source, got, flags, invoke) == (target, command, 5, self.invoke)
            if error:
                raise AdsError("router", error)
            (result,) = struct.unpack_from("<I", answer)
            if result:
                raise AdsError("device", result)
            return answer[4:]

    def read(self, group, offset, length, target=PLC):
        return self._data(self.ask(2, struct.pack("<III", group, offset, length), target))

    def read_write(self, group, offset, length, data):
        return self._data(self.ask(9, struct.pack("<IIII", group, offset, length, len(data)) + data))

    def write(self, group, offset, data):
        assert self.ask(3, struct.pack("<III", group, offset, len(data)) + data) == b""

    @staticmethod
    def _data(answer):
        (length,) = struct.unpack_from("<I", answer)
        assert length == len(answer) - 4
        return answer[4:]

    def handle(self, name):
        return struct.unpack("<I", self.read_write(0xF003, 0, 4, name.encode() + b"\0"))[0]

    def subscribe(self, group, offset, length, mode, period_ms):
        answer = self.ask(6, struct.pack("<6I16x", group, offset, length, mode, 0, period_ms * 10000))
        return struct.unpack("<I", answer)[0]

    def refused(self, level, code, *question, **more):
        try:
            self.ask(*question, **more)
        except AdsError as error:
            assert error.args == (level, code), error.args
        else:
            raise AssertionError(f"{question} was not refused")


def status_of(data):
    return dict(zip(STATUS_NAMES, STATUS.unpack(data)))


def symbols(data):
    """{name: (group, offset, size, type)} of an upload."""
    found, at = {}, 0
    while at < len(data):
        length, group, offset, size, _, _, name, kind, comment = struct.unpack_from("<6I3H", data, at)
        text = data[at + 30:at + length]
        assert len(text) == name + kind + comment + 3
        found[text[:name].decode()] = (group, offset, size, text[name + 1:name + 1 + kind].decode())
        at += length
    return found


def session(client):
    for target in (PLC, SYSTEM):
        assert struct.unpack("<HH", client.ask(4, target=target)) == (5, 0), "run"
    major, _, build, name = struct.unpack("<BBH16s", client.ask(1))
    assert (major, build, name.rstrip(b"\0")) == (3, 4022, b"Plc30 App")

    upload = struct.unpack("<6I", client.read(0xF00F, 0, 24))
    everything = symbols(client.read(0xF00B, 0, upload[1]))
    assert len(everything) == upload[0]
    assert everything["GVL_Winch.stStatus"][2:] == (120, "ST_WinchStatus")
    base = everything["GVL_Winch.stStatus"][1]
    assert everything["GVL_Winch.stStatus.fActPosition"] == (0x4040, base + 24, 8, "LREAL")
    assert everything["GVL_Winch.stCommand.nTimeoutMs"][1] == everything["GVL_Winch.stCommand"][1] + 56

    command, status = client.handle("GVL_Winch.stCommand"), client.handle("GVL_Winch.stStatus")
    by_handle = status_of(client.read(0xF005, status, 120))
    assert by_handle["layout"] == 1 and by_handle["state"] == 0 and by_handle["homed"]
    assert abs(by_handle["timestamp"] / 1e7 - FILETIME_1970 / 1e7 - time.time()) < 5, "PLC time is now"
    assert status_of(client.read_write(0xF004, 0, 120, b"GVL_Winch.stStatus"))["layout"] == 1
    assert status_of(client.read(0x4040, base, 120))["layout"] == 1

    names = [b"GVL_Winch.stCommand.nHeartbeat", b"MAIN.winch.length"]
    asked = b"".join(struct.pack("<4I", 0xF003, 0, 4, len(n)) for n in names) + b"".join(names)
    results = struct.unpack("<6I", client.read_write(0xF082, 2, 24, asked))
    assert results[:4] == (0, 4, 0, 4)
    both = client.read_write(0xF080, 2, 20, struct.pack("<6I", 0xF005, results[4], 4, 0xF005, results[5], 8))
    assert struct.unpack("<2I", both[:8]) == (0, 0)
    assert abs(struct.unpack("<d", both[12:])[0] - by_handle["position"]) < 1e-6, "length from the lower limit at 0"

    # Enabled, then paying out, with a heartbeat every 10 ms.
    cyclic = client.subscribe(0xF005, status, 120, 3, 10)
    for beat in range(1, 120):
        on = beat > 20
        client.write(0xF005, command, COMMAND.pack(1, beat, 1, 0, 0, 0.1 if on else 0, 0, 0, 2, on, 0, 0, 500, 0))
        client.pump(0.01)
    samples = [status_of(data) for handle, _, data in client.samples if handle == cyclic]
    assert len(samples) > 50, f"{len(samples)} samples"
    assert all(a["cycle"] < b["cycle"] for a, b in zip(samples, samples[1:]))
    assert samples[-1]["state"] == 3 and abs(samples[-1]["velocity"] - 0.1) < 0.05, samples[-1]
    client.ask(7, struct.pack("<I", cyclic))
    client.refused("device", 0x714, 7, struct.pack("<I", cyclic))

    client.refused("device", 0x710, 9, struct.pack("<IIII", 0xF003, 0, 4, 4) + b"nope")
    client.refused("device", 0x702, 2, struct.pack("<III", 0x1234, 0, 4))
    client.refused("device", 0x701, 77)
    client.refused("router", 6, 4, target=(PLC[0], 500))
    client.refused("router", 7, 4, target=(bytes([1, 1, 1, 1, 1, 1]), 851))
    client.write(0xF006, 0, struct.pack("<I", command))
    client.refused("device", 0x703, 2, struct.pack("<III", 0xF005, command, 64))


def write_capture(path, wire, port):
    """The session as Ethernet, IPv4 and TCP between the client and port 48898, where dissectors look for AMS.

    One frame is one packet, however long: Wireshark's dissector does not put frames together.
    """
    ours, theirs, ams_port = bytes([192, 168, 90, 70]), bytes([192, 168, 90, 150]), 48898
    sent = {True: 1, False: 1}
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for when, from_us, data in wire:
            ends = (port, ams_port) if from_us else (ams_port, port)
            tcp = struct.pack(">HHIIBBHHH", *ends, sent[from_us], sent[not from_us], 0x50, 0x18, 65535, 0, 0) + data
            addresses = (ours, theirs) if from_us else (theirs, ours)
            ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp), 0, 0x4000, 64, 6, 0, *addresses)
            packet = bytes(12) + b"\x08\x00" + ip + tcp
            sent[from_us] += len(data)
            file.write(struct.pack("<IIII", int(when), int(when % 1 * 1e6), len(packet), len(packet)) + packet)


def main():
    server = subprocess.Popen([sys.argv[1], "30"], stdout=subprocess.PIPE, text=True)
    try:
        port = int(server.stdout.readline().rsplit(":", 1)[1])
        client = Client(port)
        session(client)
        if len(sys.argv) > 2:
            write_capture(sys.argv[2], client.wire, client.stream.getsockname()[1])
        print(f"the controller's {sum(not ours for _, ours, _ in client.wire)} frames are ADS")
    finally:
        server.kill()
        server.wait()


if __name__ == "__main__":
    main()
