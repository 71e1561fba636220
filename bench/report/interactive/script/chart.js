// The chart of the part, and the drawing of a specification by Vega.

import { body, make, pageColor } from "./page.js";

export const chart = make("div", { className: "chart", tabIndex: 0 });
chart.setAttribute("role", "group");
export const width = () => Math.max((chart.clientWidth || body.clientWidth) - 18, 200);

const config = () => {
  const [text, soft, gridColor] = ["--text", "--soft", "--grid"].map(pageColor);
  const axis = {
    labelFontSize: 12,
    titleFontSize: 12,
    titleFontWeight: "normal",
    labelColor: text,
    titleColor: text,
    gridColor,
    domainColor: soft,
    tickColor: soft,
  };
  return { background: "transparent", font: "system-ui, 'DejaVu Sans', sans-serif", view: { stroke: null }, axis };
};
export const drawn = new Map(); // the chart of each place, so that an older one ends
export const embed = async (place, spec) => {
  const number = (drawn.get(place)?.number ?? 0) + 1;
  const before = drawn.get(place);
  drawn.set(place, { ...before, number });
  place.dataset.ready = "";
  const canvas = make("div", { ariaHidden: "true" }); // the place has a label, and the page a table of its values
  try {
    const marks = spec.data.values.length > 4000 && !spec.vconcat;
    const made = await vegaEmbed(
      canvas,
      { config: config(), ...(spec.vconcat ? {} : { autosize: { type: "fit-x", contains: "padding" } }), ...spec },
      { mode: "vega-lite", ast: true, actions: false, defaultStyle: false, renderer: marks ? "canvas" : "svg" },
    );
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
