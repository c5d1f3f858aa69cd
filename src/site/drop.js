// The reference as WebAssembly reads the file in this page. Nothing is sent anywhere.
"use strict";
{
  const $ = (id) => document.getElementById(id);
  const make = (name, text, attributes = {}) => {
    const element = Object.assign(document.createElement(name), text === undefined ? {} : { textContent: text });
    for (const [key, value] of Object.entries(attributes)) { element.setAttribute(key, value); }
    return element;
  };
  const say = (text) => { $("status").textContent = text; };
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

  const started = (async () => {
    const packed = new Blob([bytes($("module").textContent.trim())]).stream();
    const module = await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    const { instance } = await WebAssembly.instantiate(module, {});
    return instance.exports;
  })();

  let wasm;
  let map;

  // Opens a file and returns the report about it.
  const open = (file) => {
    const at = wasm.reserve(file.length);
    new Uint8Array(wasm.memory.buffer, at, file.length).set(file);
    wasm.open();
    const [start, length] = [wasm.report(), wasm.report_length()];
    const report = new Uint8Array(wasm.memory.buffer, start, length);
    return JSON.parse(new TextDecoder().decode(report));
  };

  const relit = (u, v, target) => {
    // The memory may grow and its buffer may be replaced during rendering, so get the buffer afterwards.
    const at = wasm.relight(u, v);
    target.data.set(new Uint8ClampedArray(wasm.memory.buffer, at, map.width * map.height * 4));
    return target;
  };

  // Light direction: the ball, the sliders and the rendered image.
  const light = { u: 0, v: 0 };
  let image;
  const drawBall = () => {
    const ball = $("ball");
    const context = ball.getContext("2d");
    const r = ball.width / 2;
    const picture = context.createImageData(ball.width, ball.height);
    const w = Math.sqrt(Math.max(0, 1 - light.u ** 2 - light.v ** 2));
    for (let y = 0; y < ball.height; y += 1) {
      for (let x = 0; x < ball.width; x += 1) {
        const [nx, ny] = [(x + 0.5 - r) / r, (r - y - 0.5) / r];
        const rest = 1 - nx * nx - ny * ny;
        if (rest < 0) { continue; }
        const shade = 30 + 215 * Math.max(0, nx * light.u + ny * light.v + Math.sqrt(rest) * w);
        picture.data.set([shade, shade, shade, 255], (y * ball.width + x) * 4);
      }
    }
    context.putImageData(picture, 0, 0);
    context.fillStyle = "#f4b13c";
    context.beginPath();
    context.arc(r + light.u * r * 0.94, r - light.v * r * 0.94, 4, 0, 7);
    context.fill();
  };
  const show = () => {
    drawBall();
    $("u").value = light.u;
    $("v").value = light.v;
    $("light").textContent = `u ${light.u.toFixed(2)}, v ${light.v.toFixed(2)}`;
    if (map) {
      $("picture").getContext("2d").putImageData(relit(light.u, light.v, image), 0, 0);
      if (viewer) { compare(); }
    }
  };
  let waiting = false;
  const turn = (u, v) => {
    const length = Math.hypot(u, v);
    [light.u, light.v] = length > 1 ? [u / length, v / length] : [u, v];
    if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; show(); }); }
  };
  const dragged = (event) => {
    if (event.type !== "pointerdown" && !event.buttons) { return; }
    if (event.type === "pointerdown") { event.currentTarget.setPointerCapture(event.pointerId); }
    const box = event.currentTarget.getBoundingClientRect();
    turn((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
  };
  for (const id of ["ball", "picture"]) {
    $(id).addEventListener("pointerdown", dragged);
    $(id).addEventListener("pointermove", dragged);
  }
  for (const id of ["u", "v"]) { $(id).addEventListener("input", () => turn(Number($("u").value), Number($("v").value))); }

  const table = (head, rows) => {
    const made = make("table", undefined, { class: "hex" });
    const line = made.createTHead().insertRow();
    for (const name of head) { line.append(make("th", name, { scope: "col" })); }
    const body = made.createTBody();
    for (const row of rows) {
      const into = body.insertRow();
      for (const cell of row) { into.insertCell().append(cell instanceof Node ? cell : String(cell)); }
    }
    return made;
  };
  // On the site, codes and clauses link to their pages. The standalone file has no pages to link to.
  const linked = (text, place) => document.body.dataset.root === undefined || !place ? make("code", text) : make("a", text, { href: place });
  const chapters = JSON.parse($("chapters").textContent);
  const clausePlace = (clause) => {
    const section = chapters.filter((of) => clause.startsWith(`${of}/`) || clause.startsWith(`${of}.`)).sort((a, b) => b.length - a.length)[0];
    return section && `format/${section}.html#c-${clause.replace("/", "-")}`;
  };

  const describe = (name, length, { inspect, lint, map: found }) => {
    say(found ? `${name}: ${found.format}, ${found.width} × ${found.height}, ${length} bytes` : `${name}: not decoded; ${length} bytes`);
    const faults = $("faults");
    faults.replaceChildren();
    if (inspect.error) {
      faults.append(make("p", `Byte ${inspect.error.offset}, clause ${inspect.error.clause}, ${inspect.error.class}: ${inspect.error.what}`, { class: "fault" }));
    }
    if (found) { faults.append(make("p", "Planes, SHA-256: "), make("code", found.planes, { class: "digest" })); }
    faults.append(make("p", lint.length ? `Lint: ${lint.length}` : "Lint finds nothing.", { class: "label" }));
    if (lint.length) {
      faults.append(table(["code", "byte", "what", "to do"], lint.slice(0, 200).map((one) =>
        [linked(one.code, `codes/${one.code}.html`), one.offset, one.says + (one.found ? `: ${one.found}` : ""), one.fix ?? ""])));
    }
    $("fields").replaceChildren(table(["byte", "length", "clause", "what", "value"], inspect.fields.slice(0, 400).map((field) =>
      [field.offset, field.length, linked(field.clause, clausePlace(field.clause)), field.name, field.value.slice(0, 120)])));
  };

  const take = async (file) => {
    try {
      wasm = await started;
      const content = new Uint8Array(await file.arrayBuffer());
      const report = open(content);
      map = report.map;
      describe(file.name, content.length, report);
      $("result").hidden = false;
      $("screen").hidden = !map;
      if (map) {
        const canvas = $("picture");
        [canvas.width, canvas.height] = [map.width, map.height];
        const scale = Math.max(1, Math.floor(360 / Math.max(map.width, map.height)));
        canvas.style.width = map.width * scale > 1 ? `${map.width * scale}px` : "";
        image = canvas.getContext("2d").createImageData(map.width, map.height);
        show();
      }
    } catch (error) { say(`The file cannot be analyzed here: ${error.message}`); }
  };

  // Compares the image of a viewer with ours and describes the transform between them.
  let viewer;
  const apart = (one, other) => {
    let sum = 0;
    let worst = 0;
    for (let i = 0; i < one.length; i += 1) {
      if (i % 4 === 3) { continue; }
      const far = Math.abs(one[i] - other[i]);
      sum += far * far;
      if (far > worst) { worst = far; }
    }
    return { rmse: Math.sqrt(sum / (one.length / 4 * 3)), worst };
  };
  const changed = (source, place, value) => {
    const { width, height } = map;
    const made = new Uint8ClampedArray(source.length);
    for (let y = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        const [fx, fy] = place(x, y, width, height);
        const from = (fy * width + fx) * 4;
        const to = (y * width + x) * 4;
        const color = value([source[from], source[from + 1], source[from + 2]]);
        made.set([...color, 255], to);
      }
    }
    return made;
  };
  const same = (color) => color;
  const here = (x, y) => [x, y];
  const gamma = (value) => 255 * (value <= 0.0031308 * 255 ? 12.92 * value / 255 : 1.055 * (value / 255) ** (1 / 2.4) - 0.055);
  const linear = (value) => 255 * (value <= 0.04045 * 255 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const causes = () => {
    const at = (u, v) => new Uint8ClampedArray(relit(u, v, new ImageData(map.width, map.height)).data);
    const own = at(light.u, light.v);
    return [
      ["the same picture", own],
      ["rows the other way up: the bottom row is stored first", changed(own, (x, y, w, h) => [x, h - 1 - y], same)],
      ["columns the other way round", changed(own, (x, y, w) => [w - 1 - x, y], same)],
      ["turned by half a turn", changed(own, (x, y, w, h) => [w - 1 - x, h - 1 - y], same)],
      ["the light's v points down", at(light.u, -light.v)],
      ["the light's u points left", at(-light.u, light.v)],
      ["both components of the light are negated", at(-light.u, -light.v)],
      ["u and v are exchanged", at(light.v, light.u)],
      ["the light is (0, 0)", at(0, 0)],
      ["red and blue are exchanged", changed(own, here, ([r, g, b]) => [b, g, r])],
      ["green and blue are exchanged", changed(own, here, ([r, g, b]) => [r, b, g])],
      ["colors are sRGB-encoded once more", changed(own, here, (color) => color.map(gamma))],
      ["colors are sRGB-decoded", changed(own, here, (color) => color.map(linear))],
      ["gray instead of color", changed(own, here, ([r, g, b]) => [r, r, r].map(() => (r + g + b) / 3))],
    ].map(([says, pixels]) => ({ says, ...apart(pixels, viewer.data) })).sort((a, b) => a.rmse - b.rmse);
  };
  const compare = () => {
    const says = $("difference");
    if (!map || viewer.width !== map.width || viewer.height !== map.height) {
      says.textContent = `The image is ${viewer.width} × ${viewer.height}` + (map ? `, but the map is ${map.width} × ${map.height}, so they cannot be compared.` : ".");
      return;
    }
    const heat = new ImageData(map.width, map.height);
    const own = relit(light.u, light.v, image).data;
    for (let i = 0; i < own.length; i += 4) {
      const far = Math.max(...[0, 1, 2].map((c) => Math.abs(own[i + c] - viewer.data[i + c])));
      heat.data.set(far <= 1 ? [128, 128, 128, 40] : [255, 180 - far * 0.7, 60, 255], i);
    }
    const canvas = $("heat");
    [canvas.width, canvas.height] = [map.width, map.height];
    canvas.style.width = $("picture").style.width;
    canvas.getContext("2d").putImageData(heat, 0, 0);
    const { rmse, worst } = apart(own, viewer.data);
    if (worst <= 1) { says.textContent = "Under this light, the images are equal within one step of 255."; return; }
    const [first] = causes();
    const likely = first.rmse < Math.max(2, rmse / 4) ? ` It is nearest to: ${first.says} (then the mean difference is ${first.rmse.toFixed(1)}).` : " No simple cause fits; is it the same light?";
    says.textContent = `The mean difference is ${rmse.toFixed(1)} and the largest is ${worst}, of 255.${likely}`;
  };
  const takePicture = async (file) => {
    try {
      const bitmap = await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
      const canvas = Object.assign(document.createElement("canvas"), { width: bitmap.width, height: bitmap.height });
      const context = canvas.getContext("2d", { willReadFrequently: true });
      context.drawImage(bitmap, 0, 0);
      viewer = context.getImageData(0, 0, bitmap.width, bitmap.height);
      const shown = $("viewer");
      [shown.width, shown.height] = [bitmap.width, bitmap.height];
      shown.style.width = $("picture").style.width;
      shown.getContext("2d").putImageData(viewer, 0, 0);
      $("comparison").hidden = false;
      compare();
    } catch (error) { $("difference").textContent = `The browser cannot read this image: ${error.message}`; }
  };

  const isPicture = (file) => file.type.startsWith("image/");
  const takeAny = (file) => isPicture(file) ? takePicture(file) : take(file);
  $("file").addEventListener("change", (event) => { const [file] = event.target.files; if (file) { take(file); } });
  $("png").addEventListener("change", (event) => { const [file] = event.target.files; if (file) { takePicture(file); } });
  for (const [label, name, contents] of JSON.parse($("samples").textContent)) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: label });
    button.addEventListener("click", () => take(new File([Uint8Array.from(atob(contents), (c) => c.charCodeAt(0))], name)));
    $("try").append(" ", button);
  }
  document.addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("over"); });
  document.addEventListener("dragleave", () => document.body.classList.remove("over"));
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("over");
    for (const file of event.dataTransfer.files) { takeAny(file); }
  });
  started.then(() => say("Ready. Drop a PTM file, or choose one."), (error) => say(`WebAssembly does not start here: ${error.message}`));
  drawBall();
}
