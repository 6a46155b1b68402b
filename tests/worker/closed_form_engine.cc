#include "tests/worker/closed_form_engine.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace knap {
namespace {

struct Parameters {
  std::size_t dimension = 4;
  std::size_t controls = 0;
  std::int64_t steps = 10;
  std::int64_t step_us = 0;
  std::size_t allocate_mb = 0;
  std::optional<double> crash_at;
  std::optional<double> hang_at;
  std::optional<double> fail_at;
};

Parameters ParseScenario(const ScenarioFiles& files) {
  const auto file = files.find("scenario.txt");
  if (file == files.end()) throw std::runtime_error("the scenario has no file scenario.txt");
  std::istringstream lines(file->second);
  Parameters parameters;
  std::string key;
  double value = 0.0;
  while (lines >> key) {
    if (!(lines >> value)) throw std::runtime_error("scenario.txt: '" + key + "' has no value");
    if (key == "dimension") {
      parameters.dimension = static_cast<std::size_t>(value);
    } else if (key == "controls") {
      parameters.controls = static_cast<std::size_t>(value);
    } else if (key == "steps") {
      parameters.steps = static_cast<std::int64_t>(value);
    } else if (key == "step_us") {
      parameters.step_us = static_cast<std::int64_t>(value);
    } else if (key == "allocate_mb") {
      parameters.allocate_mb = static_cast<std::size_t>(value);
    } else if (key == "crash_at") {
      parameters.crash_at = value;
    } else if (key == "hang_at") {
      parameters.hang_at = value;
    } else if (key == "fail_at") {
      parameters.fail_at = value;
    } else {
      throw std::runtime_error("scenario.txt: unknown key '" + key + "'");
    }
  }
  return parameters;
}

class ClosedFormScenario : public EngineScenario {
 public:
  explicit ClosedFormScenario(const Parameters& parameters) : parameters_(parameters) {}

  EngineAnswer Run(const EngineRequest& request,
                   const std::function<void(std::int64_t, std::int64_t)>& progress) override {
    if (request.theta.size() != parameters_.dimension) throw std::runtime_error("theta has another length");
    if (request.controls.size() != parameters_.controls) throw std::runtime_error("controls have another length");
    std::vector<double> x = request.theta;
    x.insert(x.end(), request.controls.begin(), request.controls.end());
    const std::vector<double>& v = request.variation;
    const auto is_at = [&](const std::optional<double>& value) { return value && !v.empty() && v[0] == *value; };
    if (is_at(parameters_.fail_at)) throw std::runtime_error("this variation cannot be simulated");
    const auto space = std::make_unique_for_overwrite<char[]>(parameters_.allocate_mb << 20);
    volatile char* const touched = space.get();  // or the compiler may leave the allocation out
    if (parameters_.allocate_mb > 0) touched[0] = 1;
    for (std::int64_t step = 0; step < parameters_.steps; ++step) {
      if (step == parameters_.steps / 2 && is_at(parameters_.crash_at)) std::abort();
      while (step == parameters_.steps / 2 && is_at(parameters_.hang_at)) {
        std::this_thread::sleep_for(std::chrono::seconds(1));
      }
      if (parameters_.step_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(parameters_.step_us));
      progress(step + 1, parameters_.steps);
    }
    EngineAnswer answer;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const bool task = request.reference.empty();
      const double weight = task ? 1.0 + 0.5 * static_cast<double>(i) : 1.0;
      const double target =
          task ? 0.1 * static_cast<double>(i) + (v.empty() ? 0.0 : v[i % v.size()]) : request.reference.at(i);
      const double error = x[i] - target;
      answer.loss += 0.5 * weight * error * error;
      if (request.gradient) answer.gradient.push_back(weight * error);
    }
    answer.success = answer.loss < 1.0;
    answer.finite = answer.converged = answer.gradient_reliable = true;
    answer.worst_residual = 1e-12;
    answer.penetration = 0.25 * answer.loss;
    answer.largest_force = 3.0 * answer.loss;
    if (answer.penetration > 0.5) answer.distrust = "bowl and target press into one another";
    answer.steps = static_cast<std::int32_t>(parameters_.steps);
    return answer;
  }

 private:
  Parameters parameters_;
};

class WrongScenario : public EngineScenario {
 public:
  explicit WrongScenario(std::unique_ptr<EngineScenario> right) : right_(std::move(right)) {}

  EngineAnswer Run(const EngineRequest& request,
                   const std::function<void(std::int64_t, std::int64_t)>& progress) override {
    EngineAnswer answer = right_->Run(request, progress);
    answer.loss = std::nextafter(answer.loss, 1e9);
    return answer;
  }

 private:
  std::unique_ptr<EngineScenario> right_;
};

}  // namespace

std::unique_ptr<EngineScenario> ClosedFormEngine::Load(const ScenarioFiles& files) {
  return std::make_unique<ClosedFormScenario>(ParseScenario(files));
}

std::unique_ptr<EngineScenario> WrongEngine::Load(const ScenarioFiles& files) {
  return std::make_unique<WrongScenario>(ClosedFormEngine::Load(files));
}

}  // namespace knap
