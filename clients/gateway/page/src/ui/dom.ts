// SPDX-License-Identifier: Apache-2.0
// Creates elements in one expression, and writes texts only when they change.

type Child = Node | string | undefined | false;
type Handlers = { [K in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[K]) => void };

export interface Properties {
  class?: string;
  title?: string;
  id?: string;
  on?: Handlers;
  /** any attribute */
  attributes?: Record<string, string>;
}

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (properties.class !== undefined) element.className = properties.class;
  if (properties.title !== undefined) element.title = properties.title;
  if (properties.id !== undefined) element.id = properties.id;
  for (const [name, value] of Object.entries(properties.attributes ?? {})) {
    element.setAttribute(name, value);
  }
  for (const [name, handler] of Object.entries(properties.on ?? {})) {
    element.addEventListener(name, handler as EventListener);
  }
  for (const child of children) if (child !== undefined && child !== false) element.append(child);
  return element;
}

const SVG = "http://www.w3.org/2000/svg";

export function s<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | number> = {},
  ...children: (Node | string)[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

export function button(label: string, press: () => void, properties: Properties = {}): HTMLButtonElement {
  const made = h("button", { ...properties, attributes: { type: "button", ...properties.attributes } }, label);
  made.addEventListener("click", press);
  return made;
}

/** Where an error is shown. */
export interface Outcomes {
  outcome?: { text: string; ok: boolean };
}

/** Does what the user asked for; an error is shown at the bottom of the page. */
export function attempt(outcomes: Outcomes, act: () => void): void {
  try {
    act();
  } catch (error) {
    outcomes.outcome = { ok: false, text: (error as Error).message };
  }
}

export function put(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function mark(element: Element, name: string, on: boolean): void {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}

/** @return a labelled text field with its unit, and its parts. */
export function field(
  label: string,
  properties: { value?: string; placeholder?: string; width?: string; unit?: () => string; id?: string } = {},
): { root: HTMLLabelElement; input: HTMLInputElement; unit: HTMLElement } {
  const input = h("input", {
    id: properties.id,
    attributes: {
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      spellcheck: "false",
      value: properties.value ?? "",
      placeholder: properties.placeholder ?? "",
    },
  });
  const unit = h("span", { class: "unit" }, properties.unit?.() ?? "");
  return { root: h("label", { class: "field" }, h("span", { class: "label" }, label), input, unit), input, unit };
}

export function select(
  label: string,
  options: { value: string; text: string }[],
  value: string,
  change: (value: string) => void,
): HTMLSelectElement {
  const made = h("select", { title: label, attributes: { "aria-label": label } });
  for (const option of options) {
    const item = h("option", { attributes: { value: option.value } }, option.text);
    item.selected = option.value === value;
    made.append(item);
  }
  made.addEventListener("change", () => change(made.value));
  return made;
}

/** Gives a canvas as many pixels as the screen shows. @return its context, scaled to CSS pixels. */
export function fit(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  }
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("no canvas");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/** @return the colour with this name in the style sheet, in the active theme. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export function download(name: string, content: Blob): void {
  const link = h("a", { attributes: { download: name, href: URL.createObjectURL(content) } });
  link.click();
  window.setTimeout(() => URL.revokeObjectURL(link.href), 1_000);
}

/** Attributes of the element of a view that gets the focus when the focused element disappeared with the previous
 *  view. */
export const FOCUS = { "data-focus": "", tabindex: "-1" };

export interface View {
  root: HTMLElement;
  /** Called once per frame of the screen. */
  update(now: number): void;
  /** The colours have changed. */
  redraw?(): void;
  close?(): void;
}
