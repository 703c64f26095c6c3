// SPDX-License-Identifier: Apache-2.0
#include "cdr_writer.hpp"

#include "vdrive/assert.hpp"

#include <limits>

namespace vdrive::bridge {
namespace {

constexpr std::string_view kLittleEndianCdr{"\0\1\0\0", 4};
constexpr std::uint64_t kSecond = 1'000'000'000;  // [ns]

}  // namespace

CdrWriter::CdrWriter(std::string& out) : out_(out.append(kLittleEndianCdr)), start_(out_.size()) {}

void CdrWriter::align(std::size_t size) {
  const std::size_t beyond = (out_.size() - start_) % size;
  if (beyond != 0) out_.append(size - beyond, '\0');
}

void CdrWriter::put(DataType type, std::int64_t value) {
  switch (size_of(type)) {
    case sizeof(std::uint8_t):
      return put(static_cast<std::uint8_t>(value));
    case sizeof(std::uint16_t):
      return put(static_cast<std::uint16_t>(value));
    default:
      return put(static_cast<std::uint32_t>(value));
  }
}

void CdrWriter::put(std::string_view text) {
  put_count(text.size() + 1);
  out_.append(text).push_back('\0');
}

void CdrWriter::put_count(std::size_t count) {
  ensure(count <= std::numeric_limits<std::uint32_t>::max(), "a count has 32 bits");
  put(static_cast<std::uint32_t>(count));
}

void CdrWriter::put_time(std::uint64_t nanoseconds) {
  put(static_cast<std::uint32_t>(nanoseconds / kSecond));
  put(static_cast<std::uint32_t>(nanoseconds % kSecond));
}

}  // namespace vdrive::bridge
