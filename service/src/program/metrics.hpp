// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "configuration/configuration.hpp"

#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::service {

/// The counters of a bench as Prometheus metrics, each labelled with the bench.
class Metrics : public prometheus::Collectable {
 public:
  /// @param counters outlive this
  Metrics(const Configuration& configuration, const BenchIdentity& identity,
          const Counters& counters);

  /// May be called from any thread.
  [[nodiscard]] std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  std::string bench_;
  std::string name_;
  std::string clock_;
  std::uint64_t incarnation_;
  std::size_t axes_;
  const Counters& counters_;
};

}  // namespace vdrive::service
