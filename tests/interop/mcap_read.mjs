// Other people's readers against our recordings: @mcap/core reads the file, by its index and as a stream, and Foxglove's IDL and
// CDR packages decode every message by the schema in the file. Value by value the same as our own decoder says.
//   mcap_read.mjs INTEROP_MCAP_DUMP [FILE…]     without a file: records one
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, openSync, readFileSync, readSync, fstatSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import parser from "@foxglove/omgidl-parser";
import serialization from "@foxglove/omgidl-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

const [dump, ...given] = process.argv.slice(2);
const decompressHandlers = { zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size))) };

// The decoder of each channel, from the schema beside it.
function decoders() {
  const known = new Map();
  return (channel, schema) => {
    if (!known.has(channel.id)) {
      assert.equal(channel.messageEncoding, "cdr");
      assert.equal(schema.encoding, "omgidl");
      const definitions = parser.parseIDL(new TextDecoder().decode(schema.data));
      known.set(channel.id, new serialization.MessageReader(schema.name, definitions));
    }
    return known.get(channel.id);
  };
}

// As our decoder writes it: 64-bit numbers as texts, what is no number by name, typed arrays as lists.
function plain(value) {
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number" && !Number.isFinite(value)) {
    return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  }
  if (ArrayBuffer.isView(value) || Array.isArray(value)) return Array.from(value, plain);
  if (value !== null && typeof value === "object") {
    return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, plain(inner)]));
  }
  return value;
}

class File {
  constructor(path) {
    this.fd = openSync(path, "r");
  }
  async size() {
    return BigInt(fstatSync(this.fd).size);
  }
  async read(offset, size) {
    const buffer = new Uint8Array(Number(size));
    assert.equal(readSync(this.fd, buffer, 0, Number(size), Number(offset)), Number(size));
    return buffer;
  }
}

const said = (channel, message, decoder) => ({
  topic: channel.topic,
  sequence: message.sequence,
  log_time: message.logTime.toString(),
  publish_time: message.publishTime.toString(),
  sample: plain(decoder.readMessage(message.data)),
});

async function byIndex(path) {
  const reader = await McapIndexedReader.Initialize({ readable: new File(path), decompressHandlers });
  const decoder = decoders();
  const messages = [];
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    messages.push(said(channel, message, decoder(channel, reader.schemasById.get(channel.schemaId))));
  }
  const attachments = [];
  for await (const attachment of reader.readAttachments()) attachments.push(attachment);
  const metadata = [];
  for await (const entry of reader.readMetadata()) metadata.push(entry);
  return { reader, messages, attachments, metadata };
}

function asStream(path) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(readFileSync(path));
  const decoder = decoders();
  const schemas = new Map(), channels = new Map(), messages = [];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type !== "Message") continue;
    const channel = channels.get(record.channelId);
    messages.push(said(channel, record, decoder(channel, schemas.get(channel.schemaId))));
  }
  assert.ok(reader.done(), "the stream has an end");
  assert.equal(reader.bytesRemaining(), 0);
  return messages;
}

async function judge(path) {
  const ours = execFileSync(dump, ["decode", path], { maxBuffer: 1 << 30 }).toString().trimEnd().split("\n").map(JSON.parse);
  const streamed = asStream(path);
  assert.equal(streamed.length, ours.length);
  ours.forEach((message, i) => assert.deepEqual(streamed[i], message, `message ${i}`));

  const { reader, messages, attachments, metadata } = await byIndex(path);
  // By the index they come in the order of time; ours is the file's, which the control thread wrote in order of time.
  const inOrder = (list) => [...list].sort((a, b) => (a.topic < b.topic ? -1 : a.topic > b.topic ? 1 : a.sequence - b.sequence));
  assert.deepEqual(inOrder(messages), inOrder(ours));
  assert.equal(reader.statistics.messageCount, BigInt(ours.length));
  const topics = [...reader.channelsById.values()].map((channel) => channel.topic).sort();
  for (const topic of ["snapshot", "estimate", "control", "arm_command", "winch_command", "mode", "event"]) {
    assert.ok(topics.includes(`motionlab/${topic}`), topic);
    assert.ok(ours.some((message) => message.topic === `motionlab/${topic}`), `a message of ${topic}`);
  }
  assert.equal(attachments.length, 1);
  assert.equal(attachments[0].name, "gateway.toml");
  assert.match(new TextDecoder().decode(attachments[0].data), /\[control\]/);
  assert.ok(metadata.some((entry) => entry.name === "motionlab/run" && entry.metadata.has("version")));
  console.log(`${path}: ${ours.length} messages on ${topics.length} channels, all agree`);
  return ours;
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
