// One recorded rollout: poses, forces and signals at any time between its samples.
(function (knap) {
  "use strict";
  const { fromPose, slerp } = knap.matrices;

  class Recording {
    constructor(replay, movers) {
      this.about = replay;
      this.movers = movers;
      this.times = knap.decoding.floats(replay.times);
      this.poses = knap.decoding.floats(replay.poses);
      this.forces = (replay.forces ?? []).map((force) => ({
        name: (force.between ?? []).join(" – "),
        force: knap.decoding.floats(force.force),
        at: knap.decoding.floats(force.at),
      }));
      this.signals = (replay.signals ?? []).map((signal) => ({
        name: signal.name, unit: signal.unit, values: knap.decoding.floats(signal.values),
      }));
    }

    get end() {
      return this.times.length ? this.times[this.times.length - 1] : 0;
    }

    // The samples on both sides of a time, and how far between them it is.
    between(time) {
      let [low, high] = [0, this.times.length - 1];
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (this.times[middle] <= time) low = middle;
        else high = middle;
      }
      high = Math.max(high, 0);
      const length = this.times[high] - this.times[low];
      const share = length > 0 ? Math.min(1, Math.max(0, (time - this.times[low]) / length)) : 0;
      return { low, high, share };
    }

    sampledPose(sample, mover) {
      const start = 7 * (sample * this.movers + mover);
      return this.poses.subarray(start, start + 7);
    }

    // X_WB of a moving body; null if the recording holds nothing finite there.
    poseAt(time, mover) {
      const { low, high, share } = this.between(time);
      const [a, b] = [this.sampledPose(low, mover), this.sampledPose(high, mover)];
      if (a.length < 7 || b.length < 7 || !a.every(Number.isFinite) || !b.every(Number.isFinite)) return null;
      const p = [0, 1, 2].map((i) => a[i] + share * (b[i] - a[i]));
      return fromPose(p, slerp(a.subarray(3), b.subarray(3), share));
    }

    // Where the body's origin was at the samples up to a time, as numbers of a polyline.
    pathUntil(time, mover) {
      const points = [];
      const { low } = this.between(time);
      for (let sample = 0; sample <= low; ++sample) points.push(...this.sampledPose(sample, mover).subarray(0, 3));
      const pose = this.poseAt(time, mover);
      if (pose) points.push(pose[12], pose[13], pose[14]);
      return points.every(Number.isFinite) ? points : [];
    }

    // The contacts that touch at a time. At touchdown and take-off one neighbour has no point: the nearer one decides.
    forcesAt(time) {
      const { low, high, share } = this.between(time);
      const mixed = (values) => [0, 1, 2].map((i) => {
        const [a, b] = [values[3 * low + i], values[3 * high + i]];
        if (Number.isFinite(a) && Number.isFinite(b)) return a + share * (b - a);
        return share < 0.5 ? a : b;
      });
      return this.forces
        .map(({ name, force, at }) => ({ name, force: mixed(force), at: mixed(at) }))
        .filter(({ force, at }) => [...force, ...at].every(Number.isFinite) && knap.matrices.norm(force) > 0);
    }

    // The size of a contact's force at each sample; zero while it does not touch.
    forceSizes({ force }) {
      return Array.from(this.times, (_, i) => Math.hypot(force[3 * i], force[3 * i + 1], force[3 * i + 2]) || 0);
    }
  }

  knap.Recording = Recording;
})(window.knap = window.knap || {});
