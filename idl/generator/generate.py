#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generates C++ from an IDL file: plain structs, enumerations, and a description of each.

generate.py FILE.idl DIRECTORY

Writes DIRECTORY/FILE.hpp (structs and enumerations) and DIRECTORY/FILE_description.hpp (a
specialisation of vdrive::wire::Description for each of them). The supported subset of IDL 4.2:

  module NAME { ... };
  const uint32 NAME = 256;
  @final struct NAME { MEMBER ... };
  MEMBER: [@key] [@unit("mm")] [@range(min=0, max=9)] TYPE NAME;
  TYPE: an integer, boolean, octet, double, string, string<N>, a struct, or a sequence<TYPE[, N]> of
        anything but a sequence. The key members come first.

Lines starting with `///` above a struct, member or constant are its help. A line with a tag adds
information that IDL cannot express. An enumeration is a plain number on the network, because enum
values differ between vendors:

  /// @enumeration NAME PREFIX_ above the first of the constants with that prefix defines an
      enumeration;
  /// @enumeration NAME above a member gives the member that type;
  /// @figure counter|gauge [headline] above an unsigned number makes it a metric: a counter only
      increases; a headline is shown even where there is room for only a few metrics.

Anything else is refused with file, line and reason (exit code 1).
"""
import dataclasses
import os
import pathlib
import re
import sys

NUMBERS = {
    "int8": "std::int8_t", "uint8": "std::uint8_t", "octet": "std::byte",
    "int16": "std::int16_t", "short": "std::int16_t",
    "uint16": "std::uint16_t", "unsigned short": "std::uint16_t",
    "int32": "std::int32_t", "long": "std::int32_t",
    "uint32": "std::uint32_t", "unsigned long": "std::uint32_t",
    "int64": "std::int64_t", "long long": "std::int64_t",
    "uint64": "std::uint64_t", "unsigned long long": "std::uint64_t",
    "double": "double",
}
SIZES = {"std::int8_t": 1, "std::uint8_t": 1, "std::byte": 1, "std::int16_t": 2, "std::uint16_t": 2,
         "std::int32_t": 4, "std::uint32_t": 4, "std::int64_t": 8, "std::uint64_t": 8, "double": 8}
LARGEST_KEY = 16  # [bytes] a longer key is hashed by DDS
UNSIGNED = ("uint8", "uint16", "uint32", "uint64")
TAGS = ("@enumeration", "@figure")
FIGURES = [(kind, *more) for kind in ("counter", "gauge") for more in ((), ("headline",))]
TOKEN = re.compile(r"""(?P<help>///[^\n]*)|(?P<skip>//[^\n]*|/\*.*?\*/|\s+)
    |(?P<text>"[^"\n]*")|(?P<number>-?\d+(?:\.\d+)?)|(?P<word>@?[A-Za-z_]\w*(?:::\w+)*)
    |(?P<sign>[{}()<>;,=])""", re.VERBOSE | re.DOTALL)


class Refused(Exception):
    """Input outside the supported subset; the text starts with the line number."""

    def __init__(self, line, reason):
        super().__init__(f"{line}: {reason}")


@dataclasses.dataclass
class Token:
    kind: str
    text: str
    line: int


@dataclasses.dataclass
class Type:
    """The type of a member. `bound` is that of a sequence, `text_bound` of a string; 0 = none."""
    name: str
    is_sequence: bool = False
    bound: int = 0
    text_bound: int = 0


@dataclasses.dataclass
class Member:
    name: str
    type: Type
    help: str
    enumeration: str = ""
    figure: tuple = ()  # its kind, then "headline" if set
    unit: str = ""
    is_key: bool = False
    range: tuple = ()


@dataclasses.dataclass
class Struct:
    module: str
    name: str
    help: str
    members: list


@dataclasses.dataclass
class Constant:
    module: str
    type: str
    name: str
    value: int
    help: str


@dataclasses.dataclass
class Enumeration:
    module: str
    type: str
    name: str
    prefix: str
    values: list  # tuples (name, value, help)


def tokens_of(text):
    place, line = 0, 1
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None:
            raise Refused(line, f"{text[place]!r} is not understood")
        if match.lastgroup != "skip":
            yield Token(match.lastgroup, match[0], line)
        line += match[0].count("\n")
        place = match.end()
    yield Token("end", "", line)


def key_size(members):
    """@return the size of the key members [bytes], each aligned to its size."""
    end = 0
    for member in members:
        if member.is_key:
            size = SIZES[NUMBERS[member.type.name]]
            end += -end % size + size
    return end


class Parser:
    """Parses a file into `items`: constants, enumerations and structs, in order."""

    def __init__(self, text):
        self.tokens = list(tokens_of(text))
        self.place = 0
        self.modules = []
        self.items = []
        self.structs = {}
        self.enumerations = {}
        self.open_enumeration = None

    def parse(self):
        while self.peek().kind != "end":
            self.definition()
        return self.items

    # ---- tokens

    def peek(self):
        return self.tokens[self.place]

    def next(self):
        token = self.peek()
        if token.kind == "end":
            raise Refused(token.line, "the file ends here")
        self.place += 1
        return token

    def take(self, text):
        """Consumes the next token if it is `text`. @return whether it was."""
        if self.peek().text != text or self.peek().kind == "help":
            return False
        self.place += 1
        return True

    def need(self, text):
        token = self.peek()
        if not self.take(text):
            raise Refused(token.line, f"{text!r} is expected instead of {token.text!r}")

    def word(self, what):
        token = self.next()
        if token.kind != "word" or token.text.startswith("@"):
            raise Refused(token.line, f"{what} is expected instead of {token.text!r}")
        return token

    def new_name(self, what, known):
        token = self.word(what)
        if "::" in token.text or token.text in known:
            raise Refused(token.line, f"{token.text!r} cannot be the name of {what}: "
                          "it is already used, or contains '::'")
        return token.text

    def number(self, kind=int):
        token = self.next()
        try:
            return kind(token.text)
        except ValueError:
            raise Refused(token.line, f"a number is expected instead of {token.text!r}") from None

    def positive(self):
        line = self.peek().line
        value = self.number()
        if value < 1:
            raise Refused(line, f"a bound is at least 1, not {value}")
        return value

    def help(self):
        """@return the help before a definition, and its tags with the words after each tag."""
        lines, tags = [], {}
        while self.peek().kind == "help":
            token = self.next()
            text = token.text[3:].strip()
            if text.startswith("@"):
                tag, *words = text.split()
                if tag not in TAGS:
                    raise Refused(token.line, f"the tag {tag!r} is not known")
                tags[tag] = words
            else:
                lines.append(text)
        return " ".join(lines), tags

    # ---- definitions

    def definition(self):
        help_text, tags = self.help()
        if self.take("module"):
            self.modules.append(self.word("the name of a module").text)
            self.open_enumeration = None
            self.need("{")
            while not self.take("}"):
                self.definition()
            self.need(";")
            self.modules.pop()
            self.open_enumeration = None
        elif self.take("const"):
            self.constant(help_text, tags.get("@enumeration", []))
        elif self.take("@final"):
            if tags:
                raise Refused(self.peek().line, f"{next(iter(tags))} must not be above a struct")
            self.need("struct")
            self.struct(help_text)
        else:
            token = self.peek()
            reason = "a struct is @final" if token.text == "struct" else \
                f"a module, constant or @final struct is expected, not {token.text!r}"
            raise Refused(token.line, reason)

    def constant(self, help_text, enumeration):
        line = self.peek().line
        type_name = self.word("the type of a constant").text
        if type_name not in UNSIGNED:
            raise Refused(line, f"a constant is unsigned, not {type_name}")
        name = self.new_name("a constant", [])
        self.need("=")
        value = self.number()
        if not 0 <= value < 2 ** int(type_name.lstrip("uint")):
            raise Refused(line, f"{name} = {value} is no {type_name}")
        self.need(";")
        module = "::".join(self.modules)
        if enumeration:
            if len(enumeration) != 2 or not name.startswith(enumeration[1]):
                raise Refused(line, "an enumeration has a name and the prefix of its constants")
            group = Enumeration(module, type_name, *enumeration, [])
            self.enumerations[group.name] = self.open_enumeration = group
            self.items.append(group)
        group = self.open_enumeration
        if group is not None and name.startswith(group.prefix):
            if any(value == other for _, other, _ in group.values):
                raise Refused(line, f"{group.name} has the value {value} twice")
            group.values.append((name[len(group.prefix):].lower(), value, help_text))
            return
        self.open_enumeration = None
        self.items.append(Constant(module, type_name, name, value, help_text))

    def struct(self, help_text):
        self.open_enumeration = None
        line = self.peek().line
        name = self.new_name("a struct", [])
        module = "::".join(self.modules)
        members = []
        self.need("{")
        while not self.take("}"):
            members.append(self.member(name, [member.name for member in members]))
            if members[-1].is_key and not all(member.is_key for member in members):
                raise Refused(self.peek().line, f"the key members of {name} are its first ones")
        self.need(";")
        if not members:
            raise Refused(line, f"{name} has no member")
        if key_size(members) > LARGEST_KEY:
            raise Refused(line, f"the key of {name} has more than {LARGEST_KEY} bytes")
        struct = Struct(module, name, help_text, members)
        self.structs[f"{module}::{name}"] = struct
        self.items.append(struct)

    def member(self, struct, known):
        help_text, tags = self.help()
        made = Member("", None, help_text, "".join(tags.get("@enumeration", [])),
                      tuple(tags.get("@figure", [])))
        while self.peek().text.startswith("@"):
            self.annotation(made)
        line = self.peek().line
        made.type = self.type()
        made.name = self.new_name(f"a member of {struct}", known)
        self.need(";")
        if made.enumeration:
            group = self.enumerations.get(made.enumeration)
            if group is None or made.type.is_sequence or \
                    NUMBERS.get(made.type.name) != NUMBERS[group.type]:
                raise Refused(line, f"there is no enumeration {made.enumeration} of the type of "
                                    f"{made.name}")
        if "@figure" in tags:
            is_number = made.type.name in UNSIGNED and not made.type.is_sequence
            if made.enumeration or not is_number or made.figure not in FIGURES:
                raise Refused(line, f"the figure {made.name} is an unsigned number, and a counter or "
                                    "a gauge, perhaps a headline")
        if made.is_key and (made.type.is_sequence or made.type.name not in NUMBERS):
            raise Refused(line, f"the key {made.name} is a number")
        return made

    def annotation(self, member):
        token = self.next()
        if token.text == "@key":
            member.is_key = True
        elif token.text == "@unit":
            self.need("(")
            member.unit = self.next().text.strip('"')
            self.need(")")
        elif token.text == "@range":
            self.need("(")
            self.need("min")
            self.need("=")
            least = self.number(float)
            self.need(",")
            self.need("max")
            self.need("=")
            member.range = (least, self.number(float))
            self.need(")")
        else:
            raise Refused(token.line, f"the annotation {token.text!r} is not known")

    def type(self):
        token = self.word("a type")
        if token.text == "sequence":
            self.need("<")
            element = self.type()
            if element.is_sequence:
                raise Refused(token.line, "a sequence of sequences")
            bound = self.positive() if self.take(",") else 0
            self.need(">")
            return Type(element.name, True, bound, element.text_bound)
        if token.text == "string":
            bound = 0
            if self.take("<"):
                bound = self.positive()
                self.need(">")
            return Type("string", text_bound=bound)
        name = token.text
        while f"{name} {self.peek().text}" in NUMBERS or \
                (name == "unsigned" and self.peek().text in ("short", "long")):
            name += " " + self.next().text
        if name in NUMBERS or name == "boolean":
            return Type(name)
        for struct in (name, "::".join(self.modules) + "::" + name):
            if struct in self.structs:
                return Type(struct)
        raise Refused(token.line, f"there is no type {name!r} here")


# ---- C++ ------------------------------------------------------------------------------------------

FIRST_LINES = "// Made from {idl} by {generator}. SPDX-License-Identifier: Apache-2.0\n#pragma once\n\n"


def text_literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def cpp_type(member):
    if member.enumeration:
        return member.enumeration
    kind = member.type
    if kind.name == "string":
        one = f"::vdrive::wire::Text<{kind.text_bound}>" if kind.text_bound else "std::string"
    elif kind.name == "boolean":
        one = "bool"
    else:
        one = NUMBERS.get(kind.name) or "::" + kind.name
    return f"std::vector<{one}>" if kind.is_sequence else one


def comment(text, indent=""):
    return f"{indent}/// {text}\n" if text else ""


def definition(item):
    """@return the C++ definition of a constant, an enumeration or a struct."""
    if isinstance(item, Constant):
        return comment(item.help) + \
            f"inline constexpr {NUMBERS[item.type]} {item.name} = {item.value};\n"
    if isinstance(item, Enumeration):
        lines = "".join(f"{comment(text, '  ')}  {name} = {value},\n"
                        for name, value, text in item.values)
        return f"enum class {item.name} : {NUMBERS[item.type]} {{\n{lines}}};\n"
    lines = ""
    for member in item.members:
        is_number = not member.type.is_sequence and member.type.name in NUMBERS
        start = "{}" if member.enumeration or member.type.name == "octet" else " = 0" if is_number else \
            " = false" if not member.type.is_sequence and member.type.name == "boolean" else "{}"
        unit = f"[{member.unit}]" if member.unit else ""
        lines += comment(" ".join(part for part in (member.help, unit) if part), "  ")
        lines += f"  {cpp_type(member)} {member.name}{start};\n"
    return f"{comment(item.help)}struct {item.name} {{\n{lines}\n" \
           f"  friend bool operator==(const {item.name}&, const {item.name}&) = default;\n}};\n"


def structs_header(items):
    text = '#include "vdrive/wire/message_types.hpp"\n\n' \
           "#include <cstddef>\n#include <cstdint>\n#include <string>\n#include <vector>\n"
    module = None
    for item in items:
        if item.module != module:
            text += f"\n}}  // namespace {module}\n" if module else ""
            text += f"\nnamespace {item.module} {{\n"
            module = item.module
        text += "\n" + definition(item)
    return text + f"\n}}  // namespace {module}\n"


def member_row(struct, member):
    row = f"Member{{{{.name = {text_literal(member.name)}"
    if member.unit:
        row += f", .unit = {text_literal(member.unit)}"
    if member.help:
        row += f", .help = {text_literal(member.help)}"
    if member.type.bound:
        row += f", .bound = {member.type.bound}"
    if member.is_key:
        row += ", .is_key = true"
    if member.range:
        row += f", .least = {member.range[0]}, .most = {member.range[1]}"
    if member.figure:
        row += f", .figure = FigureKind::{member.figure[0]}"
    if "headline" in member.figure:
        row += ", .is_headline = true"
    return row + f"}}, &::{struct.module}::{struct.name}::{member.name}}}"


def descriptions_header(items, structs_file):
    text = f'#include "{structs_file}"\n#include "vdrive/wire/description.hpp"\n\n' \
           "#include <array>\n#include <tuple>\n\nnamespace vdrive::wire {\n"
    for item in items:
        if isinstance(item, Constant):
            continue
        text += f"\ntemplate <>\nstruct Description<::{item.module}::{item.name}> {{\n" \
                f'  static constexpr std::string_view kName = "{item.module}::{item.name}";\n'
        if isinstance(item, Enumeration):
            rows = ",\n      ".join(f"EnumerationValue{{{value}U, {text_literal(name)}, "
                                    f"{text_literal(help_text)}}}"
                                    for name, value, help_text in item.values)
            text += f"  static constexpr std::array kValues{{\n      {rows}}};\n}};\n"
        else:
            rows = ",\n      ".join(member_row(item, member) for member in item.members)
            text += f"  static constexpr std::string_view kHelp = {text_literal(item.help)};\n" \
                    f"  static constexpr std::tuple kMembers{{\n      {rows}}};\n}};\n"
    return text + "\n}  // namespace vdrive::wire\n"


def main(arguments):
    if len(arguments) != 2:
        print("usage: generate.py FILE.idl DIRECTORY", file=sys.stderr)
        return 2
    idl, directory = map(pathlib.Path, arguments)
    try:
        items = Parser(idl.read_text(encoding="utf-8")).parse()
    except Refused as refused:
        print(f"{idl}:{refused}", file=sys.stderr)
        return 1
    first = FIRST_LINES.format(idl=idl.name, generator=os.path.basename(__file__))
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in ((f"{idl.stem}.hpp", structs_header(items)),
                       (f"{idl.stem}_description.hpp",
                        descriptions_header(items, f"{idl.stem}.hpp"))):
        (directory / name).write_text(first + text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
