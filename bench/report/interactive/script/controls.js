// Draw: charts, controls, zoom, and what follows from a change of the state.

const config = () => {
  const [text, soft, gridColor] = ["--text", "--soft", "--grid"].map(pageColor);
  const axis = { labelFontSize: 12, titleFontSize: 12, titleFontWeight: "normal", labelColor: text, titleColor: text, gridColor, domainColor: soft, tickColor: soft };
  return { background: "transparent", font: "system-ui, 'DejaVu Sans', sans-serif", view: { stroke: null }, axis };
};
const drawn = new Map(); // the chart of each place, so that an older one ends
const embed = async (place, spec) => {
  const number = (drawn.get(place)?.number ?? 0) + 1;
  const before = drawn.get(place);
  drawn.set(place, { ...before, number });
  place.dataset.ready = "";
  const canvas = make("div", { ariaHidden: "true" }); // the place has a label, and the page a table of its values
  try {
    const marks = spec.data.values.length > 4000 && !spec.vconcat;
    const made = await vegaEmbed(canvas, { config: config(), ...(spec.vconcat ? {} : { autosize: { type: "fit-x", contains: "padding" } }), ...spec }, { mode: "vega-lite", ast: true, actions: false, defaultStyle: false, renderer: marks ? "canvas" : "svg" });
    if (drawn.get(place).number !== number) return made.finalize();
    drawn.get(place).made?.finalize();
    drawn.set(place, { number, made });
    place.replaceChildren(canvas);
    place.dataset.ready = String(number);
    return made.view;
  } catch (error) {
    place.replaceChildren(make("p", { textContent: `This cannot be drawn: ${error.message}` }));
    place.dataset.ready = String(number);
  }
};

const body = part.querySelector(".further-body");
const width = () => Math.max((chart.clientWidth || body.clientWidth) - 18, 200);
const labelled = (name, control, ...more) => make("label", { className: "choice" }, `${name} `, control, ...more);
const option = (value, name) => make("option", { value, textContent: name });
const button = (name, onclick) => make("button", { type: "button", textContent: name, onclick });

const views = make("fieldset", { className: "views" }, make("legend", { textContent: "View" }));
for (const [name, title] of Object.entries(VIEWS))
  views.append(make("label", {}, make("input", { type: "radio", name: "further-view", value: name, onchange: () => change({ view: name }) }), ` ${title}`));

const problem = make("select", { onchange: () => change({ problem: problem.value === "" ? null : Number(problem.value), run: null }) });
const budget = make("input", { type: "range", min: 0, max: last, step: 1, oninput: () => change({ budget: Number(budget.value) }) });
const budgetText = make("output");
const target = make("input", { type: "range", min: -1, max: levels.length - 1, step: 1, oninput: () => change({ target: Number(target.value) }) });
const targetText = make("output");
const quantity = make("select", { onchange: () => change({ distance: quantity.value === "distance" }) }, option("value", "the value"), option("distance", "its distance from the best"));
const xlog = make("input", { type: "checkbox", onchange: () => change({ xlog: xlog.checked }) });
const ylog = make("input", { type: "checkbox", onchange: () => change({ ylog: ylog.checked }) });
const zooms = make("span", { className: "zooms", role: "group", ariaLabel: "Zoom" },
  button("Zoom in", () => zoom(0.5)), button("Zoom out", () => zoom(2)), button("Whole", () => change({ zoom: null })));
const choices = {
  problem: labelled("Problem", problem), budget: labelled("Budget", budget, budgetText), target: labelled("Target", target, targetText),
  quantity: labelled("Show", quantity), xlog: labelled("log x", xlog), ylog: labelled("log values", ylog), zooms,
};

const checks = (title, items, isChosen, onchoose) => {
  const summary = make("summary");
  const boxes = items.map((name, place) => {
    const box = make("input", { type: "checkbox", onchange: () => onchoose([place], box.checked) });
    return make("label", {}, box, ` ${name}`);
  });
  const places = items.map((_, place) => place);
  const both = make("p", {}, button("All", () => onchoose(places, true)), " ", button("None", () => onchoose(places, false)));
  const element = make("details", { className: "checks" }, summary, both, make("div", { className: "boxes" }, ...boxes));
  const sync = (shown) => {
    boxes.forEach((label, place) => (label.firstChild.checked = isChosen(place)));
    summary.textContent = `${title}: ${shown} of ${items.length}`;
  };
  return { element, sync, both };
};
const optimizerChecks = checks("Optimizers", optimizers.map((each) => each.label), (o) => state.optimizers.has(o), (places, on) => {
  const chosen = new Set(state.optimizers);
  for (const o of places) on ? chosen.add(o) : chosen.delete(o);
  change({ optimizers: chosen });
});
const problemChecks = checks("Problems", problems.map((each) => each.label), (p) => !state.without.has(p), (places, on) => {
  const without = new Set(state.without);
  for (const p of places) on ? without.delete(p) : without.add(p);
  change({ without });
});
const filters = features.map(([name, values]) => {
  const select = make("select", { onchange: () => {
    const { [name]: _, ...others } = state.filters;
    change({ filters: select.value === "" ? others : { ...others, [name]: select.value } });
  } }, option("", "any"), ...values.filter((value) => value !== "").map((value) => option(value, value)));
  problemChecks.both.append(" ", labelled(name, select));
  return [name, select];
});

const link = button("Copy link", async () => {
  history.replaceState(null, "", address());
  try {
    await navigator.clipboard.writeText(location.href);
    link.textContent = "Copied";
  } catch {
    prompt("The address of this view:", location.href); // without access to the clipboard, the reader copies by hand
  }
});
const status = make("p", { className: "note", role: "status" });
const about = make("p", { className: "about" });
const key = make("ul", { className: "key" });
const chart = make("div", { className: "chart", tabIndex: 0 });
chart.setAttribute("role", "group");
const tableSummary = make("summary", { textContent: "Values of this view" });
const table = make("div", { className: "scroll", role: "group", ariaLabel: "Values of this view" });
const tables = make("details", {}, tableSummary, table);
const runs = make("select", { onchange: () => {
  const [o, k] = runs.value.split(",").map(Number);
  change({ run: runs.value ? { o, k } : null, problem: shownProblem() });
} });
const runChoice = labelled("Run", runs);
const run = make("section", { className: "run" });
body.append(
  make("div", { className: "controls" }, views, ...Object.values(choices), link),
  make("div", { className: "controls" }, optimizerChecks.element, problemChecks.element),
  about, key, chart, status, tables, runChoice, run,
  ...data.notes.map((note) => make("p", { className: "note", textContent: note })),
);

const fillKey = () => {
  const own = state.view === "curves" ? chosenOptimizers() : [];
  key.hidden = !own.length;
  key.replaceChildren(...own.map((o) => {
    const { dash, label } = optimizers[o];
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    for (const [name, value] of [["width", 34], ["height", 10], ["aria-hidden", "true"]]) svg.setAttribute(name, value);
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    for (const [name, value] of [["d", "M0 5H34"], ["stroke", colorOf(o)], ["stroke-width", 3], ["stroke-dasharray", dash.join(" ")]]) line.setAttribute(name, value);
    svg.append(line);
    return make("li", {}, svg, ` ${label}`);
  }));
};

const fillTable = ({ head, rows, caption }) => {
  const heads = head.map((title) => make("th", { scope: "col", textContent: title }));
  const lines = rows.map(([first, ...others]) => make("tr", {}, make("th", { scope: "row", textContent: first }), ...others.map((each) => make("td", { textContent: each }))));
  table.replaceChildren(make("table", {}, make("caption", { textContent: caption }), make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines)));
  if (!tables.open || table.scrollWidth > table.clientWidth) table.tabIndex = 0; // a closed one may prove too wide
  else table.removeAttribute("tabindex");
};

const showRun = () => {
  const p = shownProblem();
  const usable = p !== null && state.view !== "ranks";
  runChoice.hidden = !usable || !problems.length;
  run.hidden = !usable || !state.run;
  if (!usable) return;
  const chosen = chosenOptimizers().filter((o) => cells[p][o]?.fun);
  if (state.run && !chosen.includes(state.run.o)) chosen.push(state.run.o);
  runs.replaceChildren(option("", "none chosen"), ...chosen.map((o) => {
    const group = make("optgroup", { label: optimizers[o].label });
    const sorted = cells[p][o].fun.map((fun, k) => [fun ?? Infinity, k]).sort((a, b) => a[0] - b[0]);
    group.append(...sorted.map(([fun, k]) => option(`${o},${k}`, `${optimizers[o].label}, ${runName(cells[p][o], k)}: ${text(fun)}`)));
    return group;
  }));
  runs.value = state.run ? `${state.run.o},${state.run.k}` : "";
  if (!state.run) return run.replaceChildren();
  const { o, k } = state.run;
  const again = command(p, o, k);
  const list = make("dl", {}, ...describe(p, o, k).flatMap(([name, value]) => [make("dt", { textContent: name }), make("dd", { textContent: value })]));
  const trace = make("div", { className: "chart trace" });
  run.replaceChildren(make("h3", { textContent: `Run of ${optimizers[o].label} on ${problems[p].label}` }), list);
  if (again) run.append(make("p", { className: "note", textContent: "Make it again:" }), make("code", { textContent: again }));
  run.append(make("p", { className: "about", textContent: "Its best value over evaluations; in grey, the other runs of the cell" }), trace);
  embed(trace, runSpec(p, o, k));
  if (!problems[p].data || !cells[p][o].x?.[k]) return;
  const fit = make("div", { className: "chart fit" });
  const draw = () => embed(fit, fitSpec(p, o, k));
  const slider = make("input", { type: "range", min: 0, max: 1, step: 0.01, value: from, oninput: () => { from = Number(slider.value); draw(); } });
  const box = make("input", { type: "checkbox", checked: whole, onchange: () => { whole = box.checked; slider.disabled = whole; draw(); } });
  slider.disabled = whole;
  run.append(make("p", { className: "about", textContent: "The data with the fit of this run, and the residual" }),
    make("div", { className: "controls" }, labelled("From", slider), labelled("whole signal", box)), fit);
  draw();
};

// Zoom: by the buttons, by dragging a rectangle, or with the chart in focus by +, -, 0 and the arrows

let current = null; // what the chart shows
const moved = (factor, right, up) => {
  const shift = (scale, by) => {
    const [low, high] = along(scale, scale.domain);
    const [middle, half] = [(low + high) / 2 + (by * (high - low)) / 4, ((high - low) / 2) * factor];
    return back(scale, [middle - half, middle + half]);
  };
  if (current?.x) change({ zoom: { x: shift(current.x, right), y: current.y && shift(current.y, up) } });
};
const zoom = (factor) => moved(factor, 0, 0);
const KEYS = { "+": () => zoom(0.5), "-": () => zoom(2), 0: () => change({ zoom: null }), ArrowLeft: () => moved(1, -1, 0), ArrowRight: () => moved(1, 1, 0), ArrowUp: () => moved(1, 0, 1), ArrowDown: () => moved(1, 0, -1) };
chart.addEventListener("keydown", (event) => {
  const arrow = event.key.startsWith("Arrow");
  if (!Object.hasOwn(KEYS, event.key) || event.ctrlKey || event.metaKey || event.altKey || (arrow && !state.zoom) || !current?.x) return;
  event.preventDefault();
  KEYS[event.key]();
});
chart.addEventListener("pointerdown", (down) => {
  if (!current?.x || down.button || down.pointerType === "touch") return;
  const frame = make("div", { className: "rubber" });
  const start = chart.getBoundingClientRect();
  const corner = (event) => [event.clientX - start.left, event.clientY - start.top];
  const [x0, y0] = corner(down);
  const move = (event) => {
    const [x1, y1] = corner(event);
    if (!frame.parentNode && Math.hypot(x1 - x0, y1 - y0) > 6) chart.append(frame);
    const flat = !current.y;
    Object.assign(frame.style, { left: `${Math.min(x0, x1)}px`, width: `${Math.abs(x1 - x0)}px`, top: flat ? "0" : `${Math.min(y0, y1)}px`, height: flat ? "100%" : `${Math.abs(y1 - y0)}px` });
  };
  const up = (event) => {
    removeEventListener("pointermove", move);
    if (!frame.parentNode) return;
    frame.remove();
    const made = drawn.get(chart)?.made?.view;
    const inner = chart.querySelector("svg, canvas")?.getBoundingClientRect();
    if (!made || !inner) return;
    const [left, top] = made.origin();
    const ends = (name, a, b) => [a, b].map((each) => made.scale(name).invert(each)).sort((one, other) => one - other);
    const zoomed = { x: ends("x", down.clientX - inner.left - left, event.clientX - inner.left - left), y: null };
    if (current.y) zoomed.y = ends("y", down.clientY - inner.top - top, event.clientY - inner.top - top);
    if ([...zoomed.x, ...(zoomed.y ?? [])].every(Number.isFinite) && zoomed.x[0] < zoomed.x[1]) change({ zoom: zoomed });
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", up, { once: true });
});

const show = () => {
  const [own, chosen] = [chosenProblems(), chosenOptimizers()];
  for (const radio of views.querySelectorAll("input")) radio.checked = radio.value === state.view;
  const p = shownProblem();
  const offered = p === null || own.includes(p) ? own : [...own, p].sort((a, b) => a - b);
  problem.replaceChildren(...(state.view === "curves" && problems.length > 1 ? [option("", "all chosen: targets reached")] : []), ...offered.map((each) => option(each, problems[each].label)));
  problem.value = p ?? "";
  budget.value = state.budget;
  budgetText.textContent = sameBudget || p !== null ? text(evaluations(p ?? 0, state.budget)) : `${text(common(state.budget))} ${commonUnit}`;
  budget.setAttribute("aria-valuetext", budgetText.textContent);
  target.value = state.target;
  targetText.textContent = state.target < 0 ? "all" : `${data.targets.title} ${levels[state.target]}`;
  target.setAttribute("aria-valuetext", targetText.textContent);
  quantity.value = state.distance ? "distance" : "value";
  optimizerChecks.sync(chosen.length);
  problemChecks.sync(own.length);
  for (const [name, select] of filters) select.value = state.filters[name] ?? "";
  const shares = state.view === "curves" && p === null;
  choices.problem.hidden = state.view === "ranks";
  choices.target.hidden = state.view !== "curves" || !levels.length;
  choices.quantity.hidden = state.view === "ranks" || shares || problems[p]?.precision;
  choices.xlog.hidden = state.view !== "curves";
  choices.ylog.hidden = state.view === "ranks" || shares;
  choices.zooms.hidden = state.view === "ranks";
  link.textContent = "Copy link";
  const made = { curves: curveView, values: runView, ranks: rankView }[state.view]();
  current = made;
  xlog.checked = Boolean(made.x?.log && state.xlog);
  ylog.checked = Boolean((state.view === "values" ? made.x : made.y)?.log);
  const refused = (state.view === "values" ? made.x : made.y)?.refused ? " A log axis needs positive values." : "";
  about.textContent = `${made.about}.`;
  status.textContent = `${chosen.length} of ${optimizers.length} optimizers, ${own.length} of ${problems.length} problems.${refused}`;
  chart.setAttribute("aria-label", `${made.about}. The table below has the values. ${made.x ? "Zoom with + and −, move with the arrow keys, 0 shows the whole." : ""}`);
  tableSummary.textContent = `Values of this view: ${made.caption}`;
  fillKey();
  fillTable(made);
  chart.dataset.view = state.view;
  embed(chart, made.spec).then((view) => {
    if (!view) return;
    view.addEventListener("click", (_, item) => item?.datum && made.pick?.(item.datum));
  });
  showRun();
};

// The cells of the page's own map of ranks lead here, too; with the keyboard, the choice of a problem does.

for (const place of document.querySelectorAll("[data-problem][data-optimizer]")) {
  const find = (list, label) => list.findIndex((each) => each.label === label);
  const [p, o] = [find(problems, place.dataset.problem), find(optimizers, place.dataset.optimizer)];
  if (p < 0 || o < 0) continue;
  place.classList.add("leads");
  place.addEventListener("click", (event) => {
    if (event.target.closest("a")) return;
    change({ view: "values", problem: p, cell: o, optimizers: new Set([...state.optimizers, o]) });
    part.scrollIntoView();
  });
}

tables.addEventListener("toggle", () => current && fillTable(current));
let seen = 0;
new ResizeObserver(() => {
  if (Math.abs(body.clientWidth - seen) < 2) return;
  const first = seen === 0;
  seen = body.clientWidth;
  if (!first && seen) show();
}).observe(body);
addEventListener("hashchange", () => {
  if (read()) {
    show();
    part.scrollIntoView();
  }
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => show());
const asked = read();
show();
if (asked) part.scrollIntoView();
