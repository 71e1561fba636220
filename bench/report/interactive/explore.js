"use strict";
(() => {
  const ANCHOR = "look-further";
  const part = document.getElementById(ANCHOR);
  const data = JSON.parse(document.getElementById(`${ANCHOR}.data`).textContent);
  const { problems, optimizers, grid } = data;
  const last = grid.length - 1;
  const MANY = 10; // optimizers of which all are shown at first
  const LISTED = 15; // optimizers under the pointer

  const make = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };

  const text = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "–";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    if (Number.isInteger(value) && Math.abs(value) < 1e9) return value.toLocaleString("en");
    const size = Math.abs(value);
    return size >= 1e6 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(6)));
  };
  const percent = (share) => `${Number((100 * share).toPrecision(3))} %`;
  const one = (values, k) => (Array.isArray(values) ? values[k] : values); // a column may hold one value for all runs

  // Data: every curve holds distances from the problem's reference, at the budgets of the grid.

  const cells = problems.map(() => []);
  for (const cell of data.cells) cells[cell.problem][cell.optimizer] = cell;

  const decode = (code) => {
    const values = new Float64Array(grid.length);
    const steps = code.split(",");
    let level = Infinity;
    for (let i = 0; i < values.length; i++) {
      const step = steps[i] ?? "";
      if (step === "i") level = Infinity;
      else if (step === "z") level = -Infinity;
      else if (step !== "") level = Number.isFinite(level) ? level - Number(step) : Number(step);
      values[i] = 10 ** (level / 1000);
    }
    return values;
  };

  const curves = (cell) => (cell.runs ??= (cell.curve ?? []).map(decode));

  const quartile = (sorted, share) => {
    const place = share * (sorted.length - 1);
    const [low, high] = [Math.floor(place), Math.ceil(place)];
    if (!Number.isFinite(sorted.at(-1))) return sorted[high];
    return sorted[low] + (place - low) * (sorted[high] - sorted[low]);
  };

  const quartiles = (cell) => {
    if (!cell.middle) {
      if (cell.quartiles) cell.middle = cell.quartiles.map(decode);
      else {
        cell.middle = [0.25, 0.5, 0.75].map(() => new Float64Array(grid.length));
        for (let i = 0; i <= last; i++) {
          const sorted = Float64Array.from(curves(cell), (curve) => curve[i]).sort();
          [0.25, 0.5, 0.75].forEach((share, at) => (cell.middle[at][i] = quartile(sorted, share)));
        }
      }
    }
    return cell.middle;
  };

  const evaluations = (p, i) => Math.max(1, Math.floor((grid[i] * problems[p].budget) / grid[last] + 0.5));
  const sameBudget = problems.every((each) => each.budget === problems[0].budget);
  const perDimension = problems.map((each) => each.budget / each.features.dimension);
  const byDimension = !sameBudget && perDimension.every((each) => each === perDimension[0]);
  const [commonUnit, common] = sameBudget
    ? ["evaluations", (i) => evaluations(0, i)]
    : byDimension
      ? ["evaluations / dimension", (i) => (grid[i] / grid[last]) * perDimension[0]]
      : ["% of the budget", (i) => (100 * grid[i]) / grid[last]];

  // The share of a cell's runs that are better than a run of another optimizer, of whom all are taken together; a tie
  // counts half (Mann-Whitney). Of medians where not all runs are here.
  const superiority = (p, chosen, i) => {
    const own = chosen.filter((o) => cells[p][o]);
    const pool = own.flatMap((o) => {
      const values = data.complete ? curves(cells[p][o]).map((curve) => curve[i]) : [quartiles(cells[p][o])[1][i]];
      return values.map((value) => ({ o, value }));
    });
    pool.sort((a, b) => (a.value < b.value ? -1 : a.value > b.value ? 1 : 0));
    const sums = new Map(own.map((o) => [o, { above: 0, n: 0 }]));
    for (let start = 0; start < pool.length; ) {
      let end = start;
      while (end < pool.length && pool[end].value === pool[start].value) end++;
      const middle = (start + 1 + end) / 2;
      for (; start < end; start++) {
        const sum = sums.get(pool[start].o);
        sum.above += pool.length - middle;
        sum.n++;
      }
    }
    return new Map(
      [...sums].map(([o, { above, n }]) => [o, n < pool.length ? (above - (n * (n - 1)) / 2) / (n * (pool.length - n)) : 0.5]),
    );
  };

  const ranks = (p, chosen, i) => {
    const better = superiority(p, chosen, i);
    const order = [...better].sort((a, b) => b[1] - a[1]);
    const found = new Map();
    for (let start = 0; start < order.length; ) {
      let end = start;
      while (end < order.length && order[start][1] - order[end][1] < 1e-9) end++;
      const rank = (start + 1 + end) / 2;
      for (; start < end; start++) found.set(order[start][0], { rank, better: order[start][1] });
    }
    return found;
  };

  // Features by which problems are chosen, and the levels of the targets

  const features = [...new Set(problems.flatMap((each) => Object.keys(each.features)))]
    .map((name) => [name, [...new Set(problems.map((each) => each.features[name] ?? ""))]])
    .filter(([, values]) => values.length > 1 && values.length <= 40);
  const levels = [...new Set(problems.flatMap((each) => each.targets.map(([level]) => level)))].sort((a, b) => b - a);

  // State: what is shown, as text after the anchor in the page's address

  const VIEWS = { curves: "Over evaluations", values: "Values of runs", ranks: "Ranks" };
  const meanRank = (o) => {
    const own = problems.map((_, p) => everyRank[p].get(o)?.rank).filter((rank) => rank);
    return own.length ? own.reduce((a, b) => a + b, 0) / own.length : Infinity;
  };
  const all = optimizers.map((_, o) => o);
  const everyRank = all.length > MANY ? problems.map((_, p) => ranks(p, all, last)) : [];
  const usual = all.length > MANY ? [...all].sort((a, b) => meanRank(a) - meanRank(b)).slice(0, MANY) : all;
  const initial = () => ({
    view: "curves", problem: problems.length > 1 ? null : 0, optimizers: new Set(usual), without: new Set(), filters: {},
    budget: last, target: -1, distance: false, xlog: true, ylog: null, zoom: null, cell: null, run: null,
  });
  let state = initial();

  const nearest = (values, wanted) =>
    values.reduce((best, value, i) => (Math.abs(Math.log(value / wanted)) < Math.abs(Math.log(values[best] / wanted)) ? i : best), 0);
  const sameSet = (a, b) => a.size === b.length && b.every((each) => a.has(each));

  const address = () => {
    const params = new URLSearchParams();
    if (state.view !== "curves") params.set("view", state.view);
    if (state.problem !== null) params.set("problem", problems[state.problem].label);
    if (!sameSet(state.optimizers, usual))
      for (const o of all) if (state.optimizers.has(o)) params.append("optimizer", optimizers[o].label);
    if (!state.optimizers.size) params.set("optimizer", "");
    for (const p of state.without) params.append("without", problems[p].label);
    for (const [name, value] of Object.entries(state.filters)) params.append("only", `${name}=${value}`);
    if (state.budget !== last) params.set("budget", grid[state.budget]);
    if (state.target >= 0) params.set("target", levels[state.target]);
    if (state.distance) params.set("show", "distance");
    if (!state.xlog) params.set("x", "linear");
    if (state.ylog !== null) params.set("y", state.ylog ? "log" : "linear");
    if (state.zoom) params.set("zoom", [...state.zoom.x, ...(state.zoom.y ?? [])].map((each) => Number(each.toPrecision(6))).join(","));
    if (state.cell !== null) params.set("cell", optimizers[state.cell].label);
    if (state.run) params.set("run", `${state.run.k},${optimizers[state.run.o].label}`);
    const said = params.toString();
    return `#${ANCHOR}${said && `?${said}`}`;
  };

  const read = () => {
    const [anchor, said = ""] = location.hash.slice(1).split(/\?(.*)/s);
    if (anchor !== ANCHOR) return false;
    const params = new URLSearchParams(said);
    const place = (list, label) => list.findIndex((each) => each.label === label);
    const found = initial();
    if (Object.hasOwn(VIEWS, params.get("view"))) found.view = params.get("view");
    const p = place(problems, params.get("problem"));
    if (p >= 0) found.problem = p;
    if (params.has("optimizer"))
      found.optimizers = new Set(params.getAll("optimizer").map((label) => place(optimizers, label)).filter((o) => o >= 0));
    found.without = new Set(params.getAll("without").map((label) => place(problems, label)).filter((each) => each >= 0));
    for (const each of params.getAll("only")) {
      const [name, value] = each.split(/=(.*)/s);
      const known = features.find(([feature]) => feature === name)?.[1];
      if (known?.some((one) => String(one) === value)) found.filters[name] = value;
    }
    if (Number(params.get("budget")) > 0) found.budget = nearest(grid, Number(params.get("budget")));
    if (params.has("target")) found.target = levels.indexOf(Number(params.get("target")));
    found.distance = params.get("show") === "distance";
    found.xlog = params.get("x") !== "linear";
    if (params.has("y")) found.ylog = params.get("y") === "log";
    const zoom = (params.get("zoom") ?? "").split(",").map(Number);
    if ([2, 4].includes(zoom.length) && zoom.every(Number.isFinite)) found.zoom = { x: zoom.slice(0, 2), y: zoom[2] === undefined ? null : zoom.slice(2) };
    const cell = place(optimizers, params.get("cell"));
    if (cell >= 0) found.cell = cell;
    const [k, label] = (params.get("run") ?? "").split(/,(.*)/s);
    const o = place(optimizers, label);
    if (o >= 0 && p >= 0 && Number(k) < (cells[p][o]?.fun?.length ?? 0)) found.run = { o, k: Number(k) };
    state = found;
    return true;
  };

  const change = (changes) => {
    const about = ["view", "problem", "distance", "xlog", "ylog"].some((key) => key in changes);
    if (about && !("zoom" in changes)) changes.zoom = null;
    if ("problem" in changes && !("run" in changes)) Object.assign(changes, { run: null, cell: changes.cell ?? null });
    Object.assign(state, changes);
    history.replaceState(null, "", address());
    show();
  };

  const chosenProblems = () =>
    problems
      .map((_, p) => p)
      .filter((p) => !state.without.has(p))
      .filter((p) => Object.entries(state.filters).every(([name, value]) => String(problems[p].features[name] ?? "") === value));
  const chosenOptimizers = () => all.filter((o) => state.optimizers.has(o));
  const shownProblem = () => state.problem ?? (state.view === "values" ? (chosenProblems()[0] ?? 0) : null);

  // Values of the objective, or their distance from the reference

  const valueOf = (p, distance) => (state.distance ? distance : problems[p].reference + distance);
  const titleOf = (p) =>
    problems[p].precision ? "best value less the optimum"
    : !state.distance ? "best value"
    : problems[p].known ? "best value less the known optimum" : "best value less the lowest found";

  /** The scale of an axis: its domain, that of the zoom where there is one; values of 0 stand at a log axis's low end. */
  const scaleOf = (values, wantsLog, zoomed) => {
    const finite = values.filter(Number.isFinite);
    const positive = finite.filter((value) => value > 0);
    const lowest = Math.min(...finite);
    const wide = positive.length && Math.max(...positive) > 30 * Math.min(...positive);
    const possible = positive.length > 0 && lowest >= 0;
    const log = possible && (wantsLog ?? wide);
    const floor = log ? Math.min(...positive) / (lowest === 0 ? 3 : 1) : lowest;
    let domain = finite.length ? [floor, Math.max(...finite)] : [0, 1];
    if (domain[0] === domain[1]) domain = log ? [domain[0] / 2, domain[0] * 2] : [domain[0] - 0.5, domain[1] + 0.5];
    return { log, floor, full: domain, domain: zoomed ?? domain, refused: wantsLog && !possible };
  };

  /** The scale with a margin on both sides, so that no point stands on an edge; a zoomed one as it is. */
  const padded = (scale) => {
    if (scale.domain !== scale.full) return scale;
    const [low, high] = along(scale, scale.full);
    const margin = 0.03 * (high - low);
    return { ...scale, domain: back(scale, [low - margin, high + margin]) };
  };
  const along = (scale, domain) => (scale.log ? domain.map(Math.log) : domain);
  const back = (scale, domain) => (scale.log ? domain.map(Math.exp) : domain);

  // Views: each returns a Vega-Lite specification, the table behind it, and a sentence

  const look = (chosen, field = "o") => {
    const domain = chosen.map((o) => optimizers[o].label);
    const range = (name) => chosen.map((o) => optimizers[o][name]);
    const legend = null; // the page has one, of text
    return {
      color: { field, type: "nominal", sort: null, scale: { domain, range: range("color") }, legend },
      strokeDash: { field, type: "nominal", sort: null, scale: { domain, range: range("dash").map((each) => (each.length ? each : [1, 0])) }, legend },
    };
  };

  const NUMBER = // of a tick; Vega leaves those between two powers of ten without a label
    "datum.label === '' ? '' : datum.value !== 0 && (abs(datum.value) >= 1e6 || abs(datum.value) < 1e-4) ? format(datum.value, '.3~e') : format(datum.value, ',.6~g')";
  const quantitative = (field, title, scale, more = {}) => ({
    field, type: "quantitative", title,
    scale: { type: scale.log ? "log" : "linear", domain: scale.domain, nice: false, ...(scale.log ? {} : { zero: false }) },
    axis: { tickCount: 6, format: more.format ?? "~g", ...(more.format ? {} : { labelExpr: NUMBER }), labelOverlap: true, grid: true },
  });

  const lines = ({ rows, chosen, xTitle, yTitle, x, y, format, band, under, marks }) => {
    const styles = look(chosen);
    const position = { x: quantitative("x", xTitle, x), y: quantitative("y", yTitle, y, { format }) };
    const shown = under.filter((each) => each.x >= Math.min(...x.domain) && each.x <= Math.max(...x.domain));
    const tooltip = [
      { field: "title", title: xTitle },
      ...chosen.slice(0, LISTED).map((o) => ({ field: `o${o}`, title: optimizers[o].label })),
    ];
    const layer = [
      { mark: { type: "line", interpolate: "step-after", strokeWidth: 2, clip: true }, encoding: { ...position, color: styles.color, strokeDash: styles.strokeDash } },
      ...marks.map((mark) => ({ data: { values: [mark] }, mark: { type: "rule", color: "#57606a", strokeDash: [4, 4], clip: true }, encoding: "x" in mark ? { x: position.x } : { y: position.y } })),
      {
        data: { values: shown },
        params: [{ name: "hover", select: { type: "point", fields: ["x"], nearest: true, on: "pointermove", clear: "pointerout" } }],
        mark: { type: "rule", color: "#1b1f24", strokeWidth: 1, clip: true },
        encoding: { x: position.x, opacity: { condition: { param: "hover", empty: false, value: 0.6 }, value: 0 }, tooltip },
      },
    ];
    if (band)
      layer.unshift({
        mark: { type: "area", interpolate: "step-after", opacity: 0.14, clip: true },
        encoding: { x: position.x, y: { ...position.y, field: "low" }, y2: { field: "high" }, color: styles.color },
      });
    return { data: { values: rows }, width: width(), height: 380, layer };
  };

  const curveView = () => (state.problem === null ? shareView() : valueView(state.problem));

  const valueView = (p) => {
    const chosen = chosenOptimizers().filter((o) => cells[p][o]);
    const points = chosen.map((o) => [o, quartiles(cells[p][o]).map((curve) => Array.from(curve, (each) => valueOf(p, each)))]);
    const y = scaleOf(points.flatMap(([, three]) => three.flat()), state.ylog, state.zoom?.y);
    const spent = grid.map((_, i) => evaluations(p, i));
    const x = scaleOf(spent, state.xlog, state.zoom?.x);
    const rows = [];
    const under = spent.map((each) => ({ x: each, title: text(each) }));
    for (const [o, [q1, median, q3]] of points)
      for (let i = 0; i <= last; i++) {
        const at = (value) => (value <= 0 && y.log ? y.floor : value);
        under[i][`o${o}`] = `${text(median[i])} (${text(q1[i])} to ${text(q3[i])})`;
        if (Number.isFinite(median[i]))
          rows.push({ o: optimizers[o].label, x: spent[i], y: at(median[i]), low: at(q1[i]), high: at(Number.isFinite(q3[i]) ? q3[i] : y.full[1]) });
      }
    const marks = state.budget < last ? [{ x: spent[state.budget] }] : [];
    const target = state.target >= 0 && problems[p].targets.find(([level]) => level === levels[state.target]);
    if (target) marks.push({ y: valueOf(p, target[1]) });
    const i = state.budget;
    return {
      spec: lines({ rows, chosen, xTitle: "evaluations", yTitle: titleOf(p), x, y, band: true, under, marks }), x, y,
      head: ["optimizer", "lower quartile", "median", "upper quartile"],
      rows: points.map(([o, [q1, median, q3]]) => [optimizers[o].label, ...[q1, median, q3].map((curve) => text(curve[i]))]),
      about: `${problems[p].label}: medians of the best value so far, with quartiles`,
      caption: `${problems[p].label} after ${text(spent[i])} evaluations`,
    };
  };

  const reached = (p, o, wanted) => {
    const runs = data.complete ? curves(cells[p][o]) : [quartiles(cells[p][o])[1]];
    const counts = new Float64Array(grid.length);
    for (const curve of runs)
      for (const [, distance] of wanted) {
        const first = curve.findIndex((value) => value <= distance * (1 + 1e-3)); // a curve is rounded to 0.12 %
        if (first >= 0) counts[first]++;
      }
    return { counts, of: runs.length * wanted.length };
  };

  const shareView = () => {
    const own = chosenProblems();
    const chosen = chosenOptimizers();
    const spent = grid.map((_, i) => common(i));
    const x = scaleOf(spent, state.xlog, state.zoom?.x);
    const y = { log: false, full: [0, 1], domain: state.zoom?.y ?? [0, 1] };
    const rows = [];
    const under = spent.map((each) => ({ x: each, title: text(each) }));
    const table = [];
    for (const o of chosen) {
      const total = new Float64Array(grid.length);
      let of = 0;
      for (const p of own.filter((each) => cells[each][o])) {
        const wanted = problems[p].targets.filter(([level]) => state.target < 0 || level === levels[state.target]);
        const found = reached(p, o, wanted);
        of += found.of;
        found.counts.forEach((count, i) => (total[i] += count));
      }
      let sum = 0;
      for (let i = 0; i <= last && of; i++) {
        sum += total[i];
        rows.push({ o: optimizers[o].label, x: spent[i], y: sum / of });
        under[i][`o${o}`] = percent(sum / of);
      }
      table.push([optimizers[o].label, of ? under[state.budget][`o${o}`] : "–"]);
    }
    const which = state.target < 0 ? "all targets" : `the target ${data.targets.title} = ${levels[state.target]}`;
    const marks = state.budget < last ? [{ x: spent[state.budget] }] : [];
    const what = data.complete ? "(run, problem, target)" : "(problem, target), by the median run,";
    return {
      spec: lines({ rows, chosen, xTitle: commonUnit, yTitle: "share of targets reached", x, y, format: ".0%", under, marks }), x, y,
      head: ["optimizer", "share of targets reached"],
      rows: table,
      about: `Share of all ${what} reached: ${which} of ${own.length} problems`,
      caption: `${which} after ${text(spent[state.budget])} ${commonUnit}`,
    };
  };

  const runValue = (p, o, k) => {
    const cell = cells[p][o];
    if (state.budget === last && !state.distance) return cell.fun[k] ?? Infinity;
    return valueOf(p, curves(cell)[k][state.budget]);
  };
  const runName = (cell, k) => {
    const member = cell.member ? `${problems[cell.problem].members[cell.member[k]]}, ` : "";
    return `${member}trial ${cell.number ? cell.number[k] : k}`;
  };

  const runView = () => {
    const p = shownProblem();
    const chosen = chosenOptimizers().filter((o) => cells[p][o]);
    const rows = [];
    const names = new Map();
    const table = [];
    for (const o of chosen) {
      const cell = cells[p][o];
      const values = (cell.fun ?? []).map((_, k) => runValue(p, o, k));
      const lost = values.filter((value) => !Number.isFinite(value)).length;
      names.set(o, optimizers[o].label + (lost ? ` (${lost} without a value)` : ""));
      values.forEach((value, k) => {
        if (Number.isFinite(value)) rows.push({ o, name: names.get(o), value, k, j: ((k * 0.618034) % 1) - 0.5, shown: text(value), run: runName(cell, k) });
      });
      const three = quartiles(cell).map((curve) => valueOf(p, curve[state.budget]));
      if (Number.isFinite(three[1])) rows.push({ o, name: names.get(o), value: three[1], middle: true });
      table.push([optimizers[o].label, text(cell.trials), text(cell.failed), ...three.map(text)]);
    }
    const x = padded(scaleOf(rows.map((row) => row.value), state.ylog, state.zoom?.x));
    for (const row of rows) row.x = row.value <= 0 && x.log ? x.floor : row.value;
    const labels = [...names.values()];
    const range = (name) => [...names.keys()].map((o) => optimizers[o][name]);
    const faint = state.cell !== null && chosen.includes(state.cell) ? `datum.o !== ${state.cell}` : "false";
    const isRun = state.run ? `datum.o === ${state.run.o} && datum.k === ${state.run.k}` : "false";
    const y = { field: "name", type: "nominal", sort: null, scale: { domain: labels }, title: null, axis: { labelLimit: Math.min(width() / 3, 240), grid: false } };
    const position = { x: quantitative("x", titleOf(p), x), y };
    const color = { field: "name", type: "nominal", sort: null, scale: { domain: labels, range: range("color") }, legend: null };
    return {
      spec: {
        data: { values: rows }, width: width(), height: 38 * Math.max(labels.length, 1) + 10,
        layer: [
          {
            transform: [{ filter: "datum.middle" }],
            mark: { type: "tick", thickness: 3, size: 34, color: "#1b1f24", opacity: 0.7, clip: true },
            encoding: position,
          },
          {
            transform: [{ filter: "!datum.middle" }],
            mark: { type: "point", filled: true, size: 50, clip: true, cursor: "pointer" },
            encoding: {
              ...position, color,
              yOffset: { field: "j", type: "quantitative", scale: { domain: [-0.75, 0.75], nice: false, zero: false } },
              shape: { field: "name", type: "nominal", sort: null, scale: { domain: labels, range: range("shape") }, legend: null },
              opacity: { condition: { test: faint, value: 0.15 }, value: 0.75 },
              stroke: { condition: { test: isRun, value: "#000000" }, value: "transparent" },
              strokeWidth: { value: 2 },
              size: { condition: { test: isRun, value: 220 }, value: 50 },
              tooltip: [{ field: "name", title: "optimizer" }, { field: "run", title: "run" }, { field: "shown", title: "value" }],
            },
          },
        ],
      },
      x, y: null, pick: (datum) => datum.k !== undefined && change({ problem: p, run: { o: datum.o, k: datum.k }, cell: state.cell }),
      head: ["optimizer", "trials", "failed", "lower quartile", "median", "upper quartile"],
      rows: table,
      about: `${problems[p].label}: every point is a run, the bar the median; a click on a point shows the run`,
      caption: `${problems[p].label} after ${text(evaluations(p, state.budget))} evaluations`,
    };
  };

  const rankView = () => {
    const own = chosenProblems();
    const chosen = chosenOptimizers();
    const rows = [];
    const table = [];
    const sums = new Map(chosen.map((o) => [o, []]));
    for (const p of own) {
      const found = ranks(p, chosen, state.budget);
      for (const [o, { rank, better }] of found) {
        sums.get(o).push(rank);
        rows.push({
          p, o, problem: problems[p].label, optimizer: optimizers[o].label, rank, shown: text(rank),
          median: text(valueOf(p, quartiles(cells[p][o])[1][state.budget])), better: percent(better),
        });
      }
      table.push([problems[p].label, ...chosen.map((o) => text(found.get(o)?.rank))]);
    }
    const mean = (list) => (list.length ? list.reduce((a, b) => a + b, 0) / list.length : NaN);
    table.push(["mean rank", ...chosen.map((o) => text(Number(mean(sums.get(o)).toFixed(2))))]);
    const position = {
      x: { field: "optimizer", type: "nominal", sort: null, title: null, scale: { domain: chosen.map((o) => optimizers[o].label) }, axis: { orient: "top", labelAngle: -40, labelLimit: 140, ticks: false, domain: false } },
      y: { field: "problem", type: "nominal", sort: null, title: null, scale: { domain: own.map((p) => problems[p].label) }, axis: { labelLimit: Math.min(width() / 3, 240), ticks: false, domain: false } },
    };
    const n = Math.max(chosen.length, 2);
    const few = rows.length <= 1500 && width() / n > 26;
    const how = data.complete ? "by the runs that beat those of the others" : "by the median";
    const layer = [
      {
        mark: { type: "rect", stroke: "#ffffff", strokeWidth: 1, cursor: "pointer" },
        encoding: {
          ...position,
          color: { field: "rank", type: "quantitative", scale: { domain: [1, n], range: ["#08306b", "#eaf2fb"] }, legend: null },
          tooltip: [{ field: "problem" }, { field: "optimizer" }, { field: "shown", title: "rank" }, { field: "median", title: "median" },
            ...(data.complete ? [{ field: "better", title: "beats a run of the others" }] : [])],
        },
      },
    ];
    if (few) layer.push({ mark: { type: "text", fontSize: 12, cursor: "pointer" }, encoding: { ...position, text: { field: "shown" }, color: { condition: { test: `datum.rank <= ${(n + 1) / 2}`, value: "#ffffff" }, value: "#1b1f24" } } });
    return {
      spec: { data: { values: rows }, width: width(), height: (own.length > 40 ? 16 : 24) * Math.max(own.length, 1), layer },
      x: null, y: null,
      pick: (datum) => datum.p !== undefined && change({ view: "values", problem: datum.p, cell: datum.o, optimizers: new Set([...state.optimizers, datum.o]) }),
      head: ["problem", ...chosen.map((o) => optimizers[o].label)],
      rows: table,
      about: `Ranks ${how}, dark is best; a click on a cell shows its problem`,
      caption: `ranks after ${sameBudget ? `${text(common(state.budget))} evaluations` : `${text(common(state.budget))} ${commonUnit}`}`,
    };
  };

  // One run

  const command = (p, o, k) => {
    const member = cells[p][o].member?.[k] ?? 0;
    const [problem, optimizer] = [one(problems[p].commands, member), optimizers[o].command];
    const seed = cells[p][o].seed[k];
    return problem && optimizer && seed ? `bench solve ${problem} ${optimizer} --budget ${problems[p].budget} --seed ${seed}` : "";
  };

  const describe = (p, o, k) => {
    const [problem, cell] = [problems[p], cells[p][o]];
    const named = (names, values) => (values?.[k] ?? "").split(",").map((value, i) => [names[i], value]).filter(([, value]) => value !== "");
    const listed = (pairs) => pairs.map(([name, value]) => `${name} = ${value}`).join(", ");
    const reason = cell.error?.[k];
    return [
      ["optimizer", optimizers[o].label + (optimizers[o].options && ` (${optimizers[o].options})`)],
      ["problem", problem.label + (problem.options && ` (${problem.options})`)],
      ["run", runName(cell, k)],
      ["seed", cell.seed[k] || "unknown"],
      ["best value", text(cell.fun[k])],
      [problem.known ? "above the optimum" : "above the lowest found", problem.precision ? "" : text(curves(cell)[k][last])],
      ["evaluations", `${text(one(cell.nfev, k))} of ${text(problem.budget)}`],
      ["stopped by", data.texts[one(cell.stop, k)] || "–"],
      ["time", `${text(one(cell.wall, k))} s, ${text(one(cell.objective, k))} s of it in the objective`],
      ["best point", listed(named(problem.variables, cell.x))],
      ["metrics", listed(named(problem.metrics, cell.metrics))],
      ["failure", reason === null || reason === undefined ? "" : data.texts[reason]],
    ].filter(([, value]) => value);
  };

  const runSpec = (p, o, k) => {
    const rows = [];
    const own = curves(cells[p][o]);
    const y = scaleOf(own.flatMap((curve) => Array.from(curve, (each) => valueOf(p, each))), state.ylog, null);
    own.forEach((curve, at) => curve.forEach((distance, i) => {
      const value = valueOf(p, distance);
      if (Number.isFinite(value)) rows.push({ k: at, x: evaluations(p, i), y: value <= 0 && y.log ? y.floor : value, shown: text(value) });
    }));
    const x = scaleOf(grid.map((_, i) => evaluations(p, i)), state.xlog, null);
    const encoding = { x: quantitative("x", "evaluations", x), y: quantitative("y", titleOf(p), y), detail: { field: "k", type: "nominal" } };
    return {
      data: { values: rows }, width: width(), height: 220,
      layer: [
        { transform: [{ filter: `datum.k !== ${k}` }], mark: { type: "line", interpolate: "step-after", color: "#b8bec5", strokeWidth: 0.8 }, encoding },
        { transform: [{ filter: `datum.k === ${k}` }], mark: { type: "line", interpolate: "step-after", color: optimizers[o].color, strokeWidth: 2.5 }, encoding: { ...encoding, tooltip: [{ field: "x", title: "evaluations", format: "," }, { field: "shown", title: "value" }] } },
      ],
    };
  };

  const samples = (p) => {
    const { t, values } = problems[p].data;
    if (!values.table) {
      let level = 0;
      values.table = values.steps.split(",").map((step, i) => {
        level += Number(step);
        return { t: Array.isArray(t) ? t[0] + i * t[1] : t.values[i], value: values.low + (level / 9999) * (values.high - values.low) };
      });
    }
    return values.table;
  };

  let from = 0; // the share of the signal where its window begins
  let whole = false;
  const WINDOW = 0.2; // of the signal
  const AXIS = 70; // pixels beside a panel of several
  const fitSpec = (p, o, k) => {
    const { variables, data: { model, t_title, title } } = problems[p];
    const point = Object.fromEntries(cells[p][o].x[k].split(",").map((value, i) => [variables[i], Number(value)]));
    const table = samples(p);
    const [start, end] = [table[0].t, table.at(-1).t];
    const begin = start + from * (1 - WINDOW) * (end - start);
    const domain = whole ? [start, end] : [begin, begin + WINDOW * (end - start)];
    const x = { field: "t", type: "quantitative", title: t_title, scale: { domain, nice: false, zero: false } };
    const y = (field, name) => ({ field, type: "quantitative", title: name, scale: { zero: false } });
    const tooltip = ["t", "value", "fit", "residual"].map((field) => ({ field, type: "quantitative", format: ".5~g" }));
    return {
      data: { values: whole ? table : table.filter(({ t }) => t >= domain[0] && t <= domain[1]) },
      params: [{ name: "point", value: point }],
      transform: [{ calculate: model, as: "fit" }, { calculate: "datum.value - datum.fit", as: "residual" }],
      vconcat: [
        {
          width: width() - AXIS, height: 220,
          layer: [
            { mark: { type: "point", filled: true, size: 12, color: "#8a939d", clip: true }, encoding: { x, y: y("value", title), tooltip } },
            { mark: { type: "line", color: optimizers[o].color, strokeWidth: 1.8, clip: true }, encoding: { x, y: y("fit", title) } },
          ],
        },
        { width: width() - AXIS, height: 110, mark: { type: "line", color: "#57606a", strokeWidth: 1, clip: true }, encoding: { x, y: y("residual", "residual"), tooltip } },
      ],
    };
  };

  // Drawing

  const CONFIG = {
    aria: false, background: "#ffffff", font: "system-ui, 'DejaVu Sans', sans-serif",
    view: { stroke: null },
    axis: { labelFontSize: 12, titleFontSize: 12, titleFontWeight: "normal", labelColor: "#1b1f24", titleColor: "#1b1f24", gridColor: "#dddddd", domainColor: "#57606a", tickColor: "#57606a" },
  };
  const drawn = new Map(); // the chart of each place, so that an older one ends
  const embed = async (place, spec) => {
    const number = (drawn.get(place)?.number ?? 0) + 1;
    const before = drawn.get(place);
    drawn.set(place, { ...before, number });
    place.dataset.ready = "";
    const canvas = make("div", { className: "canvas" });
    try {
      const marks = spec.data.values.length > 4000 && !spec.vconcat;
      const made = await vegaEmbed(canvas, { config: CONFIG, ...(spec.vconcat ? {} : { autosize: { type: "fit-x", contains: "padding" } }), ...spec }, { mode: "vega-lite", ast: true, actions: false, defaultStyle: false, renderer: marks ? "canvas" : "svg" });
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
  const table = make("div", { className: "scroll" });
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
      const { color, dash, label } = optimizers[o];
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      for (const [name, value] of [["width", 34], ["height", 10], ["aria-hidden", "true"]]) svg.setAttribute(name, value);
      const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
      for (const [name, value] of [["d", "M0 5H34"], ["stroke", color], ["stroke-width", 3], ["stroke-dasharray", dash.join(" ")]]) line.setAttribute(name, value);
      svg.append(line);
      return make("li", {}, svg, ` ${label}`);
    }));
  };

  const fillTable = ({ head, rows, caption }) => {
    const heads = head.map((title) => make("th", { scope: "col", textContent: title }));
    const lines = rows.map(([first, ...others]) => make("tr", {}, make("th", { scope: "row", textContent: first }), ...others.map((each) => make("td", { textContent: each }))));
    table.replaceChildren(make("table", {}, make("caption", { textContent: caption }), make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines)));
    if (!tables.open) return;
    table.toggleAttribute("tabindex", table.scrollWidth > table.clientWidth);
    if (table.hasAttribute("tabindex")) Object.assign(table, { tabIndex: 0, role: "group", ariaLabel: "Values of this view" });
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
  const asked = read();
  show();
  if (asked) part.scrollIntoView();
})();
