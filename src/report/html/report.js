// The page works without this script, which adds the color scheme, the filter and the movable light.
"use strict";

// Dark or light mode follows the system until the user chooses one.
{
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.style.colorScheme || (system.matches ? "dark" : "light")) === "dark";
  const show = () => button.setAttribute("aria-pressed", String(isDark()));
  const choose = (scheme) => { root.style.colorScheme = scheme; show(); };
  try { root.style.colorScheme = localStorage.getItem("ptm-conform-scheme") || ""; } catch { /* storage is optional */ }
  button.addEventListener("click", () => {
    choose(isDark() ? "light" : "dark");
    try { localStorage.setItem("ptm-conform-scheme", root.style.colorScheme); } catch { /* storage is optional */ }
  });
  system.addEventListener("change", show);
  show();
}

// Filter: every word must occur. A clause or section also matches everything below it, and is:fail matches an outcome. The
// filter is part of the URL, and all counts reflect it.
{
  const input = document.getElementById("filter");
  if (input) {
    const found = document.getElementById("found");
    const heading = document.getElementById("cases");
    const cards = [...document.querySelectorAll("details.case")];
    const rows = [...document.querySelectorAll("details.others table.list tbody tr")].filter((row) => row.querySelector("td:first-child code") && row.cells.length === 5);
    const all = [
      ...cards.map((element) => ({ element, text: element.textContent.toLowerCase(), clauses: element.querySelector("summary .clauses").textContent.split(" "), outcome: "fail" })),
      ...rows.map((element) => ({ element, text: element.textContent.toLowerCase(), clauses: element.cells[3].textContent.split(" "), outcome: element.closest("details.others").dataset.outcome })),
    ];
    const folds = [...document.querySelectorAll("details.more, details.others")]
      .map((fold) => ({ fold, inside: all.map((entry) => entry.element).filter((element) => fold.contains(element)) }))
      .filter(({ inside }) => inside.length);
    const groups = [...document.querySelectorAll("section.group")];
    const clause = /^\d+(\.\d+)+(\/\d+)?$/;
    const has = (entry, word) => word.startsWith("is:") ? entry.outcome === word.slice(3) : clause.test(word)
      ? entry.clauses.some((id) => id === word || id.startsWith(word + "/") || id.startsWith(word + "."))
      : entry.text.includes(word);
    const chips = [...document.querySelectorAll("button[data-filter]")];
    // Elements that display a count, with the cases that they count.
    const counts = [...document.querySelectorAll(".count")].map((count) => {
      const chip = count.closest("button[data-filter]");
      const around = count.closest("details.more, details.others, section.group");
      const counted = all.filter((entry) => chip ? has(entry, chip.dataset.filter) : around?.contains(entry.element));
      return { count, counted };
    }).filter(({ counted }) => counted.length);
    const inView = () => { const { top, bottom } = input.getBoundingClientRect(); return top >= 0 && bottom <= innerHeight; };
    // Open state of the details elements before the filter changed it.
    let before;
    // The case that was opened because a filter left only this one.
    let opened;
    const apply = () => {
      if (opened) { opened.open = false; opened = undefined; }
      const stuck = input.form.getBoundingClientRect().top <= 0;
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      let count = 0;
      for (const entry of all) {
        const match = words.every((word) => has(entry, word));
        entry.element.hidden = !match;
        count += match;
      }
      if (words.length) {
        before ??= folds.map(({ fold }) => fold.open);
        for (const { fold, inside } of folds) {
          fold.open = inside.some((element) => !element.hidden) && (fold.open || fold.classList.contains("more") || count < 200);
        }
        const only = count === 1 && all.find(({ element }) => !element.hidden).element;
        if (only && only.tagName === "DETAILS" && !only.open) { only.open = true; opened = only; }
      } else if (before) {
        folds.forEach(({ fold }, i) => { fold.open = before[i]; });
        before = undefined;
      }
      for (const { count, counted } of counts) {
        const shown = counted.filter(({ element }) => !element.hidden).length;
        count.textContent = shown === counted.length ? `${shown}` : `${shown} of ${counted.length}`;
      }
      for (const chip of chips) { chip.setAttribute("aria-pressed", String(words.includes(chip.dataset.filter))); }
      const address = words.length ? `#filter=${encodeURIComponent(words.join(" "))}` : location.hash.startsWith("#filter=") ? "#" : location.hash;
      if (address !== location.hash) { history.replaceState(null, "", address || "#"); }
      for (const group of groups) { group.hidden = !group.querySelector("details.case:not([hidden])"); }
      found.textContent = !words.length ? `${all.length} cases` : count ? `${count} of ${all.length} cases` : "No case matches. Esc clears the filter.";
      // Scroll so that the results begin below the filter.
      if (stuck || !inView()) { heading.scrollIntoView(); }
    };
    let waiting;
    input.addEventListener("input", () => { clearTimeout(waiting); waiting = setTimeout(apply, 80); });
    input.form.addEventListener("submit", (event) => { event.preventDefault(); apply(); });
    input.addEventListener("keydown", (event) => { if (event.key === "Escape") { input.value = ""; apply(); } });
    document.addEventListener("keydown", (event) => {
      // Sliders and buttons accept no text.
      if (event.key !== "/" || document.activeElement.matches("textarea, input:not([type=range])")) { return; }
      event.preventDefault();
      if (!inView()) { heading.scrollIntoView(); }
      input.focus({ preventScroll: true });
    });
    for (const tile of document.querySelectorAll("button.tile")) {
      tile.addEventListener("click", () => { input.value = tile.dataset.clause; apply(); heading.scrollIntoView(); input.focus({ preventScroll: true }); });
    }
    for (const chip of chips) {
      chip.addEventListener("click", () => {
        const others = input.value.split(/\s+/).filter((word) => word && !word.startsWith("is:"));
        const pressed = chip.getAttribute("aria-pressed") === "true";
        input.value = [...others, ...(pressed ? [] : [chip.dataset.filter])].join(" ");
        apply();
      });
    }
    // Apply the filter in the URL.
    const asked = () => {
      const [, words] = /^#filter=(.*)$/.exec(location.hash) ?? [];
      try { if (words !== undefined) { input.value = decodeURIComponent(words); apply(); } } catch { /* no filter */ }
    };
    addEventListener("hashchange", asked);
    asked();
    const openAll = (open) => { for (const card of cards) { if (!card.hidden) { card.open = open; } } };
    document.getElementById("open").addEventListener("click", () => { for (const fold of document.querySelectorAll("details.more")) { fold.open = true; } openAll(true); });
    document.getElementById("close").addEventListener("click", () => openAll(false));
  }
}

// A link to a case opens the case and its containers, and resets a filter that would hide it.
{
  const reveal = () => {
    if (location.hash.startsWith("#filter=")) { return; }
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) { return; }
    if (target.closest("[hidden]")) {
      const input = document.getElementById("filter");
      input.value = "";
      input.form.requestSubmit();
    }
    for (let at = target; at; at = at.parentElement) { if (at.tagName === "DETAILS") { at.open = true; } }
    // The size of elements that were never rendered is an estimate, so scroll repeatedly.
    const look = (more) => { target.scrollIntoView(); if (more) { requestAnimationFrame(() => look(more - 1)); } };
    look(8);
  };
  addEventListener("hashchange", reveal);
  // Following the same link again does not change the hash.
  addEventListener("click", (event) => { if (event.target.closest("a[href^='#']")) { setTimeout(reveal); } });
  reveal();
}

// Movable light: evaluates the polynomial of 1.0 for every texel of the expected and received map.
{
  const numbers = (text) => text.split(" ").filter(Boolean).map(Number);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

  // Final values: (raw − bias) · scale for coefficients (2.4); all other values are unchanged.
  const final = (raw, channels, scale, bias) => {
    const polynomials = channels === 18 ? 18 : 6;
    return Float64Array.from(raw, (value, i) => {
      const channel = i % channels;
      return channel < polynomials ? (value - bias[channel % 6]) * scale[channel % 6] : value;
    });
  };

  const color = (a, at, channels, matrix, u, v) => {
    const polynomial = (from) => a[from] * u * u + a[from + 1] * v * v + a[from + 2] * u * v + a[from + 3] * u + a[from + 4] * v + a[from + 5];
    if (channels === 18) { return [polynomial(at), polynomial(at + 6), polynomial(at + 12)]; }
    const y = polynomial(at);
    if (channels === 9) { return [6, 7, 8].map((channel) => y * a[at + channel] / 255); }
    return [0, 1, 2].map((row) => matrix[row] * y + matrix[4 + row] * a[at + 6] + matrix[8 + row] * a[at + 7] + matrix[12 + row]);
  };

  const clamp = (value) => Math.min(255, Math.max(0, value)) || 0;
  const heat = (apart) => {
    const stops = [[250, 178, 60], [226, 62, 48], [124, 30, 150]];
    const [from, to, part] = apart < 0.5 ? [stops[0], stops[1], apart * 2] : [stops[1], stops[2], apart * 2 - 1];
    return from.map((value, i) => value + (to[i] - value) * part);
  };

  const make = (name, text) => Object.assign(document.createElement(name), text ? { textContent: text } : {});

  const start = (figure) => {
    const data = figure.dataset;
    const [width, height, channels] = [data.width, data.height, data.channels].map(Number);
    const [scale, bias, matrix] = [data.scale, data.bias, data.matrix].map(numbers);
    const expected = final(bytes(data.expected), channels, scale, bias);
    const received = data.kind === "coef"
      ? Float64Array.from(new Float32Array(bytes(data.received).buffer))
      : final(bytes(data.received), channels, scale, bias);
    const size = Math.max(1, Math.min(28, Math.floor(180 / Math.max(width, height))));
    const screens = make("div");
    screens.className = "screens";
    const screen = (name) => {
      const box = make("div");
      const canvas = Object.assign(make("canvas"), { width, height });
      canvas.style.width = `${width * size}px`;
      canvas.style.height = `${height * size}px`;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${name}, under the light of the sliders`);
      box.append(canvas, name);
      screens.append(box);
      return canvas;
    };
    const [left, right, apart] = [screen("expected"), screen("received"), screen("difference")];
    const ball = make("div");
    ball.className = "ball";
    ball.title = "the light";
    screens.append(ball);
    const lights = make("div");
    lights.className = "lights";
    const slider = (name, value) => {
      const label = make("label", name);
      const input = Object.assign(make("input"), { type: "range", min: -1, max: 1, step: 0.05, value });
      label.append(input);
      lights.append(label);
      input.addEventListener("input", () => light(Number(u.value), Number(v.value)));
      return input;
    };
    const u = slider("u, to the right", 0.3);
    const v = slider("v, up", 0.3);
    const says = make("output");
    lights.append(says);
    figure.append(screens, lights);

    const light = (lu, lv) => {
      const pictures = [left, right, apart].map((canvas) => new ImageData(canvas.width, canvas.height));
      let worst = 0;
      for (let texel = 0; texel < width * height; texel += 1) {
        const one = color(expected, texel * channels, channels, matrix, lu, lv).map(clamp);
        const two = color(received, texel * channels, channels, matrix, lu, lv).map(clamp);
        const far = Math.max(...one.map((value, i) => Math.abs(value - two[i])));
        worst = Math.max(worst, far);
        pictures[0].data.set([...one, 255], texel * 4);
        pictures[1].data.set([...two, 255], texel * 4);
        pictures[2].data.set(far > 1 ? [...heat(far / 255), 255] : [0, 0, 0, 0], texel * 4);
      }
      [left, right, apart].forEach((canvas, i) => canvas.getContext("2d").putImageData(pictures[i], 0, 0));
      ball.style.setProperty("--u", lu);
      ball.style.setProperty("--v", lv);
      says.textContent = `u ${lu.toFixed(2)}  v ${lv.toFixed(2)}  difference ≤ ${Math.round(worst)}`;
    };

    const drag = (event) => {
      const box = event.currentTarget.getBoundingClientRect();
      let lu = (event.clientX - box.left) / box.width * 2 - 1;
      let lv = 1 - (event.clientY - box.top) / box.height * 2;
      const length = Math.hypot(lu, lv);
      if (length > 1) { lu /= length; lv /= length; }
      [u.value, v.value] = [lu, lv];
      light(lu, lv);
    };
    for (const canvas of [left, right, apart, ball]) {
      canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); drag(event); });
      canvas.addEventListener("pointermove", (event) => { if (event.buttons) { drag(event); } });
    }
    light(Number(u.value), Number(v.value));
  };

  // Render only visible previews. When printing, render all of them.
  const begin = (card) => {
    const figure = card.open && card.querySelector("figure.preview:not([data-lit])");
    if (figure) { figure.dataset.lit = ""; start(figure); }
  };
  for (const card of document.querySelectorAll("details.case")) {
    card.addEventListener("toggle", () => begin(card));
    begin(card);
  }
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details:not([open])")];
    for (const fold of closed) { fold.open = true; }
    document.querySelectorAll("details.case").forEach(begin);
  });
  addEventListener("afterprint", () => { for (const fold of closed) { fold.open = false; } });
}

// Expected and received image in one view, with a movable divider between them.
for (const pictures of document.querySelectorAll(".compare")) {
  const [expected, received] = ["expected", "received"].map((role) => pictures.querySelector(`[data-role=${role}] img`));
  const box = Object.assign(document.createElement("div"), { className: "picture" });
  const slide = Object.assign(document.createElement("div"), { className: "slide" });
  slide.append(expected.cloneNode(), received.cloneNode());
  const label = Object.assign(document.createElement("label"), { textContent: "expected | received" });
  const input = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 100, value: 50 });
  const move = (at) => { input.value = at; slide.style.setProperty("--at", `${input.value}%`); };
  input.addEventListener("input", () => move(input.value));
  const drag = (event) => {
    const { left, width } = slide.getBoundingClientRect();
    move((event.clientX - left) / width * 100);
  };
  slide.addEventListener("pointerdown", (event) => { event.preventDefault(); slide.setPointerCapture(event.pointerId); drag(event); });
  slide.addEventListener("pointermove", (event) => { if (event.buttons) { drag(event); } });
  label.append(input);
  // The first picture is about the received image, so most of it is shown.
  if (pictures.closest(".first")) { move(15); }
  box.append(slide, label);
  pictures.prepend(box);
}

// A button copies a command if the browser allows it, or selects the command otherwise.
for (const command of document.querySelectorAll("pre.command")) {
  const button = Object.assign(document.createElement("button"), { type: "button", className: "copy", textContent: "Copy" });
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(command.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(command);
      button.textContent = "Selected";
    }
    setTimeout(() => { button.textContent = "Copy"; }, 2000);
  });
  command.previousElementSibling.append(button);
}
