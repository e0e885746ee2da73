"""The smaller fault matrix: gateway and laboratory as processes with a bad network between them.

    matrix.py BUILD_FOLDER

The simulated laboratory lives in one network namespace, the gateway in another; between them lies a cable that loses, delays,
reorders and doubles what passes, or is unplugged. In each case the gateway, engaged in a sea, either goes on within its limits
or comes to rest, latches and says why; and nothing moves again by itself when the network is well. Prints one line for each
case. Needs root, `ip` and /dev/net/tun; says so and ends with 77 where there is none.
"""
import contextlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from wire import Impairment, Wire

HERE = pathlib.Path(__file__).resolve().parents[2]
LAB, GATEWAY = f"motionlab-lab-{os.getpid()}", f"motionlab-gw-{os.getpid()}"
LAB_ADDRESS, GATEWAY_ADDRESS = "10.77.0.1", "10.77.0.2"
BAD_S, GOOD_S = 5.0, 3.0  # how long the network is bad, and watched after that
REST_RADPS, REST_M = 2e-3, 2e-3

WORLD = f"""
[devices.mru1]
from = "{LAB_ADDRESS}:50013"
to = "{GATEWAY_ADDRESS}:50043"
[devices.mru2]
from = "{LAB_ADDRESS}:50014"
to = "{GATEWAY_ADDRESS}:50044"
[devices.qualisys]
listen = "{LAB_ADDRESS}:22223"
[devices.arm]
listen = "{LAB_ADDRESS}:50032"
[devices.winch]
listen = "{LAB_ADDRESS}:48898"
"""
# Fresh for longer than in the laboratory: a machine that runs tests stands still now and then.
GATEWAY_OVERLAY = f"""
[mru1]
listen = "{GATEWAY_ADDRESS}:50043"
source = "{LAB_ADDRESS}"
stale_after_s = 0.25
[mru2]
listen = "{GATEWAY_ADDRESS}:50044"
source = "{LAB_ADDRESS}"
stale_after_s = 0.25
[qualisys]
server = "{LAB_ADDRESS}:22223"
listen = "{GATEWAY_ADDRESS}:50199"
stale_after_s = 0.25
[comau]
robot_computer = "{LAB_ADDRESS}:50032"
listen = "{GATEWAY_ADDRESS}:50042"
stale_after_s = 0.25
[winch]
plc = "{LAB_ADDRESS}:48898"
stale_after_s = 0.25
[deadman]
heartbeat_s = 0.5
control_s = 1.0
"""

CASES = {
    "loss 30 %": Impairment(loss=0.3),
    "delay 50 ms ± 20 ms": Impairment(delay_s=0.05, jitter_s=0.02),
    "reorder 25 %": Impairment(delay_s=0.01, reorder=0.25),
    "duplicate 30 %": Impairment(duplicate=0.3),
    "link down, up": None,
}


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, **options)


def inside(namespace, *command):
    return ["ip", "netns", "exec", namespace, *map(str, command)]


class Samples:
    """The samples of one topic, as `motionlab echo` writes them, with the time at which each was read."""

    def __init__(self, namespace, hand, topic, fields):
        select = [word for field in fields for word in ("--field", field)]
        self._file = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            inside(namespace, hand, "--timeout", 60, "echo", topic, "--json", *select),
            stdout=self._file, stderr=subprocess.DEVNULL)

    def end(self):
        self._process.terminate()
        self._process.wait()
        self._file.seek(0)
        lines = self._file.read().splitlines()
        return [json.loads(line) for line in lines if line.endswith("}")]


class Bench:
    def __init__(self, build, folder):
        self._stack = contextlib.ExitStack()
        self.hand = build / "gateway/monitor/motionlab"
        (folder / "world.toml").write_text(WORLD)
        (folder / "gateway.toml").write_text(GATEWAY_OVERLAY)
        config = HERE / "deploy/config"
        self._make_network()
        self._start(folder / "sim.log", LAB, build / "simulators/lab/sim/motionlab-sim", "--config", config / "world.toml",
                    "--overlay", folder / "world.toml", "--scenario", "sea")
        self._start(folder / "gateway.log", GATEWAY, build / "gateway/service/program/motionlab-gateway", "--config",
                    config / "lab.toml", "--overlay", config / "loopback.toml", "--overlay", folder / "gateway.toml")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stack.close()

    def _make_network(self):
        for namespace, address in ((LAB, LAB_ADDRESS), (GATEWAY, GATEWAY_ADDRESS)):
            if run("ip", "netns", "add", namespace).returncode:
                skip("no network namespace can be made here")
            self._stack.callback(run, "ip", "netns", "del", namespace)
            run("ip", "-n", namespace, "link", "set", "lo", "up", check=True)
        self.wire = Wire("lab", (LAB, GATEWAY))
        self._stack.callback(self.wire.close)
        for namespace, address in ((LAB, LAB_ADDRESS), (GATEWAY, GATEWAY_ADDRESS)):
            run("ip", "-n", namespace, "address", "add", f"{address}/24", "dev", "lab", check=True)
        self.plug(True)

    def _start(self, log, namespace, *command):
        with open(log, "w") as output:
            process = subprocess.Popen(inside(namespace, *command), stdout=output, stderr=output)
        self._stack.callback(process.wait)
        self._stack.callback(process.terminate)

    def plug(self, up):
        """Both ends: unplugged is what each of them sees."""
        for namespace in (LAB, GATEWAY):
            run("ip", "-n", namespace, "link", "set", "lab", "up" if up else "down", check=True)

    def worsen(self, impairment):
        if impairment is None:
            self.plug(False)
        else:
            self.wire.impairment = impairment

    def mend(self):
        self.wire.impairment = Impairment()
        self.plug(True)

    def mode(self):
        answer = run(*inside(GATEWAY, self.hand, "--json", "status"))
        return json.loads(answer.stdout)["mode"] if answer.stdout else None

    def ask(self, *words):
        return run(*inside(GATEWAY, self.hand, "--timeout", 30, *words))

    def engage(self):
        """Stands still now and then, as the machine does: then once more."""
        for _ in range(4):
            self.ask("reset")
            self.ask("engage", "--wait", "30")
            time.sleep(1.5)
            mode = self.mode()
            if mode and mode["state"] == "engaged":
                return True
        return False

    def watch(self, impairment):
        """Modes, commands and joints while the network is bad and after it."""
        taps = (Samples(GATEWAY, self.hand, "mode", ()),
                Samples(GATEWAY, self.hand, "control", ("t_snapshot_ns", "qd_command_radps", "wire_speed_command_mps")),
                Samples(LAB, self.hand, "truth/world", ("t_ns", "q_rad", "wire_length_m")))
        time.sleep(1.0)
        self.worsen(impairment)
        time.sleep(BAD_S)
        self.mend()
        time.sleep(GOOD_S)
        return [tap.end() for tap in taps]


def beyond_limits(control, limits):
    """Commands that are too fast, or change faster than the time between two of them allows."""
    beyond = 0
    for before, after in zip(control, control[1:]):
        dt = 1e-9 * (after["t_snapshot_ns"] - before["t_snapshot_ns"])
        for i, (a, b) in enumerate(zip(before["qd_command_radps"], after["qd_command_radps"])):
            beyond += abs(b) > limits["qd"][i] + 1e-9 or abs(b - a) > limits["qdd"][i] * dt + 1e-9
        a, b = before["wire_speed_command_mps"], after["wire_speed_command_mps"]
        beyond += abs(b) > limits["wire"] + 1e-9 or abs(b - a) > limits["wire_acceleration"] * dt + 1e-9
    return beyond


def moved_at_the_end(truth, last_s):
    """How far anything went in the last seconds."""
    tail = [sample for sample in truth if sample["t_ns"] >= truth[-1]["t_ns"] - 1e9 * last_s]
    joints = max(max(q) - min(q) for q in zip(*(sample["q_rad"] for sample in tail)))
    lengths = [sample["wire_length_m"] for sample in tail]
    return joints, max(lengths) - min(lengths)


def judge(modes, control, truth, limits):
    """What became of it, and what is wrong with that."""
    wrong = []
    if not control or not truth or not modes:
        return "nothing was heard", ["nothing was heard of mode, control or truth"]
    states = [mode["state"] for mode in modes]
    left = next((i for i, state in enumerate(states) if state != "engaged"), None)
    if beyond := beyond_limits(control, limits):
        wrong.append(f"{beyond} commands beyond the limits")
    if left is None:
        return "goes on", wrong
    last = modes[-1]
    if "engaged" in states[left:]:
        wrong.append("it engaged by itself")
    if last["state"] != "fault" or not last["fault_code"] or not last["reason"]:
        wrong.append(f"it does not say why it stopped: {last['state']} {last['fault_code']} {last['reason']}")
    joints, wire = moved_at_the_end(truth, GOOD_S / 2)
    if joints > REST_RADPS or wire > REST_M:
        wrong.append(f"it does not rest: joints {joints:.4f} rad, wire {wire:.4f} m")
    if any(control[-1]["qd_command_radps"]) or control[-1]["wire_speed_command_mps"]:
        wrong.append("it is commanded to move")
    return f"rests, {last['fault_code']}", wrong


def limits_of(build):
    """Those in force, as the gateway prints them."""
    import tomllib
    with open(HERE / "deploy/config/lab.toml", "rb") as file:
        limits = tomllib.load(file)["limits"]
    degree = 3.141592653589793 / 180
    brake = limits["stop_deceleration_radps2"]
    return {"qd": [degree * v for v in limits["qd_max_degps"]], "qdd": [max(a, brake) for a in limits["qdd_max_radps2"]],
            "wire": limits["wire_speed_max_mps"], "wire_acceleration": limits["wire_acceleration_max_mps2"]}


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    if os.geteuid() != 0:
        skip("only root can make network namespaces")
    if not shutil.which("ip"):
        skip("ip is not here")
    if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        skip("/dev/net/tun is not here: no cable can be laid between two namespaces")
    limits, bad = limits_of(build), 0
    with tempfile.TemporaryDirectory() as folder, Bench(build, pathlib.Path(folder)) as bench:
        for name, impairment in CASES.items():
            if not bench.engage():
                wrong, became = [f"it could not be engaged: {bench.mode()}"], "never begun"
            else:
                became, wrong = judge(*bench.watch(impairment), limits)
            bad += bool(wrong)
            print(f"{'not ok' if wrong else 'ok'} {name}: {became}" + "".join(f"; {what}" for what in wrong), flush=True)
        if bad:
            for log in ("gateway.log", "sim.log"):
                print(f"--- {log}\n" + (pathlib.Path(folder) / log).read_text()[-4000:])
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
