// Ten watch at once; one that reads slowly costs a bounded amount of memory, keeps the newest and is told what it missed.
import {readFileSync} from 'node:fs';
import WebSocket from 'ws';
import {assert, connect, eventually, judge, Laboratory, pause, startPeer, subprotocol, urlOf} from './support.mjs';

const lab = await Laboratory.make();
const server = lab.startConsole();
const peer = startPeer('flood');
const residentKiB = () => Number(readFileSync(`/proc/${server.process.pid}/status`, 'utf8').match(/VmRSS:\s+(\d+)/)[1]);
let url;

await judge({
  'ten clients at once get what one gets': async () => {
    url = await urlOf(server);
    const clients = Array.from({length: 10}, () => connect(url));
    const counts = clients.map(() => new Map());
    clients.forEach((client, i) => {
      const topics = new Map();
      client.on('advertise', channels => channels.forEach(({id, topic}) => topics.set(client.subscribe(id), topic)));
      client.on('message', ({subscriptionId}) => {
        const topic = topics.get(subscriptionId);
        counts[i].set(topic, (counts[i].get(topic) ?? 0) + 1);
      });
    });
    await eventually('each has a thousand samples, some events and the console\'s own word', () =>
      counts.every(count => count.get('motionlab/mru') > 1000 && count.get('motionlab/event') > 3 && count.get('console/state') > 2));
    clients.forEach(client => client.close());
  },
  'who asks for thirty a second gets no more, and every event': async () => {
    const client = connect(`${url}?hz=30`);
    let mru = new Map(), events = [], at = {};
    client.on('advertise', channels => channels.forEach(({id, topic}) => {
      if (topic === 'motionlab/mru' || topic === 'motionlab/event') at[client.subscribe(id)] = topic;
    }));
    client.on('message', ({subscriptionId, data, timestamp}) => {
      const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
      if (at[subscriptionId] === 'motionlab/event') return events.push(bytes.readBigUInt64LE(4));
      const device = bytes.subarray(8, 12).toString();
      if (!mru.has(device)) mru.set(device, []);
      mru.get(device).push(Number(timestamp));
    });
    await eventually('a hundred samples of ten units, and events', () =>
      events.length > 20 && mru.size === 10 && [...mru.values()].every(times => times.length > 100));
    for (const [device, times] of mru) {
      const rate = 1e9 * (times.length - 1) / (times[times.length - 1] - times[0]);
      assert(rate < 40, `${device} comes ${rate.toFixed(0)} times a second`);
    }
    const missing = events.slice(1).filter((number, i) => number !== events[i] + 1n).length;
    assert(missing === 0, `${missing} gaps in ${events.length} events`);
    assert(client.said.length === 0, 'what was not wanted is not missed');
    client.close();
  },
  'a client that does not read costs no memory and is told what it missed': async () => {
    const slow = Array.from({length: 5}, () => new WebSocket(url.replace('http', 'ws'), [subprotocol]));
    const told = slow.map(() => []);
    await Promise.all(slow.map((socket, i) => new Promise(resolve => {
      socket.on('message', (data, binary) => {
        if (binary) return;
        const message = JSON.parse(data);
        if (message.op === 'advertise') {
          socket.send(JSON.stringify({op: 'subscribe', subscriptions: message.channels.map(({id}) => ({id, channelId: id}))}));
          resolve();
        } else if (message.op === 'status') told[i].push(message);
      });
    })));
    slow.forEach(socket => socket._socket.pause());
    const sample = [];
    await pause(3000);  // the kernel's buffers fill
    const settled = residentKiB();
    for (let i = 0; i < 10; ++i) {
      await pause(1000);
      sample.push(residentKiB());
    }
    const grown = Math.max(...sample) - settled;
    assert(grown < 8 * 1024, `memory grew by ${grown} KiB in ten seconds: ${settled}, then ${sample}`);
    console.log(`  resident ${settled} KiB, then ${sample.join(' ')}`);
    slow.forEach(socket => socket._socket.resume());
    await eventually('each is told', () => told.every(statuses => statuses.some(({missed, message}) => missed > 100 && message.includes('motionlab/mru'))));
    slow.forEach(socket => socket.terminate());
  },
  'nothing is left of those who went': async () => {
    const client = connect(url);
    let alone = false;
    client.on('advertise', channels => channels.filter(({topic}) => topic === 'console/state').forEach(({id}) => client.subscribe(id)));
    client.on('message', ({data}) => { alone = JSON.parse(Buffer.from(data.buffer, data.byteOffset, data.byteLength).toString()).clients === 1; });
    await eventually('one is watching', () => alone);
    client.close();
    await peer.stop();
    assert(await server.stop() === 0, 'the console ends');
  },
});
