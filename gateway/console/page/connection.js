// The Foxglove WebSocket protocol from the client's side, connected again whenever it is lost.
import {instanceOf, parseIdl, readCdr} from './cdr.js';

const retryAfterMs = 1000;

export class Connection extends EventTarget {
  // `wanted`: topics to subscribe to, or null for all. `hz`: at most so many samples of each instance a second.
  constructor(url, wanted, hz) {
    super();
    this.url = `${url}?hz=${hz}`;
    this.wanted = wanted;
    this.control = false;
    this.authorized = false;
    this.missed = 0;
    this.#open();
  }

  get connected() { return this.socket.readyState === WebSocket.OPEN; }

  authorize(token) { this.#say({op: 'motionlab/authorize', token}); }

  // A message on one of the topics that the console takes: "motionlab/mode_request", "motionlab/reference".
  publish(topic, value) {
    if (!this.connected) return;
    let id = this.published.get(topic);
    if (!id) {
      id = this.published.size + 1;
      this.published.set(topic, id);
      this.#say({op: 'advertise', channels: [{id, topic, encoding: 'json', schemaName: topic}]});
    }
    const json = new TextEncoder().encode(JSON.stringify(value));
    const bytes = new Uint8Array(5 + json.length);
    bytes[0] = 1;
    new DataView(bytes.buffer).setUint32(1, id, true);
    bytes.set(json, 5);
    this.socket.send(bytes);
  }

  #open() {
    this.channels = new Map();
    this.subscriptions = new Map();
    this.published = new Map();
    this.authorized = false;
    this.socket = new WebSocket(this.url, ['foxglove.websocket.v1']);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.#tell('connection');
    this.socket.onmessage = message =>
        typeof message.data === 'string' ? this.#text(JSON.parse(message.data)) : this.#binary(message.data);
    this.socket.onclose = () => {
      this.#tell('connection');
      setTimeout(() => this.#open(), retryAfterMs);
    };
  }

  #say(message) { if (this.connected) this.socket.send(JSON.stringify(message)); }
  #tell(type, detail) { this.dispatchEvent(new CustomEvent(type, {detail})); }

  #text(message) {
    switch (message.op) {
      case 'serverInfo':
        this.control = message.capabilities.includes('clientPublish');
        this.#tell('connection');
        break;
      case 'advertise':
        this.#subscribe(message.channels);
        break;
      case 'unadvertise':
        for (const id of message.channelIds) this.#forget(id);
        break;
      case 'status':
        if (message.missed) this.missed = message.missed;
        this.#tell('status', message);
        break;
      case 'motionlab/authorized':
        this.authorized = message.granted;
        this.#tell('authorized', message.granted);
        break;
    }
  }

  #subscribe(channels) {
    const subscriptions = [];
    for (const channel of channels) {
      if (this.wanted && !this.wanted.includes(channel.topic)) continue;
      this.#forget(channel.id);
      const fields = channel.encoding === 'cdr' ? parseIdl(channel.schema, channel.schemaName) : null;
      this.channels.set(channel.id, {...channel, fields});
      this.subscriptions.set(channel.id, channel.id);
      subscriptions.push({id: channel.id, channelId: channel.id});
    }
    this.#say({op: 'subscribe', subscriptions});
  }

  #forget(channel) {
    this.channels.delete(channel);
    this.subscriptions.delete(channel);
  }

  #binary(buffer) {
    const view = new DataView(buffer);
    if (view.getUint8(0) !== 1) return;
    const channel = this.channels.get(view.getUint32(1, true));
    if (!channel) return;
    const tNs = view.getBigUint64(5, true);
    const payload = new Uint8Array(buffer, 13);
    const sample = channel.fields ? readCdr(channel.fields, payload) : JSON.parse(new TextDecoder().decode(payload));
    const instance = channel.fields ? instanceOf(channel.fields, sample) : '';
    this.#tell('sample', {topic: channel.topic, instance, sample, t: Number(tNs / 1000n) * 1e-6});
  }
}
