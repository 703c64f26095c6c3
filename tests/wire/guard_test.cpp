// SPDX-License-Identifier: Apache-2.0
// Guarded participants and datagrams that end, block or fill up an unguarded one.
#include "attacker.hpp"
#include "support/deadline.hpp"
#include "support/effort.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/wire/end_announcement.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive/wire/topics.hpp"
#include "wire/datagrams.hpp"
#include "wire/raw_writer.hpp"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using test::Attacker;
using test::Body;
using test::Datagram;
using test::DatagramWriter;
using test::gap_without_end;
using test::GuidPrefix;
using test::statistics_with_more_behind;
using Clock = std::chrono::steady_clock;

constexpr auto kDeadline = 40s;

/// Repeats a check until it is true.
bool wait_until(const std::function<bool()>& is_so, std::chrono::milliseconds within = kDeadline,
                std::chrono::microseconds period = 5ms) {
  const auto deadline = Clock::now() + within;
  while (!is_so()) {
    if (Clock::now() > deadline) {
      // A shorter wait may be expected to time out.
      if (within == kDeadline) test::report_missed_deadline("the condition did not hold", within);
      return false;
    }
    std::this_thread::sleep_for(period);
  }
  return true;
}

/// A participant in a separate process.
class Visitor {
 public:
  explicit Visitor(const std::string& name, std::vector<std::string> words = {})
      : process_(std::make_unique<test::Process>(VDRIVE_VISITOR, arguments(name, words))) {
    const std::string line = process_->read_line();
    for (std::size_t byte = 0; byte < prefix_.size() && line.starts_with("ready "); ++byte) {
      const char* const digits = line.data() + 6 + 2 * byte;
      std::from_chars(digits, digits + 2, prefix_.at(byte), 16);
    }
  }

  [[nodiscard]] const GuidPrefix& prefix() const { return prefix_; }

  [[nodiscard]] test::Process& process() { return *process_; }

  void send(int signal) const { process_->send(signal); }

  [[nodiscard]] test::Finished stop() {
    send(SIGTERM);
    return process_->wait();
  }

 private:
  static std::vector<std::string> arguments(const std::string& name,
                                            std::vector<std::string> words) {
    words.insert(words.begin(), {std::to_string(test::test_domain()), name});
    return words;
  }

  std::unique_ptr<test::Process> process_;
  GuidPrefix prefix_{};
};

/// A participant of this process that sends requests.
class Requester {
 public:
  explicit Requester(const NetworkSettings& settings = {.domain = test::test_domain()})
      : participant(make_participant(settings, "requester")),
        requests(*participant),
        replies(*participant, [this](const msg::Reply& reply, const Source&) {
          last_ = reply.request_id;
        }) {}

  /// @return whether a new request is answered.
  bool is_answered(std::chrono::milliseconds within = kDeadline) {
    ++number_;
    auto sent = Clock::time_point{};
    return wait_until(
        [&] {
          if (Clock::now() - sent > 100ms) {
            sent = Clock::now();
            msg::Request request;
            request.request_id = number_;
            static_cast<void>(requests.write(request));
          }
          return last_ == number_;
        },
        within);
  }

  /// @return the number of the last request that was answered, to anyone.
  [[nodiscard]] std::uint64_t last() const { return last_; }

  std::unique_ptr<Participant> participant;
  Publication<msg::Request> requests;

 private:
  std::atomic<std::uint64_t> last_{0};
  std::uint64_t number_ = 0;
  Subscription<msg::Reply> replies;
};

Source source_of(const GuidPrefix& prefix) {
  Source source;
  source.participant = prefix;
  return source;
}

NetworkSettings settings(Role role = Role::other) {
  return {.domain = test::test_domain(), .role = role};
}

// ---- unchanged behaviour ------------------------------------------------------------------------

TEST(GuardedParticipant, AcceptsEverythingFromParticipantsOfVdrive) {
  Requester requester;
  Visitor visitor("visitor");
  ASSERT_TRUE(requester.is_answered());
  const test::Finished finished = visitor.stop();
  EXPECT_EQ(finished.output.find("refused 0 "), 0U) << finished.output;
  EXPECT_EQ(requester.participant->guard_counts().all_refused(), 0U);
}

TEST(GuardedParticipant, CommunicatesThroughSharedMemory) {
  auto with_shared_memory = settings();
  with_shared_memory.shared_memory = true;
  Requester requester(with_shared_memory);
  Visitor visitor("visitor", {"shared_memory"});
  EXPECT_TRUE(requester.is_answered());
  EXPECT_EQ(requester.participant->guard_counts().all_refused(), 0U);
  // A killed process leaves its segment in /dev/shm; one that ends normally removes it.
  EXPECT_EQ(visitor.stop().code, 0);
}

TEST(AClient, IgnoresOtherClients) {
  Visitor client("vdrive client", {"client"});
  Requester of_a_client(settings(Role::client));
  Requester of_another(settings());
  // The client answers everyone that it knows; once the other requester is answered, both have
  // received its announcement.
  ASSERT_TRUE(of_another.is_answered());
  EXPECT_TRUE(wait_until([&] {
    return of_a_client.participant->guard_counts().ignored > 0;
  }));
  EXPECT_FALSE(of_a_client.requests.wait_for_match(source_of(client.prefix()), 500ms));
}

// ---- participants that are gone -----------------------------------------------------------------

/// Sends a datagram until it first arrives in a socket.
class FirstToArrive {
 public:
  /// @param port counted from the first port of the domain
  explicit FirstToArrive(std::uint32_t port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * test::test_domain() + port));
    is_connected_ = connect(socket_, std::bit_cast<sockaddr*>(&address), sizeof address) == 0;
  }

  ~FirstToArrive() { close(socket_); }

  FirstToArrive(const FirstToArrive&) = delete;
  FirstToArrive& operator=(const FirstToArrive&) = delete;

  /// On loopback the kernel reports immediately when no socket has the port.
  /// @return whether the datagram arrived before the deadline.
  [[nodiscard]] bool send(const Datagram& datagram) const {
    return is_connected_ &&
           wait_until(
               [&] {
                 int error = 0;
                 socklen_t size = sizeof error;
                 return ::send(socket_, datagram.data(), datagram.size(), 0) > 0 &&
                        getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
               },
               kDeadline, 50us);
  }

 private:
  int socket_;
  bool is_connected_ = false;
};

// The sockets of a participant are open some milliseconds before the library reads from them.
TEST(ParticipantUnderConstruction, ReadsDatagramsThatArrivedBefore) {
  constexpr GuidPrefix kEarly{1, 15, 'e', 'a', 'r', 'l', 'y', 0, 0, 0, 0, 1};
  // Its address is 127.0.0.1, port 9.
  const Datagram locator = Body().u32(1).u32(9).raw(Datagram(12)).raw({127, 0, 0, 1}).bytes();
  Datagram body = test::announcement(kEarly, "early", 600).bytes();
  body.resize(body.size() - 4);  // sentinel
  const Datagram announcement =
      Body().raw(body).parameter(0x32, locator).parameter(0x31, locator).u32(1).bytes();
  const Datagram datagram = DatagramWriter(kEarly).add(0x15, 5, announcement).bytes();
  const FirstToArrive sender(10);  // metatraffic of participant 0
  auto arrived = std::async(std::launch::async, [&] {
    return sender.send(datagram);
  });
  const auto participant = make_participant(settings(), "late");
  EXPECT_TRUE(arrived.get());
  EXPECT_TRUE(wait_until([&] {
    return participant->presence().others("early").size() == 1;
  }));
}

TEST(KilledParticipant, IsForgottenWithinThreeSeconds) {
  Requester requester;
  Visitor visitor("vdrive client");
  ASSERT_TRUE(requester.is_answered());
  visitor.send(SIGKILL);
  const auto killed = Clock::now();
  EXPECT_TRUE(wait_until([&] {
    return requester.requests.matched() == 0;
  }));
  EXPECT_LT(Clock::now() - killed, 3500ms);
  EXPECT_EQ(requester.participant->guard_counts().judged, 1U);
}

TEST(LeavingParticipant, IsNotReportedSilent) {
  Requester requester;
  Visitor visitor("vdrive client");
  ASSERT_TRUE(requester.is_answered());
  static_cast<void>(visitor.stop());
  EXPECT_TRUE(wait_until([&] {
    return requester.requests.matched() == 0;
  }));
  EXPECT_EQ(requester.participant->guard_counts().judged, 0U);
  EXPECT_EQ(requester.participant->guard_counts().kept, 1U) << "itself alone";
}

TEST(PausedParticipant, IsFoundAgain) {
  Requester requester;
  Visitor visitor("vdrive client");
  ASSERT_TRUE(requester.is_answered());
  visitor.send(SIGSTOP);
  ASSERT_TRUE(wait_until([&] {
    return requester.requests.matched() == 0;
  }));
  EXPECT_EQ(requester.participant->guard_counts().judged, 1U);
  visitor.send(SIGCONT);
  EXPECT_TRUE(requester.is_answered());
}

TEST(AnnouncedEnd, RemovesADeadParticipantEverywhereAtOnce) {
  Requester requester;
  // The name makes it foreign, so it has its own lease of 600 s.
  Visitor visitor("talker");
  ASSERT_TRUE(requester.is_answered());
  visitor.send(SIGKILL);
  static_cast<void>(visitor.process().wait());
  const auto begin = Clock::now();
  announce_end(settings(), source_of(visitor.prefix()));
  EXPECT_TRUE(wait_until([&] {
    return requester.requests.matched() == 0;
  }));
  EXPECT_LT(Clock::now() - begin, 1s);
}

// Each client takes one of the participant's 256 places for others until it is classified.
TEST(AParticipant, ServesTheNextClientAfterAThousandKilledOnes) {
  const int deaths = test::number_of<int>({.usual = 60, .full = 60, .nightly = 1'000});
  Requester requester(settings(Role::service));
  for (int death = 0; death < deaths; ++death) {
    Visitor visitor("vdrive client", {"client"});
    static_cast<void>(requester.requests.wait_for_match(source_of(visitor.prefix()), 50ms));
    visitor.send(SIGKILL);
  }
  Visitor next("vdrive client", {"client"});
  EXPECT_TRUE(requester.requests.wait_for_match(source_of(next.prefix()), 2s));
}

TEST(AParticipant, SurvivesTwoHundredJoinsAndLeaves) {
  Visitor bench("vdrived 1");
  constexpr int kAtOnce = 5;
  constexpr int kRounds = 40;
  std::vector<std::thread> clients;
  std::atomic<int> answered{0};
  for (int client = 0; client < kAtOnce; ++client) {
    clients.emplace_back([&answered] {
      for (int round = 0; round < kRounds; ++round) {
        Requester requester(settings(Role::client));
        answered += requester.is_answered() ? 1 : 0;
      }
    });
  }
  for (auto& client : clients) client.join();
  EXPECT_EQ(answered, kAtOnce * kRounds);
  EXPECT_EQ(bench.stop().code, 0);
}

// ---- datagrams that the library does not survive ------------------------------------------------

TEST(UnguardedParticipant, EndsAfterOneStatisticsSubmessage) {
  Visitor visitor("visitor", {"unguarded"});
  Attacker().send_to_discovery(statistics_with_more_behind({1, 15, 1}));
  EXPECT_EQ(visitor.process().wait().code, -SIGABRT);
}

TEST(UnguardedParticipant, DiscoversNoParticipantAfterAnEndlessGap) {
  Requester known;
  Visitor visitor("visitor", {"unguarded"});
  ASSERT_TRUE(known.is_answered());
  Attacker().send_to_discovery(gap_without_end(known.participant->source().participant));
  Requester late;
  EXPECT_FALSE(late.is_answered(3s));
  visitor.send(SIGKILL);  // its memory grows
}

TEST(GuardedParticipant, SurvivesAStatisticsSubmessageAndAnEndlessGap) {
  Requester known;
  Visitor visitor("visitor");
  ASSERT_TRUE(known.is_answered());
  const GuidPrefix sender = known.participant->source().participant;
  Attacker().send_to_discovery(statistics_with_more_behind(sender));
  Attacker().send_to_discovery(gap_without_end(sender));
  Requester late;
  EXPECT_TRUE(late.is_answered());
  const test::Finished finished = visitor.stop();
  EXPECT_EQ(finished.code, 0);
  EXPECT_NE(finished.output.find("refused 2 "), std::string::npos) << finished.output;
}

// ---- sequence numbers --------------------------------------------------------------------------

constexpr GuidPrefix kRawWriter{1, 15, 'r', 'a', 'w', 0, 0, 0, 0, 0, 0, 1};
constexpr std::int64_t kSentBefore = 1'000'000'000;

/// Sends requests of a raw writer until one of them is answered.
bool is_served(test::RawWriter& writer, Requester& listener, std::int64_t& number,
               std::uint64_t request_id, std::chrono::milliseconds within = kDeadline) {
  auto sent = Clock::time_point{};
  return wait_until(
      [&] {
        if (Clock::now() - sent > 50ms) {
          sent = Clock::now();
          writer.announce();
          writer.send(++number, request_id);
        }
        return listener.last() == request_id;
      },
      within);
}

// Fast DDS takes 0.3 us for each number before the first that it reads: five minutes for 10^9.
TEST(LateReader, BeginsAtThePresentOfItsWriter) {
  Visitor visitor("visitor");
  Requester listener;
  ASSERT_TRUE(listener.is_answered());
  test::RawWriter writer(kRawWriter);
  std::int64_t number = kSentBefore;
  EXPECT_TRUE(is_served(writer, listener, number, 1'001));
  // The library's acknowledgements and requests must still refer to this writer.
  EXPECT_TRUE(is_served(writer, listener, number, 1'002));
  EXPECT_TRUE(listener.is_answered());
  EXPECT_EQ(visitor.stop().code, 0);
}

TEST(GuardedParticipant, SurvivesAHeartbeatFarBeyondWhatItsWriterHasSent) {
  Visitor visitor("visitor");
  Requester listener;
  ASSERT_TRUE(listener.is_answered());
  test::RawWriter writer(kRawWriter);
  std::int64_t number = 0;
  ASSERT_TRUE(is_served(writer, listener, number, 1'001));
  writer.send_heartbeat(std::int64_t{1} << 39U, 1'000'000);
  EXPECT_TRUE(listener.is_answered());
  const test::Finished finished = visitor.stop();
  EXPECT_EQ(finished.code, 0);
  EXPECT_NE(finished.output.find("1 times a sequence number far"), std::string::npos)
      << finished.output;
}

TEST(GuardedParticipant, FindsAWriterAgainThatHasSkippedNumbers) {
  Visitor visitor("visitor");
  Requester listener;
  test::RawWriter writer(kRawWriter);
  std::int64_t number = 0;
  ASSERT_TRUE(is_served(writer, listener, number, 1'001));
  number = kSentBefore;
  EXPECT_TRUE(is_served(writer, listener, number, 1'002));
  EXPECT_EQ(visitor.stop().code, 0);
}

TEST(GuardSink, ReceivesReasonAndSender) {
  std::atomic<int> reported{0};
  auto with_sink = settings();
  with_sink.guard_sink = [&reported](Refusal refusal, std::string_view sender) {
    reported += refusal == Refusal::statistics && sender.starts_with("127.0.0.1:") ? 1 : 0;
  };
  const auto participant = make_participant(with_sink, "reported");
  Attacker().send_to_discovery(statistics_with_more_behind({1, 15, 1}));
  EXPECT_TRUE(wait_until([&] {
    return reported == 1;
  }));
}

// ---- mutations of real datagrams ----------------------------------------------------------------

/// The prefixes of sender and receiver in the recorded datagrams.
constexpr GuidPrefix kKeptSender{1, 15, 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A'};
constexpr GuidPrefix kKeptReceiver{1, 15, 'B', 'B', 'B', 'B', 'B', 'B', 'B', 'B', 'B', 'B'};

void replace_all(Datagram& datagram, const GuidPrefix& from, const GuidPrefix& to) {
  for (auto place = datagram.begin();
       (place = std::search(place, datagram.end(), from.begin(), from.end())) != datagram.end();) {
    place = std::copy(to.begin(), to.end(), place);
  }
}

std::vector<Datagram> kept_datagrams(const GuidPrefix& sender, const GuidPrefix& receiver) {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path directory = VDRIVE_SOURCE_DIR "/tests/fuzz/corpus/datagram_fuzz";
  for (const auto& file : std::filesystem::directory_iterator(directory)) {
    files.push_back(file.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Datagram> kept;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    Datagram datagram{std::istreambuf_iterator<char>(file), {}};
    replace_all(datagram, kKeptSender, sender);
    replace_all(datagram, kKeptReceiver, receiver);
    kept.push_back(std::move(datagram));
  }
  return kept;
}

/// Changes a datagram as a faulty network or a faulty participant would.
class Mutator {
 public:
  Mutator(std::uint64_t seed, std::vector<Datagram> kept) : random_(seed), kept_(std::move(kept)) {}

  Datagram next() {
    Datagram datagram = kept_.at(below(kept_.size()));
    for (std::size_t changes = 1 + below(2); changes > 0 && datagram.size() > 24; --changes) {
      change(datagram);
    }
    return datagram;
  }

 private:
  std::size_t below(std::size_t bound) { return random_() % bound; }

  /// @return the offset of a random submessage.
  std::size_t submessage(const Datagram& datagram) {
    std::vector<std::size_t> offsets;
    for (std::size_t offset = 20; offset + 4 <= datagram.size();) {
      offsets.push_back(offset);
      offset += 4U + datagram[offset + 2] + 256U * datagram[offset + 3];
    }
    return offsets.empty() ? 20 : offsets.at(below(offsets.size()));
  }

  void change(Datagram& datagram) {
    constexpr std::array<std::uint8_t, 12> kKinds{0x06, 0x07, 0x08, 0x09, 0x0C, 0x0E,
                                                  0x12, 0x13, 0x15, 0x16, 0x33, 0x80};
    const std::size_t place = submessage(datagram);
    switch (below(8)) {
      case 0:
        datagram[20 + below(datagram.size() - 20)] ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 1:
        datagram[20 + below(datagram.size() - 20)] = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        datagram[place + 2 + below(2)] = static_cast<std::uint8_t>(random_());
        break;
      case 3:
        datagram[place] = kKinds.at(below(kKinds.size()));
        break;
      case 4:
        truncate(datagram);
        break;
      case 5:
        forge_gap(datagram);
        break;
      case 6:
        splice(datagram);
        break;
      default:
        overwrite_number(datagram);
        break;
    }
  }

  /// Ends a submessage early with a consistent length, so that its remaining bytes are parsed.
  static void end_at(Datagram& datagram, std::size_t place, std::size_t size) {
    datagram.resize(size);
    datagram[place + 2] = 0;
    datagram[place + 3] = 0;
  }

  void truncate(Datagram& datagram) {
    const std::size_t place = submessage(datagram);
    if (place + 4 < datagram.size()) {
      end_at(datagram, place, place + 4 + below(datagram.size() - place - 4));
    }
  }

  void forge_gap(Datagram& datagram) {
    const std::array<std::uint32_t, 4> writers{0x000003C2, 0x000004C2, 0x000200C2, 0x00000203};
    const std::uint32_t writer = writers.at(below(writers.size()));
    const auto start = static_cast<std::int64_t>(random_() >> below(64));
    const auto base = static_cast<std::int64_t>(random_() >> below(64));
    const Datagram forged =
        DatagramWriter({}).add(0x08, 1, test::gap(0, writer, start, base).bytes()).bytes();
    datagram.insert(datagram.end(), forged.begin() + 20, forged.end());
  }

  void splice(Datagram& datagram) {
    const Datagram& other = kept_.at(below(kept_.size()));
    datagram.resize(submessage(datagram));
    datagram.insert(datagram.end(), other.begin() + static_cast<std::ptrdiff_t>(submessage(other)),
                    other.end());
  }

  void overwrite_number(Datagram& datagram) {
    constexpr std::array<std::uint32_t, 6> kNumbers{0,          1,          0x7FFFFFFF,
                                                    0x80000000, 0xFFFFFFFF, 0x100};
    const std::uint32_t number = kNumbers.at(below(kNumbers.size()));
    const std::size_t place = 20 + below((datagram.size() - 20) / 4) * 4;
    for (std::size_t byte = 0; byte < 4; ++byte) {
      datagram[place + byte] = static_cast<std::uint8_t>(number >> (8 * byte));
    }
  }

  std::mt19937_64 random_;
  std::vector<Datagram> kept_;
};

TEST(GuardedParticipant, SurvivesMutatedDatagrams) {
  const auto count =
      test::number_of<std::uint64_t>({.usual = 30'000, .full = 100'000, .nightly = 10'000'000});
  Visitor visitor("visitor");
  Requester known;
  ASSERT_TRUE(known.is_answered());
  Mutator mutator(1, kept_datagrams(known.participant->source().participant, visitor.prefix()));
  const Attacker attacker;
  // Short pauses let the visitor read its sockets, which drop datagrams when they are full. At the
  // end it prints how many it has read.
  for (std::uint64_t number = 0; number < count; ++number) {
    attacker.send(mutator.next(), number % 3 == 0 ? 11 : 10);
    if (number % 64 == 0) std::this_thread::sleep_for(1ms);
  }
  Requester late;
  // On a busy machine the visitor first reads the datagrams still in its sockets, some 20,000.
  EXPECT_TRUE(late.is_answered(60s)) << "no new participant is found";
  const test::Finished finished = visitor.stop();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  std::cout << finished.output;
}

}  // namespace
}  // namespace vdrive::wire
