// Zoom: by the buttons, by dragging a rectangle, or with the chart in focus by +, -, 0 and the arrows.

import { chart, drawn } from "./chart.js";
import { along, back } from "./numbers.js";
import { button, make } from "./page.js";
import { change, state } from "./state.js";

export let current = null; // what the chart shows
export const showing = (made) => {
  current = made;
};
const moved = (factor, right, up) => {
  const shift = (scale, by) => {
    const [low, high] = along(scale, scale.domain);
    const [middle, half] = [(low + high) / 2 + (by * (high - low)) / 4, ((high - low) / 2) * factor];
    return back(scale, [middle - half, middle + half]);
  };
  if (current?.x) change({ zoom: { x: shift(current.x, right), y: current.y && shift(current.y, up) } });
};
const zoom = (factor) => moved(factor, 0, 0);
const KEYS = {
  "+": () => zoom(0.5),
  "-": () => zoom(2),
  0: () => change({ zoom: null }),
  ArrowLeft: () => moved(1, -1, 0),
  ArrowRight: () => moved(1, 1, 0),
  ArrowUp: () => moved(1, 0, 1),
  ArrowDown: () => moved(1, 0, -1),
};
chart.addEventListener("keydown", (event) => {
  const arrow = event.key.startsWith("Arrow");
  if (
    !Object.hasOwn(KEYS, event.key) ||
    event.ctrlKey ||
    event.metaKey ||
    event.altKey ||
    (arrow && !state.zoom) ||
    !current?.x
  )
    return;
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
    Object.assign(frame.style, {
      left: `${Math.min(x0, x1)}px`,
      width: `${Math.abs(x1 - x0)}px`,
      top: flat ? "0" : `${Math.min(y0, y1)}px`,
      height: flat ? "100%" : `${Math.abs(y1 - y0)}px`,
    });
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
    if ([...zoomed.x, ...(zoomed.y ?? [])].every(Number.isFinite) && zoomed.x[0] < zoomed.x[1])
      change({ zoom: zoomed });
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", up, { once: true });
});

export const zooms = make(
  "span",
  { className: "zooms", role: "group", ariaLabel: "Zoom" },
  button("Zoom in", () => zoom(0.5)),
  button("Zoom out", () => zoom(2)),
  button("Whole", () => change({ zoom: null })),
);
