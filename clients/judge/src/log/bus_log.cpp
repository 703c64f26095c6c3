// SPDX-License-Identifier: Apache-2.0
#include "log/bus_log.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace vdrive::judge {
namespace {

/// A longer line is not a frame: a line of an .asc file with its comments has some 200 characters.
constexpr std::size_t kLongestLine = 1024;

/// Time step for a log without times: it gives an order, but no durations.
constexpr Time kNoTime{1};

/// Later than any time in a log, yet small enough to be added to one.
constexpr Time kEndOfTime{std::chrono::seconds(5'000'000'000)};

/// Largest step back caused by a clock correction, or by frames from two buffers.
constexpr Time kShortStep{std::chrono::seconds(1)};

/// Reads the lines of a stream in bounded memory.
class Lines {
 public:
  explicit Lines(std::istream& stream) : stream_(stream) {}

  /// @param is_whole false: the line exceeds kLongestLine, and its rest is skipped
  bool next(std::string_view& line, bool& is_whole) {
    stream_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    const auto count = static_cast<std::size_t>(stream_.gcount());
    if (stream_.eof() && count == 0) return false;
    is_whole = true;
    std::size_t length = count;
    if (stream_.fail() && !stream_.eof()) {
      if (count == 0) return false;
      is_whole = false;
      stream_.clear();
      stream_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    } else if (!stream_.eof()) {
      --length;  // without the line end
    }
    line = {buffer_.data(), length};
    return true;
  }

 private:
  std::istream& stream_;
  std::array<char, kLongestLine> buffer_{};
};

/// Judges the frames of one log.
class LogJudge {
 public:
  LogJudge(const DecoderSettings& settings, const FrameWatcher& watcher)
      : watcher_(watcher), decoder_(settings, [this](const Record& record) {
          judge_->take(record);
        }) {}

  void take_line(std::string_view line, bool is_whole) {
    ++result_.lines.lines;
    LoggedFrame frame;
    switch (is_whole ? reader_.read(line, frame) : LineKind::broken) {
      case LineKind::nothing:
        return;
      case LineKind::foreign:
        ++result_.lines.foreign;
        return;
      case LineKind::broken:
        if (result_.lines.broken++ == 0) result_.lines.first_broken = result_.lines.lines;
        return;
      case LineKind::frame:
        return take_frame(frame);
    }
  }

  LogVerdict end() {
    decoder_.end(last_);
    if (judge_) result_.verdict = judge_->end();
    result_.frames = decoder_.counts();
    add_notes();
    return std::move(result_);
  }

 private:
  void take_frame(const LoggedFrame& frame) {
    if (!judge_) {
      interface_ = frame.interface;
      has_time_ = frame.time.has_value();
      // Sessions exist only on a bench; the unit of speeds depends on the manufacturer.
      judge_.emplace(SourceFacts{.has_time = has_time_, .shows_reads = true});
    }
    if (frame.interface != interface_) {
      ++result_.lines.other_interfaces;
      return;
    }
    advance_time(frame.time ? *frame.time + offset_ : last_ + kNoTime);
    const DecodedFrame decoded = decoder_.take(last_, frame.frame, result_.lines.lines);
    if (watcher_) watcher_(result_.lines.lines, decoded);
  }

  /// If the clock was set back, or another log follows, time continues from where it was. After a
  /// long step it is unknown what happened in between.
  void advance_time(Time time) {
    const Time now = std::min(time, kEndOfTime);
    if (now < last_) {
      ++result_.lines.backwards;
      offset_ += last_ - now;
      if (last_ - now > kShortStep) decoder_.lose(last_);
    }
    last_ = std::max(last_, now);
  }

  void note(std::uint64_t count, std::string_view one, std::string_view many,
            std::string_view what) {
    if (count == 0) return;
    result_.notes.push_back(counted(count, one, many).append(" ").append(what));
  }

  void add_notes() {
    const LogCounts& lines = result_.lines;
    result_.notes = decoder_.notes();
    if (judge_ && !has_time_) {
      result_.notes.emplace_back(
          "no time stamps: rules about durations were not judged; record with candump -L");
    }
    note(lines.broken, "line", "lines",
         "could not be read; the first is line " + std::to_string(lines.first_broken));
    note(lines.foreign, "line", "lines", "skipped: CAN FD, error frames, messages of the logger");
    note(lines.backwards, "time stamp", "time stamps",
         "earlier than the one before: the time was assumed to continue from there");
    note(
        lines.other_interfaces, "frame", "frames",
        "skipped, from interfaces other than " + in_quotes(interface_) + ": give a log of one bus");
    note(result_.frames.foreign, "frame", "frames",
         "skipped, with an identifier that CANopen does not use");
    note(result_.frames.other_nodes, "frame", "frames", "skipped, of other nodes");
    note(result_.frames.malformed, "frame", "frames",
         "skipped, with a length or content that CANopen does not allow");
  }

  const FrameWatcher& watcher_;
  LogLines reader_;
  std::optional<Judge> judge_;
  BusDecoder decoder_;
  std::string interface_;
  bool has_time_ = false;
  Time last_{};
  Time offset_{};  ///< total of the steps backwards in the times of the log
  LogVerdict result_;
};

}  // namespace

LogVerdict judge_bus_log(std::istream& log, const DecoderSettings& settings,
                         const FrameWatcher& watcher) {
  LogJudge judge(settings, watcher);
  Lines lines(log);
  std::string_view line;
  bool is_whole = true;
  while (lines.next(line, is_whole)) judge.take_line(line, is_whole);
  return judge.end();
}

}  // namespace vdrive::judge
