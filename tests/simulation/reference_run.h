// What the simulated cluster has to learn: a small problem, and how learning it goes when nothing goes wrong.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "coordinator/learning/schedule.h"

namespace knap {

inline constexpr std::uint64_t kProblems = 6;

struct SimulatedProblem {
  std::map<std::string, std::string> scenario;  // for the closed-form engine; more than one piece
  Problem problem;
  LearningOptions options;
};

// Problem `index` of kProblems: all methods, few variations.
SimulatedProblem MakeSimulatedProblem(std::uint64_t index);

// Every evaluation of a learning, and its end.
struct ReferenceRun {
  std::vector<LearningEvaluation> evaluations;
  std::vector<double> theta;
};

// Problem `index` learned without any cluster; remembered.
const ReferenceRun& GetReferenceRun(std::uint64_t index);

// Compares each evaluation of a learning with the reference's, to the last bit; throws std::runtime_error at the first
// that differs.
class ReferenceObserver : public LearningObserver {
 public:
  explicit ReferenceObserver(const ReferenceRun& reference) : reference_(reference) {}

  void OnBatchStart(const BatchStart&) override {}
  void OnEvaluation(const LearningEvaluation& evaluation) override;
  void OnBatchBox(const BatchBox&) override {}
  void OnBatchEnd(const BatchEnd&) override {}

 private:
  const ReferenceRun& reference_;
  std::size_t count_ = 0;
};

bool HasSameBits(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace knap
