// SPDX-License-Identifier: Apache-2.0
#include "mcap_format.hpp"

#include "recording.hpp"

#include <zlib.h>

#include <utility>

namespace vdrive::recording {

RecordBuilder::RecordBuilder(std::string& out, Opcode opcode)
    : out_(out), start_(out.size() + kMcapHead) {
  out_.push_back(static_cast<char>(opcode));
  put(std::uint64_t{0});
}

RecordBuilder::~RecordBuilder() {
  const std::uint64_t size = out_.size() - start_;
  std::memcpy(out_.data() + start_ - sizeof(size), &size, sizeof(size));
}

RecordBuilder& RecordBuilder::put(std::string_view text) {
  put(static_cast<std::uint32_t>(text.size()));
  return put_raw(text);
}

RecordBuilder& RecordBuilder::put(const TextMap& map) {
  const std::size_t place = out_.size();
  put(std::uint32_t{0});
  for (const auto& [key, value] : map) put(std::string_view(key)).put(std::string_view(value));
  const auto size = static_cast<std::uint32_t>(out_.size() - place - sizeof(std::uint32_t));
  std::memcpy(out_.data() + place, &size, sizeof(size));
  return *this;
}

RecordBuilder& RecordBuilder::put_raw(std::string_view bytes) {
  out_.append(bytes);
  return *this;
}

BodyReader::BodyReader(std::string_view body, std::string where)
    : body_(body), where_(std::move(where)) {}

std::string_view BodyReader::take(std::uint64_t size) {
  if (size > body_.size()) {
    throw RecordingError(where_ + " is " + std::to_string(size - body_.size()) +
                         " bytes shorter than its content");
  }
  const std::string_view bytes = body_.substr(0, size);
  body_.remove_prefix(size);
  return bytes;
}

std::string_view BodyReader::get_text() {
  return take(get<std::uint32_t>());
}

TextMap BodyReader::get_map() {
  BodyReader entries(take(get<std::uint32_t>()), where_);
  TextMap map;
  while (!entries.rest().empty()) {
    std::string key(entries.get_text());
    map[std::move(key)] = entries.get_text();
  }
  return map;
}

std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc) noexcept {
  const void* const data = bytes.data();
  return static_cast<std::uint32_t>(crc32_z(crc, static_cast<const Bytef*>(data), bytes.size()));
}

}  // namespace vdrive::recording
