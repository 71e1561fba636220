"use strict";
(() => {
  const FILTERED = 8; // a table with more rows has a filter

  const make = (tag, properties, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };

  // Sorting: by value where every cell of a column is a number, else as text; missing values stay last.

  const NUMBER = /^([<>]?)\s*([-+]?(?:[\d,]*\.?\d+(?:e[-+]?\d+)?|∞))\s*%?(?: to .*)?$/i;
  const texts = new Intl.Collator("en", { numeric: true });

  const text = (cell) =>
    [...cell.childNodes]
      .filter((node) => node.nodeName !== "SUP")
      .map((node) => node.textContent)
      .join("")
      .trim();

  const number = (shown) => {
    const [, sign, digits] = NUMBER.exec(shown.replaceAll("−", "-")) ?? [];
    if (digits === undefined) return null;
    const value = Number(digits.replaceAll(",", "").replace("∞", "Infinity"));
    return sign ? value + (sign === "<" ? -1e-9 : 1e-9) * Math.abs(value) : value;
  };

  const keys = (rows, column) => {
    const shown = rows.map((row) => text(row.cells[column])).map((each) => (each === "–" ? "" : each));
    const numbers = shown.map((each) => (each ? number(each) : null));
    return shown.every((each, i) => !each || numbers[i] !== null) ? numbers : shown.map((each) => each || null);
  };

  const order = (rows, column, sign) => {
    const values = keys(rows, column);
    const compare = (a, b) => (typeof a === "string" ? texts.compare(a, b) : a < b ? -1 : a > b ? 1 : 0);
    return rows
      .map((row, i) => ({ row, value: values[i] }))
      .sort(
        (a, b) => (a.value === null) - (b.value === null) || (a.value === null ? 0 : sign * compare(a.value, b.value)),
      )
      .map(({ row }) => row);
  };

  const sortable = (table) => {
    const body = table.tBodies[0];
    const original = [...body.rows];
    const heads = [...table.tHead.rows[0].cells];
    if (original.length < 2) return;
    heads.forEach((head, column) => {
      const button = make("button", { type: "button" }, ...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const state = { ascending: "descending", descending: "" }[head.getAttribute("aria-sort")] ?? "ascending";
        for (const each of heads) each.removeAttribute("aria-sort");
        if (state) head.setAttribute("aria-sort", state);
        body.append(...(state ? order(original, column, state === "ascending" ? 1 : -1) : original));
      });
    });
    oneStop(heads.map((head) => head.firstChild));
  };

  // The titles of a table are one stop of the Tab key; arrows, Home and End move among them.

  const oneStop = (buttons) => {
    buttons.forEach((button, place) => {
      button.tabIndex = place ? -1 : 0;
      button.title = "Sort; the arrow keys move along the columns";
      button.addEventListener("focus", () => {
        for (const each of buttons) each.tabIndex = each === button ? 0 : -1;
      });
      button.addEventListener("keydown", (event) => {
        const next = { ArrowLeft: place - 1, ArrowRight: place + 1, Home: 0, End: buttons.length - 1 }[event.key];
        if (next === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        buttons[next]?.focus();
      });
    });
  };

  // Filtering

  const filterable = (table) => {
    const rows = [...table.tBodies[0].rows];
    if (rows.length <= FILTERED) return;
    const frame = table.parentElement;
    const input = make("input", { type: "search" });
    input.setAttribute("aria-label", `Filter rows of ${frame.getAttribute("aria-label")}`);
    const status = make("span", { role: "status" });
    input.addEventListener("input", () => {
      const wanted = input.value.trim().toLowerCase();
      for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
      status.textContent = wanted && `${rows.filter((row) => !row.hidden).length} of ${rows.length} rows`;
    });
    frame.before(make("div", { className: "filter" }, make("label", {}, "Filter rows", input), status));
  };

  for (const table of document.querySelectorAll("table")) {
    sortable(table);
    filterable(table);
  }

  // A frame is a stop of the Tab key only where it scrolls; without scripts every frame is one.

  const frames = new ResizeObserver((changes) => {
    for (const { target } of changes) {
      const frame = target.closest(".scroll");
      if (frame.scrollWidth > frame.clientWidth) frame.tabIndex = 0;
      else frame.removeAttribute("tabindex");
    }
  });
  for (const frame of document.querySelectorAll(".scroll")) {
    frames.observe(frame);
    frames.observe(frame.firstElementChild);
  }

  // A specification is drawn below the picture of its figure as soon as there is room for it.

  const options = { ast: true, actions: false, defaultStyle: false, renderer: "svg", tooltip: false };
  const unseen = new ResizeObserver((changes) => {
    for (const { target } of changes) {
      if (!target.clientWidth) continue; // it is folded
      unseen.unobserve(target);
      vegaEmbed(target, JSON.parse(target.nextElementSibling.textContent), options);
    }
  });
  for (const live of document.querySelectorAll(".live")) unseen.observe(live);

  // Safari does not open a folded section that a link leads to.

  const reveal = () => {
    let anchor = location.hash.slice(1);
    try {
      anchor = decodeURIComponent(anchor);
    } catch {
      // an address that was cut is no name of a part
    }
    const target = document.getElementById(anchor);
    for (let at = target; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
    target?.scrollIntoView();
  };
  addEventListener("hashchange", reveal);
  if (location.hash) reveal();
})();
