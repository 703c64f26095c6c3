// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "errors.hpp"
#include "fork.hpp"
#include "interpreter_lock.hpp"
#include "kept_in_thread.hpp"
#include "private_bench.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {

/// A service that ends with this object.
class OwnBench {
 public:
  OwnBench(const std::string& service, const std::vector<std::string>& arguments,
           std::optional<std::uint32_t> domain)
      : bench_([service, arguments, domain] {
          return std::make_unique<process::PrivateBench>(service, arguments, domain);
        }) {
    wait_until_ready();
  }

  [[nodiscard]] std::uint32_t domain() const { return get().domain(); }

  /// Waits until the service has ended. Any number of times. Does nothing in a forked process: the
  /// bench is its parent's.
  void close() {
    if (origin_.is_inherited()) return;
    const Unlocked unlocked;
    bench_.end();
  }

 private:
  [[nodiscard]] process::PrivateBench& get() const {
    origin_.require_own("the bench");
    if (bench_.get() == nullptr) raise(client::Outcome::failed("the bench has ended"));
    return *bench_.get();
  }

  void wait_until_ready();

  const Origin origin_;
  KeptInThread<process::PrivateBench> bench_;
};

}  // namespace vdrive::python
