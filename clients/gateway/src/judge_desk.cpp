// SPDX-License-Identifier: Apache-2.0
#include "judge_desk.hpp"

#include "judge/rule.hpp"
#include "live/live_judge.hpp"
#include "protocol.hpp"
#include "vdrive/client/axis.hpp"

#include <limits>
#include <utility>

namespace vdrive::gateway {
namespace {

constexpr std::chrono::milliseconds kShowEvery{500};

Json finding_json(const judge::Finding& finding) {
  const judge::RuleRow& row = judge::row_of(finding.rule);
  return {{"rule", row.name},
          {"severity", judge::to_string(row.severity)},
          {"title", row.title},
          {"axis", finding.axis},
          {"count", finding.count},
          {"tick", finding.first.tick},
          {"happened", finding.happened},
          {"expected", row.expected},
          {"remedy", row.remedy}};
}

}  // namespace

CallAnswer JudgeDesk::call(const Json& request) {
  constexpr NumberRange kBenches{.lowest = 0, .highest = std::numeric_limits<std::uint32_t>::max()};
  const auto number = optional_integer(request, "bench", kBenches);
  if (!number) throw ProtocolError("'bench' is missing: the number of a bench, such as 1");
  const auto bench = static_cast<std::uint32_t>(*number);
  const std::scoped_lock lock(mutex_);
  forget_unasked();
  if (!benches_.contains(bench) && benches_.size() == kMostBenches) {
    return {.outcome = client::Outcome::failed("this gateway already judges " +
                                               std::to_string(kMostBenches) +
                                               " benches, which is the limit")};
  }
  auto& place = benches_[bench];
  if (place == nullptr) {
    place = std::make_unique<Judged>();
    place->thread = std::jthread([this, bench, judged = place.get()](const std::stop_token& stop) {
      work(bench, *judged, stop);
    });
  }
  CallAnswer answer = answer_of(*place);
  if (!answer.outcome) benches_.erase(bench);  // the next call tries again
  return answer;
}

CallAnswer JudgeDesk::answer_of(Judged& judged) {
  const std::scoped_lock lock(judged.mutex);
  judged.asked = Clock::now();
  if (!judged.outcome) return {.outcome = judged.outcome};
  Json findings = Json::array();
  for (const judge::Finding& finding : judged.verdict.findings) {
    findings.push_back(finding_json(finding));
  }
  return {.outcome = {},
          .fields = {{"judged", judged.has_begun}, {"findings", std::move(findings)}}};
}

void JudgeDesk::work(std::uint32_t bench, Judged& judged, const std::stop_token& stop) {
  const auto ends = [&judged](client::Outcome outcome) {
    const std::scoped_lock lock(judged.mutex);
    judged.outcome = std::move(outcome);
  };
  auto axes = session_.axes(bench);
  if (!axes) return ends(axes.outcome());
  if (axes->size() > kMostAxes) {
    return ends(client::Outcome::failed(
        "bench " + std::to_string(bench) + " has " + std::to_string(axes->size()) +
        " axes; a gateway judges at most " + std::to_string(kMostAxes) + ": use vdrive judge"));
  }
  auto judge = judge::LiveJudge::create(session_, bench, std::move(*axes));
  if (!judge) return ends(judge.outcome());
  Clock::time_point shown{};
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(judge::LiveJudge::kPollEvery);
    client::Outcome polled = judge->poll(judge::LiveJudge::kPollEvery);
    if (!polled) return ends(std::move(polled));
    const auto now = Clock::now();
    if (now - shown < kShowEvery) continue;
    shown = now;
    judge::Verdict verdict = judge->verdict();
    const std::scoped_lock lock(judged.mutex);
    judged.verdict = std::move(verdict);
    judged.has_begun = true;
    judged.is_unasked = now - judged.asked > kForgottenAfter;
    if (judged.is_unasked) return;
  }
}

void JudgeDesk::forget_unasked() {
  std::erase_if(benches_, [](const auto& entry) {
    Judged& judged = *entry.second;
    const std::scoped_lock lock(judged.mutex);
    const bool is_left = !judged.outcome && Clock::now() - judged.asked > kForgottenAfter;
    return judged.is_unasked || is_left;
  });
}

}  // namespace vdrive::gateway
