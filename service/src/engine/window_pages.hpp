// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "journal/black_box.hpp"
#include "journal/window_replay.hpp"
#include "seam/queues.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::service {

/// Computes pages of black box windows, in the thread that sends replies, so that no tick has to
/// wait. A page that follows the last one continues where that one ended.
class WindowPages {
 public:
  /// Both arguments outlive this object.
  WindowPages(const Configuration& configuration, BlackBox& box);

  /// Computes the page of an answer and adds it.
  void complete(OutgoingReply& outgoing);

 private:
  [[nodiscard]] bool continues(const WindowPage& page) const;
  void go_to(const WindowPage& page);
  [[nodiscard]] bool add_item(OutgoingReply& outgoing);
  [[nodiscard]] bool add_value(msg::Reply& reply);
  [[nodiscard]] bool add_entry(msg::Reply& reply);
  [[nodiscard]] bool add_statuses(OutgoingReply& outgoing) const;
  void add_context(msg::Reply& reply);
  void advance();

  const Configuration& configuration_;
  BlackBox& box_;
  std::optional<WindowReplay> replay_;  ///< created for the first page
  WindowPage page_;                     ///< the last one
  std::uint64_t place_ = 0;             ///< items before the present one
  WindowReplay::Item item_{};
  std::size_t value_ = 0;         ///< of Item::state: how many values were shown
  bool has_context_ = false;      ///< the page has marks that still apply
  std::uint64_t shown_tick_ = 0;  ///< of these marks
  std::optional<JournalAuthor> shown_author_;
};

}  // namespace vdrive::service
