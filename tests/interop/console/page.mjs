// A browser shows the simulated laboratory: the scene draws, curves move, a silent device and a dead gateway are seen at a
// glance, and the load hangs still after the right person pressed Engage.
//   page.mjs CONSOLE PEER GATEWAY SIMULATOR [FOLDER]     pictures go to FOLDER
import {mkdirSync} from 'node:fs';
import path from 'node:path';
import process from 'node:process';
import {chromium} from 'playwright-core';
import {assert, Child, consoleProgram, eventually, file, judge, Laboratory, startPeer, urlOf} from './support.mjs';

const pictures = process.argv[6];
if (pictures) mkdirSync(pictures, {recursive: true});
const browserPath = process.env.MOTIONLAB_CHROMIUM ?? '/usr/bin/chromium';
const token = 'the-token-of-the-browser-test';
const patienceMs = 180_000;

const lab = await Laboratory.make();
const simulator = lab.startSimulator('--scenario', 'thesis-wave');
let gateway = lab.startGateway();
const server = lab.startConsole('--control', '--token-file', file('token', `${token}\n`));
let browser, page;
const complaints = [];

const picture = async name => {
  if (!pictures) return;
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({path: path.join(pictures, `${name}.jpg`), type: 'jpeg', quality: 75});
};
const words = async selector => (await page.textContent(selector)).trim();
const mode = () => page.getAttribute('#mode', 'data-state');
const tile = device => page.getAttribute(`.tile[data-device="${device}"]`, 'data-state', {timeout: patienceMs});
const wait = (sentence, look, ms = patienceMs) => eventually(sentence, look, ms);
const said = text => wait(`the page says "${text}"`, async () => (await page.textContent('#said')).includes(text));

// How much there is to see on a canvas: the spread of its brightness, and of how many colours it consists.
const look = selector => page.evaluate(name => {
  const from = document.querySelector(name);
  const to = Object.assign(document.createElement('canvas'), {width: 160, height: 100});
  const context = to.getContext('2d');
  context.drawImage(from, 0, 0, 160, 100);
  const {data} = context.getImageData(0, 0, 160, 100);
  const grey = [], colours = new Set();
  for (let i = 0; i < data.length; i += 4) {
    grey.push((data[i] + data[i + 1] + data[i + 2]) / 3);
    colours.add((data[i] >> 3) << 10 | (data[i + 1] >> 3) << 5 | data[i + 2] >> 3);
  }
  const mean = grey.reduce((sum, value) => sum + value, 0) / grey.length;
  const spread = Math.sqrt(grey.reduce((sum, value) => sum + (value - mean) ** 2, 0) / grey.length);
  return {spread, colours: colours.size, picture: data.reduce((hash, value) => (hash * 31 + value) >>> 0, 7)};
}, selector);

// Whether scene and curves have been drawn at the size that the page has now.
const isSettled = () => page.evaluate(() => {
  const scene = document.querySelector('#scene');
  const fits = box => Math.abs(box.querySelector('canvas').clientWidth - box.clientWidth) <= 1;
  return Math.abs(scene.width / scene.height - scene.clientWidth / scene.clientHeight) < 0.02 &&
      [...document.querySelectorAll('.curve')].every(fits);
});

// The contrast of a text's colour with a background, as WCAG has it.
const contrast = (ink, paper) => page.evaluate(([a, b]) => {
  const light = name => {
    const probe = document.body.appendChild(document.createElement('i'));
    probe.style.color = `var(${name})`;
    const parts = getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map(value => {
      const c = value / 255;
      return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    });
    probe.remove();
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
  };
  const [x, y] = [light(a), light(b)];
  return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05);
}, [ink, paper]);

await judge({
  'the page opens, without a word of complaint': async () => {
    const url = await urlOf(server);
    browser = await chromium.launch({executablePath: browserPath, args: [
      '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
      '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage'], timeout: patienceMs});
    page = await browser.newPage({viewport: {width: 1440, height: 900}, colorScheme: 'dark'});
    page.setDefaultTimeout(patienceMs);
    page.on('console', message => { if (['error', 'warning'].includes(message.type())) complaints.push(message.text()); });
    page.on('pageerror', error => complaints.push(String(error)));
    const strangers = [];
    page.on('request', request => { if (!request.url().startsWith(url)) strangers.push(request.url()); });
    await page.goto(url);
    await page.waitForSelector('.tile');
    assert(strangers.length === 0, `it asks nobody else: ${strangers}`);
  },
  'every device has a tile that is up': async () => {
    for (const device of ['mru1', 'mru2', 'qualisys', 'arm', 'winch']) {
      await wait(`${device} is up`, async () => ['up', 'late'].includes(await tile(device)));
    }
    await wait('the gateway is ready', async () => await mode() === 'ready');
  },
  'the scene draws and moves': async () => {
    await wait('the scene is drawn from what is heard', async () => (await words('#source')).startsWith('drawn from'));
    const first = await look('#scene');
    assert(first.spread > 12 && first.colours > 60, `there is something to see: ${JSON.stringify(first)}`);
    await wait('it moves', async () => (await look('#scene')).picture !== first.picture);
    const shown = await words('#fps');
    console.log(`  ${shown} in software`);
  },
  'the curves move': async () => {
    assert(await page.locator('.curve canvas').count() === 5, 'five of them');
    for (let i = 0; i < 5; ++i) {
      await page.evaluate(n => document.querySelectorAll('.curve canvas')[n].id = `curve-${n}`, i);
      const first = await look(`#curve-${i}`);
      await wait(`curve ${i} moves`, async () => (await look(`#curve-${i}`)).picture !== first.picture);
    }
    await wait('each has a value', () => page.evaluate(() => document.querySelectorAll('figcaption output.none').length === 0));
  },
  'settle needs no token': async () => {
    await page.click('#settle');
    await said('settle was asked');
    await wait('the gateway gets ready again', async () => await mode() === 'ready');
  },
  'engage without a token is refused': async () => {
    await page.click('#engage');
    await said('show the token first');
    await page.fill('#token', 'a wrong token');
    await page.press('#token', 'Enter');
    await said('this is not the token');
    assert(!['engaged', 'stopping'].includes(await mode()), 'nothing was engaged');
  },
  'with the token it is engaged, and the load hangs still while the ghost swings': async () => {
    await page.fill('#token', token);
    await page.press('#token', 'Enter');
    await wait('unlocked', () => page.isHidden('#token-form'));
    assert(!(await page.content()).includes(token), 'the token stands nowhere in the page');
    const swings = () => page.evaluate(() => [...document.querySelectorAll('figcaption output')].slice(0, 2).map(output => Number(output.textContent)));
    // A machine that stands still for a second ends an engagement, as it should: then once more.
    let engagedAt = null, seen = [];
    await wait('engaged, and for four seconds the load swings a quarter as far as the ghost at most', async () => {
      const now = await mode(), t = Date.now();
      if (now !== 'engaged') [engagedAt, seen] = [null, []];
      if (now === 'fault') await page.keyboard.press('Shift+R');
      if (now === 'ready') await page.click('#engage');
      if (now !== 'engaged') return false;
      engagedAt ??= t;
      if (t - engagedAt > 25_000) await page.keyboard.press('s');  // the winch or the arm gave up and wants to be asked anew
      seen = [...seen.filter(one => one.t > t - 4000), {t, swings: await swings()}];
      const [load, ghost] = [0, 1].map(i => Math.max(...seen.map(one => one.swings[i])));
      return t - engagedAt > 6000 && seen.length >= 3 && ghost > 2 && load < 0.25 * ghost;
    }, 4 * patienceMs);
    await picture('engaged');
  },
  'a device that falls silent turns its tile stale': async () => {
    const peer = startPeer('fault', 'mru2', 'silent');
    await peer.ended;
    await wait('mru2 is stale, its neighbour is not', async () =>
      ['stale', 'down'].includes(await tile('mru2')) && ['up', 'late'].includes(await tile('mru1')));
    assert((await words('.tile[data-device="mru2"] .advice')).length > 10, 'it says what to look at');
    await picture('mru2-silent');
  },
  'keys do what the help says': async () => {
    await page.keyboard.press('?');
    await wait('the help is open', () => page.evaluate(() => document.querySelector('#help').open));
    await page.keyboard.press('Escape');
    const order = [];
    await page.evaluate(() => document.activeElement.blur());
    for (let i = 0; i < 45; ++i) {  // round the page once, from wherever it begins
      await page.keyboard.press('Tab');
      order.push(await page.evaluate(() => document.activeElement.id || document.activeElement.className || document.activeElement.dataset.view));
    }
    assert(order.join().includes('skip,settle,scene'), `what matters comes first: ${order}`);
    for (const one of ['engage', 'reset', 'ladder', 'theme', 'help-button', 'tile']) assert(order.includes(one), `${one} can be reached: ${order}`);
    const before = await look('#scene');
    await page.focus('#scene');
    await page.keyboard.press('2');
    await page.keyboard.press('ArrowLeft');
    await wait('the view turns', async () => (await look('#scene')).picture !== before.picture);
    await picture('load');
    await page.keyboard.press('1');
    await page.keyboard.press('s');
    await said('settle was asked');
    await wait('not engaged any more', async () => !['engaged', 'stopping'].includes(await mode()));
  },
  'it reads well on a tablet, by day and by night': async () => {
    await page.setViewportSize({width: 820, height: 1180});
    for (const theme of ['dark', 'light']) {
      if (await page.getAttribute('html', 'data-theme') !== theme) await page.click('#theme');
      await wait('the picture has the new size', isSettled);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert(wide <= 0, `nothing hangs over by ${wide} pixels`);
      for (const ink of ['--ink', '--soft', '--good', '--warn', '--bad', '--accent', '--load', '--twin', '--dead']) {
        const ratio = await contrast(ink, '--panel');
        assert(ratio >= (ink === '--dead' ? 3 : 4.5), `${theme}: ${ink} has a contrast of ${ratio.toFixed(1)}`);
      }
      assert(await contrast('--settle-ink', '--settle') >= 4.5, `${theme}: settle can be read`);
      await picture(`tablet-${theme}`);
    }
    await page.setViewportSize({width: 1440, height: 900});
    await wait('the picture is wide again', isSettled);
    await picture('light');
    await page.click('#theme');
  },
  'a dead gateway is stale, not still': async () => {
    await gateway.stop('SIGKILL');
    await wait('the mode is stale', async () => await mode() === 'stale');
    for (const device of ['mru1', 'arm', 'winch']) await wait(`${device} is stale`, async () => await tile(device) === 'unheard');
    await simulator.stop();
    await wait('so is the scene', () => page.isVisible('#veil'));
    await wait('its age is told', async () => /stale \d/.test(await words('#veil')));
    assert(await page.evaluate(() => getComputedStyle(document.querySelector('#scene')).filter.includes('grayscale')), 'it is grey');
    await picture('stale');
  },
  'and alive again when it is started again, without a reload': async () => {
    lab.startSimulator('--scenario', 'thesis-wave');
    gateway = lab.startGateway();
    await wait('up again', async () => ['up', 'late'].includes(await tile('arm')) && await mode() === 'ready');
    await wait('drawn again', () => page.isHidden('#veil'));
  },
  'a console that is started again is found again': async () => {
    const {port} = new URL(page.url());
    await server.stop();
    await wait('the page says so', async () => (await words('#link')).includes('lost'));
    const again = new Child(consoleProgram, ['--listen', `127.0.0.1:${port}`, ...lab.gatewayArgs]);
    await urlOf(again);
    await wait('live again', async () => await words('#link') === 'live');
    await wait('with what it shows', async () => await mode() === 'ready');
    assert(await page.isHidden('#control'), 'this one only shows');
  },
  'nobody complained': async () => {
    const real = complaints.filter(text => !/WebSocket connection|GPU stall|ERR_CONNECTION_REFUSED/.test(text));
    assert(real.length === 0, real.join('\n'));
    await browser.close();
  },
});
