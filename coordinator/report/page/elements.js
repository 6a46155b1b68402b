// Makes HTML and SVG elements. Text from the run goes in as text, never as markup.
(function (knap) {
  "use strict";

  // Asked from the parser, so that the page holds no address at all: its test asserts that.
  function findSvgNamespace() {
    const template = document.createElement("template");
    template.innerHTML = "<svg></svg>";
    return template.content.firstChild.namespaceURI;
  }
  const svgNamespace = findSvgNamespace();

  // Attributes whose name begins with "on" are listeners; false, null and undefined leave an attribute out.
  function fill(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes ?? {})) {
      if (value === false || value === null || value === undefined) continue;
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else element.setAttribute(name, value === true ? "" : value);
    }
    element.append(...children.filter((child) => child !== null && child !== undefined));
    return element;
  }

  function html(tag, attributes, ...children) {
    return fill(document.createElement(tag), attributes, children);
  }

  function svg(tag, attributes, ...children) {
    return fill(document.createElementNS(svgNamespace, tag), attributes, children);
  }

  // A clipboard may be refused, to a page from disk for one; the text is then selected for the reader to copy.
  async function copy(node) {
    try {
      await navigator.clipboard.writeText(node.textContent);
      return "copied";
    } catch {
      const range = document.createRange();
      range.selectNodeContents(node);
      getSelection().removeAllRanges();
      getSelection().addRange(range);
      return "selected";
    }
  }

  function copyButton(node, label) {
    const button = html("button", {
      type: "button", class: "copy", "aria-label": label,
      onclick: async () => {
        button.textContent = await copy(node);
        setTimeout(() => { button.textContent = "copy"; }, 1500);
      },
    }, "copy");
    return button;
  }

  // A table, which scrolls by itself where it is too wide or long. Cells are texts or elements; the columns of which
  // `numeric` has the numbers are set to the right.
  function table(caption, heads, rows, numeric = []) {
    const kind = (index) => ({ class: numeric.includes(index) ? "number" : null });
    const filled = html("table", null,
      html("caption", null, caption),
      html("thead", null, html("tr", null, ...heads.map((head, i) => html("th", { scope: "col", ...kind(i) }, head)))),
      html("tbody", null, ...rows.map((row) => html("tr", null, ...row.map((cell, i) => html("td", kind(i), cell))))));
    return html("div", { class: "table", tabindex: 0, role: "region", "aria-label": caption }, filled);
  }

  // Calls changed() at the frame after the node's size has changed, and at the first: what changes sizes again while
  // sizes are being told makes the browser complain of a loop.
  function onSize(node, changed) {
    new ResizeObserver(() => requestAnimationFrame(changed)).observe(node);
  }

  // Calls draw(width) once the node has a width, and whenever that changes.
  function onWidth(node, draw) {
    let drawn = 0;
    onSize(node, () => {
      const width = Math.floor(node.clientWidth);
      if (width > 0 && width !== drawn) draw(drawn = width);
    });
  }

  knap.elements = { html, svg, copyButton, table, onSize, onWidth };
})(window.knap = window.knap || {});
