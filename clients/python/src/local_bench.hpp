// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "errors.hpp"
#include "fork.hpp"
#include "python.hpp"
#include "vdrive/bench/bench.hpp"

#include <cstdint>
#include <memory>
#include <optional>

namespace vdrive::python {

/// A bench that ends with this object. A forked process leaves it as it is: it is its parent's.
class LocalBench {
 public:
  /// @throws bench::BenchError
  explicit LocalBench(const bench::BenchOptions& options) : bench_(options) {}

  /// @return where sessions meet it.
  /// @throws py::error_already_set when it has ended, and in a forked process
  [[nodiscard]] std::shared_ptr<wire::LocalBus> bus() const;

  [[nodiscard]] std::uint32_t number() const {
    origin_.require_own("the bench");
    return bench_ ? bench_->number() : 0;
  }

  /// Any number of times. Does nothing in a forked process.
  void close();

 private:
  const Origin origin_;
  std::optional<bench::Bench> bench_;
};

}  // namespace vdrive::python
