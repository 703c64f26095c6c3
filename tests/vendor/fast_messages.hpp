// SPDX-License-Identifier: Apache-2.0
// Our side: every message is filled and printed field by field from its description, so a member
// added to the IDL is compared automatically.
#pragma once

#include "vdrive/wire/cdr.hpp"
#include "vdrive_messages_description.hpp"
#include "vendor/canonical.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <vector>

namespace vdrive::test {

template <typename Number>
inline constexpr int kBits = static_cast<int>(8 * sizeof(Number));

template <wire::CdrNumber Number>
void fill(const wire::MemberTraits& member, Number& number, Filler& filler);
template <std::size_t kBound>
void fill(const wire::MemberTraits& member, wire::Text<kBound>& text, Filler& filler);
template <typename Element>
void fill(const wire::MemberTraits& member, std::vector<Element>& elements, Filler& filler);

template <wire::CdrNumber Number>
void write(FILE* out, const char* path, const char* name, Number number);
template <std::size_t kBound>
void write(FILE* out, const char* path, const char* name, const wire::Text<kBound>& text);
template <typename Element>
void write(FILE* out, const char* path, const char* name, const std::vector<Element>& elements);

/// In the order of the IDL, like the rows of generate_fields.py.
template <wire::DescribedStruct Struct>
void fill(Struct& message, Filler& filler) {
  wire::for_each_member<Struct>([&](const auto& member) {
    fill(member, message.*member.pointer, filler);
  });
}

template <wire::CdrNumber Number>
void fill(const wire::MemberTraits& member, Number& number, Filler& filler) {
  if constexpr (std::is_same_v<Number, double>) {
    number = next_real(&filler);
  } else if constexpr (std::is_same_v<Number, bool>) {
    number = next_boolean(&filler);
  } else if constexpr (std::is_signed_v<Number>) {
    number = static_cast<Number>(next_signed(&filler, kBits<Number>));
  } else {
    number = static_cast<Number>(member.is_key ? next_key(&filler, kBits<Number>)
                                               : next_unsigned(&filler, kBits<Number>));
  }
}

template <std::size_t kBound>
void fill(const wire::MemberTraits& /*member*/, wire::Text<kBound>& text, Filler& filler) {
  std::array<char, kLongestString> room{};
  text = next_string(&filler, kBound, room.data());
}

template <typename Element>
void fill(const wire::MemberTraits& member, std::vector<Element>& elements, Filler& filler) {
  elements.resize(next_length(&filler, static_cast<std::uint32_t>(member.bound)));
  for (Element& element : elements) {
    if constexpr (wire::DescribedStruct<Element>) {
      fill(element, filler);
    } else {
      fill(wire::MemberTraits{}, element, filler);
    }
  }
}

template <wire::DescribedStruct Struct>
void write(FILE* out, const char* path, const Struct& message) {
  wire::for_each_member<Struct>([&](const auto& member) {
    write(out, path, std::string(member.name).c_str(), message.*member.pointer);
  });
}

template <wire::CdrNumber Number>
void write(FILE* out, const char* path, const char* name, Number number) {
  if constexpr (std::is_same_v<Number, double>) {
    write_real(out, path, name, number);
  } else if constexpr (std::is_signed_v<Number>) {
    write_signed(out, path, name, number);
  } else {
    write_unsigned(out, path, name, static_cast<std::uint64_t>(number));
  }
}

template <std::size_t kBound>
void write(FILE* out, const char* path, const char* name, const wire::Text<kBound>& text) {
  write_string(out, path, name, text.to_string().c_str());
}

template <typename Element>
void write(FILE* out, const char* path, const char* name, const std::vector<Element>& elements) {
  write_length(out, path, name, elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    std::array<char, kLongestPath> child{};
    if constexpr (wire::DescribedStruct<Element>) {
      write(out, element_path(child.data(), path, name, i, "."), elements[i]);
    } else {
      write(out, element_path(child.data(), path, name, i, ""), "", elements[i]);
    }
  }
}

/// Fills each sequence, including those inside elements, to its bound and then to one more; the
/// others are empty or have one element. @param check called with whether all are within their
/// bounds
template <wire::DescribedStruct Struct, typename Check>
void reach_bounds(Struct& message, const Check& check) {
  const auto reach = [&check](const wire::MemberTraits& member, auto& value) {
    if constexpr (requires { value.resize(1); }) {
      value.resize(member.bound);
      check(true, member.name);
      value.resize(member.bound + 1);
      check(false, member.name);
      value.resize(1);
      if constexpr (wire::DescribedStruct<std::remove_reference_t<decltype(value.front())>>) {
        reach_bounds(value.front(), check);
      }
      value.clear();
    }
  };
  wire::for_each_member<Struct>([&](const auto& member) {
    reach(member, message.*member.pointer);
  });
}

/// @return every field of `message`, one per line.
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
