// A tile for each device: who is late is seen at a glance, by word, sign and place, not by colour alone.

const reasons = ['too short', 'too long', 'bad header', 'bad checksum', 'bad value', 'foreign', 'duplicate',
                 'out of order', 'unexpected', 'refused', 'transport'];
const silentAfterS = 1.0;  // health itself comes ten times a second
const signs = {up: '●', late: '▲', connecting: '◌', stale: '◼', down: '✕', unheard: '?'};
const words = {up: 'up', late: 'late', connecting: 'connecting', stale: 'stale', down: 'down', unheard: 'stale'};

export const seconds = s => !Number.isFinite(s) ? '–' : s < 1 ? `${(1000 * s).toFixed(s < 0.0995 ? 1 : 0)} ms`
    : s < 90 ? `${s.toFixed(1)} s` : `${(s / 60).toFixed(0)} min`;

// What to say of a device: its health's own word, unless its health is old or its age nears the limit.
export function condition(health, age) {
  if (age > silentAfterS) return 'unheard';
  if (health.link === 'up' && health.stale_after_s > 0 && health.age_s > 0.6 * health.stale_after_s) return 'late';
  return health.link;
}

export class HealthBoard {
  #tiles = new Map();
  constructor(parent) { this.parent = parent; }

  update(lab) {
    for (const device of lab.instances('motionlab/health')) {
      const {sample, age} = lab.newest('motionlab/health', device) ?? {};
      if (sample) this.#show(device, sample, age);
    }
    this.parent.classList.toggle('empty', this.#tiles.size === 0);
  }

  #show(device, health, age) {
    if (!this.#tiles.has(device)) this.#tiles.set(device, this.#make(device));
    const tile = this.#tiles.get(device);
    const now = condition(health, age);
    const dataAge = health.age_s < 0 ? Infinity : health.age_s + Math.max(age, 0);
    tile.root.dataset.state = now;
    tile.sign.textContent = signs[now] ?? '?';
    tile.word.textContent = (words[now] ?? now) + (health.required ? '' : ' · not required');
    const dead = now === 'unheard' || now === 'stale' || now === 'down';
    tile.age.textContent = seconds(dead ? dataAge : health.age_s < 0 ? Infinity : health.age_s);
    tile.rate.textContent = now === 'unheard' ? '–' : `${health.rate_hz.toFixed(0)} Hz`;
    tile.lost.textContent = health.lost.toString();
    const rejected = health.rejected.reduce((sum, count) => sum + count, 0n);
    tile.rejected.textContent = rejected.toString();
    // Who has no limit, as the gateway itself, has nothing to be measured against.
    const share = health.stale_after_s > 0 ? Math.max(health.age_s, 0) / health.stale_after_s : 0;
    tile.meter.value = dead ? 1 : Math.min(share, 1);
    const why = health.rejected.map((count, i) => count > 0n ? `${reasons[i] ?? i} ${count}` : '').filter(Boolean).join(', ');
    tile.advice.textContent = now === 'unheard' ? `Nothing was heard of it for ${seconds(age)}: is the gateway running?`
        : health.advice || (why && `rejected: ${why}`);
    tile.root.setAttribute('aria-label', `${device}: ${tile.word.textContent}, age ${tile.age.textContent}`);
  }

  #make(device) {
    const root = document.createElement('article');
    root.className = 'tile';
    root.tabIndex = 0;
    root.dataset.device = device;
    root.innerHTML = `
      <header><span class="sign" aria-hidden="true"></span><h3></h3><span class="word"></span></header>
      <div class="age"><output class="value"></output><meter min="0" max="1" low="0.6" high="0.95" optimum="0"
        title="age of the newest sample, against the limit"></meter></div>
      <dl><div><dt>rate</dt><dd class="rate"></dd></div><div><dt>lost</dt><dd class="lost"></dd></div>
      <div><dt>rejected</dt><dd class="rejected"></dd></div></dl><p class="advice"></p>`;
    root.querySelector('h3').textContent = device;
    const before = [...this.parent.querySelectorAll('.tile')].find(tile => tile.dataset.device > device);
    this.parent.insertBefore(root, before ?? null);
    const part = name => root.querySelector(name);
    return {root, sign: part('.sign'), word: part('.word'), age: part('.value'), meter: part('meter'), rate: part('.rate'),
            lost: part('.lost'), rejected: part('.rejected'), advice: part('.advice')};
  }
}
