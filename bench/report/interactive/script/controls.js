// The choices above the chart, and the texts around it.

import { colorOf, features, last, levels, optimizers, problems } from "./data.js";
import { button, labelled, make, option } from "./page.js";
import { address, change, chosenOptimizers, state, VIEWS } from "./state.js";
import { zooms } from "./zoom.js";

export const views = make("fieldset", { className: "views" }, make("legend", { textContent: "View" }));
for (const [name, title] of Object.entries(VIEWS))
  views.append(
    make(
      "label",
      {},
      make("input", { type: "radio", name: "further-view", value: name, onchange: () => change({ view: name }) }),
      ` ${title}`,
    ),
  );

export const problem = make("select", {
  onchange: () => change({ problem: problem.value === "" ? null : Number(problem.value), run: null }),
});
export const budget = make("input", {
  type: "range",
  min: 0,
  max: last,
  step: 1,
  oninput: () => change({ budget: Number(budget.value) }),
});
export const budgetText = make("output");
export const target = make("input", {
  type: "range",
  min: -1,
  max: levels.length - 1,
  step: 1,
  oninput: () => change({ target: Number(target.value) }),
});
export const targetText = make("output");
export const quantity = make(
  "select",
  { onchange: () => change({ distance: quantity.value === "distance" }) },
  option("value", "the value"),
  option("distance", "its distance from the best"),
);
export const xlog = make("input", { type: "checkbox", onchange: () => change({ xlog: xlog.checked }) });
export const ylog = make("input", { type: "checkbox", onchange: () => change({ ylog: ylog.checked }) });
export const choices = {
  problem: labelled("Problem", problem),
  budget: labelled("Budget", budget, budgetText),
  target: labelled("Target", target, targetText),
  quantity: labelled("Show", quantity),
  xlog: labelled("log x", xlog),
  ylog: labelled("log values", ylog),
  zooms,
};

const checks = (title, items, isChosen, onchoose) => {
  const summary = make("summary");
  const boxes = items.map((name, place) => {
    const box = make("input", { type: "checkbox", onchange: () => onchoose([place], box.checked) });
    return make("label", {}, box, ` ${name}`);
  });
  const places = items.map((_, place) => place);
  const both = make(
    "p",
    {},
    button("All", () => onchoose(places, true)),
    " ",
    button("None", () => onchoose(places, false)),
  );
  const element = make(
    "details",
    { className: "checks" },
    summary,
    both,
    make("div", { className: "boxes" }, ...boxes),
  );
  const sync = (shown) => {
    for (const [place, label] of boxes.entries()) label.firstChild.checked = isChosen(place);
    summary.textContent = `${title}: ${shown} of ${items.length}`;
  };
  return { element, sync, both };
};
export const optimizerChecks = checks(
  "Optimizers",
  optimizers.map((each) => each.label),
  (o) => state.optimizers.has(o),
  (places, on) => {
    const chosen = new Set(state.optimizers);
    for (const o of places) on ? chosen.add(o) : chosen.delete(o);
    change({ optimizers: chosen });
  },
);
export const problemChecks = checks(
  "Problems",
  problems.map((each) => each.label),
  (p) => !state.without.has(p),
  (places, on) => {
    const without = new Set(state.without);
    for (const p of places) on ? without.delete(p) : without.add(p);
    change({ without });
  },
);
export const filters = features.map(([name, values]) => {
  const select = make(
    "select",
    {
      onchange: () => {
        const { [name]: _, ...others } = state.filters;
        change({ filters: select.value === "" ? others : { ...others, [name]: select.value } });
      },
    },
    option("", "any"),
    ...values.filter((value) => value !== "").map((value) => option(value, value)),
  );
  problemChecks.both.append(" ", labelled(name, select));
  return [name, select];
});

export const link = button("Copy link", async () => {
  history.replaceState(null, "", address());
  try {
    await navigator.clipboard.writeText(location.href);
    link.textContent = "Copied";
  } catch {
    prompt("The address of this view:", location.href); // without access to the clipboard, the reader copies by hand
  }
});
export const status = make("p", { className: "note", role: "status" });
export const about = make("p", { className: "about" });
export const key = make("ul", { className: "key" });
export const tableSummary = make("summary", { textContent: "Values of this view" });
export const table = make("div", { className: "scroll", role: "group", ariaLabel: "Values of this view" });
export const tables = make("details", {}, tableSummary, table);

export const fillKey = () => {
  const own = state.view === "curves" ? chosenOptimizers() : [];
  key.hidden = !own.length;
  key.replaceChildren(
    ...own.map((o) => {
      const { dash, label } = optimizers[o];
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      for (const [name, value] of [
        ["width", 34],
        ["height", 10],
        ["aria-hidden", "true"],
      ])
        svg.setAttribute(name, value);
      const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
      for (const [name, value] of [
        ["d", "M0 5H34"],
        ["stroke", colorOf(o)],
        ["stroke-width", 3],
        ["stroke-dasharray", dash.join(" ")],
      ])
        line.setAttribute(name, value);
      svg.append(line);
      return make("li", {}, svg, ` ${label}`);
    }),
  );
};

export const fillTable = ({ head, rows, caption }) => {
  const heads = head.map((title) => make("th", { scope: "col", textContent: title }));
  const lines = rows.map(([first, ...others]) =>
    make(
      "tr",
      {},
      make("th", { scope: "row", textContent: first }),
      ...others.map((each) => make("td", { textContent: each })),
    ),
  );
  table.replaceChildren(
    make(
      "table",
      {},
      make("caption", { textContent: caption }),
      make("thead", {}, make("tr", {}, ...heads)),
      make("tbody", {}, ...lines),
    ),
  );
  if (!tables.open || table.scrollWidth > table.clientWidth)
    table.tabIndex = 0; // a closed one may prove too wide
  else table.removeAttribute("tabindex");
};
