// The console serves its page and nothing else, to those who may have it, and says clearly what is wrong with its options.
import http from 'node:http';
import net from 'node:net';
import WebSocket from 'ws';
import {assert, Child, consoleProgram, eventually, file, judge, Laboratory, startPeer, subprotocol, urlOf} from './support.mjs';

const lab = await Laboratory.make();
const server = lab.startConsole('--allow-origin', 'https://app.example.org');
let url;

// A request as it stands, without a library that tidies the path.
const ask = (path, {method = 'GET', headers = {}} = {}) => new Promise((resolve, reject) => {
  const {hostname, port} = new URL(url);
  const request = http.request({hostname, port, path, method, headers}, answer => {
    const parts = [];
    answer.on('data', part => parts.push(part));
    answer.on('end', () => resolve({status: answer.statusCode, headers: answer.headers, body: Buffer.concat(parts).toString()}));
  });
  request.on('error', reject);
  request.end();
});

// How an upgrade is answered: 101 or the status of the refusal.
const upgrade = (options, protocols = [subprotocol]) => new Promise(resolve => {
  const socket = new WebSocket(url.replace('http', 'ws'), protocols, options);
  socket.on('open', () => { socket.close(); resolve(101); });
  socket.on('unexpected-response', (_, answer) => resolve(answer.statusCode));
  socket.on('error', () => resolve(0));
});

const refused = async (sentence, args, ...words) => {
  const child = new Child(consoleProgram, args);
  await child.ended;
  assert(child.code !== 0, `${sentence}: it started`);
  for (const word of words) assert(child.output.includes(word), `${sentence}: its words lack "${word}": ${child.output}`);
};

await judge({
  'every file of the page is there, with its type and the rules for browsers': async () => {
    url = await urlOf(server);
    const page = await ask('/');
    assert(page.status === 200 && page.headers['content-type'] === 'text/html; charset=utf-8', 'the page');
    const policy = page.headers['content-security-policy'];
    assert(policy.includes("default-src 'none'") && policy.includes("script-src 'self'") && !policy.includes('unsafe'), 'a strict policy');
    assert(page.headers['x-content-type-options'] === 'nosniff', 'types are not guessed');
    assert(!/<script(?![^>]*\bsrc=)|\son\w+=|\sstyle=/.test(page.body), 'no script or style within the page');
    const seen = new Set();
    const look = async path => {
      if (seen.has(path)) return;
      seen.add(path);
      const answer = await ask(path);
      assert(answer.status === 200, `${path} is there`);
      const type = {js: 'text/javascript', css: 'text/css', svg: 'image/svg+xml'}[path.split('.').pop()];
      assert(answer.headers['content-type'].startsWith(type), `${path} is ${type}`);
      if (!path.endsWith('.js')) return;
      for (const [, name] of answer.body.matchAll(/^(?:import|export)[^;]*?from\s+'(\.[^']+)'/gm)) await look(new URL(name, `http://x${path}`).pathname);
    };
    for (const [, name] of page.body.matchAll(/(?:src|href)="([\w/.]+\.(?:js|css|svg))"/g)) await look(`/${name}`);
    assert(seen.has('/vendor/three.core.js') && seen.has('/vendor/uPlot.esm.js') && seen.has('/scene.js'), `all modules: ${[...seen]}`);
    assert(!/https?:\/\/(?!www\.w3\.org)/.test(page.body), 'the page needs nothing from elsewhere');
  },
  'the laboratory is told as the gateway has it': async () => {
    const answer = await ask('/config.json');
    const config = JSON.parse(answer.body);
    assert(config.arm.reach_m === 2.2692 && config.control === false, 'the arm');
    assert(config.stale_after_s.arm === 1.0, 'overlays are laid over');
  },
  'an unchanged file is not sent again': async () => {
    const first = await ask('/scene.js');
    assert(first.headers['cache-control'] === 'no-cache', 'browsers ask each time');
    const again = await ask('/scene.js', {headers: {'If-None-Match': first.headers.etag}});
    assert(again.status === 304 && again.body === '', 'not modified');
    const head = await ask('/scene.js', {method: 'HEAD'});
    assert(head.status === 200 && head.body === '' && Number(head.headers['content-length']) === Buffer.byteLength(first.body), 'HEAD');
  },
  'no path leads out of the page': async () => {
    for (const path of ['/../../../../etc/passwd', '/%2e%2e/%2e%2e/etc/passwd', '//etc/passwd', '/vendor/../../CMakeLists.txt', '/etc/passwd',
                        '/vendor', '/vendor/', '/.', '/..', '/index.html/', '/package.json', '/\\..\\x', '/%00', '/app.js%00.html']) {
      assert((await ask(path)).status === 404, `${path} is not there`);
    }
  },
  'nothing is written by HTTP': async () => {
    for (const method of ['POST', 'PUT', 'DELETE', 'PATCH', 'OPTIONS']) assert((await ask('/', {method})).status === 405, method);
    assert((await ask('/settle')).status === 405, 'a link does not settle');
  },
  'names that were bent to our address are not ours': async () => {
    assert((await ask('/', {headers: {Host: 'evil.example:8080'}})).status === 421, 'a page');
    assert(await upgrade({headers: {Host: 'evil.example'}}) === 421, 'a WebSocket');
    assert((await ask('/', {headers: {Host: 'localhost:1'}})).status === 200, 'localhost');
  },
  'pages from elsewhere neither look on nor settle': async () => {
    assert(await upgrade({origin: 'https://evil.example'}) === 403, 'a stranger');
    assert(await upgrade({origin: 'null'}) === 403, 'a frame without origin');
    assert(await upgrade({origin: 'https://app.example.org'}) === 101, 'an allowed one');
    assert(await upgrade({origin: 'http://localhost:3000'}) === 101, 'one of this machine');
    assert(await upgrade({}) === 101, 'no browser');
    assert(await upgrade({}, ['chat']) === 400, 'another protocol');
    assert((await ask('/settle', {method: 'POST', headers: {Origin: 'https://evil.example'}})).status === 403, 'settle');
  },
  'anyone may settle, and is told whether somebody listens': async () => {
    const before = await ask('/settle', {method: 'POST'});
    assert(before.status === 503 && before.body.includes('no gateway'), before.body);
    const peer = startPeer('requests');
    await eventually('the request comes again and again', async () => {
      await ask('/settle', {method: 'POST'});
      return peer.json.some(({topic, sample}) => topic === 'motionlab/mode_request' && sample.action === 0 && sample.requester.startsWith('console@'));
    });
    await eventually('the console hears the gateway', async () => (await ask('/settle', {method: 'POST'})).status === 200);
    await peer.stop();
  },
  'rubbish does not end it': async () => {
    const {hostname, port} = new URL(url);
    const throwAt = bytes => new Promise(resolve => {
      const socket = net.connect(Number(port), hostname, () => socket.end(bytes));
      socket.on('close', resolve);
      socket.on('error', resolve);
      socket.resume();
    });
    await throwAt('\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03');
    await throwAt(`GET / HTTP/1.1\r\nHost: ${'x'.repeat(40_000)}\r\n\r\n`);
    await throwAt('POST /settle HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n');
    await throwAt('GET / HTTP/1.1\r\n\r\n');
    const socket = new WebSocket(url.replace('http', 'ws'), [subprotocol]);
    await new Promise(resolve => socket.on('open', resolve));
    const answers = [];
    socket.on('message', (data, binary) => { if (!binary) answers.push(JSON.parse(data)); });
    for (const text of ['', '{', '[]', '{"op":1}', '{"op":"subscribe"}', '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]}',
                        '{"op":"subscribe","subscriptions":[{"id":1,"channelId":999}]}', '{"op":"fetchAsset","uri":"file:///etc/passwd"}',
                        '{"op":"motionlab/authorize","token":""}', '['.repeat(20_000)]) socket.send(text);
    for (const bytes of [[], [1], [9, 0, 0, 0, 0], [1, 7, 0, 0, 0, 1, 2, 3]]) socket.send(Uint8Array.from(bytes));
    await eventually('each is answered', () => answers.filter(({op}) => op === 'status').length === 13 &&
      answers.some(({op, granted}) => op === 'motionlab/authorized' && granted === false));
    socket.terminate();
    assert((await ask('/')).status === 200, 'it still serves');
  },
  'wrong options are refused with what to do': async () => {
    const readable = file('readable', 'a-token-of-many-letters\n', 0o644), short = file('short', 'abc\n');
    const good = file('token', 'a-token-of-many-letters\n');
    const run = (...args) => ['--listen', '127.0.0.1:0', ...lab.gatewayArgs, ...args];
    await refused('a word that it does not know', ['--colour'], '--colour');
    await refused('an address that is none', ['--listen', 'here', ...lab.gatewayArgs], 'here');
    await refused('a port in use', ['--listen', new URL(url).host, ...lab.gatewayArgs], 'in use', '--listen');
    await refused('no configuration', ['--config', '/nowhere/lab.toml'], '/nowhere/lab.toml');
    await refused('a token that all can read', run('--control', '--token-file', readable), 'chmod 600');
    await refused('a short token', run('--control', '--token-file', short), '16');
    await refused('no token file', run('--control', '--token-file', '/nowhere/token'), '/nowhere/token');
    await refused('a token without control', run('--token-file', good), '--control');
    await refused('a token that would stand in a log', run('--control'), 'no terminal', '--token-file');
    await refused('control of other machines without a token', ['--listen', '0.0.0.0:0', ...lab.gatewayArgs, '--control'], '--token-file');
  },
  'a page for other machines is possible, and said': async () => {
    const wide = new Child(consoleProgram, ['--listen', '0.0.0.0:0', ...lab.gatewayArgs]);
    await urlOf(wide);
    await eventually('it warns', () => wide.output.includes('can look on'));
    assert(await wide.stop() === 0, 'it ends');
  },
});
