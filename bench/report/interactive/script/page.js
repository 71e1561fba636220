// The page around the interactive part: its elements and its colours.

export const ANCHOR = "look-further";
export const part = document.getElementById(ANCHOR);
export const body = part.querySelector(".further-body");

export const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};

export const labelled = (name, control, ...more) =>
  make("label", { className: "choice" }, `${name} `, control, ...more);
export const option = (value, name) => make("option", { value, textContent: name });
export const button = (name, onclick) => make("button", { type: "button", textContent: name, onclick });
/** A colour of the page as it is now, light or dark. */
export const pageColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
