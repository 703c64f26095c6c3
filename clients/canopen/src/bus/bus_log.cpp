// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_log.hpp"

#include "bus/asio.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdrive::canopen {
namespace {

// When the buffer is larger, it is written before the end of the turn.
constexpr std::size_t kMostLogBuffer = 1U << 16U;  // [bytes]

void append_hex(std::string& out, std::uint32_t number, std::size_t digits) {
  out += std::string_view(hex(number, digits)).substr(2);
}

void append_padded(std::string& out, std::int64_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  out.append(digits - std::min(digits, text.size()), '0').append(text);
}

std::string reason_of(int error) {
  return std::generic_category().message(error);
}

}  // namespace

void append_log_line(std::string& out, const std::string& interface, const Frame& frame,
                     std::chrono::microseconds time) {
  constexpr std::int64_t kMicroseconds = 1'000'000;
  constexpr std::size_t kSecondDigits = 10;
  constexpr std::size_t kMicrosecondDigits = 6;
  constexpr std::size_t kBaseDigits = 3;
  constexpr std::size_t kExtendedDigits = 8;
  out += '(';
  append_padded(out, time.count() / kMicroseconds, kSecondDigits);
  out += '.';
  append_padded(out, time.count() % kMicroseconds, kMicrosecondDigits);
  out.append(") ").append(interface).append(" ");
  append_hex(out, frame.id, frame.is_extended ? kExtendedDigits : kBaseDigits);
  out += '#';
  if (frame.is_remote) {
    out += 'R';
    if (frame.size > 0) out += std::to_string(frame.size);
  }
  for (const std::uint8_t byte : frame.bytes()) append_hex(out, byte, 2);
  out += '\n';
}

struct BusLog::State final : Port, std::enable_shared_from_this<BusLog::State> {
  State(asio::io_context& its_context, Bus& its_bus, BusHost& its_host,
        BusLogSettings&& its_settings)
      : context(its_context), bus(its_bus), host(its_host), settings(std::move(its_settings)) {
    errno = 0;
    stream.open(settings.file, std::ios::binary | std::ios::trunc);
    if (!stream) {
      throw std::runtime_error("log " + in_quotes(settings.file.string()) +
                               " cannot be opened: " + reason_of(errno));
    }
  }

  void deliver(const Frame& frame) override {
    if (has_failed) {
      ++missed;
      return;
    }
    append_log_line(lines, settings.interface, frame, host.frame_time());
    ++waiting;
    if (lines.size() >= kMostLogBuffer) write();
    if (std::exchange(is_posted, true)) return;
    asio::post(context, [self = shared_from_this()] {
      self->is_posted = false;
      self->write();
    });
  }

  void write() {
    if (lines.empty()) return;
    if (bytes + lines.size() > settings.most_bytes) {
      fail("has reached its limit of " + std::to_string(settings.most_bytes) + " bytes");
    } else {
      errno = 0;
      stream.write(lines.data(), static_cast<std::streamsize>(lines.size()));
      if (!stream.flush()) fail("cannot be written: " + reason_of(errno));
    }
    bytes += lines.size();
    waiting = 0;
    lines.clear();
  }

  void fail(const std::string& reason) {
    has_failed = true;
    missed += waiting;
    host.report(bridge::Severity::error, "",
                "log " + in_quotes(settings.file.string()) + " " + reason +
                    ": no further frames are logged; give another file and restart");
  }

  asio::io_context& context;
  Bus& bus;       ///< not used after the log is destroyed
  BusHost& host;  ///< not used after the log is destroyed
  const BusLogSettings settings;
  std::ofstream stream;
  std::string lines;
  std::uint64_t waiting = 0;  ///< frames in `lines`
  std::uint64_t bytes = 0;    ///< of the file
  std::uint64_t missed = 0;
  bool is_posted = false;
  bool has_failed = false;
};

BusLog::BusLog(asio::io_context& context, Bus& bus, BusHost& host, BusLogSettings settings)
    : state_(std::make_shared<State>(context, bus, host, std::move(settings))) {
  bus.attach(*state_);
}

BusLog::~BusLog() {
  state_->bus.detach(*state_);
  state_->write();
}

std::uint64_t BusLog::flush() {
  state_->write();
  return state_->missed;
}

}  // namespace vdrive::canopen
