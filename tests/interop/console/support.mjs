// What the tests of the console share: programs as children, a laboratory of their own, strangers' clients.
import {spawn} from 'node:child_process';
import dgram from 'node:dgram';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import net from 'node:net';
import {tmpdir} from 'node:os';
import path from 'node:path';
import process from 'node:process';
import foxglove from '@foxglove/ws-protocol';
import WebSocket from 'ws';

export const source = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../../..');
// Where the programs are: given by CTest, in this order.
export const [consoleProgram, peerProgram, gatewayProgram, simulatorProgram] = process.argv.slice(2);
export const subprotocol = 'foxglove.websocket.v1';
const patienceMs = 60_000;  // a loaded machine is slow, not wrong

export function assert(holds, sentence) {
  if (!holds) throw new Error(sentence);
}
export const pause = ms => new Promise(resolve => setTimeout(resolve, ms));

// Looks again and again until `look` gives something.
export async function eventually(sentence, look, ms = patienceMs) {
  const end = Date.now() + ms;
  for (;;) {
    const got = await look();
    if (got) return got;
    if (Date.now() > end) throw new Error(`not within ${ms / 1000} s: ${sentence}`);
    await pause(50);
  }
}

const children = [];
export class Child {
  constructor(program, args, options = {}) {
    this.output = '';
    this.name = path.basename(program);
    this.process = spawn(program, args, {stdio: ['pipe', 'pipe', 'pipe'], ...options});
    for (const stream of [this.process.stdout, this.process.stderr]) stream.on('data', data => { this.output += data; });
    this.ended = new Promise(resolve => this.process.on('exit', (code, signal) => { this.code = code ?? signal; resolve(this.code); }));
    children.push(this);
  }
  get running() { return this.code === undefined; }
  get lines() { return this.output.split('\n').slice(0, -1); }
  get json() { return this.lines.filter(line => line.startsWith('{')).map(line => JSON.parse(line)); }
  async stop(signal = 'SIGTERM') {
    this.process.stdin.end();
    if (this.running) this.process.kill(signal);
    return this.ended;
  }
}

const folder = mkdtempSync(path.join(tmpdir(), 'motionlab-console-'));
export function file(name, text, mode = 0o600) {
  const where = path.join(folder, name);
  writeFileSync(where, text, {mode});
  return where;
}

// Ports that are free now, all different.
async function ports(kinds) {
  const held = await Promise.all(kinds.map(kind => new Promise((resolve, reject) => {
    const socket = kind === 'udp' ? dgram.createSocket('udp4') : net.createServer();
    socket.on('error', reject);
    if (kind === 'udp') socket.bind(0, '127.0.0.1', () => resolve(socket));
    else socket.listen(0, '127.0.0.1', () => resolve(socket));
  })));
  const numbers = held.map(socket => socket.address().port);
  await Promise.all(held.map(socket => new Promise(resolve => socket.close(resolve))));
  return numbers;
}

export const domain = 85 + process.pid % 5;  // tests/support/own_domain.hpp has those below
const config = name => path.join(source, 'deploy/config', name);

export class Laboratory {
  static async make() {
    const lab = new Laboratory();
    const udp = ['mru1', 'mru2', 'mru1_from', 'mru2_from', 'frames', 'arm', 'robot'], tcp = ['qtm', 'plc'];
    const numbers = await ports([...udp.map(() => 'udp'), ...tcp.map(() => 'tcp')]);
    const at = Object.fromEntries([...udp, ...tcp].map((name, i) => [name, `"127.0.0.1:${numbers[i]}"`]));
    // A shared machine may stand still for longer than any laboratory's limit.
    const limit = 'stale_after_s = 1.0\n';
    lab.gatewayFile = file('gateway.toml', `[bus]\ndomain = ${domain}\n[mru1]\nlisten = ${at.mru1}\n${limit}` +
      `[mru2]\nlisten = ${at.mru2}\n${limit}[qualisys]\nserver = ${at.qtm}\nlisten = ${at.frames}\n${limit}` +
      `[comau]\nrobot_computer = ${at.robot}\nlisten = ${at.arm}\n${limit}[winch]\nplc = ${at.plc}\n${limit}`);
    lab.worldFile = file('world.toml', `[bus]\ndomain = ${domain}\n[devices.mru1]\nfrom = ${at.mru1_from}\nto = ${at.mru1}\n` +
      `[devices.mru2]\nfrom = ${at.mru2_from}\nto = ${at.mru2}\n[devices.qualisys]\nlisten = ${at.qtm}\n` +
      `[devices.arm]\nlisten = ${at.robot}\n[devices.winch]\nlisten = ${at.plc}\n`);
    return lab;
  }
  get gatewayArgs() { return ['--config', config('lab.toml'), '--overlay', config('loopback.toml'), '--overlay', this.gatewayFile]; }
  startGateway() { return new Child(gatewayProgram, this.gatewayArgs); }
  startSimulator(...more) {
    return new Child(simulatorProgram, ['--config', config('world.toml'), '--overlay', this.worldFile, ...more]);
  }
  startConsole(...more) { return new Child(consoleProgram, ['--listen', '127.0.0.1:0', ...this.gatewayArgs, ...more]); }
}

export const startPeer = (verb, ...more) => new Child(peerProgram, [verb, String(domain), ...more]);

// Where the console says that it is.
export async function urlOf(child) {
  return eventually('the console says where it is', () => {
    if (!child.running) throw new Error(`${child.name} ended with ${child.code}: ${child.output}`);
    return child.output.match(/http:\/\/[\d.:]+\//)?.[0];
  });
}

// A stranger's client, connected.
export function connect(url, options = {}) {
  const client = new foxglove.FoxgloveClient({ws: new WebSocket(url.replace(/^http/, 'ws'), [subprotocol], options)});
  client.said = [];
  client.channels = new Map();
  client.on('status', status => client.said.push(status));
  client.on('advertise', channels => channels.forEach(channel => client.channels.set(channel.topic, channel)));
  client.on('serverInfo', info => { client.info = info; });
  client.on('error', error => { client.failure = error; });
  return client;
}

// Runs the steps, tells which failed, leaves nothing running.
export async function judge(steps) {
  let failed = 0;
  try {
    for (const [sentence, step] of Object.entries(steps)) {
      try {
        await step();
        console.log(`ok ${sentence}`);
      } catch (error) {
        ++failed;
        console.log(`not ok ${sentence}\n${error.stack}`);
        break;
      }
    }
  } finally {
    for (const child of children) {
      if (failed) console.log(`--- ${child.name}\n${child.output.slice(-3000)}`);
      await child.stop(child.name === 'motionlab-gateway' ? 'SIGKILL' : 'SIGTERM');
    }
    rmSync(folder, {recursive: true, force: true});
  }
  process.exit(failed ? 1 : 0);
}
