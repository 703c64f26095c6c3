// SPDX-License-Identifier: Apache-2.0
#include "engine/window_files.hpp"

#include "base/content_check.hpp"
#include "base/log.hpp"
#include "configuration/configuration_file.hpp"
#include "vdrive/axis_bank.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>

namespace vdrive::service {
namespace {

constexpr std::uint64_t kWindowMagic = 0x776F646E69777664ULL;      // "dvwindow"
constexpr std::uint64_t kHighestNumber = std::uint64_t{1} << 62U;  // of a tick and of a window
constexpr std::uint64_t kMostTicks = 1'000'000;                    // of a segment, far above 5 s
constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 30U;

/// The header of a file, before the segments.
struct WindowHead {
  std::uint64_t magic = kWindowMagic;
  std::uint64_t axes = 0;
  std::uint64_t check = 0;  // of everything after the header
  std::uint64_t window_size = sizeof(Window);
  std::uint64_t entry_size = sizeof(BoxEntry);
};

struct SegmentHead {
  std::uint64_t cause = 0;
  std::uint64_t tick = 0;
  std::uint64_t ticks = 0;
  std::uint64_t state = 0;    // size [bytes]
  std::uint64_t entries = 0;  // count
};

template <typename Value>
void put_raw(std::vector<std::byte>& bytes, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const auto raw = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

/// Takes a value from the front. @return false if too little is left.
template <typename Value>
bool take_raw(std::span<const std::byte>& bytes, Value& value) {
  if (bytes.size() < sizeof(value)) return false;
  std::memcpy(&value, bytes.data(), sizeof(value));
  bytes = bytes.subspan(sizeof(value));
  return true;
}

std::uint64_t hash_of(const Configuration& configuration) {
  Configuration axes;
  axes.period = configuration.period;
  axes.axes = configuration.axes;
  const std::string text = to_yaml(axes);
  return check_of(std::as_bytes(std::span(text))) ^ AxisBank::snapshot_layout();
}

std::vector<std::byte> bytes_of_file(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kLargestFile) return {};
  std::vector<std::byte> bytes(size);
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()),  // NOLINT(*-reinterpret-cast): raw bytes
              static_cast<std::streamsize>(bytes.size()));
  if (!stream) bytes.clear();
  return bytes;
}

/// A segment of a file. Its entries are copied, because they are not aligned in the file.
struct ReadSegment {
  BlackBox::KeptSegment kept;
  std::vector<BoxEntry> entries;
};

/// @return whether a replay of these entries stays within the axes and the ticks of their segment.
bool are_sound(std::span<const BoxEntry> entries, std::uint64_t ticks, std::size_t axes) {
  std::uint64_t counted = 0;
  for (const BoxEntry& entry : entries) {
    const bool is_of_an_axis =
        entry.kind == BoxEntry::Kind::change || entry.kind == BoxEntry::Kind::refusal;
    if (entry.kind > BoxEntry::Kind::event || (is_of_an_axis && entry.axis >= axes)) return false;
    if (entry.kind != BoxEntry::Kind::ticks) continue;
    const auto more = static_cast<std::uint64_t>(entry.value);
    if (more > ticks - counted) return false;
    counted += more;
  }
  return counted == ticks;
}

bool take_segment(std::span<const std::byte>& bytes, std::size_t state_size, ReadSegment& segment) {
  SegmentHead head;
  if (!take_raw(bytes, head) || head.state != state_size || head.state > bytes.size()) return false;
  if (head.ticks > kMostTicks || head.tick > kHighestNumber) return false;
  if (head.cause > static_cast<std::uint64_t>(BlackBox::Segment::Cause::jumped)) return false;
  segment.kept = {.cause = static_cast<BlackBox::Segment::Cause>(head.cause),
                  .tick = head.tick,
                  .ticks = head.ticks,
                  .state = bytes.first(head.state),
                  .entries = {}};
  bytes = bytes.subspan(head.state);
  if (head.entries > bytes.size() / sizeof(BoxEntry)) return false;
  segment.entries.resize(head.entries);
  std::memcpy(segment.entries.data(), bytes.data(), head.entries * sizeof(BoxEntry));
  bytes = bytes.subspan(head.entries * sizeof(BoxEntry));
  segment.kept.entries = segment.entries;
  return true;
}

}  // namespace

WindowFiles::WindowFiles(std::filesystem::path directory, const Configuration& configuration)
    : directory_(std::move(directory)),
      prefix_("bench-" + std::to_string(configuration.bench) + ".window-"),
      axis_count_(configuration.axes.size()),
      axes_(hash_of(configuration)) {}

std::filesystem::path WindowFiles::file(std::uint64_t number) const {
  return directory_ / (prefix_ + std::to_string(number));
}

void WindowFiles::load(BlackBox& box) {
  if (!box.is_on()) return;
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().filename().string().starts_with(prefix_)) paths.push_back(entry->path());
  }
  // Newest first. Longer names are sorted first, because a number with more digits is greater.
  std::ranges::sort(paths, std::greater{}, [](const std::filesystem::path& path) {
    return std::pair(path.string().size(), path.string());
  });
  for (const std::filesystem::path& path : paths) {
    if (load(path, box)) continue;
    log_warning("{}: not a black box window for these axes; it is removed", path.string());
    std::filesystem::remove(path, error);
  }
  box.hand_over_windows();
}

bool WindowFiles::load(const std::filesystem::path& path, BlackBox& box) {
  const std::vector<std::byte> content = bytes_of_file(path);
  std::span<const std::byte> bytes(content);
  WindowHead head;
  const WindowHead wanted{.axes = axes_};
  Window window;
  const bool is_ours = take_raw(bytes, head) && head.magic == wanted.magic && head.axes == axes_ &&
                       head.window_size == wanted.window_size &&
                       head.entry_size == wanted.entry_size && head.check == check_of(bytes) &&
                       take_raw(bytes, window) && path == file(window.number) &&
                       window.segment_count <= Window::kMostSegments && window.cause_count > 0 &&
                       window.cause_count <= Window::kMostCauses;
  if (!is_ours) return false;
  std::vector<ReadSegment> read(window.segment_count);
  std::vector<BlackBox::KeptSegment> segments;
  for (ReadSegment& segment : read) {
    if (!take_segment(bytes, box.state_size(), segment)) return false;
    if (!are_sound(segment.entries, segment.kept.ticks, axis_count_)) return false;
    segments.push_back(segment.kept);
  }
  kept_.insert(kept_.begin(), window);
  if (!box.adopt(window, segments)) {
    log_warning("{}: black_box.memory_mib is too small to load this window; the file is kept",
                path.string());
  }
  return true;
}

void WindowFiles::save(BlackBox& box) {
  const Window* const window = box.handed_over();
  if (window == nullptr) return;
  try {
    write(box, *window);
  } catch (const std::exception& error) {
    log_warning("window {} of the black box could not be saved: {}", window->number, error.what());
  }
  box.pop_handed_over();
}

void WindowFiles::write(const BlackBox& box, const Window& window) {
  std::vector<std::byte> content;
  put_raw(content, window);
  for (std::size_t place = 0; place < window.segment_count; ++place) {
    const BlackBox::Segment& segment = box.segment(window.segments[place]);
    put_raw(content, SegmentHead{.cause = static_cast<std::uint64_t>(segment.cause),
                                 .tick = segment.tick,
                                 .ticks = segment.ticks,
                                 .state = segment.state.size(),
                                 .entries = segment.entries});
    content.insert(content.end(), segment.state.begin(), segment.state.end());
    BlackBox::Entries entries(box, segment);
    while (const BoxEntry* const entry = entries.next()) put_raw(content, *entry);
  }
  std::vector<std::byte> head;
  put_raw(head, WindowHead{.axes = axes_, .check = check_of(content)});
  const std::filesystem::path name = file(window.number);
  // If a failure leaves this file, the next start removes it.
  const std::filesystem::path temporary_file = directory_ / (prefix_ + "new");
  {
    std::ofstream stream;
    stream.exceptions(std::ios::failbit | std::ios::badbit);
    stream.open(temporary_file, std::ios::binary | std::ios::trunc);
    for (const std::vector<std::byte>* part : {&head, &content}) {
      stream.write(reinterpret_cast<const char*>(part->data()),  // NOLINT(*-reinterpret-cast)
                   static_cast<std::streamsize>(part->size()));
    }
  }
  std::filesystem::rename(temporary_file, name);
  std::erase_if(kept_, [&](const Window& kept) {
    return kept.number == window.number;  // it was written while open, and is complete now
  });
  while (kept_.size() >= kMostWindows) {
    const std::size_t place = place_to_drop(kept_);
    std::error_code gone;
    std::filesystem::remove(file(kept_[place].number), gone);
    kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(place));
  }
  kept_.push_back(window);
}

}  // namespace vdrive::service
