// SPDX-License-Identifier: Apache-2.0
// A participant in a separate process, which tests may kill, stop and attack. It answers requests
// until SIGTERM and then prints the counts of its guard.
//
//   wire_visitor DOMAIN NAME [unguarded] [client] [request] [shared_memory] [security=DIR]
//
// It prints "ready" and its prefix in hexadecimal. With `request` it sends requests instead, one
// after the other, and prints "answered" after the first reply.
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive/wire/topics.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <iostream>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;

/// Passes messages from the library's thread to the main thread, because a listener must not write.
template <typename Message>
class Arrived {
 public:
  typename Subscription<Message>::Handler handler() {
    return [this](const Message& message, const Source& /*source*/) {
      const std::scoped_lock lock(mutex_);
      messages_.push_back(message);
      changed_.notify_all();
    };
  }

  bool take(Message& message, std::chrono::milliseconds within) {
    std::unique_lock lock(mutex_);
    const bool there = changed_.wait_for(lock, within, [&] {
      return !messages_.empty();
    });
    if (there) {
      message = messages_.front();
      messages_.pop_front();
    }
    return there;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Message> messages_;
};

// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables): a handler reaches nothing
// else
volatile std::sig_atomic_t ends = 0;

bool is_wanted() {
  return ends == 0;
}

void answer(Participant& participant) {
  Arrived<msg::Request> arrived;
  Publication<msg::Reply> replies(participant);
  const Subscription<msg::Request> requests(participant, arrived.handler());
  for (msg::Request request; is_wanted();) {
    if (arrived.take(request, 20ms)) {
      msg::Reply reply;
      reply.request_id = request.request_id;
      reply.client = request.client;
      static_cast<void>(replies.write(reply));
    }
  }
}

void send_requests(Participant& participant) {
  Arrived<msg::Reply> arrived;
  Publication<msg::Request> requests(participant);
  const Subscription<msg::Reply> replies(participant, arrived.handler());
  msg::Reply reply;
  for (std::uint64_t number = 1; is_wanted(); ++number) {
    msg::Request request;
    request.request_id = number;
    static_cast<void>(requests.write(request));
    if (arrived.take(reply, 20ms) && reply.request_id != 0) {
      std::cout << "answered " << reply.request_id << std::endl;
    }
  }
}

void print_prefix(const Participant& participant) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "ready ";
  for (const std::uint8_t byte : participant.source().participant) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  std::cout << text << std::endl;
}

int run(const std::vector<std::string>& words) {
  std::signal(SIGTERM, [](int) {
    ends = 1;
  });
  const auto has = [&words](const char* word) {
    return std::find(words.begin() + 2, words.end(), word) != words.end();
  };
  std::string security;
  for (const auto& word : words) {
    constexpr std::string_view kKey = "security=";
    if (word.starts_with(kKey)) security = word.substr(kKey.size());
  }
  const auto participant =
      make_participant({.domain = static_cast<std::uint32_t>(std::stoul(words.at(0))),
                        .shared_memory = has("shared_memory"),
                        .security = security,
                        .role = has("client") ? Role::client : Role::other,
                        .guard = !has("unguarded")},
                       words.at(1));
  print_prefix(*participant);
  has("request") ? send_requests(*participant) : answer(*participant);
  const GuardCounts counts = participant->guard_counts();
  std::cout << "refused " << counts.all_refused() << " ignored " << counts.ignored << " judged "
            << counts.judged << " kept " << counts.kept << " handed over " << counts.handed_over
            << std::endl;
  for (std::size_t reason = 1; reason < kRefusals; ++reason) {
    if (counts.refused.at(reason) > 0) {
      std::cout << counts.refused.at(reason) << " times " << describe(static_cast<Refusal>(reason))
                << std::endl;
    }
  }
  return 0;
}

}  // namespace
}  // namespace vdrive::wire

int main(int argc, char** argv) {
  const std::span all(argv, static_cast<std::size_t>(argc));
  return vdrive::wire::run({all.begin() + 1, all.end()});
}
