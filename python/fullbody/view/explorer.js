// Sliders beside a scene and curves. When a slider moves, the run is computed again; values that are superseded meanwhile are skipped.
// `compute(values)` resolves to { scene, curves, time, unit, notice }: the argument of `scene().load`, a list of { label, unit, values, inverted },
// the times (K,) of the curves and their unit, and a text or nothing. It rejects with an error whose message is shown beside the slider.

const INK = "#1b5e92", BAND = "rgba(27, 94, 146, .35)", MARK = "#b3261e", GREY = "#666";

// Returns a number as text with at most four digits.
function brief(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(4));
}

// Returns a number with six digits; zero for one that is zero within the rounding of its slider's range.
function rounded(value, range) {
  return Math.abs(value) < 1e-9 * range ? 0 : +value.toPrecision(6);
}

// Draws a curve with a mark at the time that the scene shows. Where a column of pixels has several samples, their envelope and mean are drawn.
function draw_curve(canvas, { label, unit, values, inverted }, time, time_unit, position) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width) return;
  [canvas.width, canvas.height] = [width * ratio, height * ratio];
  const pen = canvas.getContext("2d"), [left, right, top, bottom] = [64, 12, 22, 20];
  pen.scale(ratio, ratio);
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  let [low, up] = [Infinity, -Infinity];
  for (const value of values) if (Number.isFinite(value)) [low, up] = [Math.min(low, value), Math.max(up, value)];
  pen.fillStyle = "#222";
  pen.fillText(unit ? `${label} [${unit}]` : label, left, 14);
  if (low > up) {
    pen.fillText("has no values in this run", left, height / 2);
    return;
  }
  // A curve that is constant but for rounding is drawn as a line.
  const span = Math.max(up - low, 1e-12 * Math.max(Math.abs(up), Math.abs(low)), 1e-300), last = values.length - 1;
  const x = k => left + (width - left - right) * (time[k] - time[0]) / (time[last] - time[0]);
  const y = value => {
    const share = (value - low) / span;
    return top + (height - top - bottom) * (inverted ? share : 1 - share);
  };
  pen.strokeStyle = "#ccc";
  pen.strokeRect(left, top, width - left - right, height - top - bottom);
  pen.textAlign = "right";
  for (const value of up > low ? [low, up] : [low]) pen.fillText(brief(value), left - 5, y(value) + 4);
  pen.textAlign = "left";
  pen.fillStyle = GREY;
  pen.fillText(brief(time[0]), left, height - 5);
  pen.textAlign = "right";
  pen.fillText(`${brief(time[last])} ${time_unit}`.trim(), width - right, height - 5);
  pen.textAlign = "left";
  if (values.length > 2 * width) {
    const columns = new Map();
    values.forEach((value, k) => {
      if (!Number.isFinite(value)) return;
      const column = Math.round(x(k)), summary = columns.get(column) || [Infinity, -Infinity, 0, 0];
      columns.set(column, [Math.min(summary[0], value), Math.max(summary[1], value), summary[2] + value, summary[3] + 1]);
    });
    pen.strokeStyle = BAND;
    pen.beginPath();
    for (const [column, [least, most]] of columns) {
      pen.moveTo(column, y(least) + 0.5);
      pen.lineTo(column, y(most) - 0.5);
    }
    pen.stroke();
    pen.strokeStyle = INK;
    pen.beginPath();
    for (const [column, [, , sum, count]] of columns) pen.lineTo(column, y(sum / count));
    pen.stroke();
  } else {
    pen.strokeStyle = INK;
    pen.lineWidth = 1.2;
    pen.beginPath();
    let drawing = false;
    values.forEach((value, k) => {
      if (Number.isFinite(value)) pen[drawing ? "lineTo" : "moveTo"](x(k), y(value));
      drawing = Number.isFinite(value);
    });
    pen.stroke();
  }
  const now = left + (width - left - right) * position;
  pen.strokeStyle = MARK;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(now, top);
  pen.lineTo(now, height - bottom);
  pen.stroke();
}

// Makes the explorer within an element; `code(values)` returns the text of the lines that make the same run in Python.
function explorer(root, { compute, code, onValues = () => {} }) {
  root.classList.add("fullbody-explorer");
  root.innerHTML = `<form class="fullbody-controls" onsubmit="return false"></form>
<div class="fullbody-shown"><div class="fullbody-view" tabindex="0"></div><p class="fullbody-notice" role="status"></p><div class="fullbody-curves"></div>
<p><button type="button" class="fullbody-copy">Copy as Python</button></p><pre class="fullbody-code" hidden></pre></div>`;
  const element = name => root.querySelector(`.fullbody-${name}`);
  let values = {}, faults = {}, moved = null, busy = false, waiting = false, shown = null, position = 0;
  const picture = scene(element("view"), now => {
    position = now;
    redraw();
  });

  function redraw() {
    if (!shown) return;
    [...element("curves").children].forEach((canvas, k) => draw_curve(canvas, shown.curves[k], shown.time, shown.unit, position));
  }

  function seek(event) {
    if (!event.buttons) return;
    const box = event.target.getBoundingClientRect();
    picture.seek((event.clientX - box.left - 64) / (box.width - 76));
  }

  function load(result) {
    const first = !shown;
    shown = result;
    const charts = element("curves");
    while (charts.children.length > result.curves.length) charts.lastChild.remove();
    while (charts.children.length < result.curves.length) {
      const canvas = document.createElement("canvas");
      canvas.onpointerdown = canvas.onpointermove = seek;
      charts.append(canvas);
    }
    result.curves.forEach((curve, k) => charts.children[k].setAttribute("aria-label", `${curve.label} against time`));
    picture.load(result.scene);
    if (first) picture.seek(0);
    redraw();
    element("notice").textContent = result.notice || "";
    // Tests listen to this event for the numbers that are shown.
    root.dispatchEvent(new CustomEvent("fullbody-result", { detail: { values: { ...values }, ...result } }));
  }

  async function update() {
    if (busy) {
      waiting = true;
      return;
    }
    busy = true;
    root.setAttribute("aria-busy", "true");
    do {
      waiting = false;
      const name = moved;
      try {
        const result = await compute({ ...values });
        for (const fault of Object.values(faults)) fault.textContent = "";
        load(result);
      } catch (error) {
        // The last good run stays on the page.
        const fault = faults[name] || element("notice");
        fault.textContent = error.message;
      }
    } while (waiting);
    busy = false;
    root.setAttribute("aria-busy", "false");
  }

  // Makes the sliders of groups [{ title, open, controls: [{ name, label, min, max, value, unit }] }], and computes their run.
  function setControls(groups) {
    values = {};
    faults = {};
    moved = null;
    element("controls").replaceChildren(...groups.map(({ title, open, controls }) => {
      const group = document.createElement("details"), summary = document.createElement("summary");
      group.open = open;
      summary.textContent = title;
      group.append(summary);
      for (const { name, label, min, max, value, unit } of controls) {
        values[name] = value;
        const row = document.createElement("label"), text = document.createElement("span");
        const slider = document.createElement("input"), number = document.createElement("input"), fault = document.createElement("em");
        text.textContent = unit ? `${label} [${unit}]` : label;
        Object.assign(slider, { type: "range", min, max, step: "any", value, name });
        Object.assign(number, { type: "number", step: "any", value: rounded(value, max - min) });
        number.setAttribute("aria-label", `${label}, typed in`);
        fault.setAttribute("role", "alert");
        faults[name] = fault;
        // With the step "any" browsers move a slider by too little for a key.
        slider.onkeydown = event => {
          const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
          if (!sign) return;
          slider.value = +slider.value + sign * (max - min) / (event.shiftKey ? 1000 : 100);
          slider.oninput();
          event.preventDefault();
        };
        const change = value => {
          values[name] = value;
          moved = name;
          onValues({ ...values });
          update();
        };
        slider.oninput = () => {
          number.value = rounded(+slider.value, max - min);
          change(+slider.value);
        };
        number.onchange = () => {
          if (!Number.isFinite(number.valueAsNumber)) {
            fault.textContent = `${label} has to be a number`;
            return;
          }
          slider.value = number.valueAsNumber;
          change(number.valueAsNumber);
        };
        row.append(text, slider, number, fault);
        group.append(row);
      }
      return group;
    }));
    update();
  }

  element("copy").onclick = async () => {
    const text = await code({ ...values });
    Object.assign(element("code"), { textContent: text, hidden: false });
    try {
      await navigator.clipboard.writeText(text);
      element("copy").textContent = "Copied";
    } catch {
      element("copy").textContent = "Copy as Python: select the lines below";
    }
  };
  new ResizeObserver(redraw).observe(element("curves"));
  return { setControls, update, picture };
}
