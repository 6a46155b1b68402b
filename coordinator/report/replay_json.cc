#include "coordinator/report/replay_json.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "coordinator/report/packed_numbers.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostContacts = 16;

// Of an outcome that there is: worse sorts first.
struct Rank {
  int group = 2;  // 0: the learned tool fails, 1: it alone succeeds, 2: the others
  double loss = 0.0;
};

Rank CalcRank(const std::optional<RolloutOutcome>& initial, const std::optional<RolloutOutcome>& learned,
              bool has_success) {
  if (!learned) return {3, 0.0};
  const double loss = std::isfinite(learned->loss) ? learned->loss : HUGE_VAL;
  if (!has_success) return {0, loss};
  if (!learned->success) return {0, loss};
  return {initial && !initial->success ? 1 : 2, 0.0};
}

void Append(const Eigen::Vector3d& v, std::vector<float>* out) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

std::string PackPoses(const Recording& recording) {
  std::vector<float> numbers;
  for (std::size_t k = 0; k < recording.time.size(); ++k) {
    for (const Recording::Body& body : recording.bodies) {
      if (!body.moves) continue;
      const Eigen::Quaterniond q(body.X_WB[k].R);
      Append(body.X_WB[k].p, &numbers);
      for (const double x : {q.w(), q.x(), q.y(), q.z()}) numbers.push_back(static_cast<float>(x));
    }
  }
  return PackSingles(numbers);
}

std::string Pack(const std::vector<double>& values) {
  const std::vector<float> numbers(values.begin(), values.end());
  return PackSingles(numbers);
}

std::string Pack(const std::vector<Eigen::Vector3d>& values) {
  std::vector<float> numbers;
  for (const Eigen::Vector3d& value : values) Append(value, &numbers);
  return PackSingles(numbers);
}

Json MakeForcesJson(const Recording& recording) {
  std::vector<std::pair<double, const Recording::Contact*>> contacts;
  for (const Recording::Contact& contact : recording.contacts) {
    double largest = 0.0;
    for (const Eigen::Vector3d& f : contact.f_W) largest = std::max(largest, f.norm());
    contacts.emplace_back(largest, &contact);
  }
  std::stable_sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (contacts.size() > kMostContacts) contacts.resize(kMostContacts);
  Json json = Json::array();
  for (const auto& [largest, contact] : contacts) {
    json.push_back({{"between", contact->bodies}, {"force", Pack(contact->f_W)}, {"at", Pack(contact->p_W)}});
  }
  return json;
}

Json MakeSignalsJson(const Recording& recording) {
  Json json = Json::array();
  for (const Recording::Joint& joint : recording.joints) {
    json.push_back({{"name", joint.body + " joint"}, {"unit", joint.unit}, {"values", Pack(joint.q)}});
  }
  for (const Recording::Signal& signal : recording.signals) {
    json.push_back({{"name", signal.name}, {"unit", signal.unit}, {"values", Pack(signal.values)}});
  }
  return json;
}

}  // namespace

std::vector<std::size_t> ChooseReplays(const ReportSource& source, bool has_success) {
  std::vector<std::size_t> order(source.variations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto rank = [&](std::size_t i) {
    return CalcRank(source.tests[0].outcomes[i], source.tests[1].outcomes[i], has_success);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Rank x = rank(a);
    const Rank y = rank(b);
    return x.group != y.group ? x.group < y.group : x.loss > y.loss;
  });
  return order;
}

Json MakeReplayJson(const ReportedTest& test, std::size_t variation, const RecordedRollout& rollout, bool has_success) {
  const Eigen::Vector3d& g = rollout.recording.gravity_W;
  return {{"design", test.name},
          {"variation", variation},
          {"id", test.ids[variation]},
          {"loss", MakeJsonNumber(rollout.output.loss)},
          {"success", has_success ? Json(rollout.output.success) : Json()},
          {"distrust", rollout.output.distrust},
          {"doubts", Json::array()},
          {"times", Pack(rollout.recording.time)},
          {"poses", PackPoses(rollout.recording)},
          {"forces", MakeForcesJson(rollout.recording)},
          {"signals", MakeSignalsJson(rollout.recording)},
          {"gravity", {g.x(), g.y(), g.z()}}};
}

}  // namespace knap
