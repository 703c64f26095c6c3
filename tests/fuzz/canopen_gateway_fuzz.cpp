// SPDX-License-Identifier: Apache-2.0
//
// Any lines for the ASCII gateway (CiA 309-3), up to the first zero byte, and any answers of the
// nodes: each command has one answer, on one line, and no transfer is left over.
#include "bus/ascii_gateway.hpp"
#include "bus/bus_faults.hpp"
#include "fuzz/support/bytes.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace {

using namespace vdrive::canopen;
using vdrive::test::Bytes;
using vdrive::test::demand;

void check_line(std::string_view line) {
  demand(!line.empty(), "a line has words");
  demand(std::ranges::none_of(line,
                              [](char c) {
                                return c == '\r' || c == '\n' || c == '\0';
                              }),
         "and is one line");
}

/// A gateway with one session, and nodes that answer with the fuzzer's bytes.
class FuzzedGateway final : private GatewayHost {
 public:
  explicit FuzzedGateway(Bytes& bytes) : bytes_(bytes), gateway_({}, *this) {
    session_ = gateway_.open();
  }

  void take(std::string_view line) {
    const auto parsed = parse_gateway_command(line);
    if (!std::holds_alternative<std::monostate>(parsed)) ++commands_;
    gateway_.take_line(session_, line, now_);
    while (gateway_.has_syncs()) gateway_.send_sync(now_);
    while (gateway_.next_due() && !bytes_.empty()) answer_as_node();
    // From here on no bytes are left, and the nodes are silent.
    while (const auto due = gateway_.next_due()) {
      now_ = *due;
      gateway_.advance(now_);
    }
    demand(gateway_.waiting(session_) == 0, "no line waits for ever");
    demand(answers_ == commands_, "each command has one answer");
  }

 private:
  void send(const Frame& frame) override {
    demand(frame.size <= kMostData && !frame.is_extended && !frame.is_remote,
           "a master sends data frames in the base format");
    request_ = frame;
  }

  void answer(GatewaySession /*session*/, std::string_view line) override {
    check_line(line);
    demand(line.front() == '[', "an answer has its sequence");
    ++answers_;
  }

  void report(GatewaySession /*session*/, std::string_view line) override { check_line(line); }

  std::optional<std::string> disturb(std::uint8_t /*node*/, std::string_view fault) override {
    const auto parsed = parse_bus_fault(fault, {});
    const auto* const refusal = std::get_if<std::string>(&parsed);
    return refusal == nullptr ? std::nullopt : std::optional(*refusal);
  }

  /// Mostly for the last request, and sometimes anything.
  void answer_as_node() {
    Frame frame = request_;
    frame.id =
        bytes_.below(16) == 0 ? bytes_.take<std::uint16_t>() & kHighestBaseId : request_.id - 0x80U;
    frame.data[0] = bytes_.take();
    const auto given = bytes_.take_span(bytes_.below(8));
    std::ranges::copy(given, frame.data.end() - static_cast<std::ptrdiff_t>(given.size()));
    gateway_.receive(frame, now_);
  }

  Bytes& bytes_;
  Frame request_{};
  BusTime now_{};
  std::uint64_t commands_ = 0;
  std::uint64_t answers_ = 0;
  GatewaySession session_ = 0;
  AsciiGateway gateway_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::uint8_t* const end = std::find(data, data + size, std::uint8_t{0});
  const std::string text(data, end);
  Bytes bytes({end, data + size});
  FuzzedGateway gateway(bytes);
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    gateway.take(line);
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
  }
  return 0;
}
