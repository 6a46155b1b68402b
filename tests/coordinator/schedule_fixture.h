// What the tests of the schedule share: a problem of seven parameters with a known optimum, and a recording observer.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "coordinator/learning/schedule.h"

namespace knap {

class Recorder : public LearningObserver {
 public:
  void OnBatchStart(const BatchStart& start) override { starts.push_back(start); }
  void OnEvaluation(const LearningEvaluation& evaluation) override { evaluations.push_back(evaluation); }
  void OnBatchBox(const BatchBox& box) override { boxes.push_back(box); }
  void OnBatchEnd(const BatchEnd& end) override { ends.push_back(end); }

  std::vector<BatchStart> starts;
  std::vector<LearningEvaluation> evaluations;
  std::vector<BatchBox> boxes;
  std::vector<BatchEnd> ends;
};

inline constexpr std::size_t kDimensions = 7;
inline const std::vector<double> kOptimum = {0.6, 0.3, 0.55, 0.45, 0.7, 0.35, 0.5};
inline const std::vector<double> kWeights = {1.0, 4.0, 2.0, 0.5, 3.0, 1.5, 2.5};

// Two different ranges: were all alike, a forgotten normalisation would not show.
inline Problem MakeProblem(double noise = 0.02) {
  Problem problem;
  for (std::size_t i = 0; i < kDimensions; ++i) {
    problem.parameters.names.push_back(std::string("p").append(std::to_string(i)));
    problem.parameters.lower.push_back(0.0);
    problem.parameters.upper.push_back(i % 2 == 0 ? 1.0 : 0.8);
    problem.parameters.initial.push_back(0.4);
    problem.variations.push_back({{std::string("v").append(std::to_string(i))}, UniformDraw{-noise, noise}});
  }
  return problem;
}

inline LearningOptions MakeOptions(LearningMethod method = LearningMethod::kOurs) {
  LearningOptions options;
  options.method = method;
  return options;
}

inline double CalcDistance(const std::vector<double>& theta, const std::vector<double>& optimum) {
  double sum = 0.0;
  for (std::size_t i = 0; i < theta.size(); ++i) sum += (theta[i] - optimum[i]) * (theta[i] - optimum[i]);
  return std::sqrt(sum);
}

}  // namespace knap
