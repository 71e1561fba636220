// Keep the state: what is shown, as text after the anchor in the page's address.

import { cells, features, grid, last, levels, MANY, optimizers, problems, ranks } from "./data.js";
import { nearest, sameSet } from "./numbers.js";
import { ANCHOR } from "./page.js";

export const VIEWS = { curves: "Over evaluations", values: "Values of runs", ranks: "Ranks" };
const meanRank = (o) => {
  const own = problems.map((_, p) => everyRank[p].get(o)?.rank).filter((rank) => rank);
  return own.length ? own.reduce((a, b) => a + b, 0) / own.length : Infinity;
};
export const all = optimizers.map((_, o) => o);
const everyRank = all.length > MANY ? problems.map((_, p) => ranks(p, all, last)) : [];
const usual = all.length > MANY ? [...all].sort((a, b) => meanRank(a) - meanRank(b)).slice(0, MANY) : all;
const initial = () => ({
  view: "curves",
  problem: problems.length > 1 ? null : 0,
  optimizers: new Set(usual),
  without: new Set(),
  filters: {},
  budget: last,
  target: -1,
  distance: false,
  xlog: true,
  ylog: null,
  zoom: null,
  cell: null,
  run: null,
});
export let state = initial();
const listeners = []; // called after each change

export const address = () => {
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
  if (state.zoom)
    params.set("zoom", [...state.zoom.x, ...(state.zoom.y ?? [])].map((each) => Number(each.toPrecision(6))).join(","));
  if (state.cell !== null) params.set("cell", optimizers[state.cell].label);
  if (state.run) params.set("run", `${state.run.k},${optimizers[state.run.o].label}`);
  const said = params.toString();
  return `#${ANCHOR}${said && `?${said}`}`;
};

export const read = () => {
  const [anchor, said = ""] = location.hash.slice(1).split(/\?(.*)/s);
  if (anchor !== ANCHOR) return false;
  const params = new URLSearchParams(said);
  const place = (list, label) => list.findIndex((each) => each.label === label);
  const found = initial();
  if (Object.hasOwn(VIEWS, params.get("view"))) found.view = params.get("view");
  const p = place(problems, params.get("problem"));
  if (p >= 0) found.problem = p;
  if (params.has("optimizer"))
    found.optimizers = new Set(
      params
        .getAll("optimizer")
        .map((label) => place(optimizers, label))
        .filter((o) => o >= 0),
    );
  found.without = new Set(
    params
      .getAll("without")
      .map((label) => place(problems, label))
      .filter((each) => each >= 0),
  );
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
  if ([2, 4].includes(zoom.length) && zoom.every(Number.isFinite))
    found.zoom = { x: zoom.slice(0, 2), y: zoom[2] === undefined ? null : zoom.slice(2) };
  const cell = place(optimizers, params.get("cell"));
  if (cell >= 0) found.cell = cell;
  const [k, label] = (params.get("run") ?? "").split(/,(.*)/s);
  const o = place(optimizers, label);
  if (o >= 0 && p >= 0 && Number(k) < (cells[p][o]?.fun?.length ?? 0)) found.run = { o, k: Number(k) };
  state = found;
  return true;
};

export const change = (changes) => {
  const about = ["view", "problem", "distance", "xlog", "ylog"].some((key) => key in changes);
  if (about && !("zoom" in changes)) changes.zoom = null;
  if ("problem" in changes && !("run" in changes)) Object.assign(changes, { run: null, cell: changes.cell ?? null });
  Object.assign(state, changes);
  history.replaceState(null, "", address());
  for (const listener of listeners) listener();
};
export const onChange = (listener) => listeners.push(listener);

export const chosenProblems = () =>
  problems
    .map((_, p) => p)
    .filter((p) => !state.without.has(p))
    .filter((p) =>
      Object.entries(state.filters).every(([name, value]) => String(problems[p].features[name] ?? "") === value),
    );
export const chosenOptimizers = () => all.filter((o) => state.optimizers.has(o));
export const shownProblem = () => state.problem ?? (state.view === "values" ? (chosenProblems()[0] ?? 0) : null);
