// SPDX-License-Identifier: Apache-2.0
// Identifies the program that shows this page, because other clients of the gateway see it before they take control.

/** The word in the user agent, and the name. The order matters: most claim to be Chrome too, and Chrome to be
 *  Safari. */
const BROWSERS = [
  ["Edg", "Edge"],
  ["OPR", "Opera"],
  ["Firefox", "Firefox"],
  ["Chrome", "Chrome"],
  ["Version", "Safari"],
] as const;
const SYSTEMS = ["Windows", "Android", "iPhone", "iPad", "Mac OS", "CrOS", "Linux"];

/** @return such as "Chrome 131, Windows"; empty if the user agent contains neither */
export function browserOf(userAgent: string): string {
  const browser = BROWSERS.map(([word, name]) => {
    const version = new RegExp(`${word}/(\\d+)`).exec(userAgent)?.[1];
    return version === undefined ? "" : `${name} ${version}`;
  }).find((found) => found !== "");
  const system = SYSTEMS.find((name) => userAgent.includes(name));
  return [browser, system].filter((part) => part !== undefined).join(", ");
}
