// How still the load is, as one number.

const ownWindowS = 10;
const scoreLimitS = 3;  // it comes once a second
const sampleLimitS = 0.5;

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
const degrees = rad => Math.hypot(...rad) * 180 / Math.PI;
const rms = values => values.length ? Math.sqrt(values.reduce((sum, v) => sum + v * v, 0) / values.length) : null;

// The load's place that is wanted: the last reference in the world, or the configured one.
export function wantedPlace(lab, config) {
  const reference = lab.newest('motionlab/reference')?.sample;
  return reference && reference.frame === 'world' ? reference.p_world_load_m : config.reference.p_world_load_m;
}

// Swing and error of the load and of its uncontrolled twin now; null where nothing fresh tells.
export function momentary(lab, config) {
  const estimate = lab.fresh('motionlab/estimate', sampleLimitS);
  const truth = lab.fresh('truth/world', sampleLimitS);
  const wanted = wantedPlace(lab, config);
  const load = truth ?? (estimate?.valid ? estimate : null);
  return {
    swing: load ? degrees(load.swing_rad) : null,
    error: load ? 1000 * distance(load.p_world_load_m, wanted) : null,
    twinSwing: truth ? degrees(truth.twin_swing_rad) : null,
    twinError: truth ? 1000 * distance(truth.p_world_twin_load_m, config.reference.p_world_load_m) : null,
    source: truth ? 'truth' : load ? 'estimate' : null,
  };
}

export class Score {
  #own = [];
  constructor(root) {
    this.part = name => root.querySelector(name);
    this.root = root;
  }

  tick(lab, config) {
    const now = lab.now(), moment = momentary(lab, config);
    if (moment.error !== null) this.#own.push({t: now, ...moment});
    while (this.#own.length && this.#own[0].t < now - ownWindowS) this.#own.shift();
    const live = lab.fresh('motionlab/score', scoreLimitS);
    const own = key => rms(this.#own.map(entry => entry[key]).filter(value => value !== null));
    const fresh = moment.error !== null;
    const shown = live && live.duration_s > 0 ? {
      error: 1000 * live.load_error_rms_norm_m, swing: live.swing_rms_deg,
      twinError: 1000 * live.baseline_load_error_rms_norm_m, twinSwing: live.baseline_swing_rms_deg,
      note: `rms of ${live.duration_s.toFixed(0)} s, from the ${live.from_truth ? 'truth' : 'estimate'}`,
    } : fresh ? {error: own('error'), swing: own('swing'), twinError: own('twinError'), twinSwing: own('twinSwing'),
                 note: `rms of the last ${ownWindowS} s, from the ${moment.source}`} : null;
    this.root.classList.toggle('stale', !shown);
    const text = (value, digits) => value === null || !Number.isFinite(value) ? '–' : value.toFixed(digits);
    const digits = value => value !== null && value < 10 ? 1 : 0;
    this.part('.number').textContent = shown ? text(shown.error, digits(shown.error)) : '–';
    this.part('.swing').textContent = shown ? `${text(shown.swing, 2)}°` : '–';
    this.part('.twin').textContent = shown && Number.isFinite(shown.twinError) && shown.twinError !== null
        ? `${text(shown.twinError, 0)} mm · ${text(shown.twinSwing, 1)}°` : '–';
    const times = shown && shown.error > 0 ? shown.twinError / shown.error : null;
    this.part('.times').textContent = times >= 1.5 ? `${times.toFixed(times < 10 ? 1 : 0)}× stiller` : '';
    this.part('.note').textContent = shown?.note ?? 'stale: nothing fresh tells where the load is';
  }
}
