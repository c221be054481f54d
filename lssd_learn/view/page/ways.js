// Along what the first shape of the page changes.
"use strict";

// The slider: which way, how far, and what that is; `show` puts the surface there, `colour` shows what changes.
function along(show, colour) {
  const [{ ways }] = data.shapes, get = (id) => document.getElementById(id);
  const way = get("way"), slider = get("along"), place = get("place"), play = get("play");
  get("ways").hidden = false;
  for (const { title } of ways) way.append(new Option(title));
  let playing = null;

  function said(chosen, s) {
    const far = Math.abs(s) > 1.005 ? `, ${Math.abs(s).toFixed(1)} times as far as that end` : "";
    if (chosen.at) {
      const [low, high] = chosen.at, sd = 2 * s;
      const value = (low + high) / 2 + (s * (high - low)) / 2;
      return `${Number(value.toPrecision(3))} (${sd < 0 ? "−" : "+"}${Math.abs(sd).toFixed(1)} sd)`;
    }
    if (Math.abs(s) < 0.005) return "midway";
    const end = chosen.ends[s < 0 ? 0 : 1];
    return Math.abs(s) < 0.995 ? `${Math.round(50 + 50 * Math.abs(s))} % ${end}` : `${end}${far}`;
  }

  function go() {
    const s = Number(slider.value);
    place.textContent = said(ways[way.selectedIndex], s);
    show(way.selectedIndex, s);
  }

  function stop() {
    if (playing !== null) cancelAnimationFrame(playing);
    playing = null;
    play.textContent = "▶";
  }

  way.addEventListener("change", () => {
    const { field } = ways[way.selectedIndex];
    if (field !== null) colour(field);
    go();
  });
  slider.addEventListener("input", () => { stop(); go(); });
  play.addEventListener("click", () => {
    if (playing !== null) return stop();
    play.textContent = "❚❚";
    const start = performance.now();
    const step = (now) => {
      slider.value = Math.sin((now - start) / 900); // to and fro between the ends
      go();
      playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
  });
  go();
}
