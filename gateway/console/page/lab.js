// What is known of the laboratory now: the newest sample of every instance of every topic, and how old it is.

export class Lab {
  #newest = new Map();
  #offset = null;  // of the console's clock against ours, s

  // `t`: when the console got it, by its own clock.
  accept({topic, instance, sample, t}) {
    const here = performance.now() / 1000;
    if (topic === 'console/state') {
      // The sample that travelled fastest tells the offset; it may drift by a millisecond a second.
      this.#offset = this.#offset === null ? t - here : Math.max(t - here, this.#offset - 0.001);
    }
    if (!this.#newest.has(topic)) this.#newest.set(topic, new Map());
    this.#newest.get(topic).set(instance, {sample, t});
  }

  // The console's clock, s.
  now() { return performance.now() / 1000 + (this.#offset ?? 0); }

  // The newest sample with its age in s; null when there was none. Without an instance: of any.
  newest(topic, instance) {
    const instances = this.#newest.get(topic);
    if (!instances || this.#offset === null) return null;
    const entry = instance === undefined ? [...instances.values()].pop() : instances.get(instance);
    return entry ? {sample: entry.sample, age: Math.max(this.now() - entry.t, 0)} : null;
  }

  // The newest sample if it is not older than `limit` s; else null: what is stale is not shown.
  fresh(topic, limit, instance) {
    const newest = this.newest(topic, instance);
    return newest && newest.age <= limit ? newest.sample : null;
  }

  instances(topic) { return [...(this.#newest.get(topic)?.keys() ?? [])].sort(); }

  // Age of the youngest sample of a topic, s; infinite when there was none.
  age(topic) {
    const ages = this.instances(topic).map(instance => this.newest(topic, instance)?.age ?? Infinity);
    return Math.min(Infinity, ...ages);
  }
}
