(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const NS = "http://www.w3.org/2000/svg";
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];

  // Makes an element; `on…` are listeners, everything else is an attribute. Text is never HTML.
  function make(tag, attributes = {}, ...children) {
    const svg = ["svg", "path", "rect", "text", "line", "circle"].includes(tag);
    const node = svg ? document.createElementNS(NS, tag) : document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
      else if (value !== null && value !== undefined) node.setAttribute(name, value);
    }
    node.append(...children);
    return node;
  }

  // Writes a number with six significant digits.
  function short(x) {
    if (typeof x !== "number" || !Number.isFinite(x)) return exact(x);
    if (Number.isInteger(x) && Math.abs(x) < 1e6) return String(x).replace("-", "−");
    const size = Math.abs(x);
    const text = size >= 1e6 || (size > 0 && size < 1e-4)
      ? x.toExponential(5).replace(/\.?0+e/, "e")
      : String(Number(x.toPrecision(6)));
    return text.replace(/^-/, "−");
  }
  const exact = x => (x === null || x === undefined ? "–" : String(x).replace("Infinity", "inf"));
  const withUnit = (text, unit) => (unit && unit !== "1" ? `${text} ${unit}` : text);
  // Chooses a prefix for values up to a magnitude.
  function prefixed(unit, magnitude) {
    if (!/^(Pa|m|N|J|s)$/.test(unit) || !(magnitude > 0)) return [unit, 1];
    const step = Math.min(unit === "s" ? 0 : unit === "m" ? 1 : 3,
      Math.max(-5, Math.floor(Math.log10(magnitude) / 3 + 1e-9)));
    return [["f", "p", "n", "µ", "m", "", "k", "M", "G"][step + 5] + unit, 10 ** (3 * step)];
  }

  const jobs = data.jobs;
  const cellOf = (row, column) => ("same" in column ? column.same : jobs.rows[row][column.slot]) ?? null;
  jobs.columns.forEach(column => {
    const kinds = new Set(jobs.keys.map((_, row) => cellOf(row, column)).filter(x => x !== null)
      // JSON has no infinite numbers.
      .map(x => (column.number && typeof x === "string" ? "number" : typeof x)));
    column.kind = kinds.size > 1 ? "mixed" : kinds.has("number") ? "number" : kinds.has("string") ? "text" : null;
  });
  const listeners = [];
  let chosen = null;
  // Chooses the job of a row everywhere on the page.
  function choose(row) {
    chosen = row;
    listeners.forEach(listener => listener(row));
  }
  function value(row, column) {
    const cell = cellOf(row, column);
    return column.number && typeof cell === "string" ? (cell === "inf" ? Infinity : -Infinity) : cell;
  }
  const keyOf = row => jobs.keys[row];
  function quantity(x, unit) {
    if (typeof x !== "number") return exact(x);
    if (!Number.isFinite(x)) return withUnit(short(x), unit);
    const [name, per] = prefixed(unit, Math.abs(x));
    return withUnit(short(Number((x / per).toPrecision(6))), name);
  }
  const axesOf = row => jobs.columns.filter(column => column.group === "axis")
    .map(column => `${column.name} = ${quantity(value(row, column), column.unit)}`).join(", ");
  const nameOf = row => axesOf(row) || `job ${keyOf(row).slice(0, 8)}`;

  // ---- figures --------------------------------------------------------------------------------
  data.figures.forEach((figure, index) => {
    const box = document.querySelector(`[data-figure="${index}"]`);
    const svg = box.querySelector("svg");
    const title = svg.querySelector("title");
    const [along, up] = figure.axes[0];
    const name = title.textContent || `${up.label} over ${along.label}`;
    svg.setAttribute("aria-label", `${name}. Arrow keys go from point to point.`);
    // A title would cover the values with a bubble of its own.
    title.remove();
    svg.style.setProperty("--natural", `${svg.width.baseVal.value}px`);
    svg.setAttribute("role", "application");
    svg.setAttribute("tabindex", "0");
    const tip = box.appendChild(make("div", { class: "tip", role: "status" }));
    const mark = make("circle", { class: "spot", r: 6, visibility: "hidden" });
    const chosenMarks = [];
    svg.append(mark);
    const off = new Set();
    const spots = figure.spots.map(([panel, entry, left, top, x, y, row]) =>
      ({ panel, entry, left, top, x, y, row }));
    let current = null;

    const axisText = (axis, x) => {
      if (axis.categories.length) return `${axis.label}: ${axis.categories[Math.round(x)]}`;
      const scaled = axis.exponent < 0 ? x * 10 ** -axis.exponent : x / 10 ** axis.exponent;
      return `${axis.label} = ${withUnit(short(scaled), axis.unit)}`;
    };
    function show(spot) {
      current = spot;
      mark.setAttribute("visibility", spot ? "visible" : "hidden");
      if (!spot) { tip.textContent = ""; return; }
      mark.setAttribute("cx", spot.left);
      mark.setAttribute("cy", spot.top);
      const [x, y] = figure.axes[spot.panel];
      const lines = [figure.entries[spot.entry], axisText(x, spot.x), axisText(y, spot.y)];
      if (spot.row !== null) lines.push(`job ${keyOf(spot.row).slice(0, 8)}: click to choose it`);
      tip.textContent = lines.filter(line => line).join("\n");
      const place = new DOMPoint(spot.left, spot.top).matrixTransform(svg.getScreenCTM());
      const frame = box.getBoundingClientRect();
      const left = place.x - frame.left + 14;
      tip.style.left = `${Math.max(0, Math.min(left, frame.width - tip.offsetWidth - 4))}px`;
      tip.style.top = `${place.y - frame.top + 14}px`;
    }
    function nearest(event) {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      let best = null, least = 30;
      for (const spot of spots) {
        const distance = Math.hypot(spot.left - at.x, spot.top - at.y);
        if (distance < least && !off.has(spot.entry)) [best, least] = [spot, distance];
      }
      return best;
    }
    svg.addEventListener("pointermove", event => show(nearest(event)));
    svg.addEventListener("pointerdown", event => show(nearest(event)));
    // A finger leaves when it is lifted, and what it has pointed at stays to be read.
    svg.addEventListener("pointerleave", event => { if (event.pointerType !== "touch") show(null); });
    svg.addEventListener("click", event => {
      const spot = nearest(event);
      show(spot);
      if (spot && spot.row !== null && !event.target.closest("[data-legend]")) choose(spot.row);
    });
    svg.addEventListener("blur", () => show(null));
    svg.addEventListener("keydown", event => {
      if (event.target !== svg) return;
      const visible = spots.filter(spot => !off.has(spot.entry));
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (step && visible.length) {
        const place = visible.indexOf(current);
        const next = place < 0 ? (step > 0 ? 0 : visible.length - 1) : place + step;
        show(visible[(next + visible.length) % visible.length]);
      } else if (event.key === "Enter" && current && current.row !== null) choose(current.row);
      else if (event.key === "Escape") show(null);
      else return;
      event.preventDefault();
    });

    const drawn = new Set(spots.map(spot => spot.entry));
    all("[data-legend]", svg).forEach(label => {
      const entry = Number(label.dataset.legend);
      if (!drawn.has(entry)) return;
      label.setAttribute("role", "button");
      label.setAttribute("tabindex", "0");
      label.setAttribute("aria-pressed", "true");
      label.setAttribute("aria-label", `show ${figure.entries[entry]}`);
      const toggle = () => {
        const hide = !off.has(entry);
        hide ? off.add(entry) : off.delete(entry);
        label.classList.toggle("off", hide);
        label.setAttribute("aria-pressed", String(!hide));
        all(`[data-entry="${entry}"]`, svg).forEach(part => part.classList.toggle("off", hide));
        markChosen(chosen);
        show(null);
      };
      label.addEventListener("click", toggle);
      label.addEventListener("keydown", event => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        toggle();
      });
    });
    function markChosen(row) {
      chosenMarks.splice(0).forEach(old => old.remove());
      const wanted = spots.filter(spot => row !== null && spot.row === row && !off.has(spot.entry));
      const [look, r] = wanted.length > 8 ? ["spot chosen many", 3.5] : ["spot chosen", 7];
      for (const spot of wanted.slice(0, 500)) {
        const ring = make("circle", { class: look, r, cx: spot.left, cy: spot.top });
        svg.append(ring);
        chosenMarks.push(ring);
      }
    }
    listeners.push(markChosen);
  });

  // ---- the table ------------------------------------------------------------------------------
  const STEP = 25;
  // The most rows on paper, where a page has some fifty.
  const PRINTED = 1000;
  function table() {
    const box = document.getElementById("jobs-table");
    if (!box) return;
    const everything = jobs.keys.map((_, row) => row);
    const state = { sort: null, down: false, kept: everything, most: STEP, full: false };
    const body = make("tbody"), head = make("tr");
    const count = make("span", { class: "faint", role: "status", id: "jobs-count" });
    const problem = make("p", { class: "warning", hidden: "", role: "alert" });
    const more = make("button", { type: "button", onclick: () => { state.most = Infinity; draw(); } });
    const filter = make("input", {
      type: "search", id: "jobs-filter", "aria-label": "filter",
      placeholder: "filter: words, or mu > 0.3 && status == certified",
      oninput: () => { read(filter.value); draw(); },
    });
    const full = make("input", { type: "checkbox", onchange: () => { state.full = full.checked; draw(); } });

    const holds = (row, word) => keyOf(row).startsWith(word) || jobs.columns.some(column =>
      column.shown && exact(value(row, column)).toLowerCase().includes(word));
    function read(text) {
      state.kept = everything;
      let wrong = "";
      try {
        const test = jobFilter(text, jobs.columns, value, holds);
        state.kept = everything.filter(test);
      } catch (error) {
        if (!(error instanceof SyntaxError)) throw error;
        wrong = `${error.message} All rows are shown.`;
      }
      problem.textContent = wrong;
      problem.hidden = !wrong;
    }
    function rows() {
      const kept = [...state.kept];
      const column = state.sort;
      if (!column) return kept;
      const order = (a, b) => {
        const [x, y] = [value(a, column) ?? null, value(b, column) ?? null];
        if (x === null || y === null) return (x === null) - (y === null);
        const kinds = (typeof x === "string") - (typeof y === "string");
        const compared = kinds || (x < y ? -1 : x > y ? 1 : 0);
        return state.down ? -compared : compared;
      };
      return kept.sort((a, b) => order(a, b) || a - b);
    }
    function draw() {
      const columns = jobs.columns.filter(column => column.shown);
      const kept = rows();
      head.replaceChildren(make("th", { scope: "col" }, "job"), ...columns.map(column => {
        const sorted = state.sort === column;
        const arrow = sorted ? (state.down ? " ▼" : " ▲") : "";
        const sort = () => {
          if (!sorted) [state.sort, state.down] = [column, false];
          else if (!state.down) state.down = true;
          else [state.sort, state.down] = [null, false];
          draw();
          head.querySelector(`[data-column="${column.name}"]`)?.focus();
        };
        const button = make("button", { type: "button", title: column.meaning, onclick: sort,
          "data-column": column.name }, column.name + arrow);
        const cell = make("th", { scope: "col", class: column.number ? "number" : null,
          "aria-sort": sorted ? (state.down ? "descending" : "ascending") : "none" }, button);
        if (column.unit) cell.append(make("span", { class: "unit" }, `[${column.unit}]`));
        return cell;
      }));
      body.replaceChildren(...kept.slice(0, state.most).map(row => {
        const key = make("button", { type: "button" }, keyOf(row).slice(0, 8));
        const cells = columns.map(column => {
          const cell = value(row, column);
          const text = state.full || typeof cell !== "number" ? exact(cell) : short(cell);
          return make("td", { class: column.number ? "number" : null, title: exact(cell) }, text);
        });
        return make("tr", { "data-row": row, class: row === chosen ? "chosen" : null,
          onclick: () => choose(row) }, make("td", { class: "job" }, key), ...cells);
      }));
      const left = kept.length - Math.min(kept.length, state.most);
      more.hidden = left === 0;
      more.textContent = `show ${left} more`;
      const of = kept.length === jobs.rows.length ? "" : ` of ${jobs.rows.length}`;
      const shown = left ? `, the first ${state.most} are shown` : "";
      count.textContent = `${kept.length}${of} rows${shown}`;
    }
    const groups = [...new Set(jobs.columns.map(column => column.group))];
    const choices = groups.flatMap(group => [
      make("h3", {}, group),
      ...jobs.columns.filter(column => column.group === group).map(column => {
        const tick = make("input", { type: "checkbox", value: column.name,
          onchange: () => { column.shown = tick.checked; draw(); } });
        tick.checked = column.shown;
        return make("label", { title: column.meaning }, tick, ` ${column.name}`);
      }),
    ]);
    box.append(
      make("div", { class: "controls" }, filter, count,
        make("label", {}, full, " all digits")),
      make("details", { class: "columns" }, make("summary", {}, "Choose columns"),
        make("div", { class: "choices" }, ...choices)),
      problem,
      make("div", { class: "scroll" }, make("table", { id: "jobs" }, make("thead", {}, head), body)),
      more);
    draw();
    // All rows are printed, as far as that is sensible; the count says how many are not.
    let most = null;
    function print(begins) {
      if (begins === (most !== null)) return;
      if (begins) [most, state.most] = [state.most, Math.max(state.most, PRINTED)];
      else [state.most, most] = [most, null];
      draw();
    }
    addEventListener("beforeprint", () => print(true));
    addEventListener("afterprint", () => print(false));
    listeners.push(row => all("tr[data-row]", body).forEach(line =>
      line.classList.toggle("chosen", Number(line.dataset.row) === row)));
  }

  // ---- one job --------------------------------------------------------------------------------
  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  // Returns the values of a map, NaN where there is none.
  function decode(map, states) {
    if (map.names) return Float64Array.from(states);
    if (map.data === "") return Float64Array.from(states, state => (state === 0 ? NaN : map.low));
    const raw = bytes(map.data);
    const codes = map.bits === 16
      ? Uint16Array.from({ length: raw.length / 2 }, (_, i) => raw[2 * i] + 256 * raw[2 * i + 1]) : raw;
    const step = (map.high - map.low) / (2 ** map.bits - 2);
    return Float64Array.from(codes, code => (code === 0 ? NaN : map.low + (code - 1) * step));
  }
  function color(map, x) {
    if (map.names) return data.colors.states[x];
    if (Number.isNaN(x)) return null;
    const scale = map.signed ? data.colors.signed : data.colors.plain;
    const [low, high] = map.data === "" ? [map.low, map.low] : map.shade;
    const share = high > low ? (x - low) / (high - low) : 0;
    return scale[Math.max(0, Math.min(scale.length - 1, Math.round(share * (scale.length - 1))))];
  }
  function paint(canvas, job, map, values) {
    [canvas.width, canvas.height] = [job.nx, job.ny];
    const context = canvas.getContext("2d");
    const picture = context.createImageData(job.nx, job.ny);
    values.forEach((x, i) => {
      const rgb = color(map, x);
      if (!rgb) return;
      const place = 4 * ((job.ny - 1 - Math.floor(i / job.nx)) * job.nx + (i % job.nx));
      const number = parseInt(rgb, 16);
      picture.data.set([number >> 16, (number >> 8) & 255, number & 255, 255], place);
    });
    context.putImageData(picture, 0, 0);
  }

  function oneJob() {
    const box = document.getElementById("one-job");
    if (!box) return;
    const select = make("select", { id: "job-choice", "aria-label": "job with fields" });
    const facts = make("div"), maps = make("div", { id: "maps" });
    data.fields.forEach((job, index) => {
      const row = jobs.keys.indexOf(job.key);
      select.append(make("option", { value: index }, row < 0 ? job.key.slice(0, 8) : nameOf(row)));
    });
    select.addEventListener("change", () => {
      const job = data.fields[Number(select.value)];
      const row = jobs.keys.indexOf(job.key);
      if (row >= 0) choose(row); else drawMaps(job);
    });
    const state = { field: "pressure", along: 0, share: 0.5 };
    if (data.fields.length) {
      box.append(make("div", { class: "controls" }, make("label", {}, "job with fields: ", select)));
    }
    box.append(facts, maps);

    function drawFacts(row) {
      const reason = jobs.columns.find(column => column.name === "reason");
      const said = reason && value(row, reason);
      const groups = [...new Set(jobs.columns.map(column => column.group))].flatMap(group => {
        const lines = jobs.columns
          .filter(column => column.group === group && column.name !== "reason" && column.name !== "key")
          .filter(column => (value(row, column) ?? null) !== null)
          .map(column => make("div", { title: column.meaning }, make("dt", {}, column.name),
            make("dd", {}, quantity(value(row, column), column.unit))));
        return lines.length ? [make("h3", {}, group), make("dl", { class: "facts" }, ...lines)] : [];
      });
      facts.replaceChildren(
        make("h3", { id: "job-title" }, nameOf(row)),
        make("pre", { class: "command" }, `tribosweep show ${keyOf(row)}`),
        ...(said ? [make("p", { class: "warning" }, said)] : []),
        make("details", {}, make("summary", {}, "Every number of this job"), ...groups));
    }

    function drawMaps(job) {
      if (!job) {
        const say = words => make("p", { class: "faint" }, words);
        const status = jobs.columns.find(column => column.name === "status");
        if (chosen === null) maps.replaceChildren();
        else if (jobs.fieldless.includes(chosen)) {
          const hasResult = status && value(chosen, status) !== null;
          maps.replaceChildren(say(hasResult ? "This job has left no fields." : "This job has no result yet."));
        } else {
          const keys = [...data.fields.map(other => other.key), keyOf(chosen)].map(key => key.slice(0, 12));
          maps.replaceChildren(say("The fields of this job are not in this page. This adds them:"),
            make("pre", { class: "command" }, `${data.report} --fields ${keys.join(",")}`));
        }
        return;
      }
      select.value = data.fields.indexOf(job);
      if (!job.maps.some(map => map.name === state.field)) state.field = job.maps[0].name;
      const codes = bytes(job.maps.find(map => map.names).data);
      const values = new Map(job.maps.map(map => [map, decode(map, codes)]));
      const map = job.maps.find(map => map.name === state.field);
      const field = values.get(map);
      const lengths = [job.nx * job.element[0], job.ny * job.element[1]];
      const ends = [0, 1].map(k => [job.origin[k], job.origin[k] + lengths[k]]);
      const [lengthUnit, perLength] = prefixed("m", Math.max(...ends.flat().map(Math.abs)));
      const [unit, per] = prefixed(map.unit, Math.max(Math.abs(map.low), Math.abs(map.high)));
      const words = x => (map.names ? map.names[x] : Number.isNaN(x) ? "no value"
        : withUnit(short(Number((x / per).toPrecision(4))), unit));
      const length = x => `${short(Number((x / perLength).toPrecision(4)))} ${lengthUnit}`;

      const thumbs = job.maps.map(other => {
        const canvas = make("canvas");
        paint(canvas, job, other, values.get(other));
        const [width, height] = fit(lengths, 84);
        canvas.style.width = `${width}px`;
        canvas.style.height = `${height}px`;
        return make("button", { type: "button", "aria-pressed": String(other === map),
          "data-field": other.name,
          onclick: () => {
            state.field = other.name;
            drawMaps(job);
            maps.querySelector(`[data-field="${other.name}"]`).focus();
          } }, canvas, other.name);
      });

      const canvas = make("canvas");
      paint(canvas, job, map, field);
      const [width, height] = fit(lengths, Math.min(380, Math.max(200, box.clientWidth - 120)));
      const line = make("div", { class: "line" });
      const plate = make("div", { class: "map", tabindex: "0", role: "slider", id: "map",
        "aria-label": "section line; arrow keys move it" }, canvas, line);
      plate.style.width = `${width}px`;
      plate.style.height = `${height}px`;
      const bar = make("div", { class: "bar" });
      const isFlat = map.data === "";
      if (map.names || isFlat) bar.style.visibility = "hidden";
      else {
        const scale = map.signed ? data.colors.signed : data.colors.plain;
        bar.style.background = `linear-gradient(to top, ${scale.map(rgb => `#${rgb}`).join(",")})`;
        const [low, high] = map.shade;
        [["high", high], ["middle", (low + high) / 2], ["low", low]].forEach(([name, x]) =>
          bar.append(make("span", { class: name }, words(x))));
      }
      bar.style.height = `${height}px`;
      bar.style.marginRight = map.names ? "0" : "5rem";
      const readout = make("p", { class: "readout", role: "status", id: "map-readout" });
      const step = map.names || isFlat ? "" : ` The page holds it in steps of ${
        quantity(Number(((map.high - map.low) / (2 ** map.bits - 2)).toPrecision(2)), map.unit)}.`;
      const rest = isFlat ? `The ${map.name} is ${words(map.low)} everywhere.`
        : `The ${map.name} runs from ${words(map.low)} to ${words(map.high)}.${step}`;
      readout.textContent = map.names ? "" : rest;
      const section = make("svg", { class: "section-plot", id: "section", viewBox: "0 0 400 250",
        width: 400, height: 250, role: "img" });
      const other = make("button", { type: "button", id: "section-turn",
        onclick: () => { state.along = 1 - state.along; moved(); } });

      function moved() {
        const along = state.along, across = 1 - along;
        const counts = [job.nx, job.ny];
        const index = Math.max(0, Math.min(counts[across] - 1, Math.floor(state.share * counts[across])));
        const share = (index + 0.5) / counts[across];
        const place = `${(across === 1 ? 1 - share : share) * 100}%`;
        Object.assign(line.style, across === 1
          ? { top: place, left: "0", width: "100%", height: "1.5px" }
          : { left: place, top: "0", height: "100%", width: "1.5px" });
        const at = job.origin[across] + (index + 0.5) * job.element[across];
        const name = `${map.name} along ${"xy"[along]} at ${"xy"[across]} = ${length(at)}`;
        plate.setAttribute("aria-valuenow", String(index));
        plate.setAttribute("aria-valuemin", "0");
        plate.setAttribute("aria-valuemax", String(counts[across] - 1));
        plate.setAttribute("aria-valuetext", name);
        other.textContent = `turn the section along ${"xy"[across]}`;
        drawSection(along, index, name);
      }
      function drawSection(along, index, name) {
        const count = along === 0 ? job.nx : job.ny;
        const [least, most] = isFlat ? [map.low, map.low] : map.names ? [0, map.names.length - 1] : map.shade;
        const [low, high] = [Math.min(least, 0), Math.max(most, 0)];
        const frame = { x: 74, y: 26, width: 314, height: 176 };
        const place = (i, x) => [frame.x + (frame.width * (i + 0.5)) / count,
          frame.y + frame.height * (high > low ? (high - x) / (high - low) : 0.5)];
        let path = "", pen = "M";
        for (let i = 0; i < count; i++) {
          const x = field[along === 0 ? index * job.nx + i : i * job.nx + index];
          if (Number.isNaN(x)) { pen = "M"; continue; }
          path += pen + place(i, x).map(c => c.toFixed(1)).join(" ");
          if (pen === "M") path += "h0.1";
          pen = "L";
        }
        const text = (x, y, anchor, words) => make("text", { x, y, "text-anchor": anchor }, words);
        const zero = place(0, 0)[1];
        const from = job.origin[along], to = from + lengths[along];
        const bottom = frame.y + frame.height;
        const labels = map.names
          ? map.names.map((state, i) => text(frame.x - 6, place(0, i)[1] + 4, "end", state))
          : [text(frame.x - 6, frame.y + 10, "end", words(high)), text(frame.x - 6, bottom, "end", words(low))];
        section.setAttribute("aria-label", name);
        section.replaceChildren(text(0, 14, "start", name), make("rect", frame),
          make("line", { class: "zero", x1: frame.x, x2: frame.x + frame.width, y1: zero, y2: zero }),
          make("path", { d: path || "M0 0" }), ...labels,
          text(frame.x, bottom + 16, "start", length(from)),
          text(frame.x + frame.width / 2, bottom + 32, "middle", "xy"[along]),
          text(frame.x + frame.width, bottom + 16, "end", length(to)));
      }
      const shares = event => {
        const frame = canvas.getBoundingClientRect();
        const inside = share => Math.max(0, Math.min(0.999999, share));
        return [inside((event.clientX - frame.left) / frame.width),
          inside(1 - (event.clientY - frame.top) / frame.height)];
      };
      let dragged = false;
      function tell(event) {
        const at = shares(event);
        const [i, j] = [Math.floor(at[0] * job.nx), Math.floor(at[1] * job.ny)];
        const centre = [0, 1].map(k => length(job.origin[k] + ([i, j][k] + 0.5) * job.element[k]));
        readout.textContent = `x = ${centre[0]}, y = ${centre[1]}: ${map.name} ${words(field[j * job.nx + i])}`;
      }
      plate.addEventListener("pointermove", event => {
        if (dragged) { state.share = shares(event)[1 - state.along]; moved(); }
        tell(event);
      });
      plate.addEventListener("pointerleave", event => {
        if (event.pointerType !== "touch") readout.textContent = map.names ? "" : rest;
      });
      plate.addEventListener("pointerdown", event => {
        dragged = true;
        plate.setPointerCapture(event.pointerId);
        state.share = shares(event)[1 - state.along];
        moved();
        tell(event);
      });
      const drop = () => { dragged = false; };
      plate.addEventListener("pointerup", drop);
      plate.addEventListener("pointercancel", drop);
      plate.addEventListener("keydown", event => {
        const step = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key];
        if (!step) return;
        event.preventDefault();
        const count = state.along === 0 ? job.ny : job.nx;
        const index = Math.max(0, Math.min(count - 1, Math.floor(state.share * count) + step));
        state.share = (index + 0.5) / count;
        moved();
      });

      const key = map.names ? [make("p", { class: "legend-of-states" }, ...map.names.map((name, i) => {
        const swatch = make("i");
        if (data.colors.states[i]) swatch.style.background = `#${data.colors.states[i]}`;
        return make("span", {}, swatch, name);
      }))] : [];
      maps.replaceChildren(
        ...job.notes.map(note => make("p", { class: "faint" }, note)),
        make("div", { class: "thumbs" }, ...thumbs),
        make("div", { class: "plates" },
          make("div", {}, ...key, make("div", { class: "plate" }, plate, bar, readout)),
          make("div", {}, section, make("div", { class: "controls" }, other))));
      moved();
    }
    const fit = ([x, y], side) => {
      const per = side / Math.max(x, y);
      return [Math.max(12, x * per), Math.max(12, y * per)];
    };
    listeners.push(row => {
      if (row === null) return;
      drawFacts(row);
      drawMaps(data.fields.find(job => job.key === keyOf(row)));
    });
  }

  table();
  oneJob();
  if (jobs.keys.length) {
    const first = data.fields.length ? jobs.keys.indexOf(data.fields[0].key) : 0;
    choose(Math.max(0, first));
  }
})();
