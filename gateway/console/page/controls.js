// What a person may ask. Settle is always there and needs nothing but HTTP; the rest needs the console's --control and
// its token, which is kept in memory only.

const by = id => document.getElementById(id);

export class Controls {
  #said = 0;
  constructor(connection, config) {
    this.connection = connection;
    by('settle').onclick = () => this.settle();
    by('engage').onclick = () => this.ask({action: 'engage'});
    by('reset').onclick = () => this.ask({action: 'reset'});
    by('set-authority').onclick = () => this.ask({action: 'authority', authority: by('ladder').value});
    by('ladder').value = 'limited';
    by('reference-form').onsubmit = event => {
      event.preventDefault();
      const p = ['x', 'y', 'z'].map(axis => Number(by(`ref-${axis}`).value));
      this.publish('motionlab/reference', {frame: 'world', p_world_load_m: p});
    };
    ['x', 'y', 'z'].forEach((axis, i) => { by(`ref-${axis}`).value = config.reference.p_world_load_m[i].toFixed(3); });
    by('token-form').onsubmit = event => {
      event.preventDefault();
      this.token = by('token').value.trim();
      by('token').value = '';
      connection.authorize(this.token);
    };
    connection.addEventListener('connection', () => this.show());
    connection.addEventListener('authorized', ({detail}) => this.answered(detail));
    connection.addEventListener('status', ({detail}) => this.say(detail.message, ['good', 'warn', 'bad'][detail.level]));
    addEventListener('keydown', event => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
      if (event.target.closest('input, select')) return;
      if (event.key === 's') this.settle();
      if (event.key === 'E' && connection.control) by('engage').click();
      if (event.key === 'R' && connection.control) by('reset').click();
    });
    this.show();
  }

  async settle() {
    try {
      const answer = await fetch('settle', {method: 'POST'});
      this.say((await answer.text()).trim(), answer.ok ? 'good' : 'bad');
    } catch {
      this.say('the console does not answer: settle was not sent. Use `motionlab settle`, or the stop button', 'bad');
    }
  }

  ask(request) { this.publish('motionlab/mode_request', request); }

  // The console judges, also what this page would not let through.
  publish(topic, value) {
    if (this.connection.connected) this.connection.publish(topic, value);
    else this.say('the console does not answer: nothing was sent', 'bad');
  }

  answered(granted) {
    if (granted) this.say('unlocked', 'good');
    else {
      this.token = undefined;
      this.say('this is not the token', 'bad');
    }
    this.show();
  }

  show() {
    const {control, authorized, connected} = this.connection;
    by('control').hidden = !control;
    by('token-form').hidden = authorized;
    by('hands').classList.toggle('locked', !authorized);
    if (connected && control && !authorized && this.token) this.connection.authorize(this.token);
  }

  say(text, kind) {
    const said = by('said');
    said.textContent = text;
    said.dataset.kind = kind;
    said.hidden = false;
    clearTimeout(this.#said);
    this.#said = setTimeout(() => { said.hidden = true; }, 6000);
  }
}
