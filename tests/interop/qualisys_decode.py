#!/usr/bin/env python3
"""A client of QTM's real-time protocol that shares nothing with ours: sockets and struct alone.

    qualisys_decode.py SERVER      starts interop_qualisys_server and compares what it sends with what it was told to show

Written from the protocol's documentation: headers, components, texts and XML are spelled out here once more.
"""
import math
import socket
import struct
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

ERROR, COMMAND, XML, DATA, NO_MORE_DATA, EVENT = 0, 1, 2, 3, 4, 6
# name of a component: its number, floats of an item (with residual), where an id stands
COMPONENTS = {
    "3D": (1, 3, None), "3DRes": (9, 4, None), "3DNoLabels": (2, 4, 3), "3DNoLabelsRes": (10, 5, 3),
    "6D": (5, 12, None), "6DRes": (11, 13, None), "6DEuler": (6, 6, None), "6DEulerRes": (12, 7, None),
}
# Column by column: roll 10, pitch 20, yaw 30 degrees, published to six digits with the angles' definition.
TILTED = [0.813798, 0.543838, -0.204874, -0.469846, 0.823173, 0.318796, 0.342020, -0.163176, 0.925417]
UPRIGHT = [1, 0, 0, 0, 1, 0, 0, 0, 1]

checks = 0


def expect(condition, text):
    global checks
    checks += 1
    if not condition:
        raise SystemExit(f"not ok after {checks} checks: {text}")


def expect_near(got, wanted, tolerance, text):
    expect(len(got) == len(wanted), f"{text}: {got} has not the length of {wanted}")
    for a, b in zip(got, wanted):
        same = math.isnan(a) if math.isnan(b) else abs(a - b) <= tolerance
        expect(same, f"{text}: {got} is not {wanted}")


class Client:
    def __init__(self, port, order="<", version="1.25"):
        self.order = order
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=5)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer = b""
        if version:
            expect(self.packet() == (COMMAND, b"QTM RT Interface connected\0"), "the greeting has no full stop, but NUL")
            expect(self.ask("Version " + version) == "Version set to " + version, "the version is echoed")

    def send(self, text, kind=COMMAND, nul=b"\0"):
        payload = text.encode() + nul
        self.socket.sendall(struct.pack(self.order + "II", 8 + len(payload), kind) + payload)

    def packet(self):
        while True:
            if len(self.buffer) >= 8:
                size, kind = struct.unpack_from(self.order + "II", self.buffer)
                expect(8 <= size < 1 << 20, f"a packet of {size} bytes")
                if len(self.buffer) >= size:
                    payload, self.buffer = self.buffer[8:size], self.buffer[size:]
                    return kind, payload
            more = self.socket.recv(65536)
            if not more:
                return None
            self.buffer += more

    def next(self, *kinds):
        """The next packet of one of these kinds; frames that come in between are passed over, and only they."""
        while True:
            kind, payload = self.packet()
            if kind in kinds:
                return kind, payload
            expect(kind == DATA, f"a packet of kind {kind} while {kinds} were expected: {payload[:60]}")

    def ask(self, text, kind=COMMAND, nul=b"\0", answer=COMMAND):
        self.send(text, kind, nul)
        _, payload = self.next(answer)
        expect(payload.endswith(b"\0") and payload.count(b"\0") == 1, "every text ends with one NUL")
        return payload[:-1].decode()

    def refused(self, text, kind=COMMAND):
        return self.ask(text, kind, answer=ERROR)

    def event(self):
        return self.next(EVENT)[1]

    def close(self):
        self.socket.close()


def decode(payload, order):
    """Time stamp, frame number and {component number: (head, items)}, floats as they are written."""
    stamp, number, count = struct.unpack_from(order + "QII", payload)
    at, found = 16, {}
    for _ in range(count):
        size, kind = struct.unpack_from(order + "II", payload, at)
        body = payload[at + 8:at + size]
        at += size
        if kind == 17:
            (items,) = struct.unpack_from(order + "I", body)
            found[17] = [struct.unpack_from(order + "III", body, 4 + 12 * i) for i in range(items)]
            continue
        (floats, id_at) = next((f, i) for number_, f, i in COMPONENTS.values() if number_ == kind)
        items, drop, out_of_sync = struct.unpack_from(order + "IHH", body)
        expect(len(body) == 8 + 4 * floats * items, f"component {kind}: {len(body)} bytes for {items} items")
        expect((drop, out_of_sync) == (2, 1), f"rates in per mille: {drop}, {out_of_sync}")
        layout = "".join("I" if i == id_at else "f" for i in range(floats))
        found[kind] = [struct.unpack_from(order + layout, body, 8 + 4 * floats * i) for i in range(items)]
    expect(at == len(payload), "nothing stands behind the last component")
    return stamp, number, found


def check_scene(payload, order, asked):
    nan = float("nan")
    stamp, number, found = decode(payload, order)
    expect(set(found) == {17 if a == "Timecode" else COMPONENTS[a][0] for a in asked}, f"components {set(found)}")
    x_mm = None
    for name in asked:
        if name == "Timecode":
            (kind, high, low), = found[17]
            expect(kind == 2, "the kind of the time code is camera time")
            age_s = time.time() - (high << 32 | low) * 1e-7
            expect(-0.5 < age_s < 5, f"camera time is {age_s} s old")
            continue
        kind, floats, _ = COMPONENTS[name]
        items, residual = found[kind], name.endswith("Res")
        if name.startswith("6D"):
            angles = "Euler" in name
            load, platform, lost = items
            expect(x_mm in (None, load[0]), "one place in all components of a frame")
            x_mm = load[0]
            expect(999.5 < x_mm < 2000.5 and abs(x_mm - round(x_mm)) < 1e-3, f"x = {x_mm} mm")
            orientation = [10, 20, 30] if angles else TILTED
            expect_near(load[1:], [-250.25, 1500] + orientation + [0.25] * residual, 1e-4, name + " load")
            orientation = [0, 0, 0] if angles else UPRIGHT
            expect_near(platform, [-1000, 2500, 500] + orientation + [0.5] * residual, 1e-4, name + " platform")
            expect_near(lost, [nan] * floats, 0, name + " of a body that is not seen")
        elif name.startswith("3DNoLabels"):
            expect_near(items[0], [4000, 5000, 6000, 7] + [1.0] * residual, 1e-3, name)
            expect_near(items[1], [4000, 5062, 6000, 4000000000] + [2.0] * residual, 1e-3, name)
        else:
            expect_near(items[0], [100, 200, 300] + [0.4] * residual, 1e-4, name)
            expect_near(items[1], [nan] * floats, 0, name + " of a marker that is not seen")
    return stamp, number, x_mm


def check_stream(frames, order, asked):
    last = None
    for payload in frames:
        stamp, number, x_mm = check_scene(payload, order, asked)
        if last and number == last[1] + 1:
            expect(stamp > last[0], "time stamps go on")
            if x_mm is not None:
                expect(abs((x_mm - last[2]) % 1000 - 1) < 1e-2, "the load moves by a millimetre a frame")
        last = stamp, number, x_mm


def check_frames(port, order):
    client = Client(port, order)
    word = {"<": "little", ">": "big"}[order]
    expect(client.ask("ByteOrder") == f"Byte order is {word} endian", "byte order")
    for asked in [[name] for name in COMPONENTS] + [list(COMPONENTS) + ["Timecode"]]:
        client.send("GetCurrentFrame " + " ".join(asked))
        check_scene(client.next(DATA)[1], order, asked)
        client.send("StreamFrames AllFrames " + " ".join(asked))
        check_stream([client.next(DATA)[1] for _ in range(10)], order, asked)
        client.send("StreamFrames Stop")
        client.send("GetState")
        expect(client.event() == b"\x03", "a capture runs")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", 0))
        udp.settimeout(5)
        asked = ["6DRes", "3DNoLabels", "Timecode"]
        client.send(f"streamframes Frequency:100  UDP:{udp.getsockname()[1]} {' '.join(asked)} ", nul=b"")
        frames = []
        for _ in range(50):
            datagram = udp.recv(65536)
            size, kind = struct.unpack_from(order + "II", datagram)
            expect((size, kind) == (len(datagram), DATA), "one packet a datagram")
            frames.append(datagram[8:])
        check_stream(frames, order, asked)
        numbers = [decode(f, order)[1] for f in frames]
        expect(1.5 < (numbers[-1] - numbers[0]) / (len(numbers) - 1) < 2.5, f"half of the frames: {numbers}")
    client.close()


def check_xml(port):
    for minor in range(8, 29):
        client = Client(port, version=f"1.{minor}")
        root = ET.fromstring(client.ask("GetParameters General 3D 6D Force", answer=XML))
        expect(root.tag == f"QTM_Parameters_Ver_1.{minor}", f"root {root.tag}")
        names = ["load", "platform", "never seen"]
        group = root.find("The_6D")
        expect([b.findtext("Name") for b in group.findall("Body")] == names, "names of the bodies")
        expect(root.findtext("General/Frequency") == "200", "frequency")
        expect([e.findtext("Name") for e in root.findall("The_3D/Label")] == ["corner", "never seen"], "labels")
        expect(root.findtext("The_3D/Labels") == "2", "count of labels")
        attributes = minor >= 21
        expect((group.findtext("Bodies") == "3") == (not attributes), "count of bodies, before 1.21")
        expect((group.find("Euler") is not None) == (16 <= minor < 21), "Euler in the 6D group, 1.16 to 1.20")
        expect((root.find("General/EulerAngles") is not None) == attributes, "EulerAngles in General, from 1.21")
        for body in group.findall("Body"):
            expect((body.findtext("Enabled") == "true") == (minor >= 24), "Enabled, from 1.24")
            if attributes:
                expect(len(body.findall("Points/Point")) >= 3, "a body has three points")
                expect(body.find("Data_origin").get("Relative_body") == body.find("Data_orientation").get("Relative_body"),
                       "origin and orientation name the same body")
            else:
                expect(len(body.findall("Point/X")) >= 3, "points by elements, before 1.21")
                expect((body.find("Point/Virtual") is not None) == (minor == 20), "Virtual, 1.20")
        client.close()
    client = Client(port)
    for bad in ["Version 1.7", "Version 1.29", "Version 2.25"]:
        expect(client.refused(bad) == "Version NOT supported", "a version that is not spoken")
    expect(client.ask("version") == "Version is 1.25", "a refusal changes nothing")
    expect(client.refused("GetParameters Weather") == "Parse error", "an unknown group")
    expect(client.ask("QTMVersion") == "QTM Version is 2.17 (build 3700)", "version of QTM")
    client.close()


def check_control(port):
    master, watcher = Client(port), Client(port)
    watcher.send("StreamFrames AllFrames 6D")
    watcher.next(DATA)
    expect(watcher.refused("Stop") == "You must be master to issue this command", "only a master stops")
    expect(master.ask("takecontrol ") == "You are now master", "control")
    expect(watcher.refused("TakeControl").endswith("is already master"), "one master at a time")
    expect(master.ask("Stop") == "Stopping measurement", "stop")
    expect(master.event() == b"\x04" and watcher.event() == b"\x04", "everybody gets the event")
    expect(watcher.next(NO_MORE_DATA) == (NO_MORE_DATA, b""), "no more data")
    master.send("GetCurrentFrame 6D")
    expect(master.next(NO_MORE_DATA)[0] == NO_MORE_DATA, "no frame while nothing is measured")
    expect(master.refused("New") == "The previous measurement has not been saved or closed", "new before close")
    for command, answer, event in [("Close", "Closing connection", 2), ("New", "Creating new connection", 1),
                                   ("Start", "Starting measurement", 3)]:
        expect(master.ask(command) == answer, command)
        expect(master.event() == bytes([event]), f"the event of {command}")
        while watcher.next(EVENT, NO_MORE_DATA) != (EVENT, bytes([event])):
            pass
    expect(master.refused("Start") == "Measurement is already running", "start twice")
    watcher.next(DATA)
    settings = "<QTM_Settings><The_6D><Body><Name>other</Name></Body></The_6D></QTM_Settings>"
    expect(master.ask(settings, XML) == "Setting parameters succeeded", "settings")
    expect(master.event() == b"\x0b", "a change of settings is told")
    root = ET.fromstring(master.ask("GetParameters 6D", answer=XML))
    expect([b.findtext("Name") for b in root.findall("The_6D/Body")] == ["other"], "the list was changed")
    expect(master.refused("<Broken", XML) == "Setting parameters failed", "settings that are no XML")
    watcher.close()
    master.close()


def check_clients(port):
    clients = [Client(port) for _ in range(10)]
    late = Client(port, version=None)
    expect(late.packet() == (ERROR, b"Connection refused. Max number of clients reached.\0"), "the eleventh client")
    expect(late.packet() is None, "and its connection is closed")
    for client in clients:
        expect(client.ask("ByteOrder").startswith("Byte order"), "ten are served")
        client.close()


def check_discovery(port, little):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", 0))
        udp.settimeout(5)
        udp.sendto(b"not a question", ("127.0.0.1", port))
        udp.sendto(struct.pack("<II", 10, 7) + struct.pack(">H", udp.getsockname()[1]), ("127.0.0.1", port))
        answer = udp.recv(65536)
    size, kind = struct.unpack_from("<II", answer)
    expect((size, kind) == (len(answer), 1), "size and type of the answer")
    info, (base,) = answer[8:-2], struct.unpack(">H", answer[-2:])
    expect(info.endswith(b"\0") and info.count(b",") == 2, f"host, version and cameras: {info}")
    expect(info.split(b",")[2].split()[0].isdigit(), "the third part begins with the number of cameras")
    expect(base + 1 == little, "the base port is told")


def main():
    server = subprocess.Popen([sys.argv[1], "60"], stdout=subprocess.PIPE, text=True)
    try:
        little, big, discovery = (int(word) for word in server.stdout.readline().split()[-3:])
        check_discovery(discovery, little)
        check_frames(little, "<")
        check_frames(big, ">")
        check_xml(little)
        check_clients(little)
        check_control(little)
    finally:
        server.terminate()
        server.wait()
    print(f"ok {checks} checks")


main()
