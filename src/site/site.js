// The pages work without this script, which adds the color scheme, the search and the filters.
"use strict";

// Dark or light mode follows the system until the user chooses one.
{
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.style.colorScheme || (system.matches ? "dark" : "light")) === "dark";
  const show = () => button.setAttribute("aria-pressed", String(isDark()));
  try { root.style.colorScheme = localStorage.getItem("ptm-conform-scheme") || ""; } catch { /* storage is optional */ }
  button.addEventListener("click", () => {
    root.style.colorScheme = isDark() ? "light" : "dark";
    show();
    try { localStorage.setItem("ptm-conform-scheme", root.style.colorScheme); } catch { /* storage is optional */ }
  });
  system.addEventListener("change", show);
  show();
}

// Search box: ids first, then words. The index is a separate script that is loaded when the box receives the focus.
{
  const input = document.getElementById("search");
  const hits = document.getElementById("hits");
  const root = document.body.dataset.root;
  const MAX_HITS = 20;
  let selected = -1;
  let loading;
  const load = () => {
    loading ??= new Promise((resolve) => {
      const script = document.createElement("script");
      script.src = `${root}search-index.js`;
      script.addEventListener("load", () => resolve(window.searchIndex));
      document.head.append(script);
    });
    return loading;
  };
  // Rank of an entry. Lower is better, and the rank is Infinity if a word does not occur.
  const rank = ([id, , , words], wanted) => {
    const name = id.toLowerCase();
    const text = `${name} ${words.toLowerCase()}`;
    if (!wanted.every((word) => text.includes(word))) { return Infinity; }
    const slug = wanted.join("-");
    if (name === slug || name === wanted.join(" ")) { return 0; }
    if (name.startsWith(slug)) { return 1; }
    return wanted.every((word) => name.includes(word)) ? 2 : 3;
  };
  const close = () => { hits.hidden = true; selected = -1; input.setAttribute("aria-expanded", "false"); input.removeAttribute("aria-activedescendant"); };
  const find = async () => {
    const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    if (!wanted.length) { close(); return; }
    const index = await load();
    const found = index.map((entry) => ({ entry, rank: rank(entry, wanted) })).filter((hit) => hit.rank < Infinity);
    found.sort((a, b) => a.rank - b.rank || a.entry[0].length - b.entry[0].length);
    hits.replaceChildren(...found.slice(0, MAX_HITS).map(({ entry: [id, kind, url, words] }, i) => {
      const item = document.createElement("li");
      item.id = `hit-${i}`;
      item.setAttribute("role", "option");
      item.setAttribute("aria-selected", "false");
      const link = document.createElement("a");
      link.href = root + url;
      link.tabIndex = -1;
      const name = document.createElement("b");
      name.textContent = id;
      const label = document.createElement("small");
      label.textContent = ` ${kind} `;
      link.append(name, label, words.slice(0, 90));
      item.append(link);
      return item;
    }));
    if (!found.length) {
      const item = document.createElement("li");
      item.setAttribute("role", "option");
      item.setAttribute("aria-selected", "false");
      item.setAttribute("aria-disabled", "true");
      item.textContent = "No entry has this name, and no text contains these words.";
      hits.append(item);
    }
    selected = -1;
    hits.hidden = false;
    input.setAttribute("aria-expanded", "true");
  };
  const choose = (step) => {
    const items = [...hits.querySelectorAll("li:has(a)")];
    if (!items.length) { return; }
    items[selected]?.setAttribute("aria-selected", "false");
    selected = (selected + step + items.length) % items.length;
    items[selected].setAttribute("aria-selected", "true");
    items[selected].scrollIntoView({ block: "nearest" });
    input.setAttribute("aria-activedescendant", items[selected].id);
  };
  input.addEventListener("focus", load, { once: true });
  input.addEventListener("input", find);
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") { close(); input.value = ""; }
    if (event.key === "ArrowDown") { event.preventDefault(); choose(1); }
    if (event.key === "ArrowUp") { event.preventDefault(); choose(-1); }
    if (event.key === "Enter") { hits.querySelectorAll("li a")[Math.max(selected, 0)]?.click(); }
  });
  document.addEventListener("click", (event) => { if (!event.target.closest("search")) { close(); } });
  document.addEventListener("keydown", (event) => {
    if (event.key !== "/" || document.activeElement.matches("input:not([type=range], [type=checkbox]), textarea")) { return; }
    event.preventDefault();
    input.focus();
  });
}

// Filter of a list: every word must occur. A clause or section also matches everything in it. The filter is part of the URL.
{
  const input = document.getElementById("list-filter");
  if (input) {
    const found = document.getElementById("list-found");
    const differing = document.getElementById("differing");
    const rows = [...document.querySelectorAll("table.filtered tbody tr, section.filtered li, section.case-text.filtered")];
    const sections = [...document.querySelectorAll("section.filtered:not(.case-text)")];
    const groups = [...document.querySelectorAll("section.filtered > details")];
    const clause = /^\d+(\.\d+)+(\/\d+)?$/;
    const texts = rows.map((row) => `${row.textContent} ${row.title}`.toLowerCase());
    const words = texts.map((text) => text.split(/[\s,;:]+/));
    const has = (i, word) => clause.test(word)
      ? words[i].some((id) => id === word || id.startsWith(`${word}/`) || id.startsWith(`${word}.`))
      : texts[i].includes(word);
    const apply = () => {
      const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      let count = 0;
      rows.forEach((row, i) => {
        const match = wanted.every((word) => has(i, word)) && !(differing?.checked && "same" in row.dataset);
        row.hidden = !match;
        count += match;
      });
      // Groups with entries that match are open while the filter is in use.
      for (const group of groups) {
        group.hidden = !group.querySelector("li:not([hidden])");
        if (wanted.length && !group.hidden && !group.open) { group.open = true; group.dataset.found = ""; }
        if (!wanted.length && "found" in group.dataset) { group.open = false; delete group.dataset.found; }
      }
      for (const section of sections) { section.hidden = !section.querySelector("li:not([hidden])"); }
      found.textContent = count === rows.length ? `${count}` : `${count} of ${rows.length}`;
      const query = encodeURIComponent(input.value.trim());
      history.replaceState(null, "", (query ? `?${query}` : location.pathname) + location.hash);
    };
    const initial = decodeURIComponent(location.search.slice(1));
    if (initial) { input.value = initial; }
    input.addEventListener("input", apply);
    differing?.addEventListener("change", apply);
    input.form.addEventListener("submit", (event) => event.preventDefault());
    if (initial) { apply(); } else { found.textContent = `${rows.length}`; }
  }
}

// Objects under a light. A file has the images of a grid of lights; the four nearest ones are blended. The grid is a square
// that is mapped to the disk of the lights.
{
  const GRID = 5;
  const MAX_LENGTH = 0.98;
  // The place in the grid, from 0 to 4 in both directions, of a light.
  const placeOf = ([u, v]) => {
    const along = (a, b) => {
      const middle = 2 + a * a - b * b;
      const side = 2 * Math.SQRT2 * a;
      return (Math.sqrt(Math.max(0, middle + side)) - Math.sqrt(Math.max(0, middle - side))) / 2;
    };
    const place = (s) => Math.min(GRID - 1, Math.max(0, (s + 1) / 2 * (GRID - 1)));
    return [place(along(u, v)), place(-along(v, u))];
  };
  const draw = (canvas, image, light, side) => {
    const context = canvas.getContext("2d");
    const [x, y] = placeOf(light);
    const [column, row] = [x, y].map((value) => Math.min(GRID - 2, Math.floor(value)));
    const [right, below] = [x - column, y - row];
    const pitch = image.naturalWidth / GRID;
    let sum = 0;
    for (const [i, j, weight] of [[0, 0, (1 - right) * (1 - below)], [1, 0, right * (1 - below)], [0, 1, (1 - right) * below], [1, 1, right * below]]) {
      if (!weight) { continue; }
      sum += weight;
      context.globalAlpha = weight / sum;
      context.drawImage(image, (column + i) * pitch, (row + j) * pitch, side, side, 0, 0, side, side);
    }
  };
  for (const object of document.querySelectorAll(".object")) {
    const dial = object.querySelector(".dial");
    const output = object.querySelector("output");
    const side = Number(object.dataset.side);
    const layers = [];
    let light;
    let planned = false;
    const show = () => {
      planned = false;
      for (const [canvas, image] of layers) { draw(canvas, image, light, side); }
      const [u, v] = light.map((value) => value * MAX_LENGTH);
      dial.style.setProperty("--u", u);
      dial.style.setProperty("--v", v);
      dial.setAttribute("aria-valuenow", Math.hypot(u, v).toFixed(2));
      const text = `u ${u.toFixed(2)}, v ${v.toFixed(2)}`.replaceAll("-0.00", "0.00");
      dial.setAttribute("aria-valuetext", text);
      output.textContent = text;
    };
    const move = (u, v) => {
      const length = Math.max(1, Math.hypot(u, v));
      light = [u / length, v / length];
      if (!planned) { planned = true; requestAnimationFrame(show); }
    };
    const listen = (element) => {
      const drag = (event) => {
        const box = element.getBoundingClientRect();
        move((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
      };
      element.addEventListener("pointerdown", (event) => { element.setPointerCapture(event.pointerId); drag(event); });
      element.addEventListener("pointermove", (event) => { if (event.buttons) { drag(event); } });
    };
    const replace = (image) => {
      const canvas = Object.assign(document.createElement("canvas"), { width: side, height: side });
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", image.alt.replace(/, lit from .*/, "") + " under the light of the dial");
      layers.push([canvas, image]);
      draw(canvas, image, light, side);
      image.replaceWith(canvas);
      listen(canvas);
    };
    light = [object.dataset.u / MAX_LENGTH, object.dataset.v / MAX_LENGTH];
    show();
    for (const image of object.querySelectorAll("img")) {
      if (image.complete && image.naturalWidth) { replace(image); } else { image.addEventListener("load", () => replace(image), { once: true }); }
    }
    listen(dial);
    dial.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 0.2 : 0.05;
      const steps = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step], Home: [-light[0], -light[1]] }[event.key];
      if (steps) { event.preventDefault(); move(light[0] + steps[0], light[1] + steps[1]); }
    });
    dial.parentElement.hidden = false;
  }
}
