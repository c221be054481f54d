// What charts and texts of the page can do beside being read: be saved, be copied, be named by a finger.
"use strict";

function download(name, address) {
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
}

(() => {
  // A chart as SVG, for a paper.
  for (const figure of document.querySelectorAll("figure")) {
    const svg = figure.querySelector("svg");
    if (!svg) continue;
    const button = document.createElement("button"), title = figure.querySelector("figcaption").textContent;
    button.type = "button";
    button.className = "small";
    button.textContent = "SVG";
    button.setAttribute("aria-label", `Save ${title} as SVG`);
    button.addEventListener("click", () => {
      const name = title.replace(/[^\w.-]+/g, "_");
      download(`${name}.svg`, URL.createObjectURL(new Blob([svg.outerHTML], { type: "image/svg+xml" })));
    });
    figure.querySelector("figcaption").append(button);
  }

  // A finger has no way to rest on a point: a touch names it.
  for (const circle of document.querySelectorAll("svg circle")) {
    circle.addEventListener("click", () => {
      const figure = circle.closest("figure");
      let said = figure.querySelector(".said");
      if (!said) figure.append((said = Object.assign(document.createElement("div"), { className: "said hint" })));
      said.textContent = circle.querySelector("title").textContent;
    });
  }

  // What can be pasted into a paper.
  for (const text of document.querySelectorAll("p.paste")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "small";
    button.textContent = "Copy";
    button.addEventListener("click", () => {
      const range = document.createRange();
      range.selectNodeContents(text);
      getSelection().removeAllRanges();
      getSelection().addRange(range);
      document.execCommand("copy"); // works from a file too, where the clipboard's own interface does not
    });
    text.after(button);
  }

  // On paper nothing is folded.
  let folded = [];
  window.addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const one of folded) one.open = true;
  });
  window.addEventListener("afterprint", () => folded.forEach((one) => { one.open = false; }));
})();
