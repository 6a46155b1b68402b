// What check_report.py asks the page again and again.
window.test = {
  shown: (name) => !document.getElementById(name).hidden,
  canvas: (design) => document.querySelector(`#replay .pane.${design} canvas`),
  pixels: () => ["initial", "learned"].map((design) => test.canvas(design).toDataURL()).join(),
  frames: (count) => new Promise((done) => {
    const next = () => count-- > 0 ? requestAnimationFrame(next) : done(true);
    next();
  }),
  time: () => parseFloat(document.querySelector("#replay .clock").textContent),
  end: () => parseFloat(document.querySelector("#replay .clock").textContent.split("/")[1]),
  playing: () => document.querySelector("#replay .play").getAttribute("aria-label") === "Pause",
  // When the contacts of the rollouts that are shown press the most; null where nothing touches.
  timeOfForce: () => {
    const row = Number(document.querySelector("#replay button.choose[aria-current=true]").dataset.row);
    const { replays } = JSON.parse(document.getElementById("data").textContent);
    let [time, largest] = [null, 0];
    for (const replay of replays.filter((one) => one.variation === row)) {
      const recording = new knap.Recording(replay, 0);
      for (const force of recording.forces) {
        recording.forceSizes(force).forEach((size, i) => {
          if (size > largest) [time, largest] = [recording.times[i], size];
        });
      }
    }
    return time;
  },
  ids: () => [...document.querySelectorAll("#replay .id")].map((node) => node.textContent).join(),
  // Pixels of a strong colour, as tools have and the ground has not. Those that are nearly clear are left out:
  // their colours are rounded to anything.
  coloured: (canvas) => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const {data} = context.getImageData(0, 0, copy.width, copy.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      const pixel = data.subarray(i, i + 3);
      if (data[i + 3] > 250 && Math.max(...pixel) - Math.min(...pixel) > 60) ++count;
    }
    return count;
  },
  middle: (node) => {
    node.scrollIntoView({block: "center", behavior: "instant"});
    const box = node.getBoundingClientRect();
    return [box.x + box.width / 2, box.y + box.height / 2];
  },
  // The first dot of a map, recorded or not, that is not chosen and lies open to the pointer.
  openDot: (recorded) => [...document.querySelectorAll("#map .learned .dot:not(.selected)")].find((dot) => {
    if ((dot.querySelector(".recorded") !== null) !== recorded) return false;
    return document.elementFromPoint(...test.middle(dot))?.closest(".dot") === dot;
  }),
  image: () => document.querySelector("#shape canvas")?.toDataURL(),
  slide: (input, value) => {
    input.value = value;
    input.dispatchEvent(new Event("input", {bubbles: true}));
  },
};
