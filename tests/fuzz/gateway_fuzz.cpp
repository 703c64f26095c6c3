// SPDX-License-Identifier: Apache-2.0
//
// Any bytes of a client are either a message of the protocol or refused with a sentence, and any
// request to open a WebSocket is accepted or refused.
#include "admission.hpp"
#include "directory.hpp"
#include "fuzz/support/bytes.hpp"
#include "protocol.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

namespace {

using namespace vdrive::gateway;
using vdrive::test::demand;

template <typename Parse>
void check_message(const Parse& parse, std::string_view bytes) {
  try {
    const ClientMessage message = parse(bytes);
    demand(!message.valueless_by_exception(), "a message has a meaning");
  } catch (const ProtocolError& error) {
    const std::string_view text = error.what();
    demand(!text.empty() && text.size() < 1000, "a refusal is a sentence");
    demand(text.find('\n') == std::string_view::npos, "on one line");
    // The answer to the client is JSON whatever the input.
    demand(!Json::parse(status_text(Level::error, text), nullptr, false).is_discarded(),
           "a status is JSON");
  }
}

void check_admission(std::string_view bytes) {
  const auto take = [&] {
    const auto part = bytes.substr(0, bytes.find('\n'));
    bytes.remove_prefix(std::min(bytes.size(), part.size() + 1));
    return part;
  };
  const UpgradeRequest request{.target = take(),
                               .host = take(),
                               .origin = take(),
                               .protocols = take(),
                               .authorization = take()};
  const Admission answer = admit(request, {.token = "0123456789abcdef"});
  if (answer.status != 101) {
    demand(!answer.reason.empty(), "a refusal has a reason");
    return;
  }
  demand(request.target.find("0123456789abcdef") != std::string_view::npos ||
             request.authorization.find("0123456789abcdef") != std::string_view::npos,
         "no client is admitted without the token");
  demand(request.protocols.find(answer.subprotocol) != std::string_view::npos,
         "the sub-protocol was offered");
}

void check_name(std::string_view bytes) {
  const auto object = vdrive::parse_object(bytes);
  if (object && vdrive::find_object(*object)) {
    demand(vdrive::parse_object(object_key(*object)) == object, "a text for each object");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(data, data + size);
  check_message(parse_text, bytes);
  check_message(parse_binary, bytes);
  check_admission(bytes);
  check_name(bytes);
  return 0;
}
