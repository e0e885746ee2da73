// A recorded run of the control thread under other people's readers.
//   mcap_read.mjs INTEROP_MCAP_DUMP [FILE…]     without a file: records one
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { agree } from "./mcap_agree.mjs";

const [dump, ...given] = process.argv.slice(2);

async function judge(path) {
  const { messages, topics, attachments, metadata } = await agree(dump, path);
  for (const topic of ["snapshot", "estimate", "control", "arm_command", "winch_command", "mode", "event"]) {
    assert.ok(topics.includes(`motionlab/${topic}`), topic);
    assert.ok(messages.some((message) => message.topic === `motionlab/${topic}`), `a message of ${topic}`);
  }
  assert.equal(attachments.length, 1);
  assert.equal(attachments[0].name, "gateway.toml");
  assert.match(new TextDecoder().decode(attachments[0].data), /\[control\]/);
  assert.ok(metadata.some((entry) => entry.name === "motionlab/run" && entry.metadata.has("version")));
  return messages;
}

if (given.length > 0) {
  for (const path of given) await judge(path);
} else {
  const folder = mkdtempSync(join(tmpdir(), "motionlab-mcap-"));
  try {
    const path = join(folder, "run.mcap");
    execFileSync(dump, ["record", path], { stdio: ["ignore", "inherit", "inherit"] });
    const messages = await judge(path);
    // What was sent in at known times is there.
    const snapshots = messages.filter((message) => message.topic === "motionlab/snapshot").map((message) => message.sample);
    assert.equal(snapshots.length, 5000);
    snapshots.forEach((sample, i) => assert.equal(sample.sequence_number, String(i + 1)));
    const requests = snapshots.flatMap((sample) => sample.requests);
    assert.deepEqual(requests.map((request) => [request.requester, request.action]), [["lockstep", 1]]);
    const references = snapshots.flatMap((sample) => sample.references);
    assert.deepEqual(references.map((reference) => reference.requester), ['a "stranger"']);
    assert.deepEqual(references[0].p_world_load_m, [0.85, -0.4, "nan"]);
    for (const source of ["mru", "load", "platform", "arm", "winch", "second_mru"]) {
      assert.ok(snapshots.filter((sample) => sample[source].length === 1).length > 200, source);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
}
