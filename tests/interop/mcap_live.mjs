// `motionlab record` beside a live simulated laboratory, its file under other people's readers; and what `motionlab replay` makes of
// it in a domain without a gateway.
//   mcap_live.mjs MOTIONLAB INTEROP_MCAP_DUMP MOTIONLAB_GATEWAY MOTIONLAB_SIM
import strict from "node:assert/strict";
import path from "node:path";
import process from "node:process";

import { Child, Laboratory, domain, eventually, file, judge } from "./console/support.mjs";
import { agree } from "./mcap_agree.mjs";

const [hand, dump] = process.argv.slice(2);
const lab = await Laboratory.make();
const run = (...args) => new Child(hand, ["--domain", String(domain), "--interface", "127.0.0.1", ...args]);
const folder = path.dirname(lab.gatewayFile);
const recording = path.join(folder, "live.mcap");
let gateway, simulator, seen;

async function good(child) {
  strict.equal(await child.ended, 0, child.output);
  return child.output;
}

await judge({
  "a laboratory is recorded from its first word": async () => {
    const configuration = file("lab.toml", "[control]\n");
    const recorder = run("record", "-o", recording, "--config", configuration);
    simulator = lab.startSimulator("--scenario", "sea");
    gateway = lab.startGateway();
    for (const topic of ["mru", "bodies", "arm_state", "winch_state", "estimate", "timing"])
      await good(run("echo", topic, "--once", "--timeout", "100"));
    await new Promise((resolve) => setTimeout(resolve, 3000));
    recorder.process.kill("SIGINT");
    await good(recorder);
  },
  "other people's readers agree with ours on every value": async () => {
    seen = await agree(dump, recording);
    for (const topic of ["mru", "bodies", "arm_state", "winch_state", "estimate", "control", "mode", "health", "timing", "event"]) {
      strict.ok(seen.messages.some((message) => message.topic === `motionlab/${topic}`), `a message of ${topic}`);
    }
    strict.ok(seen.messages.some((message) => message.topic === "truth/world"));
    strict.deepEqual(seen.attachments.map((attachment) => attachment.name), ["gateway.toml", "lab.toml"]);
  },
  "the file has its origin and a ledger of every topic": async () => {
    const entries = (name) => seen.metadata.filter((entry) => entry.name === name).map((entry) => Object.fromEntries(entry.metadata));
    strict.equal(entries("motionlab/recording").length, 1);
    strict.ok(entries("motionlab/recording")[0].version);
    const ledger = entries("motionlab/losses");
    strict.deepEqual(ledger.map((entry) => entry.topic).sort(), [...seen.topics].sort());
    for (const entry of ledger) {
      strict.equal(Number(entry.messages), seen.messages.filter((message) => message.topic === entry.topic).length, entry.topic);
      strict.equal(entry.lost_in_queue, "0", entry.topic);
    }
    const devices = entries("motionlab/wire").map((entry) => entry.device);
    for (const device of ["mru1", "mru2", "qualisys", "arm", "winch"]) strict.ok(devices.includes(device), device);
  },
  "motionlab verify finds it whole": async () => {
    const answer = JSON.parse(await good(run("verify", recording, "--json")));
    strict.equal(answer.whole, true);
    strict.equal(answer.messages, seen.messages.length);
  },
  "nothing of it is said while the gateway lives": async () => {
    const refused = run("replay", recording);
    strict.equal(await refused.ended, 1);
    strict.match(refused.output, /a gateway lives in domain/);
  },
  "it is said again when the gateway is gone, and comes back with the same bytes": async () => {
    await gateway.stop("SIGKILL");
    await simulator.stop();
    const again = path.join(folder, "again.mcap");
    await eventually("the domain is empty", async () => (await run("topics", "--wait", "1").ended) === 2);
    const recorder = run("record", "-o", again);
    await good(run("replay", recording, "--speed", "0.7"));
    recorder.process.kill("SIGINT");
    await good(recorder);
    const known = new Set(seen.messages.map((message) => message.topic + JSON.stringify(message.sample)));
    const heard = (await agree(dump, again)).messages;
    for (const message of heard) strict.ok(known.has(message.topic + JSON.stringify(message.sample)), message.topic);
    const asked = ["motionlab/mode_request", "motionlab/reference", "motionlab/arm_command", "motionlab/winch_command"];
    strict.ok(!heard.some((message) => asked.includes(message.topic)), "nobody is asked for anything");
    const expected = seen.messages.filter((message) => !asked.includes(message.topic)).length;
    console.log(`${heard.length} of ${expected} heard again`);
    strict.ok(heard.length > expected / 2, "best effort: some may be lost on a busy machine, not most");
  },
});
