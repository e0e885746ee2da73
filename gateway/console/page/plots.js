// Curves of the last half minute. A value that is stale leaves a gap.
import uPlot from './vendor/uPlot.esm.js';

const windowS = 30;
const everyMs = 50;

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

class Plot {
  // series: [{label, colour (name of a CSS variable), dash, value: () => number|null}]
  constructor(parent, {title, unit, digits, series, least}) {
    this.series = series;
    this.now = 0;
    this.title = title;
    this.unit = unit;
    this.digits = digits;
    this.least = least;
    this.figure = document.createElement('figure');
    const caption = document.createElement('figcaption');
    caption.innerHTML = `<b></b><span class="unit"></span>`;
    caption.querySelector('b').textContent = title;
    caption.querySelector('.unit').textContent = unit;
    this.values = series.map(({label, colour, dash}) => {
      const item = document.createElement('span');
      item.className = `key ${dash ? 'dashed' : ''}`;
      item.style.setProperty('--ink', `var(${colour})`);
      item.append(label, ' ');
      const value = item.appendChild(document.createElement('output'));
      caption.append(item);
      return value;
    });
    this.box = document.createElement('div');
    this.box.className = 'curve';
    this.figure.append(caption, this.box);
    parent.append(this.figure);
    this.data = [[], ...series.map(() => [])];
    this.draw();
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  draw() {
    this.chart?.destroy();
    const axis = {stroke: css('--soft'), grid: {stroke: css('--line'), width: 1}, ticks: {show: false}, font: '11px system-ui'};
    this.chart = new uPlot({
      width: Math.max(this.box.clientWidth, 50), height: Math.max(this.box.clientHeight, 50),
      legend: {show: false}, cursor: {show: false}, padding: [6, 6, 0, 0],
      scales: {
        x: {time: false, range: () => [this.now - windowS, this.now]},
        y: {range: (_, low, high) => this.range(low, high)},
      },
      axes: [{...axis, size: 20, space: 60, values: (_, ticks) => ticks.map(t => `${Math.round(t - this.now)} s`),
              splits: () => [20, 10].map(back => this.now - back)},
             {...axis, size: 42, space: 26}],
      series: [{}, ...this.series.map(({label, colour, dash}) => ({
        label, stroke: css(colour), width: dash ? 1.5 : 2, dash: dash ? [4, 4] : undefined, spanGaps: false, points: {show: false},
      }))],
    }, this.data, this.box);
  }

  range(low, high) {
    if (low === null || high === null) return [0, this.least];
    const middle = (low + high) / 2, half = Math.max((high - low) / 2, this.least / 2) * 1.08;
    return low >= 0 && low < half ? [0, Math.max(high * 1.08, this.least)] : [middle - half, middle + half];
  }

  resize() { this.chart.setSize({width: this.box.clientWidth, height: this.box.clientHeight}); }

  sample(now) {
    this.now = now;
    this.data[0].push(now);
    this.series.forEach(({value}, i) => {
      const got = value();
      this.data[i + 1].push(got);
      this.values[i].textContent = got === null ? '–' : got.toFixed(this.digits);
      this.values[i].classList.toggle('none', got === null);
    });
    let old = 0;
    while (this.data[0][old] < now - windowS) ++old;
    if (old) this.data.forEach(column => column.splice(0, old));
  }

  show() { this.chart.setData(this.data); }
}

export class Plots {
  constructor(parent, descriptions, now) {
    this.now = now;
    this.plots = descriptions.map(description => new Plot(parent, description));
    this.last = 0;
    this.odd = false;
  }
  // Every frame; samples twenty times a second and draws ten times.
  tick() {
    const here = performance.now();
    if (here - this.last < everyMs) return;
    this.last = here;
    this.odd = !this.odd;
    for (const plot of this.plots) {
      plot.sample(this.now());
      if (this.odd) plot.show();
    }
  }
  recolour() { for (const plot of this.plots) plot.draw(); }
}
