"""A cable between two network namespaces that does to frames what netem does, for kernels that have no sch_netem.

Two Ethernet devices (TAP), one in each namespace, and a thread that carries frames from one to the other: late, twice, out of
order or not at all. The same seed gives the same dice, though not the same frames.
"""
import dataclasses
import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import threading
import time

TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
LONGEST_FRAME = 2048


@dataclasses.dataclass(frozen=True)
class Impairment:
    """Of each frame, in both directions. Shares are probabilities."""

    loss: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0  # uniform, ± this: a frame may overtake another
    reorder: float = 0.0  # share that is not delayed: it overtakes those that are
    duplicate: float = 0.0


class Wire:
    """Devices called `name` in both namespaces. The namespaces' owner sets addresses, and sets them up and down."""

    def __init__(self, name, namespaces, seed=1):
        self.impairment = Impairment()
        self.passed = self.lost = 0
        self._dice = random.Random(seed)
        self._ends = [self._open(f"{name}{i}", name, namespace) for i, namespace in enumerate(namespaces)]
        self._over = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @staticmethod
    def _open(drawn, name, namespace):
        end = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH22x", drawn.encode(), IFF_TAP | IFF_NO_PI))
        subprocess.run(["ip", "link", "set", drawn, "netns", namespace, "name", name], check=True)
        return end

    def close(self):
        self._over = True
        self._thread.join()
        for end in self._ends:
            os.close(end)

    def _run(self):
        late, order = [], 0
        while not self._over:
            wait_s = max(0.0, late[0][0] - time.monotonic()) if late else 0.05
            for end in select.select(self._ends, [], [], min(wait_s, 0.05))[0]:
                frame = self._read(end)
                other = self._ends[1 - self._ends.index(end)]
                for due in self._dues(time.monotonic()) if frame else ():
                    heapq.heappush(late, (due, order, other, frame))
                    order += 1
            while late and late[0][0] <= time.monotonic():
                _, _, end, frame = heapq.heappop(late)
                self._write(end, frame)

    def _dues(self, now):
        """When a frame that came now goes on: never, once or twice."""
        how = self.impairment
        copies = 2 if self._dice.random() < how.duplicate else 1
        for _ in range(copies):
            if self._dice.random() < how.loss:
                self.lost += 1
                continue
            self.passed += 1
            at_once = self._dice.random() < how.reorder
            late_s = 0.0 if at_once else how.delay_s + how.jitter_s * self._dice.uniform(-1, 1)
            yield now + max(0.0, late_s)

    # A device that is down takes and gives nothing.
    @staticmethod
    def _read(end):
        try:
            return os.read(end, LONGEST_FRAME)
        except OSError:
            time.sleep(0.001)
            return None

    @staticmethod
    def _write(end, frame):
        try:
            os.write(end, frame)
        except OSError:
            pass
