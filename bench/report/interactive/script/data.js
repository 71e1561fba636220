// Read the data: decode curves, and compute quartiles, ranks and budgets from them.

import { decode, quartile } from "./numbers.js";
import { ANCHOR, pageColor } from "./page.js";
import { standing } from "./standing.js";

export const data = JSON.parse(document.getElementById(`${ANCHOR}.data`).textContent);
export const { problems, optimizers, grid } = data;
export const last = grid.length - 1;
export const MANY = 10; // optimizers of which all are shown at first
export const LISTED = 15; // optimizers under the pointer
export const colorOf = (o) => (optimizers[o].color === "#000000" ? pageColor("--text") : optimizers[o].color);

// Data: every curve holds distances from the problem's reference, at the budgets of the grid.

export const cells = problems.map(() => []);
for (const cell of data.cells) cells[cell.problem][cell.optimizer] = cell;

export const curves = (cell) => {
  cell.runs ??= (cell.curve ?? []).map((code) => decode(code, grid.length));
  return cell.runs;
};

export const quartiles = (cell) => {
  if (!cell.middle) {
    if (cell.quartiles) cell.middle = cell.quartiles.map((code) => decode(code, grid.length));
    else {
      cell.middle = [0.25, 0.5, 0.75].map(() => new Float64Array(grid.length));
      for (let i = 0; i <= last; i++) {
        const sorted = Float64Array.from(curves(cell), (curve) => curve[i]).sort();
        for (const [at, share] of [0.25, 0.5, 0.75].entries()) cell.middle[at][i] = quartile(sorted, share);
      }
    }
  }
  return cell.middle;
};

export const evaluations = (p, i) => Math.max(1, Math.floor((grid[i] * problems[p].budget) / grid[last] + 0.5));
export const sameBudget = problems.every((each) => each.budget === problems[0].budget);
const perDimension = problems.map((each) => each.budget / each.features.dimension);
const byDimension = !sameBudget && perDimension.every((each) => each === perDimension[0]);
export const [commonUnit, common] = sameBudget
  ? ["evaluations", (i) => evaluations(0, i)]
  : byDimension
    ? ["evaluations / dimension", (i) => (grid[i] / grid[last]) * perDimension[0]]
    : ["% of the budget", (i) => (100 * grid[i]) / grid[last]];

// The values by which runs are compared: at the whole budget their places among all runs of the problem, which are
// exact; before, values rounded to 0.12%. Of medians where not all runs are here.
const compared = (cell, i) =>
  !data.complete ? [quartiles(cell)[1][i]] : i === last ? cell.place : curves(cell).map((curve) => curve[i]);

export const ranks = (p, chosen, i) => {
  const own = chosen.filter((o) => cells[p][o]);
  const found = standing(own.map((o) => compared(cells[p][o], i)));
  return new Map(own.map((o, at) => [o, found[at]]));
};

// Features by which problems are chosen, and the levels of the targets

export const features = [...new Set(problems.flatMap((each) => Object.keys(each.features)))]
  .map((name) => [name, [...new Set(problems.map((each) => each.features[name] ?? ""))]])
  .filter(([, values]) => values.length > 1 && values.length <= 40);
export const levels = [...new Set(problems.flatMap((each) => each.targets.map(([level]) => level)))].sort((a, b) =>
  data.targets.rising ? a - b : b - a,
);

export const runName = (cell, k) => {
  const member = cell.member ? `${problems[cell.problem].members[cell.member[k]]}, ` : "";
  return `${member}trial ${cell.number ? cell.number[k] : k}`;
};
