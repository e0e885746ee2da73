// Other people's readers and ours over one recording: @mcap/core reads the file, by its index and as a stream, and Foxglove's IDL
// and CDR packages decode every message by the schema in the file. Value by value the same as our own decoder says.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { openSync, readFileSync, readSync, fstatSync } from "node:fs";

import parser from "@foxglove/omgidl-parser";
import serialization from "@foxglove/omgidl-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

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

// Everything in the file, once our decoder and theirs agree on it.
//   dump   the program interop_mcap_dump
export async function agree(dump, path) {
  const ours = execFileSync(dump, ["decode", path], { maxBuffer: 1 << 30 }).toString().trimEnd().split("\n").map(JSON.parse);
  const streamed = asStream(path);
  assert.equal(streamed.length, ours.length);
  ours.forEach((message, i) => assert.deepEqual(streamed[i], message, `message ${i}`));

  const { reader, messages, attachments, metadata } = await byIndex(path);
  // By the index they come in the order of time, in the file as they were heard.
  const inOrder = (list) => [...list].sort((a, b) => (a.topic < b.topic ? -1 : a.topic > b.topic ? 1 : a.sequence - b.sequence));
  assert.deepEqual(inOrder(messages), inOrder(ours));
  assert.equal(reader.statistics.messageCount, BigInt(ours.length));
  const topics = [...reader.channelsById.values()].map((channel) => channel.topic).sort();
  console.log(`${path}: ${ours.length} messages on ${topics.length} channels, all agree`);
  return { messages: ours, topics, attachments, metadata };
}
