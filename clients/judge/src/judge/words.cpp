// SPDX-License-Identifier: Apache-2.0
#include "judge/words.hpp"

#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <array>
#include <cstdlib>

namespace vdrive::judge {
namespace {

constexpr std::size_t kWordDigits = 4;
constexpr unsigned kWordBits = 16;

void add_word(std::string& text, std::string_view word) {
  text.append(text.empty() ? "" : ", ").append(word);
}

std::string_view command_text(PowerCommand command) {
  switch (command) {
    case PowerCommand::none:
      return "no command";
    case PowerCommand::disable_voltage:
      return "disable voltage";
    case PowerCommand::quick_stop:
      return "quick stop";
    case PowerCommand::shutdown:
      return "shutdown";
    case PowerCommand::switch_on:
      return "switch on";
    case PowerCommand::enable_operation:
      return "enable operation";
    case PowerCommand::fault_reset:
      return "fault reset";
  }
  return {};
}

/// @return the number cut off after three digits, but not before its decimal point.
std::string shortened(double value) {
  const std::size_t digits = value < 10 ? 2 : (value < 100 ? 1 : 0);
  std::string text = std::to_string(value);
  const std::size_t point = text.find('.');
  if (point == std::string::npos) return text;
  text.resize(digits == 0 ? point : point + 1 + digits);
  while (digits != 0 && text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string_view fate_text(Fate fate) {
  switch (fate) {
    case Fate::accepted:
      return {};
    case Fate::refused:
      return "refused";
    case Fate::ignored:
      return "ignored";
    case Fate::late:
      return "too late";
    case Fate::unanswered:
      return "not answered";
  }
  return {};
}

}  // namespace

std::string hex_text(std::uint16_t word) {
  return hex(word, kWordDigits);
}

std::string duration_text(Time time) {
  constexpr double kNanosecondsOfAMillisecond = 1.0e6;
  const auto milliseconds = static_cast<double>(time.count()) / kNanosecondsOfAMillisecond;
  if (milliseconds < 0) return "-" + duration_text(-time);
  if (milliseconds < 1) return shortened(1000 * milliseconds) + " us";
  return milliseconds < 1000 ? shortened(milliseconds) + " ms"
                             : shortened(milliseconds / 1000) + " s";
}

std::string place_text(const Place& place) {
  constexpr std::int64_t kMicroseconds = 1'000'000;
  constexpr std::size_t kDigits = 6;
  if (place.tick != 0) return "tick " + std::to_string(place.tick);
  const std::int64_t all = place.time.count() / 1000;
  const std::string fraction = std::to_string(std::abs(all % kMicroseconds));
  return std::string(all < 0 && all > -kMicroseconds ? "-" : "") +
         std::to_string(all / kMicroseconds) + "." + std::string(kDigits - fraction.size(), '0') +
         fraction + " s";
}

std::string mode_text(std::int8_t mode) {
  const std::string_view name = to_string(static_cast<OperatingMode>(mode));
  return "mode " + std::to_string(mode) + " (" + std::string(name) + ")";
}

std::string state_and_mode_text(const AxisTrack& track) {
  std::string text(track.has_status ? to_string(track.state) : "an unknown state");
  if (const auto mode = track.mode_in_force()) text += ", " + mode_text(*mode);
  return text;
}

std::string controlword_text(std::uint16_t word, std::int8_t mode) {
  const bool is_reset = (word & Controlword::kFaultReset) != 0;
  std::string text(is_reset ? "bit 7 (fault reset)" : command_text(decode_command(word, 0)));
  for (unsigned bit = 4; bit < kWordBits; ++bit) {
    const auto mask = static_cast<std::uint16_t>(1U << bit);
    if ((word & mask) == 0 || mask == Controlword::kFaultReset) continue;
    const std::string_view name = controlword_bit_name(mask, static_cast<OperatingMode>(mode));
    add_word(text, name.empty() ? "bit " + std::to_string(bit) : std::string(name));
  }
  return text;
}

std::string statusword_text(std::uint16_t word, std::int8_t mode) {
  // These are almost always 1, or part of the state.
  constexpr std::uint16_t kUsual =
      Statusword::kState | Statusword::kVoltageEnabled | Statusword::kRemote;
  const PowerState state = decode_power_state(word);
  const auto read_as = state == PowerState::operation_enabled ? static_cast<OperatingMode>(mode)
                                                              : OperatingMode::none;
  std::string text(to_string(state));
  for (unsigned bit = 0; bit < kWordBits; ++bit) {
    const auto mask = static_cast<std::uint16_t>(1U << bit);
    if ((word & mask) == 0 || (kUsual & mask) != 0) continue;
    const std::string_view name = statusword_bit_name(mask, read_as);
    add_word(text, name.empty() ? "bit " + std::to_string(bit) : std::string(name));
  }
  return text;
}

std::string object_name(ObjectAddress object) {
  std::string text = index_text(object.index);
  if (object.subindex != 0) text += ":" + std::to_string(object.subindex);
  return text;
}

std::string_view waiting_text(Waiting waiting) noexcept {
  switch (waiting) {
    case Waiting::nothing:
      return {};
    case Waiting::switch_on_disabled:
      return "Switch on disabled";
    case Waiting::ready_to_switch_on:
      return "Ready to switch on";
    case Waiting::switched_on:
      return "Switched on";
    case Waiting::operation_enabled:
      return "Operation enabled";
    case Waiting::quick_stop:
      return "Quick stop active";
    case Waiting::mode:
      return "6061h";
    case Waiting::acknowledge:
      return "bit 12 = 1";
    case Waiting::acknowledge_gone:
      return "bit 12 = 0";
    case Waiting::arrival:
      return "bit 10 = 1";
    case Waiting::homing:
      return "bit 12 or 13 = 1";
  }
  return {};
}

std::string event_text(const Line& line) {
  if (!line.write) {
    std::string text(line.event);
    if (line.event_code != 0) {
      text += " " + hex_text(line.event_code) + " " +
              std::string(describe(static_cast<ErrorCode>(line.event_code)));
    }
    return text;
  }
  const Write& write = *line.write;
  std::string text = object_name(write.object);
  const bool is_word = write.object == objects::kControlword;
  text += " = " + (is_word ? hex_text(static_cast<std::uint16_t>(write.value))
                           : std::to_string(write.value));
  // A PDO never has an answer.
  const bool is_open = write.channel == Channel::pdo && write.fate == Fate::unanswered;
  const std::string_view fate = is_open ? std::string_view() : fate_text(write.fate);
  if (!fate.empty()) text.append(" (").append(fate);
  if (write.code != 0) {
    text +=
        ": " + hex(write.code, 8) + " " + std::string(describe(static_cast<AbortCode>(write.code)));
  }
  if (!fate.empty()) text += ")";
  return text;
}

std::string writer_text(const Line& line) {
  if (!line.write) return line.event.starts_with("NMT") ? "master" : "drive";
  switch (line.write->channel) {
    case Channel::sdo:
      return "SDO";
    case Channel::pdo:
      return "RPDO " + std::to_string(line.write->writer);
    case Channel::request:
    case Channel::frame:
      break;
  }
  const std::string_view how = line.write->channel == Channel::frame ? "frame" : "request";
  if (line.write->writer == 0) return std::string(how);
  return std::string(how) + " " + session_text(line.write->writer);
}

}  // namespace vdrive::judge
