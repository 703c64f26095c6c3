// SPDX-License-Identifier: Apache-2.0
// The Fast DDS side: every message is filled and printed field by field. The rows are generated
// from the IDL, so a member that is added there is compared here.
#pragma once

#include "vdrive_messages.h"
#include "vendor/canonical.h"

#include <cstdint>
#include <string>

namespace vdrive::test {

// clang-format off
#define STRUCTURE(type) inline void fill(msg::type& m, Filler& filler) {
#define END(type) }
#define UNSIGNED(name, bits) m.name() = static_cast<std::uint##bits##_t>(next_unsigned(&filler, bits));
#define SIGNED(name, bits) m.name() = static_cast<std::int##bits##_t>(next_signed(&filler, bits));
#define KEY_UNSIGNED(name, bits) m.name() = static_cast<std::uint##bits##_t>(next_key(&filler, bits));
#define REAL(name) m.name() = next_real(&filler);
#define BOOLEAN(name) m.name() = next_boolean(&filler);
#define STRING(name, bound) \
  { char text[kLongestString]; m.name() = next_string(&filler, bound, text); }
#define SEQUENCE(name, type, bound) \
  m.name().resize(next_length(&filler, bound)); for (auto& e : m.name()) fill(e, filler);
#define SEQUENCE_OF_UNSIGNED(name, bits, bound) \
  m.name().resize(next_length(&filler, bound)); \
  for (auto& e : m.name()) e = static_cast<std::uint##bits##_t>(next_unsigned(&filler, bits));
#define SEQUENCE_OF_SIGNED(name, bits, bound) \
  m.name().resize(next_length(&filler, bound)); \
  for (auto& e : m.name()) e = static_cast<std::int##bits##_t>(next_signed(&filler, bits));
#include "fields.inc"
#undef STRUCTURE
#undef END
#undef UNSIGNED
#undef SIGNED
#undef KEY_UNSIGNED
#undef REAL
#undef BOOLEAN
#undef STRING
#undef SEQUENCE
#undef SEQUENCE_OF_UNSIGNED
#undef SEQUENCE_OF_SIGNED

#define STRUCTURE(type) inline void write(FILE* out, const char* path, const msg::type& m) {
#define END(type) }
#define UNSIGNED(name, bits) write_unsigned(out, path, #name, m.name());
#define SIGNED(name, bits) write_signed(out, path, #name, m.name());
#define KEY_UNSIGNED(name, bits) UNSIGNED(name, bits)
#define REAL(name) write_real(out, path, #name, m.name());
#define BOOLEAN(name) write_unsigned(out, path, #name, m.name());
#define STRING(name, bound) write_string(out, path, #name, m.name().c_str());
#define ELEMENTS(name, statement) \
  write_length(out, path, #name, m.name().size()); \
  for (std::size_t i = 0; i < m.name().size(); ++i) { char child[kLongestPath]; statement; }
#define SEQUENCE(name, type, bound) \
  ELEMENTS(name, write(out, element_path(child, path, #name, i, "."), m.name()[i]))
#define SEQUENCE_OF_UNSIGNED(name, bits, bound) \
  ELEMENTS(name, write_unsigned(out, element_path(child, path, #name, i, ""), "", m.name()[i]))
#define SEQUENCE_OF_SIGNED(name, bits, bound) \
  ELEMENTS(name, write_signed(out, element_path(child, path, #name, i, ""), "", m.name()[i]))
#include "fields.inc"
#undef STRUCTURE
#undef END
#undef UNSIGNED
#undef SIGNED
#undef KEY_UNSIGNED
#undef REAL
#undef BOOLEAN
#undef STRING
#undef ELEMENTS
#undef SEQUENCE
#undef SEQUENCE_OF_UNSIGNED
#undef SEQUENCE_OF_SIGNED

// Each sequence, also of elements, as long as its bound and longer by one; the others are empty or
// have one element.
#define STRUCTURE(type) \
  template <typename Check> void reach_bounds([[maybe_unused]] msg::type& m, \
                                              [[maybe_unused]] const Check& check) {
#define END(type) }
#define UNSIGNED(name, bits)
#define SIGNED(name, bits)
#define KEY_UNSIGNED(name, bits)
#define REAL(name)
#define BOOLEAN(name)
#define STRING(name, bound)
#define REACH(name, bound) \
  m.name().resize(bound); check(true, #name); m.name().resize(bound + 1); check(false, #name);
#define SEQUENCE(name, type, bound) \
  REACH(name, bound) m.name().resize(1); reach_bounds(m.name().front(), check); m.name().clear();
#define SEQUENCE_OF_UNSIGNED(name, bits, bound) REACH(name, bound) m.name().clear();
#define SEQUENCE_OF_SIGNED(name, bits, bound) REACH(name, bound) m.name().clear();
#include "fields.inc"
#undef STRUCTURE
#undef END
#undef UNSIGNED
#undef SIGNED
#undef KEY_UNSIGNED
#undef REAL
#undef BOOLEAN
#undef STRING
#undef REACH
#undef SEQUENCE
#undef SEQUENCE_OF_UNSIGNED
#undef SEQUENCE_OF_SIGNED

// clang-format on

/// @return every field of `message`, one in each line.
template <typename Message>
std::string text_of(const Message& message) {
  char* buffer = nullptr;
  std::size_t size = 0;
  FILE* const out = open_memstream(&buffer, &size);
  write(out, "", message);
  std::fclose(out);
  std::string text(buffer, size);
  std::free(buffer);  // NOLINT(*-no-malloc): the C library made it
  return text;
}

}  // namespace vdrive::test
