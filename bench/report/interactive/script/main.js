// Put the part together, and draw it after each change of the state.

import { chart, embed } from "./chart.js";
import {
  about,
  budget,
  budgetText,
  choices,
  fillKey,
  fillTable,
  filters,
  key,
  link,
  optimizerChecks,
  problem,
  problemChecks,
  quantity,
  status,
  tableSummary,
  tables,
  target,
  targetText,
  views,
  xlog,
  ylog,
} from "./controls.js";
import { curveView } from "./curve-view.js";
import { common, commonUnit, data, evaluations, levels, optimizers, problems, sameBudget } from "./data.js";
import { text } from "./numbers.js";
import { body, make, option, part } from "./page.js";
import { rankView } from "./rank-view.js";
import { run, runChoice, showRun } from "./run.js";
import { change, chosenOptimizers, chosenProblems, onChange, read, shownProblem, state } from "./state.js";
import { runView } from "./value-view.js";
import { current, showing } from "./zoom.js";

body.append(
  make("div", { className: "controls" }, views, ...Object.values(choices), link),
  make("div", { className: "controls" }, optimizerChecks.element, problemChecks.element),
  about,
  key,
  chart,
  status,
  tables,
  runChoice,
  run,
  ...data.notes.map((note) => make("p", { className: "note", textContent: note })),
);

const show = () => {
  const [own, chosen] = [chosenProblems(), chosenOptimizers()];
  for (const radio of views.querySelectorAll("input")) radio.checked = radio.value === state.view;
  const p = shownProblem();
  const offered = p === null || own.includes(p) ? own : [...own, p].sort((a, b) => a - b);
  problem.replaceChildren(
    ...(state.view === "curves" && problems.length > 1 ? [option("", "all chosen: targets reached")] : []),
    ...offered.map((each) => option(each, problems[each].label)),
  );
  problem.value = p ?? "";
  budget.value = state.budget;
  budgetText.textContent =
    sameBudget || p !== null ? text(evaluations(p ?? 0, state.budget)) : `${text(common(state.budget))} ${commonUnit}`;
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
  showing(made);
  xlog.checked = Boolean(made.x?.log && state.xlog);
  ylog.checked = Boolean((state.view === "values" ? made.x : made.y)?.log);
  const refused = (state.view === "values" ? made.x : made.y)?.refused ? " A log axis needs positive values." : "";
  about.textContent = `${made.about}.`;
  const counts = [
    `${chosen.length} of ${optimizers.length} optimizers`,
    `${own.length} of ${problems.length} problems`,
  ];
  status.textContent = `${counts.join(", ")}.${refused}`;
  const keys = made.x ? "Zoom with + and −, move with the arrow keys, 0 shows the whole." : "";
  chart.setAttribute("aria-label", `${made.about}. The table below has the values. ${keys}`);
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
onChange(show);
const asked = read();
show();
if (asked) part.scrollIntoView();
