// SPDX-License-Identifier: Apache-2.0
// A question before an irreversible action. It is part of the page, so that STOP stays within reach; the second click
// of a double click does not answer it.

import { t } from "../i18n";
import { SECOND_PRESS_MS } from "../model";
import { button, h } from "./dom";

export interface Asked {
  /** the question; its text may change while it is shown */
  text: HTMLElement;
  /** the button that confirms */
  label: string;
  /** of the buttons, for tests */
  name: string;
  agree: () => void;
  /** Called when the question has been removed, whatever the answer.
   *  @param hadFocus the question had the focus, which is now lost */
  leave: (hadFocus: boolean) => void;
}

/** Shows the question in `place`, with the focus on "Cancel". Escape cancels too.
 *  @return a function that cancels it */
export function ask(place: HTMLElement, { text, label, name, agree, leave }: Asked): () => void {
  const since = performance.now();
  const end = () => {
    document.removeEventListener("keydown", escape);
    const hadFocus = place.contains(document.activeElement);
    place.replaceChildren();
    leave(hadFocus);
  };
  const confirm = () => {
    if (performance.now() - since < SECOND_PRESS_MS) return;
    end();
    agree();
  };
  // On the document, because the second click of a double click may have moved the focus out of the question.
  const escape = (event: KeyboardEvent) => {
    if (event.key === "Escape" || !place.isConnected) end();
  };
  const cancel = button(t("cancel"), end, { attributes: { "data-test": `${name}-cancel` } });
  place.replaceChildren(
    text,
    cancel,
    button(label, confirm, { class: "primary", attributes: { "data-test": `${name}-confirm` } }),
  );
  cancel.focus();
  document.addEventListener("keydown", escape);
  return end;
}

/** A button that is replaced by its question. */
export function askingButton(label: string, name: string, question: () => string, agree: () => void): HTMLElement {
  const place = h("span", { class: "asking" });
  const leave = (hadFocus: boolean) => {
    place.replaceChildren(first);
    if (hadFocus) first.focus();
  };
  const first = button(label, () => void ask(place, { text: h("span", {}, question()), label, name, agree, leave }), {
    attributes: { "data-test": name },
  });
  place.append(first);
  return place;
}
