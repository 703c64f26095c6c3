// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace vdrive::test {

/// Cyclone DDS on the loopback interface, with the same lease as our own participants.
inline constexpr const char* kCycloneOnLoopback =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/>"
    "</Interfaces></General><Discovery><LeaseDuration>2s</LeaseDuration></Discovery>"
    "</Domain></CycloneDDS>";

/// A vendor_peer running on the domain of this test; the destructor ends it.
class Peer {
 public:
  /// @param topic full name
  /// @param side "reader" or "writer"
  Peer(std::string_view topic, const char* side);
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// Waits until its endpoint is matched.
  [[nodiscard]] bool match();

  /// Lets it write a sample (canonical.h). @return the text of the sample, empty if that failed
  std::string write(int filling, std::uint64_t instance, std::uint64_t count);

  /// Waits for a sample. @return the text of the sample, empty if none arrived
  std::string take(std::chrono::milliseconds patience);

 private:
  void command(const std::string& line);
  std::string read_text();
  std::string read_line();

  pid_t child_ = 0;
  std::FILE* to_ = nullptr;
  std::FILE* from_ = nullptr;
};

}  // namespace vdrive::test
