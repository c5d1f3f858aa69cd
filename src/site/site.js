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
