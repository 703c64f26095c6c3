#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The generator of messages: what it makes of each construct, and what it refuses."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "idl/generator"))
import generate  # noqa: E402


def items(body):
    return generate.Parser(f"module a {{ module b {{\n{body}\n}}; }};").parse()


def header(body):
    return generate.structs_header(items(body))


def description(body):
    return generate.descriptions_header(items(body), "x.hpp")


class Makes(unittest.TestCase):
    def test_a_plain_struct_with_public_members_that_begin_with_0(self):
        text = header("@final struct S { uint16 axis; double rate; boolean on; octet level; };")
        for line in ("namespace a::b {", "struct S {", "  std::uint16_t axis = 0;",
                     "  double rate = 0;", "  bool on = false;", "  std::byte level{};",
                     "  friend bool operator==(const S&, const S&) = default;"):
            self.assertIn(line + "\n", text)

    def test_sequences_and_texts(self):
        text = header("@final struct E { uint8 x; };\n"
                      "@final struct S { sequence<E, 4> some; sequence<string> names; string<16> t; };")
        for line in ("std::vector<::a::b::E> some{};", "std::vector<std::string> names{};",
                     "::vdrive::wire::Text<16> t{};"):
            self.assertIn(line, text)
        self.assertIn('{.name = "some", .bound = 4}, &::a::b::S::some',
                      description("@final struct E { uint8 x; };\n"
                                  "@final struct S { sequence<E, 4> some; };"))

    def test_help_unit_range_and_key_of_a_member(self):
        text = description('@final struct S {\n  /// how "far"\n'
                           '  @key @unit("mm") @range(min=-1, max=2.5) int32 way;\n};')
        self.assertIn('Member{{.name = "way", .unit = "mm", .help = "how \\"far\\"", .is_key = true, '
                      '.least = -1.0, .most = 2.5}, &::a::b::S::way}', text)

    def test_an_enumeration_of_constants_with_one_prefix(self):
        body = ("/// @enumeration Kind KIND_\n/// nothing\nconst uint32 KIND_NONE = 0;\n"
                "const uint32 KIND_ANY_OTHER = 7;\nconst uint32 MOST = 9;\n"
                "@final struct S {\n  /// @enumeration Kind\n  uint32 kind;\n};")
        text = header(body)
        self.assertIn("enum class Kind : std::uint32_t {\n  /// nothing\n  none = 0,\n"
                      "  any_other = 7,\n};", text)
        self.assertIn("inline constexpr std::uint32_t MOST = 9;", text)
        self.assertIn("  Kind kind{};", text)
        self.assertIn('EnumerationValue{7U, "any_other", ""}', description(body))

    def test_figures_with_their_kind(self):
        text = description("@final struct S {\n  /// @figure counter\n  /// what came\n  uint64 came;\n"
                           "  /// @figure gauge headline\n  uint32 waits;\n};")
        self.assertIn('{.name = "came", .help = "what came", .figure = FigureKind::counter}', text)
        self.assertIn('{.name = "waits", .figure = FigureKind::gauge, .is_headline = true}', text)

    def test_the_numbers_of_classic_idl(self):
        text = header("@final struct S { long a; unsigned long b; unsigned long long c; short d; };")
        for line in ("std::int32_t a", "std::uint32_t b", "std::uint64_t c", "std::int16_t d"):
            self.assertIn(line, text)


class Refuses(unittest.TestCase):
    def refusal(self, body):
        with self.assertRaises(generate.Refused) as refused:
            items(body)
        return str(refused.exception)

    def test_what_is_outside_the_subset_with_line_and_reason(self):
        for body, expected in (
                ("struct S { uint8 a; };", "2: a struct is @final"),
                ("@final struct S { };", "2: S has no member"),
                ("@final struct S { uint8 a; uint8 a; };", "2: 'a' cannot be the name of a member of S"),
                ("@final struct S {\n  float a;\n};", "3: there is no type 'float' here"),
                ("@final struct S {\n  @optional uint8 a;\n};", "3: the annotation '@optional'"),
                ("@final struct S { sequence<sequence<uint8>> a; };", "a sequence of sequences"),
                ("@final struct S { string<0> a; };", "a bound is at least 1, not 0"),
                ("@final struct S { uint8 a; @key uint8 b; };", "the key members of S are its first"),
                ("@final struct S { @key string<4> a; };", "the key a is a number"),
                ("const uint8 A = 300;", "2: A = 300 is no uint8"),
                ("const uint32 A = -1;", "2: A = -1 is no uint32"),
                ("@final struct S { @key uint64 a; @key uint64 b; @key uint8 c; };",
                 "2: the key of S has more than 16 bytes"),
                ("enum E { A };", "2: a module, constant or @final struct is expected, not 'enum'"),
                ("const int32 A = -1;", "a constant is unsigned, not int32"),
                ("/// @enumeration E\nconst uint32 E_A = 1;", "an enumeration has a name and the prefix"),
                ("/// @enumeration E E_\nconst uint32 E_A = 1;\nconst uint32 E_B = 1;",
                 "4: E has the value 1 twice"),
                ("@final struct S {\n  /// @enumeration E\n  uint32 a;\n};",
                 "there is no enumeration E"),
                ("@final struct S {\n  /// @figure counter\n  double a;\n};",
                 "4: the figure a is an unsigned number"),
                ("@final struct S {\n  /// @figure rate\n  uint64 a;\n};", "4: the figure a is"),
                ("/// @deprecated\n@final struct S { uint8 a; };", "2: the tag '@deprecated'"),
                ("const uint32 A = 1 $", "'$' is not understood"),
                ("@final struct S { uint8 a; }", "';' is expected instead of '}'")):
            with self.subTest(body):
                self.assertIn(expected, self.refusal(body))

    def test_a_file_that_ends_in_the_middle(self):
        with self.assertRaises(generate.Refused) as refused:
            generate.Parser("module m {\n@final struct S { @unit(").parse()
        self.assertEqual(str(refused.exception), "2: the file ends here")

    def test_a_file_with_the_name_of_the_file_and_exit_code_1(self):
        with tempfile.TemporaryDirectory() as directory:
            idl = pathlib.Path(directory) / "bad.idl"
            idl.write_text("module m {\n  union U;\n};\n", encoding="utf-8")
            done = subprocess.run([sys.executable, ROOT / "idl/generator/generate.py", idl, directory],
                                  check=False, capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertIn("bad.idl:2: a module, constant or @final struct is expected, not 'union'", done.stderr)
            self.assertFalse((pathlib.Path(directory) / "bad.hpp").exists())


if __name__ == "__main__":
    unittest.main()
