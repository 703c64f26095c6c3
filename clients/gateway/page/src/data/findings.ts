// SPDX-License-Identifier: Apache-2.0
// The answer of the service /judge.

import type { Of } from "../protocol/checked";

export const FINDINGS = {
  type: "object",
  properties: {
    judged: { type: "boolean" },
    findings: {
      type: "array",
      items: {
        type: "object",
        properties: {
          rule: { type: "string" },
          severity: { type: "string" },
          title: { type: "string" },
          axis: { type: "integer" },
          count: { type: "integer" },
          tick: { type: "integer" },
          happened: { type: "string" },
          remedy: { type: "string" },
        },
        required: ["rule", "severity", "title", "axis", "count", "tick", "happened", "remedy"],
      },
    },
  },
  required: ["judged", "findings"],
} as const;

export type FoundMistake = Of<typeof FINDINGS>["findings"][number];
