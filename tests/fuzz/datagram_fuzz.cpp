// SPDX-License-Identifier: Apache-2.0
// Any bytes as a datagram: the guard's check, and its parsing and modification of accepted
// datagrams.
#include "guard/announcement.hpp"
#include "guard/datagram_check.hpp"

#include <cstdlib>
#include <vector>

namespace {

using namespace vdrive::wire;

void demand(bool holds) {
  if (!holds) std::abort();
}

/// Does the same as Guard::pass_discovery.
void change(std::vector<std::uint8_t>& datagram) {
  Submessages submessages(datagram);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    if (submessage.kind != SubmessageKind::data) continue;
    const DataSubmessage data = parse_data(submessage, 16);
    demand(data.whole);
    if (may_announce(submessage, data)) {
      static_cast<void>(read_announcement(submessage, data));
    }
    if (submessage.has(kThird) && data.is_list() && is_discovery(submessage, data)) {
      const auto list = list_in(datagram, submessage, data);
      raise_leases(list, data.list_is_little());
      hide_types(list, data.list_is_little());
    }
  }
}

/// @return whether the datagram passes in this mode; if so, it is modified as the guard does it.
bool passes(std::span<const std::uint8_t> bytes, Mode mode) {
  const DatagramReport report = check_datagram(bytes, mode);
  if (report.refusal != Refusal::none) return false;
  demand(report.length <= bytes.size());
  std::vector<std::uint8_t> datagram(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(report.length));
  if (report.announces) {
    change(datagram);
    demand(check_datagram(datagram, mode).refusal == Refusal::none);
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bool in_open = passes({data, size}, Mode::open);
  const bool in_closed = passes({data, size}, Mode::closed);
  demand(in_open || !in_closed);  // the closed mode only refuses more
  return 0;
}
