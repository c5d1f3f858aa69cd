// The reference decoder as WebAssembly reads the file in this page. No data leaves the page.
"use strict";
{
  const $ = (id) => document.getElementById(id);
  const make = (name, text, attributes = {}) => {
    const element = Object.assign(document.createElement(name), text === undefined ? {} : { textContent: text });
    for (const [key, value] of Object.entries(attributes)) { element.setAttribute(key, value); }
    return element;
  };
  const setStatus = (text) => { $("status").textContent = text; };
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
    const offset = wasm.reserve(file.length);
    new Uint8Array(wasm.memory.buffer, offset, file.length).set(file);
    wasm.open();
    wasm.examine();
    const [start, length] = [wasm.report(), wasm.report_length()];
    const report = new Uint8Array(wasm.memory.buffer, start, length);
    return JSON.parse(new TextDecoder().decode(report));
  };

  const relight = (u, v, target) => {
    // Rendering may grow the memory and replace its buffer, so get the buffer afterwards.
    const offset = wasm.relight(u, v);
    target.data.set(new Uint8ClampedArray(wasm.memory.buffer, offset, map.width * map.height * 4));
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
      $("picture").getContext("2d").putImageData(relight(light.u, light.v, image), 0, 0);
      if (viewer) { compare(); }
    }
  };
  let waiting = false;
  const setLight = (u, v) => {
    const length = Math.hypot(u, v);
    [light.u, light.v] = length > 1 ? [u / length, v / length] : [u, v];
    if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; show(); }); }
  };
  const onDrag = (event) => {
    if (event.type !== "pointerdown" && !event.buttons) { return; }
    if (event.type === "pointerdown") { event.currentTarget.setPointerCapture(event.pointerId); }
    const box = event.currentTarget.getBoundingClientRect();
    setLight((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
  };
  for (const id of ["ball", "picture"]) {
    $(id).addEventListener("pointerdown", onDrag);
    $(id).addEventListener("pointermove", onDrag);
  }
  for (const id of ["u", "v"]) { $(id).addEventListener("input", () => setLight(Number($("u").value), Number($("v").value))); }

  const table = (head, rows) => {
    const element = make("table", undefined, { class: "hex" });
    const header = element.createTHead().insertRow();
    for (const name of head) { header.append(make("th", name, { scope: "col" })); }
    const body = element.createTBody();
    for (const row of rows) {
      const line = body.insertRow();
      for (const cell of row) { line.insertCell().append(cell instanceof Node ? cell : String(cell)); }
    }
    return element;
  };
  // On the site, codes and clauses link to their pages. The standalone file has no pages to link to.
  const linkOrCode = (text, url) => document.body.dataset.root === undefined || !url ? make("code", text) : make("a", text, { href: url });
  const chapters = JSON.parse($("chapters").textContent);
  const clauseUrl = (clause) => {
    const section = chapters.filter((id) => clause.startsWith(`${id}/`) || clause.startsWith(`${id}.`)).sort((a, b) => b.length - a.length)[0];
    return section && `format/${section}.html#c-${clause.replace("/", "-")}`;
  };

  const describe = (name, length, { inspect, lint, map: found }) => {
    setStatus(found ? `${name}: ${found.format}, ${found.width} × ${found.height}, ${length} bytes` : `${name}: not decoded; ${length} bytes`);
    const faults = $("faults");
    faults.replaceChildren();
    if (inspect.error) {
      faults.append(make("p", `Byte ${inspect.error.offset}, clause ${inspect.error.clause}, ${inspect.error.class}: ${inspect.error.what}`, { class: "fault" }));
    }
    if (found) { faults.append(make("p", "Planes, SHA-256: "), make("code", found.planes, { class: "digest" })); }
    faults.append(make("p", lint.length ? `Lint findings: ${lint.length}` : "Lint has no findings.", { class: "label" }));
    if (lint.length) {
      faults.append(table(["code", "byte", "message", "fix"], lint.slice(0, 200).map((finding) =>
        [linkOrCode(finding.code, `codes/${finding.code}.html`), finding.offset, finding.says + (finding.found ? `: ${finding.found}` : ""), finding.fix ?? ""])));
    }
    $("fields").replaceChildren(table(["byte", "length", "clause", "field", "value"], inspect.fields.slice(0, 400).map((field) =>
      [field.offset, field.length, linkOrCode(field.clause, clauseUrl(field.clause)), field.name, field.value.slice(0, 120)])));
  };

  const loadFile = async (file) => {
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
    } catch (error) { setStatus(`The file cannot be analyzed: ${error.message}`); }
  };

  // Compares the image from a viewer with the rendered one, and describes the transform between them.
  let viewer;
  const difference = (a, b) => {
    let sum = 0;
    let worst = 0;
    for (let i = 0; i < a.length; i += 1) {
      if (i % 4 === 3) { continue; }
      const error = Math.abs(a[i] - b[i]);
      sum += error * error;
      if (error > worst) { worst = error; }
    }
    return { rmse: Math.sqrt(sum / (a.length / 4 * 3)), worst };
  };
  const transformed = (source, position, value) => {
    const { width, height } = map;
    const result = new Uint8ClampedArray(source.length);
    for (let y = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        const [fx, fy] = position(x, y, width, height);
        const from = (fy * width + fx) * 4;
        const to = (y * width + x) * 4;
        const color = value([source[from], source[from + 1], source[from + 2]]);
        result.set([...color, 255], to);
      }
    }
    return result;
  };
  const sameColor = (color) => color;
  const samePosition = (x, y) => [x, y];
  const gamma = (value) => 255 * (value <= 0.0031308 * 255 ? 12.92 * value / 255 : 1.055 * (value / 255) ** (1 / 2.4) - 0.055);
  const linear = (value) => 255 * (value <= 0.04045 * 255 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const causes = () => {
    const render = (u, v) => new Uint8ClampedArray(relight(u, v, new ImageData(map.width, map.height)).data);
    const own = render(light.u, light.v);
    return [
      ["the same image", own],
      ["the rows are reversed: the bottom row is stored first", transformed(own, (x, y, w, h) => [x, h - 1 - y], sameColor)],
      ["the columns are reversed", transformed(own, (x, y, w) => [w - 1 - x, y], sameColor)],
      ["the image is rotated by 180°", transformed(own, (x, y, w, h) => [w - 1 - x, h - 1 - y], sameColor)],
      ["the v axis of the light points down", render(light.u, -light.v)],
      ["the u axis of the light points left", render(-light.u, light.v)],
      ["both components of the light are negated", render(-light.u, -light.v)],
      ["u and v are swapped", render(light.v, light.u)],
      ["the light is (0, 0)", render(0, 0)],
      ["red and blue are swapped", transformed(own, samePosition, ([r, g, b]) => [b, g, r])],
      ["green and blue are swapped", transformed(own, samePosition, ([r, g, b]) => [r, b, g])],
      ["colors are sRGB-encoded", transformed(own, samePosition, (color) => color.map(gamma))],
      ["colors are sRGB-decoded", transformed(own, samePosition, (color) => color.map(linear))],
      ["colors are converted to gray", transformed(own, samePosition, ([r, g, b]) => [r, r, r].map(() => (r + g + b) / 3))],
    ].map(([cause, pixels]) => ({ cause, ...difference(pixels, viewer.data) })).sort((a, b) => a.rmse - b.rmse);
  };
  const compare = () => {
    const output = $("difference");
    if (!map || viewer.width !== map.width || viewer.height !== map.height) {
      output.textContent = `The size of the image is ${viewer.width} × ${viewer.height}` + (map ? `, but the size of the map is ${map.width} × ${map.height}, so they cannot be compared.` : ".");
      return;
    }
    const heat = new ImageData(map.width, map.height);
    const own = relight(light.u, light.v, image).data;
    for (let i = 0; i < own.length; i += 4) {
      const error = Math.max(...[0, 1, 2].map((c) => Math.abs(own[i + c] - viewer.data[i + c])));
      heat.data.set(error <= 1 ? [128, 128, 128, 40] : [255, 180 - error * 0.7, 60, 255], i);
    }
    const canvas = $("heat");
    [canvas.width, canvas.height] = [map.width, map.height];
    canvas.style.width = $("picture").style.width;
    canvas.getContext("2d").putImageData(heat, 0, 0);
    const { rmse, worst } = difference(own, viewer.data);
    if (worst <= 1) { output.textContent = "Under this light, the colors of the images differ by at most 1 of 255."; return; }
    const [first] = causes();
    const likely = first.rmse < Math.max(2, rmse / 4) ? ` The most likely cause: ${first.cause} (with it, the RMS difference is ${first.rmse.toFixed(1)}).` : " No simple cause fits. Check that the light is the same.";
    output.textContent = `The RMS difference is ${rmse.toFixed(1)}, and the largest difference is ${worst}, of 255.${likely}`;
  };
  const loadPicture = async (file) => {
    try {
      const bitmap = await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
      const canvas = Object.assign(document.createElement("canvas"), { width: bitmap.width, height: bitmap.height });
      const context = canvas.getContext("2d", { willReadFrequently: true });
      context.drawImage(bitmap, 0, 0);
      viewer = context.getImageData(0, 0, bitmap.width, bitmap.height);
      const target = $("viewer");
      [target.width, target.height] = [bitmap.width, bitmap.height];
      target.style.width = $("picture").style.width;
      target.getContext("2d").putImageData(viewer, 0, 0);
      $("comparison").hidden = false;
      compare();
    } catch (error) { $("difference").textContent = `The browser cannot read this image: ${error.message}`; }
  };

  const isPicture = (file) => file.type.startsWith("image/");
  const load = (file) => isPicture(file) ? loadPicture(file) : loadFile(file);
  $("file").addEventListener("change", (event) => { const [file] = event.target.files; if (file) { loadFile(file); } });
  $("png").addEventListener("change", (event) => { const [file] = event.target.files; if (file) { loadPicture(file); } });
  for (const [label, name, contents] of JSON.parse($("samples").textContent)) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: label });
    button.addEventListener("click", () => loadFile(new File([Uint8Array.from(atob(contents), (c) => c.charCodeAt(0))], name)));
    $("try").append(" ", button);
  }
  document.addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("over"); });
  document.addEventListener("dragleave", () => document.body.classList.remove("over"));
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("over");
    for (const file of event.dataTransfer.files) { load(file); }
  });
  started.then(() => setStatus("Ready. Drop a PTM file, or choose one."), (error) => setStatus(`The browser cannot start the WebAssembly module: ${error.message}`));
  drawBall();
}
