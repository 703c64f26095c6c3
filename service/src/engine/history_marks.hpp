// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "journal/journal_file.hpp"
#include "vdrive/wire/written.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::service {

/// Adds a mark (vdrive/wire/written.hpp) to the objects of an answer that reports history.
/// @return the mark
inline msg::ObjectResult& add_mark(wire::WrittenMark mark, std::uint64_t value, msg::Reply& reply) {
  auto& entry = reply.objects.emplace_back();
  entry.subindex = static_cast<std::uint8_t>(mark);
  entry.value = static_cast<std::int64_t>(value);
  return entry;
}

/// @return the mark for the author of the writes that follow.
[[nodiscard]] constexpr wire::WrittenMark mark_of(JournalAuthor::Means means) noexcept {
  switch (means) {
    case JournalAuthor::Means::request:
      return wire::WrittenMark::by_request;
    case JournalAuthor::Means::frame:
      return wire::WrittenMark::by_frame;
    case JournalAuthor::Means::none:
      break;
  }
  return wire::WrittenMark::by_bench;
}

}  // namespace vdrive::service
