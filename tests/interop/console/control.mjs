// Only who shows the token moves anything, and the token is nowhere to be read.
import WebSocket from 'ws';
import {assert, connect, eventually, file, judge, Laboratory, pause, startPeer, subprotocol, urlOf} from './support.mjs';

const token = 'this-is-the-token-of-this-test';
const lab = await Laboratory.make();
const peer = startPeer('requests');
const shows = lab.startConsole();
const server = lab.startConsole('--control', '--token-file', file('token', `${token}\n`));
const action = {settle: 0, engage: 1, reset: 2, authority: 3};
const asked = (topic, holds) => peer.json.filter(line => line.topic === topic && holds(line.sample));

// A stranger's client that publishes JSON.
function hand(url, options) {
  const client = connect(url, options);
  const mine = new Map();
  client.publish = (topic, value) => {
    if (!mine.has(topic)) mine.set(topic, client.advertise({topic, encoding: 'json', schemaName: topic}));
    client.sendMessage(mine.get(topic), new TextEncoder().encode(JSON.stringify(value)));
  };
  client.told = words => eventually(`it is told "${words}", not only ${JSON.stringify(client.said)}`,
    () => client.said.some(({message}) => message.includes(words)));
  client.ready = () => eventually('the gateway is heard', () => client.channels.has('motionlab/mode'));
  return client;
}

// A socket that shows a token in its first message. @returns what it is told
async function show(url, given) {
  const socket = new WebSocket(url.replace('http', 'ws'), [subprotocol]);
  const answer = await new Promise((resolve, reject) => {
    socket.on('error', reject);
    socket.on('open', () => socket.send(JSON.stringify({op: 'motionlab/authorize', token: given})));
    socket.on('message', (data, binary) => {
      const message = binary ? {} : JSON.parse(data);
      if (message.op === 'motionlab/authorized') resolve(message.granted);
    });
  });
  socket.terminate();
  return answer;
}

let url, client;
await judge({
  'a console that only shows takes nothing, whoever asks': async () => {
    const shown = await urlOf(shows);
    const watcher = hand(shown, {headers: {Authorization: `Bearer ${token}`}});
    await watcher.ready();
    watcher.publish('motionlab/mode_request', {action: 'engage'});
    await watcher.told('--control');
    assert(await show(shown, '') === false && await show(shown, token) === false, 'there is no token to show');
    watcher.close();
  },
  'without the token nothing is taken': async () => {
    url = await urlOf(server);
    const stranger = hand(url);
    await stranger.ready();
    assert(stranger.info.capabilities.includes('clientPublish') && stranger.info.supportedEncodings.includes('json'), 'it offers control');
    stranger.publish('motionlab/mode_request', {action: 'engage'});
    await stranger.told('show the token first');
    stranger.close();
  },
  'a wrong token opens nothing, the right one does': async () => {
    for (const wrong of ['', 'x', token.slice(1), `${token}x`, token.toUpperCase(), token + token]) {
      assert(await show(url, wrong) === false, `"${wrong}" is wrong`);
    }
    assert(await show(url, token) === true, 'the token');
    const wrong = hand(url, {headers: {Authorization: `Bearer ${token}x`}});
    await wrong.ready();
    wrong.publish('motionlab/mode_request', {action: 'engage'});
    await wrong.told('show the token first');
    wrong.close();
    const inAddress = hand(`${url}?token=${token}`);
    await inAddress.ready();
    inAddress.publish('motionlab/mode_request', {action: 'engage'});
    await inAddress.told('show the token first');
    inAddress.close();
    await pause(500);
    assert(asked('motionlab/mode_request', () => true).length === 0, 'nothing of all that has reached DDS');
  },
  'who has the token asks, in the name of the console': async () => {
    client = hand(url, {headers: {Authorization: `Bearer ${token}`}});
    await client.ready();
    await eventually('the request arrives', async () => {
      client.publish('motionlab/mode_request', {action: 'engage', requester: 'somebody else', sequence_number: 1});
      await pause(200);
      return asked('motionlab/mode_request', sample => sample.action === action.engage).length > 0;
    });
    for (const {sample} of asked('motionlab/mode_request', () => true)) {
      assert(sample.requester.startsWith('console@'), 'who asks is said by the console');
      assert(BigInt(sample.sequence_number) > 1_600_000_000_000_000_000n, 'and numbered by it');
    }
    client.publish('motionlab/mode_request', {action: 'authority', authority: 'limited'});
    await eventually('authority', () => asked('motionlab/mode_request', sample => sample.action === action.authority && sample.authority === 2).length);
    client.publish('motionlab/reference', {frame: 'world', p_world_load_m: [0.5, -0.25, 4]});
    await eventually('a reference', () => asked('motionlab/reference', sample => sample.p_world_load_m.join() === '0.5,-0.25,4').length);
    client.publish('motionlab/mode_request', {action: 'settle'});
    await eventually('settle, more than once', () => asked('motionlab/mode_request', sample => sample.action === action.settle).length > 3);
    const numbers = new Set(asked('motionlab/mode_request', sample => sample.action === action.settle).map(({sample}) => sample.sequence_number));
    assert(numbers.size === 1, 'repetitions are told by their number');
  },
  'what makes no sense is refused with a reason': async () => {
    const before = asked('motionlab/reference', () => true).length;
    for (const [topic, value, words] of [
      ['motionlab/mode_request', {action: 'fly'}, 'settle, engage, reset, authority'],
      ['motionlab/mode_request', {}, 'no action'],
      ['motionlab/mode_request', {action: 'engage', colour: 'red'}, 'there are only'],
      ['motionlab/mode_request', [], 'no JSON object'],
      ['motionlab/reference', {p_world_load_m: [1, 2]}, 'no list of 3'],
      ['motionlab/reference', {p_world_load_m: [1, 2, null]}, 'no number'],
      ['motionlab/reference', {frame: 'world'}, 'no p_world_load_m'],
      ['motionlab/arm_command', {follow: true}, 'not published from here'],
    ]) {
      client.said.length = 0;
      client.publish(topic, value);
      await client.told(words);
    }
    assert(asked('motionlab/reference', () => true).length === before, 'none has reached DDS');
    client.close();
  },
  'the token is in no output and in no answer': async () => {
    for (const path of ['', 'config.json', 'app.js', 'controls.js']) {
      assert(!(await (await fetch(url + path)).text()).includes(token), `not in /${path}`);
    }
    await server.stop();
    assert(!server.output.includes(token), 'not in what the console printed');
  },
});
