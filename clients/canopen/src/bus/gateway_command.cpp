// SPDX-License-Identifier: Apache-2.0
#include "bus/gateway_command.hpp"

#include "node/frame.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace vdrive::canopen {
namespace {

struct GatewayErrorRow {
  GatewayError error{};
  std::string_view words;
};

constexpr std::array kGatewayErrors{
    GatewayErrorRow{GatewayError::not_supported, "request not supported"},
    GatewayErrorRow{GatewayError::syntax, "syntax error"},
    GatewayErrorRow{GatewayError::internal_state, "request not processed due to internal state"},
    GatewayErrorRow{GatewayError::time_out, "time-out"},
    GatewayErrorRow{GatewayError::no_default_net, "no default net set"},
    GatewayErrorRow{GatewayError::no_default_node, "no default node set"},
    GatewayErrorRow{GatewayError::unsupported_net, "unsupported net"},
    GatewayErrorRow{GatewayError::unsupported_node, "unsupported node"},
    GatewayErrorRow{GatewayError::pdo_length_exceeded, "PDO length exceeded"},
};

/// The address that may precede the verb of a command.
enum class GatewayScope : std::uint8_t { nothing, net, node };

struct GatewayVerbRow {
  std::string_view word;    ///< in lower case
  std::string_view second;  ///< in lower case; empty = none
  GatewayVerb verb{};
  GatewayScope scope{};
};

constexpr std::array kGatewayVerbs{
    GatewayVerbRow{"r", "", GatewayVerb::read, GatewayScope::node},
    GatewayVerbRow{"read", "", GatewayVerb::read, GatewayScope::node},
    GatewayVerbRow{"w", "", GatewayVerb::write, GatewayScope::node},
    GatewayVerbRow{"write", "", GatewayVerb::write, GatewayScope::node},
    GatewayVerbRow{"start", "", GatewayVerb::start, GatewayScope::node},
    GatewayVerbRow{"stop", "", GatewayVerb::stop, GatewayScope::node},
    GatewayVerbRow{"preop", "", GatewayVerb::preoperational, GatewayScope::node},
    GatewayVerbRow{"preoperational", "", GatewayVerb::preoperational, GatewayScope::node},
    GatewayVerbRow{"reset", "node", GatewayVerb::reset_node, GatewayScope::node},
    GatewayVerbRow{"reset", "comm", GatewayVerb::reset_communication, GatewayScope::node},
    GatewayVerbRow{"reset", "communication", GatewayVerb::reset_communication, GatewayScope::node},
    GatewayVerbRow{"set", "network", GatewayVerb::set_network, GatewayScope::nothing},
    GatewayVerbRow{"set", "node", GatewayVerb::set_node, GatewayScope::net},
    GatewayVerbRow{"set", "sdo_timeout", GatewayVerb::set_sdo_timeout, GatewayScope::net},
    GatewayVerbRow{"boot_up_indication", "", GatewayVerb::boot_up_indication, GatewayScope::net},
    GatewayVerbRow{"info", "version", GatewayVerb::info_version, GatewayScope::net},
    GatewayVerbRow{"set", "rpdo", GatewayVerb::set_receive_pdo, GatewayScope::net},
    GatewayVerbRow{"set", "tpdo", GatewayVerb::set_transmit_pdo, GatewayScope::net},
    GatewayVerbRow{"r", "p", GatewayVerb::read_pdo, GatewayScope::net},
    GatewayVerbRow{"r", "pdo", GatewayVerb::read_pdo, GatewayScope::net},
    GatewayVerbRow{"read", "p", GatewayVerb::read_pdo, GatewayScope::net},
    GatewayVerbRow{"read", "pdo", GatewayVerb::read_pdo, GatewayScope::net},
    GatewayVerbRow{"w", "p", GatewayVerb::write_pdo, GatewayScope::net},
    GatewayVerbRow{"w", "pdo", GatewayVerb::write_pdo, GatewayScope::net},
    GatewayVerbRow{"write", "p", GatewayVerb::write_pdo, GatewayScope::net},
    GatewayVerbRow{"write", "pdo", GatewayVerb::write_pdo, GatewayScope::net},
    GatewayVerbRow{"_sync", "", GatewayVerb::sync, GatewayScope::net},
    GatewayVerbRow{"_disturb", "", GatewayVerb::disturb, GatewayScope::node},
};

/// Thrown only inside this file: parsing can fail in many places.
struct BadCommand {
  GatewayError error = GatewayError::syntax;
};

template <typename Value>
Value value_or_refuse(std::optional<Value> value) {
  if (!value) throw BadCommand{};
  return *std::move(value);
}

std::string lower_case_token(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

/// Splits a line into tokens.
class GatewayTokens final {
 public:
  explicit GatewayTokens(std::string_view line) : rest_(line) { skip_blanks(); }

  [[nodiscard]] bool empty() const noexcept { return rest_.empty(); }

  [[nodiscard]] bool has_digit() const noexcept {
    return !empty() && rest_.front() >= '0' && rest_.front() <= '9';
  }

  /// @throws BadCommand at the end of the line
  std::string_view take() {
    if (empty()) throw BadCommand{};
    const std::size_t length = std::min(rest_.find_first_of(" \t\r#"), rest_.size());
    return take_length(length);
  }

  std::string take_word() { return lower_case_token(take()); }

  /// @return the rest of the line, without a comment.
  std::string take_rest() {
    const std::string_view text = take_length(std::min(rest_.find('#'), rest_.size()));
    return std::string(text.substr(0, text.find_last_not_of(" \t\r") + 1));
  }

  std::uint64_t take_number(std::uint64_t highest) {
    const std::uint64_t number = value_or_refuse(parse_natural(take()));
    if (number > highest) throw BadCommand{};
    return number;
  }

  /// Takes a value, which may be in double quotes; inside them "" stands for one double quote.
  std::string take_value() {
    if (empty() || rest_.front() != '"') return std::string(take());
    std::string value;
    for (std::size_t i = 1; i < rest_.size(); ++i) {
      if (rest_[i] == '"') {
        const bool is_doubled = i + 1 < rest_.size() && rest_[i + 1] == '"';
        if (!is_doubled) {
          take_length(i + 1);
          return value;
        }
        ++i;
      }
      value += rest_[i];
    }
    throw BadCommand{};
  }

 private:
  std::string_view take_length(std::size_t length) {
    const std::string_view token = rest_.substr(0, length);
    rest_.remove_prefix(length);
    skip_blanks();
    return token;
  }

  void skip_blanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    if (rest_.starts_with('#')) rest_ = {};
  }

  std::string_view rest_;
};

std::uint32_t take_sequence(GatewayTokens& tokens) {
  const std::string_view token = tokens.take();
  if (token.size() < 2 || token.front() != '[' || token.back() != ']') throw BadCommand{};
  return value_or_refuse(parse_digits<std::uint32_t>(token.substr(1, token.size() - 2)));
}

/// The second word of a verb does not begin with a digit: "r pdo 1" reads a PDO, "r 0x6041 0" an
/// object.
const GatewayVerbRow& take_verb(GatewayTokens& tokens) {
  const std::string word = tokens.take_word();
  const bool has_second = std::ranges::any_of(kGatewayVerbs, [&](const GatewayVerbRow& row) {
    return row.word == word && !row.second.empty();
  });
  const std::string second = has_second && !tokens.has_digit() ? tokens.take_word() : "";
  const auto row = std::ranges::find_if(kGatewayVerbs, [&](const GatewayVerbRow& candidate) {
    return candidate.word == word && candidate.second == second;
  });
  if (row == kGatewayVerbs.end()) throw BadCommand{GatewayError::not_supported};
  return *row;
}

void assign_names(GatewayCommand& command, GatewayScope scope,
                  const std::vector<std::uint64_t>& numbers) {
  // A single number is the node, or the net if the command does not address a node.
  const std::size_t most = scope == GatewayScope::node ? 2 : scope == GatewayScope::net ? 1 : 0;
  if (numbers.size() > most) throw BadCommand{};
  if (scope == GatewayScope::node && !numbers.empty()) command.node = numbers.back();
  if (numbers.size() == 2 || (scope == GatewayScope::net && !numbers.empty())) {
    command.net = numbers.front();
  }
}

GatewayType take_type(GatewayTokens& tokens) {
  return value_or_refuse(find_gateway_type(tokens.take_word()));
}

ObjectAddress take_object(GatewayTokens& tokens) {
  const auto index = static_cast<std::uint16_t>(tokens.take_number(0xFFFF));
  return {.index = index, .subindex = static_cast<std::uint8_t>(tokens.take_number(0xFF))};
}

std::uint64_t take_positive(GatewayTokens& tokens, std::uint64_t highest) {
  const std::uint64_t number = tokens.take_number(highest);
  if (number == 0) throw BadCommand{};
  return number;
}

/// An RPDO takes its values when its frame arrives, whatever its type. A TPDO is sent when it is
/// written: waiting for SYNC or a remote frame ("rtr") is not supported.
void take_transmission(GatewayTokens& tokens, GatewayVerb verb) {
  constexpr std::string_view kSync = "sync";
  constexpr unsigned kHighestSync = 240;
  const std::string word = tokens.take_word();
  if (word == "event") return;
  if (word == "rtr") throw BadCommand{GatewayError::not_supported};
  const auto sync = word.starts_with(kSync)
                        ? parse_digits<unsigned>(std::string_view(word).substr(kSync.size()))
                        : std::nullopt;
  if (!sync || *sync > kHighestSync) throw BadCommand{};
  if (verb == GatewayVerb::set_transmit_pdo) throw BadCommand{GatewayError::not_supported};
}

void take_pdo_arguments(GatewayCommand& command, GatewayTokens& tokens) {
  constexpr std::uint64_t kMostMapped = 64;
  command.value = take_positive(tokens, kHighestPdo);
  if (command.verb == GatewayVerb::read_pdo) return;
  if (command.verb != GatewayVerb::write_pdo) {
    command.cob_id = take_positive(tokens, kHighestBaseId);
    take_transmission(tokens, command.verb);
  }
  for (std::uint64_t count = tokens.take_number(kMostMapped); count > 0; --count) {
    if (command.verb == GatewayVerb::write_pdo) {
      command.values.push_back(tokens.take_number(std::numeric_limits<std::uint64_t>::max()));
    } else {
      command.mapped.push_back(take_object(tokens));
    }
  }
}

void take_arguments(GatewayCommand& command, GatewayTokens& tokens) {
  constexpr std::uint64_t kHighest = std::numeric_limits<std::uint32_t>::max();
  switch (command.verb) {
    case GatewayVerb::read:
    case GatewayVerb::write:
      command.object = take_object(tokens);
      break;
    case GatewayVerb::set_receive_pdo:
    case GatewayVerb::set_transmit_pdo:
    case GatewayVerb::read_pdo:
    case GatewayVerb::write_pdo:
      take_pdo_arguments(command, tokens);
      break;
    case GatewayVerb::sync:
      command.value = tokens.empty() ? 1 : take_positive(tokens, kMostSyncs);
      break;
    case GatewayVerb::disturb:
      command.fault = lower_case_token(tokens.take_rest());
      break;
    case GatewayVerb::set_network:
    case GatewayVerb::set_node:
    case GatewayVerb::set_sdo_timeout:
      command.value = tokens.take_number(kHighest);
      break;
    case GatewayVerb::boot_up_indication: {
      const std::string word = tokens.take_word();
      if (word != "enable" && word != "disable") throw BadCommand{};
      command.value = word == "enable" ? 1 : 0;
      break;
    }
    default:
      break;
  }
  if (command.verb == GatewayVerb::read && !tokens.empty()) command.type = take_type(tokens);
  if (command.verb == GatewayVerb::write) {
    command.type = take_type(tokens);
    command.data = value_or_refuse(encode_value(*command.type, tokens.take_value()));
  }
}

void take_command(GatewayCommand& command, GatewayTokens& tokens) {
  std::vector<std::uint64_t> numbers;
  while (tokens.has_digit()) numbers.push_back(value_or_refuse(parse_natural(tokens.take())));
  const GatewayVerbRow& row = take_verb(tokens);
  command.verb = row.verb;
  assign_names(command, row.scope, numbers);
  take_arguments(command, tokens);
  if (!tokens.empty()) throw BadCommand{};
}

}  // namespace

std::string_view describe(GatewayError error) noexcept {
  const auto found = std::ranges::find(kGatewayErrors, error, &GatewayErrorRow::error);
  return found == kGatewayErrors.end() ? "unknown error" : found->words;
}

std::variant<std::monostate, GatewayCommand, GatewayRefusal> parse_gateway_command(
    std::string_view line) {
  GatewayTokens tokens(line);
  if (tokens.empty()) return std::monostate{};
  GatewayCommand command;
  try {
    command.sequence = take_sequence(tokens);
    take_command(command, tokens);
  } catch (const BadCommand& bad) {
    return GatewayRefusal{.sequence = command.sequence, .error = bad.error};
  }
  return command;
}

bool is_for_node(GatewayVerb verb) noexcept {
  const auto found = std::ranges::find(kGatewayVerbs, verb, &GatewayVerbRow::verb);
  return found != kGatewayVerbs.end() && found->scope == GatewayScope::node;
}

}  // namespace vdrive::canopen
