// A stranger's client and a stranger's decoder read every topic from the console, and agree with what was published,
// value by value. So does the page's own decoder.
import omgidl from '@foxglove/omgidl-parser';
import serialization from '@foxglove/omgidl-serialization';
import {parseIdl, readCdr} from '../../../gateway/console/page/cdr.js';
import {assert, connect, eventually, judge, Laboratory, startPeer, urlOf} from './support.mjs';

// One form for both: 64-bit integers as text, typed arrays as lists.
const plain = value => typeof value === 'bigint' ? String(value)
    : ArrayBuffer.isView(value) ? [...value].map(plain)
    : Array.isArray(value) ? value.map(plain)
    : value && typeof value === 'object' ? Object.fromEntries(Object.entries(value).map(([key, one]) => [key, plain(one)]))
    : value;
const text = sample => JSON.stringify(plain(sample));

const lab = await Laboratory.make();
const peer = startPeer('samples');
const server = lab.startConsole();
const topics = 17;
let client;
const readers = new Map(), seen = new Map();

await judge({
  'a stranger is told of every topic': async () => {
    const url = await urlOf(server);
    client = connect(url);
    await eventually('every topic is advertised', () => client.channels.size === topics + 1);
    assert(client.info.name === 'motionlab-console', 'the console says its name');
    assert(client.info.capabilities.length === 0, 'a console that only shows takes no messages');
    for (const channel of client.channels.values()) {
      if (channel.topic === 'console/state') continue;
      assert(channel.encoding === 'cdr' && channel.schemaEncoding === 'omgidl', `${channel.topic} is CDR with an IDL`);
    }
  },
  'a stranger understands every schema': () => {
    for (const channel of client.channels.values()) {
      if (channel.encoding !== 'cdr') continue;
      const reader = new serialization.MessageReader(channel.schemaName, omgidl.parseIDL(channel.schema));
      readers.set(client.subscribe(channel.id), {channel, reader, fields: parseIdl(channel.schema, channel.schemaName)});
    }
    assert(readers.size === topics, 'all of them');
  },
  'every sample is what was published, to a stranger and to the page': async () => {
    const known = new Map();
    await eventually('the peer has printed what it publishes', () => peer.json.length === 5 * topics);
    for (const {topic, sample} of peer.json) {
      if (!known.has(topic)) known.set(topic, new Set());
      known.get(topic).add(text(sample));
    }
    let wrong = null;
    client.on('message', ({subscriptionId, data, timestamp}) => {
      const {channel, reader, fields} = readers.get(subscriptionId);
      const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
      const read = text(reader.readMessage(bytes));
      if (!known.get(channel.topic).has(read)) wrong ??= `${channel.topic}: ${read}`;
      // Ours gives names where theirs gives numbers: both name the same sample if all else agrees.
      const ours = readCdr(fields, bytes);
      const theirs = reader.readMessage(bytes);
      for (const field of fields) {
        const same = field.kind === 'enum' ? field.names[theirs[field.name]] === ours[field.name]
            : text({x: ours[field.name]}) === text({x: theirs[field.name]});
        if (!same) wrong ??= `${channel.topic}.${field.name}: ours ${ours[field.name]}, theirs ${theirs[field.name]}`;
      }
      if (timestamp < 1_600_000_000_000_000_000n) wrong ??= `${channel.topic} has no time of receipt`;
      if (!seen.has(channel.topic)) seen.set(channel.topic, new Set());
      seen.get(channel.topic).add(read);
    });
    await eventually('five different samples of every topic', () => {
      if (wrong) throw new Error(`this was never published, or is read in two ways: ${wrong}`);
      return seen.size === topics && [...seen.values()].every(samples => samples.size === 5);
    });
  },
  'who no longer wants a topic gets none of it': async () => {
    const [id, {channel}] = [...readers].find(([, {channel}]) => channel.topic === 'motionlab/mru');
    client.unsubscribe(id);
    seen.clear();
    await eventually('others go on', () => (seen.get('motionlab/estimate')?.size ?? 0) >= 3);
    seen.clear();
    await eventually('others go on', () => (seen.get('motionlab/estimate')?.size ?? 0) >= 3);
    assert(!seen.has(channel.topic), 'none of the unsubscribed');
  },
  'who comes late is told the states and the last events': async () => {
    peer.process.kill('SIGSTOP');  // from now on nothing new comes
    try {
      const late = connect(await urlOf(server));
      await eventually('the late one is told of the topics', () => late.channels.size === topics + 1);
      const got = new Map();
      const wanted = ['motionlab/mode', 'motionlab/health', 'motionlab/event'];
      const ids = new Map(wanted.map(topic => [late.subscribe(late.channels.get(topic).id), topic]));
      late.on('message', ({subscriptionId}) => {
        const topic = ids.get(subscriptionId);
        got.set(topic, (got.get(topic) ?? 0) + 1);
      });
      await eventually('mode, health of five devices, events', () =>
        got.get('motionlab/mode') === 1 && got.get('motionlab/health') === 5 && got.get('motionlab/event') >= 5);
      late.close();
    } finally {
      peer.process.kill('SIGCONT');
    }
  },
  'a topic that nobody writes any more goes': async () => {
    let gone = [];
    client.on('unadvertise', ids => { gone = gone.concat(ids); });
    await peer.stop();
    // The console itself writes requests and references; all else is gone.
    await eventually('the topics are unadvertised', () => gone.length === topics - 2);
    client.close();
  },
  'the console ends when it is told to': async () => {
    assert(await server.stop() === 0, `exit code ${server.code}: ${server.output}`);
  },
});
