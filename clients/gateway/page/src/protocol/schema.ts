// SPDX-License-Identifier: Apache-2.0
// Message definitions of ROS 2 (schemaEncoding "ros2msg").

export type Primitive =
  | "bool"
  | "int8"
  | "uint8"
  | "int16"
  | "uint16"
  | "int32"
  | "uint32"
  | "int64"
  | "uint64"
  | "float32"
  | "float64"
  | "string";

export interface Field {
  name: string;
  type: Primitive | Definition;
  /** false: one value; true: a sequence; a number: an array of that length */
  array: boolean | number;
}

export interface Definition {
  fields: Field[];
}

const PRIMITIVES = new Set<string>([
  "bool",
  "int8",
  "uint8",
  "int16",
  "uint16",
  "int32",
  "uint32",
  "int64",
  "uint64",
  "float32",
  "float64",
  "string",
]);
const ALIASES: Record<string, Primitive> = { byte: "uint8", char: "uint8" };
const BUILT_IN: Record<string, string> = {
  "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
  "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
};
const LINE = /^([A-Za-z][\w/]*)(?:<=\d+)?(\[(?:<=)?(\d*)\])?\s+(\w+)(\s*=)?/;

function shortName(name: string): string {
  return name.replace("/msg/", "/");
}

/** @throws Error when a line or a type is unknown. */
export function parseSchema(text: string): Definition {
  const sections = text.split(/^=+\s*$/m);
  const texts = new Map<string, string>(Object.entries(BUILT_IN));
  for (const section of sections.slice(1)) {
    const head = /^\s*MSG:\s*(\S+)\s*$/m.exec(section);
    if (head === null) throw new Error("schema: a section without MSG:");
    texts.set(shortName(head[1]), section.slice(head.index + head[0].length));
  }
  const known = new Map<string, Definition>();

  const named = (name: string): Definition => {
    const short = shortName(name);
    const before = known.get(short);
    if (before !== undefined) return before;
    const body = texts.get(short) ?? [...texts].find(([key]) => key.endsWith("/" + short))?.[1];
    if (body === undefined) throw new Error(`schema: unknown type ${name}`);
    const made: Definition = { fields: [] };
    known.set(short, made);
    made.fields = fields(body);
    return made;
  };

  const fields = (body: string): Field[] => {
    const found: Field[] = [];
    for (const raw of body.split("\n")) {
      const line = raw.replace(/#.*$/, "").trim();
      if (line === "") continue;
      const match = LINE.exec(line);
      if (match === null) throw new Error(`schema: cannot read "${line}"`);
      const [, type, brackets, size, name, constant] = match;
      if (constant !== undefined) continue;
      const primitive = ALIASES[type] ?? (PRIMITIVES.has(type) ? (type as Primitive) : undefined);
      const bounded = brackets?.includes("<=") ?? false;
      const fixed = size !== undefined && size !== "" && !bounded;
      found.push({
        name,
        type: primitive ?? named(type),
        array: brackets === undefined ? false : fixed ? Number(size) : true,
      });
    }
    return found;
  };

  return { fields: fields(sections[0]) };
}
