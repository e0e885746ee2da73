// What happened, newest first: a sentence and what to do.

const most = 60;
const signs = {info: '●', warning: '▲', fault: '✕'};

export class Events {
  #seen = new Set();
  constructor(list, nothing) { Object.assign(this, {list, nothing}); }

  // The console tells the last events again to whoever comes back: each is shown once.
  accept(event) {
    const key = `${event.t_ns} ${event.source} ${event.sequence_number}`;
    if (this.#seen.has(key)) return;
    this.#seen.add(key);
    this.nothing.hidden = true;
    const item = document.createElement('li');
    item.dataset.severity = event.severity;
    item.t = event.t_ns;
    const part = (name, text) => {
      const span = item.appendChild(document.createElement('span'));
      span.className = name;
      span.textContent = text;
    };
    part('sign', signs[event.severity] ?? '');
    part('time', new Date(Number(event.t_ns / 1000000n)).toLocaleTimeString([], {hour12: false}));
    part('source', event.source);
    part('text', event.text);
    if (event.advice) part('advice', event.advice);
    const later = [...this.list.children].find(other => other.t <= event.t_ns);
    this.list.insertBefore(item, later ?? null);
    while (this.list.children.length > most) this.list.lastChild.remove();
  }
}
