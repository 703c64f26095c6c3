// SPDX-License-Identifier: Apache-2.0
// Which program shows this page: other clients of the gateway read it before they take control.

/** The word in the user agent, and the name; most also claim to be Chrome, and Chrome to be Safari. */
const BROWSERS = [
  ["Edg", "Edge"],
  ["OPR", "Opera"],
  ["Firefox", "Firefox"],
  ["Chrome", "Chrome"],
  ["Version", "Safari"],
] as const;
const SYSTEMS = ["Windows", "Android", "iPhone", "iPad", "Mac OS", "CrOS", "Linux"];

/** @return such as "Chrome 131, Windows"; empty where the user agent shows neither */
export function browserOf(userAgent: string): string {
  const browser = BROWSERS.map(([word, name]) => {
    const version = new RegExp(`${word}/(\\d+)`).exec(userAgent)?.[1];
    return version === undefined ? "" : `${name} ${version}`;
  }).find((found) => found !== "");
  const system = SYSTEMS.find((name) => userAgent.includes(name));
  return [browser, system].filter((part) => part !== undefined).join(", ");
}
