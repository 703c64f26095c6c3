// SPDX-License-Identifier: Apache-2.0

/** The longest silence that the gateway allows a page that holds control [ms]. */
export const LONGEST_SILENCE_MS = 10_000;
