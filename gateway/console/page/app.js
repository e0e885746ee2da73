// Ties the page together: one connection, one picture of the laboratory, drawn every frame.
import {Connection} from './connection.js';
import {Controls} from './controls.js';
import {Events} from './events.js';
import {HealthBoard, seconds} from './health.js';
import {Lab} from './lab.js';
import {Plots} from './plots.js';
import {Scene} from './scene.js';
import {momentary, Score} from './score.js';

const by = id => document.getElementById(id);
const modeLimitS = 2.5;  // it comes once a second
const sampleLimitS = 0.5;
const wanted = ['console/state', 'motionlab/mode', 'motionlab/health', 'motionlab/event', 'motionlab/estimate', 'motionlab/control',
                'motionlab/arm_state', 'motionlab/winch_state', 'motionlab/reference', 'motionlab/score', 'truth/world'];

const config = await (await fetch('config.json')).json();
const lab = new Lab();
const events = new Events(by('events'), by('no-events'));
const connection = new Connection(`${location.origin.replace(/^http/, 'ws')}/`, wanted, 30);
connection.addEventListener('sample', ({detail}) => {
  if (detail.topic === 'motionlab/event') events.accept(detail.sample);
  else lab.accept(detail);
});
new Controls(connection, config);

const scene = new Scene(by('scene'), config);
const score = new Score(by('score'));
const board = new HealthBoard(by('tiles'));

const fresh = (topic, take) => () => {
  const sample = lab.fresh(topic, sampleLimitS);
  const value = sample ? take(sample) : null;
  return value === null || !Number.isFinite(value) ? null : value;
};
const now = key => () => momentary(lab, config)[key];
const degrees = 180 / Math.PI;
const age = key => fresh('motionlab/control', control => control[key] < 0 ? null : 1000 * control[key]);
const plots = new Plots(by('plots'), [
  {title: 'Swing', unit: 'deg', digits: 2, least: 0.5, series: [
    {label: 'load', colour: '--load', value: now('swing')},
    {label: 'without', colour: '--twin', dash: true, value: now('twinSwing')}]},
  {title: 'Load error', unit: 'mm', digits: 1, least: 20, series: [
    {label: 'load', colour: '--load', value: now('error')},
    {label: 'without', colour: '--twin', dash: true, value: now('twinError')}]},
  {title: 'Joints', unit: 'deg from home', digits: 1, least: 2, series: [0, 1, 2].map(i => (
    {label: `${i + 1}`, colour: `--series-${i + 1}`,
     value: fresh('motionlab/arm_state', arm => arm.q_rad[i] * degrees + (i === 2 ? 90 : 0))}))},
  {title: 'Wire', unit: 'm', digits: 3, least: 0.02, series: [
    {label: 'length', colour: '--series-1', value: fresh('motionlab/winch_state', winch => winch.wire_length_m)}]},
  {title: 'Ages', unit: 'ms', digits: 1, least: 20, series: [
    {label: 'mru', colour: '--series-1', value: age('age_mru_s')},
    {label: 'bodies', colour: '--series-2', value: age('age_bodies_s')},
    {label: 'arm', colour: '--series-3', value: age('age_arm_s')},
    {label: 'winch', colour: '--load', value: age('age_winch_s')}]},
], () => lab.now());

function showMode() {
  const newest = lab.newest('motionlab/mode');
  const mode = newest && newest.age <= modeLimitS ? newest.sample : null;
  const root = by('mode');
  root.dataset.state = mode ? mode.state : 'stale';
  root.querySelector('.state').textContent = mode ? mode.state : newest ? `stale ${seconds(newest.age)}` : 'no gateway';
  root.querySelector('.reason').textContent = mode ? mode.reason
      : newest ? `It was ${newest.sample.state}; nothing was heard since. Is the gateway running?` : 'Nothing was heard of a gateway yet.';
  by('authority').textContent = mode ? mode.authority : '–';
  by('owner').textContent = mode ? mode.owner || 'nobody' : '–';
}

function showLink() {
  const late = lab.age('console/state');
  const link = by('link');
  const state = !connection.connected ? 'lost' : late > 2 ? 'slow' : 'live';
  link.dataset.state = state;
  link.textContent = state === 'live' ? 'live' : state === 'slow' ? `silent ${seconds(late)}` : 'lost, trying again';
  by('missed').textContent = connection.missed;
}

function showVeil() {
  const veil = by('veil');
  const late = Math.min(lab.age('motionlab/estimate'), lab.age('truth/world'));
  const blind = scene.source === null;
  document.querySelector('.stage').classList.toggle('stale', blind);
  veil.hidden = !blind;
  if (blind) {
    veil.textContent = Number.isFinite(late) && late > sampleLimitS ? `stale ${seconds(late)}`
        : Number.isFinite(late) ? 'the gateway does not know where things are yet' : 'nothing is heard of the laboratory';
  }
  by('source').textContent = blind ? '' : `drawn from the ${scene.source}`;
  by('fps').textContent = `${scene.fps.toFixed(0)} fps`;
}

const frameMs = 1000 / 30;  // as often as there is something new
let slowly = 0, drawn = 0;
function frame() {
  requestAnimationFrame(frame);
  const here = performance.now();
  if (here - drawn < frameMs - 4) return;
  drawn = here;
  scene.tick(lab);
  plots.tick();
  if (here - slowly < 100) return;
  slowly = here;
  score.tick(lab, config);
  board.update(lab);
  showMode();
  showLink();
  showVeil();
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  by('theme').textContent = theme === 'dark' ? 'light' : 'dark';
  scene.recolour();
  plots.recolour();
}
const preferred = matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark';
setTheme(localStorage.getItem('theme') ?? preferred);
function turnTheme() {
  const theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  localStorage.setItem('theme', theme);
  setTheme(theme);
}

by('theme').onclick = turnTheme;
by('help-button').onclick = () => by('help').showModal();
for (const button of document.querySelectorAll('[data-view]')) button.onclick = () => scene.view(Number(button.dataset.view));
addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest('input, select, dialog')) return;
  if (event.key === '?') by('help').showModal();
  if (event.key === 't') turnTheme();
  if (/^[1-4]$/.test(event.key)) scene.view(Number(event.key));
});
requestAnimationFrame(frame);
