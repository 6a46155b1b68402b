// Colours are named once, in page.css; drawings on canvases ask here for what they are at the moment.
(function (knap) {
  "use strict";

  const names = ["muted", "ground", "grid", "fixed", "moving", "initial", "learned", "force"];

  let known = null;

  // Red, green and blue from 0 to 1, by name.
  const palette = () => (known ??= readPalette());

  // A computed colour is resolved, where a custom property is still a formula.
  function readPalette() {
    const probe = document.body.appendChild(document.createElement("span"));
    const colours = {};
    for (const name of names) {
      probe.style.color = `var(--${name})`;
      colours[name] = getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map((part) => Number(part) / 255);
    }
    probe.remove();
    return colours;
  }

  // Calls changed() whenever colours may have changed: by the button, by the system, and around printing on white.
  function install(button, changed) {
    const root = document.documentElement;
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const current = () => root.dataset.theme ?? (dark.matches ? "dark" : "light");
    const show = () => {
      button.textContent = current() === "dark" ? "Light" : "Dark";
      button.setAttribute("aria-label", `Use ${button.textContent.toLowerCase()} colours`);
      known = null;
      changed();
    };
    button.addEventListener("click", () => {
      root.dataset.theme = current() === "dark" ? "light" : "dark";
      show();
    });
    dark.addEventListener("change", show);
    let before;
    addEventListener("beforeprint", () => {
      before = root.dataset.theme;
      root.dataset.theme = "light";
      show();
    });
    addEventListener("afterprint", () => {
      if (before) root.dataset.theme = before;
      else delete root.dataset.theme;
      show();
    });
    show();
  }

  knap.theme = { palette, install };
})(window.knap = window.knap || {});
