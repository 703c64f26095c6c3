// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "seam/queues.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <memory>
#include <utility>

namespace vdrive::service {

/// Requests about the windows of the black box.
class Windows {
 public:
  Windows(BenchAxes& axes, const BenchClock& clock) : axes_(axes), clock_(clock) {}

  /// Freezes a window around the present tick.
  [[nodiscard]] Reason freeze(const msg::Request& request, msg::Reply& reply);

  /// Returns the window after number `request.snapshot`, and its causes.
  [[nodiscard]] Reason show_next(const msg::Request& request, msg::Reply& reply) const;

  /// Orders a page of a window. If time stands still, an open window ends now.
  [[nodiscard]] Reason read(const msg::Request& request, msg::Reply& reply);

  /// @return the page that the last request has ordered; nullptr if none.
  [[nodiscard]] std::unique_ptr<WindowPage> take_page() noexcept { return std::move(page_); }

 private:
  /// @return the window with this number, or nullptr.
  [[nodiscard]] const Window* find(std::uint64_t number) const noexcept;

  BenchAxes& axes_;
  const BenchClock& clock_;
  std::unique_ptr<WindowPage> page_;
};

}  // namespace vdrive::service
