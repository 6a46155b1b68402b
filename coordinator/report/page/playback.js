// The time that both replays show, and how it runs.
(function (knap) {
  "use strict";

  class Playback {
    // moved(time) is called when the time has changed, switched(playing) when it begins or stops to run.
    constructor(moved, switched) {
      this.moved = moved;
      this.switched = switched;
      this.time = 0;
      this.end = 0;
      this.speed = 1;
      this.playing = false;
    }

    restart(end) {
      this.pause();
      this.end = end;
      this.seek(0);
    }

    seek(time) {
      this.time = Math.min(this.end, Math.max(0, time));
      this.moved(this.time);
    }

    toggle() {
      if (this.playing) this.pause();
      else this.play();
    }

    play() {
      if (this.playing || this.end <= 0) return;
      if (this.time >= this.end) this.seek(0);
      this.playing = true;
      this.switched(true);
      this.last = null;
      requestAnimationFrame((now) => this.step(now));
    }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      this.switched(false);
    }

    step(now) {
      if (!this.playing) return;
      // A hidden page gets no frames; after a long gap the replay goes on where it was.
      const passed = this.last === null ? 0 : Math.min(0.25, (now - this.last) / 1000);
      this.last = now;
      this.seek(this.time + passed * this.speed);
      if (this.time >= this.end) this.pause();
      else requestAnimationFrame((next) => this.step(next));
    }
  }

  knap.Playback = Playback;
})(window.knap = window.knap || {});
