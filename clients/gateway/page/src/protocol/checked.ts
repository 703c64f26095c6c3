// SPDX-License-Identifier: Apache-2.0
// Checks messages against their JSON schema, so that the page can rely on their types.

export type Schema =
  | { readonly type: "string" | "integer" | "number" | "boolean" }
  | { readonly type: "array"; readonly items: Schema }
  | {
      readonly type: "object";
      readonly properties: { readonly [name: string]: Schema };
      readonly required: readonly string[];
    };

/** The type of the values that a schema describes. */
export type Of<S> = S extends { readonly type: "string" }
  ? string
  : S extends { readonly type: "integer" | "number" }
    ? number
    : S extends { readonly type: "boolean" }
      ? boolean
      : S extends { readonly type: "array"; readonly items: infer Item }
        ? Of<Item>[]
        : S extends { readonly properties: infer Properties; readonly required: readonly (infer Required)[] }
          ? { -readonly [Name in keyof Properties & Required]: Of<Properties[Name]> } & {
              -readonly [Name in Exclude<keyof Properties, Required>]?: Of<Properties[Name]>;
            }
          : never;

function kindOf(value: unknown): string {
  if (Array.isArray(value)) return "array";
  return value === null ? "null" : typeof value;
}

function check(schema: Schema, value: unknown, path: string): void {
  const kind = kindOf(value);
  const wanted = schema.type === "integer" ? "number" : schema.type;
  if (kind !== wanted) throw new Error(`${path} is of type ${kind}: expected ${schema.type}`);
  if (schema.type === "array") {
    (value as unknown[]).forEach((item, index) => check(schema.items, item, `${path}[${index}]`));
  } else if (schema.type === "object") {
    const members = value as Record<string, unknown>;
    for (const [name, member] of Object.entries(schema.properties)) {
      if (members[name] !== undefined) check(member, members[name], `${path}.${name}`);
      else if (schema.required.includes(name)) throw new Error(`${path}.${name} is missing`);
    }
  }
}

/**
 * @param name of the message, for the error
 * @returns `value` with the type of its schema
 * @throws Error with the member that does not match. Members that are not in the schema may have any value.
 */
export function checked<S extends Schema>(schema: S, value: unknown, name: string): Of<S> {
  check(schema, value, name);
  return value as Of<S>;
}
