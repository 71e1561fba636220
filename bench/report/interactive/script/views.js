// Make the views: each returns a Vega-Lite specification, the table behind it, and a sentence.

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
  const range = (name) => chosen.map((o) => (name === "color" ? colorOf(o) : optimizers[o][name]));
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
    ...marks.map((mark) => ({ data: { values: [mark] }, mark: { type: "rule", color: pageColor("--soft"), strokeDash: [4, 4], clip: true }, encoding: "x" in mark ? { x: position.x } : { y: position.y } })),
    {
      data: { values: shown },
      params: [{ name: "hover", select: { type: "point", fields: ["x"], nearest: true, on: "pointermove", clear: "pointerout" } }],
      mark: { type: "rule", color: pageColor("--text"), strokeWidth: 1, clip: true },
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
    if (Number.isFinite(three[1])) rows.push({ o, name: names.get(o), value: three[1], middle: true, low: three[0], high: Number.isFinite(three[2]) ? three[2] : null });
    table.push([optimizers[o].label, text(cell.trials), text(cell.failed), ...three.map(text)]);
  }
  const x = padded(scaleOf(rows.flatMap((row) => (row.middle ? [row.low, row.value, row.high ?? row.value] : [row.value])), state.ylog, state.zoom?.x));
  const at = (value) => (value <= 0 && x.log ? x.floor : value);
  for (const row of rows) Object.assign(row, { x: at(row.value), low: at(row.low), high: at(row.high ?? x.full[1]) });
  const labels = [...names.values()];
  const range = (name) => [...names.keys()].map((o) => (name === "color" ? colorOf(o) : optimizers[o][name]));
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
          mark: { type: "rule", strokeWidth: 2, color: pageColor("--soft"), clip: true },
          encoding: { x: { ...position.x, field: "low" }, x2: { field: "high" }, y },
        },
        {
          transform: [{ filter: "datum.middle" }],
          mark: { type: "tick", thickness: 3, size: 34, color: pageColor("--text"), opacity: 0.7, clip: true },
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
            stroke: { condition: { test: isRun, value: pageColor("--text") }, value: "transparent" },
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
    about: `${problems[p].label}: ${rows.some((row) => !row.middle) ? "every point is a run; bars are medians, lines quartiles; a click on a point shows the run" : "bars are medians, lines quartiles"}`,
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
    for (const [o, { rank, chance }] of found) {
      sums.get(o).push(rank);
      rows.push({
        p, o, problem: problems[p].label, optimizer: optimizers[o].label, rank, shown: text(rank),
        median: text(valueOf(p, quartiles(cells[p][o])[1][state.budget])), chance: percent(chance),
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
  const how = data.complete ? "by the rivals beaten" : "by the median";
  const layer = [
    {
      mark: { type: "rect", stroke: pageColor("--page"), strokeWidth: 1, cursor: "pointer" },
      encoding: {
        ...position,
        color: { field: "rank", type: "quantitative", scale: { domain: [1, n], range: ["#08306b", "#eaf2fb"] }, legend: null },
        tooltip: [{ field: "problem" }, { field: "optimizer" }, { field: "shown", title: "rank" }, { field: "median", title: "median" },
          ...(data.complete ? [{ field: "chance", title: "beats a run of the others" }] : [])],
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
