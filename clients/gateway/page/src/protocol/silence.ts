// SPDX-License-Identifier: Apache-2.0

/** The longest silence of a page that holds control [ms], as the gateway allows it. */
export const LONGEST_SILENCE_MS = 10_000;
