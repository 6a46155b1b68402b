#include "coordinator/optimizer/bounded_minimizer.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <memory>
#include <stdexcept>
#include <utility>

#include "coordinator/optimizer/evolution_strategy.h"

namespace knap {
namespace {

struct NloptDeleter {
  void operator()(nlopt_opt opt) const { nlopt_destroy(opt); }
};
using NloptHandle = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, NloptDeleter>;

bool IsFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

void CheckProblem(const MinimizerProblem& problem, const MinimizerOptions& options) {
  const std::size_t n = problem.start.size();
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("Minimize: " + what); };
  if (n == 0) refuse("no coordinates");
  if (problem.lower.size() != n || problem.upper.size() != n || problem.scale.size() != n) {
    refuse("lower, upper, scale and start differ in length");
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string coordinate = "coordinate " + std::to_string(i) + ": ";
    if (!std::isfinite(problem.lower[i]) || !std::isfinite(problem.upper[i])) refuse(coordinate + "bound not finite");
    if (!(problem.lower[i] <= problem.start[i] && problem.start[i] <= problem.upper[i])) {
      refuse(coordinate + "start outside the box");
    }
    if (!(problem.scale[i] > 0.0 && std::isfinite(problem.scale[i]))) refuse(coordinate + "scale must be > 0");
  }
  if (!problem.start_value.accepted || !std::isfinite(problem.start_value.value)) refuse("the start has no value");
  CheckMinimizerAlgorithm(options.algorithm);
  if (options.max_evaluations < 1) refuse("max_evaluations must be >= 1");
  if (!(options.value_tolerance >= 0.0) || !(options.step_tolerance >= 0.0)) refuse("tolerances must be >= 0");
  if (!(options.first_step > 0.0 && options.first_step <= 1.0)) refuse("first_step must be in (0, 1]");
}

void CheckValue(const ObjectiveValue& answer, std::size_t n, bool uses_gradient) {
  if (!std::isfinite(answer.value)) throw std::invalid_argument("Minimize: an accepted value is not finite");
  if (uses_gradient && (answer.gradient.size() != n || !IsFinite(answer.gradient))) {
    throw std::invalid_argument("Minimize: an accepted gradient has " + std::to_string(answer.gradient.size()) +
                                " values or non-finite ones; expected " + std::to_string(n) + " finite values");
  }
}

// (z - 0.3)² summed over the coordinates.
double CalcParabola(unsigned n, const double* z, double* df_dz, void*) {
  double sum = 0.0;
  for (unsigned i = 0; i < n; ++i) {
    sum += (z[i] - 0.3) * (z[i] - 0.3);
    if (df_dz != nullptr) df_dz[i] = 2.0 * (z[i] - 0.3);
  }
  return sum;
}

// NLopt knows names of algorithms that a build may lack, and algorithms that need two coordinates at least.
bool RunsOnUnitBox(nlopt_algorithm algorithm, unsigned n) {
  const NloptHandle opt(nlopt_create(algorithm, n));
  if (!opt) return false;
  nlopt_set_min_objective(opt.get(), CalcParabola, nullptr);
  nlopt_set_lower_bounds1(opt.get(), 0.0);
  nlopt_set_upper_bounds1(opt.get(), 1.0);
  nlopt_set_maxeval(opt.get(), 5);
  std::vector<double> z(n, 0.5);
  double value = 0.0;
  const nlopt_result code = nlopt_optimize(opt.get(), z.data(), &value);
  return code != NLOPT_INVALID_ARGS && code != NLOPT_OUT_OF_MEMORY;
}

// One search: everything NLopt's callback needs.
class Search {
 public:
  Search(const Objective& f, const MinimizerProblem& problem, const MinimizerOptions& options)
      : f_(f), problem_(problem), options_(options), uses_gradient_(UsesGradient(options.algorithm)) {
    const std::size_t n = problem.start.size();
    z_lower_.resize(n);
    z_upper_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      z_lower_[i] = (problem.lower[i] - problem.start[i]) / problem.scale[i];
      z_upper_[i] = (problem.upper[i] - problem.start[i]) / problem.scale[i];
      width_ = std::max(width_, z_upper_[i] - z_lower_[i]);
    }
    result_ = {.x = problem.start, .value = problem.start_value.value, .evaluations = 1};
    z_best_.assign(n, 0.0);
    highest_ = problem.start_value.value;
    CalcFactor();
  }

  MinimizerResult Run() {
    const auto n = static_cast<unsigned>(z_best_.size());
    if (width_ == 0.0 || (uses_gradient_ && steepest_ == 0.0)) return result_;  // nothing can move: converged
    if (options_.max_evaluations == 1) {
      result_.stop = MinimizerStop::kEvaluations;
      return result_;
    }
    opt_.reset(nlopt_create(nlopt_algorithm_from_string(options_.algorithm.c_str()), n));
    if (!opt_) throw std::runtime_error("Minimize: NLopt could not create " + options_.algorithm);
    nlopt_srand(static_cast<unsigned long>(options_.seed));
    Require(nlopt_set_min_objective(opt_.get(), &Search::CallBack, this));
    Require(nlopt_set_lower_bounds(opt_.get(), z_lower_.data()));
    Require(nlopt_set_upper_bounds(opt_.get(), z_upper_.data()));
    Require(nlopt_set_ftol_rel(opt_.get(), options_.value_tolerance));
    Require(nlopt_set_xtol_abs1(opt_.get(), options_.step_tolerance));
    Require(nlopt_set_maxeval(opt_.get(), options_.max_evaluations));
    if (!uses_gradient_) {
      // Each side's own: methods with a simplex or a trust region refuse a step that a narrow side has no room for.
      std::vector<double> first(n);
      for (std::size_t i = 0; i < n; ++i) {
        const double width = z_upper_[i] - z_lower_[i];
        first[i] = options_.first_step * (width > 0.0 ? width : width_);
      }
      Require(nlopt_set_initial_step(opt_.get(), first.data()));
    }

    std::vector<double> z(n, 0.0);
    double value = 0.0;
    const nlopt_result code = nlopt_optimize(opt_.get(), z.data(), &value);
    if (thrown_) std::rethrow_exception(thrown_);
    if (exhausted_ || code == NLOPT_MAXEVAL_REACHED) {
      result_.stop = MinimizerStop::kEvaluations;
    } else if (broken_) {
      result_.stop = MinimizerStop::kStalled;
    } else if (code > 0) {
      result_.stop = MinimizerStop::kConverged;
    } else if (code == NLOPT_FAILURE || code == NLOPT_ROUNDOFF_LIMITED) {
      result_.stop = MinimizerStop::kStalled;
    } else {
      Require(code);
    }
    return result_;
  }

 private:
  static double CallBack(unsigned n, const double* z, double* df_dz, void* self) {
    return static_cast<Search*>(self)->Evaluate(n, z, df_dz);
  }

  // No exception may cross NLopt's C frames: it is stored, the search is stopped, and Run rethrows it.
  double Evaluate(unsigned n, const double* z, double* df_dz) {
    if (df_dz != nullptr) std::fill(df_dz, df_dz + n, 0.0);
    if (thrown_ || exhausted_ || broken_) return HUGE_VAL;  // a line search may ask on for a few points after the stop
    try {
      // Some algorithms without gradients divide by zero once their steps vanish in rounding.
      if (!std::all_of(z, z + n, [](double value) { return std::isfinite(value); })) {
        broken_ = true;
        nlopt_force_stop(opt_.get());
        return HUGE_VAL;
      }
      const bool at_start = std::all_of(z, z + n, [](double value) { return value == 0.0; });
      if (!at_start && result_.evaluations >= options_.max_evaluations) {
        exhausted_ = true;
        nlopt_force_stop(opt_.get());
        return HUGE_VAL;
      }
      const ObjectiveValue answer = at_start ? problem_.start_value : CallObjective(n, z);
      return answer.accepted ? CalcScaled(answer, df_dz) : CalcRejection(n, z, df_dz);
    } catch (...) {
      thrown_ = std::current_exception();
      nlopt_force_stop(opt_.get());
      return HUGE_VAL;
    }
  }

  ObjectiveValue CallObjective(unsigned n, const double* z) {
    std::vector<double> x(n);
    for (unsigned i = 0; i < n; ++i) {
      x[i] = std::clamp(problem_.start[i] + z[i] * problem_.scale[i], problem_.lower[i], problem_.upper[i]);
      if (z[i] <= z_lower_[i]) x[i] = problem_.lower[i];
      if (z[i] >= z_upper_[i]) x[i] = problem_.upper[i];
    }
    ObjectiveValue answer = f_({&x, 1}).front();
    ++result_.evaluations;
    if (!answer.accepted) {
      ++result_.rejected;
      return answer;
    }
    highest_ = std::max(highest_, answer.value);
    if (answer.value < result_.value) {
      result_.value = answer.value;
      result_.x = x;
      z_best_.assign(z, z + n);
    }
    return answer;
  }

  double CalcScaled(const ObjectiveValue& answer, double* df_dz) const {
    if (df_dz != nullptr) {
      for (std::size_t i = 0; i < z_best_.size(); ++i) df_dz[i] = factor_ * answer.gradient[i] * problem_.scale[i];
    }
    return factor_ * answer.value;
  }

  // highest + rise (1 + |z - z_best|), rise being the larger of the spread of the values seen and the fall that the
  // first gradient promises over the box.
  double CalcRejection(unsigned n, const double* z, double* df_dz) const {
    double distance_squared = 0.0;
    for (unsigned i = 0; i < n; ++i) distance_squared += (z[i] - z_best_[i]) * (z[i] - z_best_[i]);
    const double distance = std::sqrt(distance_squared);
    double rise = factor_ * std::max(highest_ - result_.value, steepest_ * width_);
    if (rise == 0.0) rise = 1.0;  // an algorithm without gradients before its second value
    if (df_dz != nullptr && distance > 0.0) {
      for (unsigned i = 0; i < n; ++i) df_dz[i] = rise * (z[i] - z_best_[i]) / distance;
    }
    return factor_ * highest_ + rise * (1.0 + distance);
  }

  void CalcFactor() {
    if (!uses_gradient_) return;
    for (std::size_t i = 0; i < z_best_.size(); ++i) {
      const double slope = problem_.start_value.gradient[i] * problem_.scale[i];
      const bool blocked = (slope > 0.0 && z_lower_[i] == 0.0) || (slope < 0.0 && z_upper_[i] == 0.0);
      if (!blocked) steepest_ = std::max(steepest_, std::abs(slope));
    }
    const double factor = options_.first_step * width_ / steepest_;
    if (std::isfinite(factor) && factor > 0.0) factor_ = factor;  // a subnormal slope leaves the factor at 1
  }

  void Require(nlopt_result code) const {
    if (code > 0) return;
    const char* message = nlopt_get_errmsg(opt_.get());
    throw std::runtime_error("Minimize: NLopt's " + options_.algorithm +
                             " refuses the problem: " + (message != nullptr ? message : nlopt_result_to_string(code)));
  }

  const Objective& f_;
  const MinimizerProblem& problem_;
  const MinimizerOptions& options_;
  const bool uses_gradient_;
  NloptHandle opt_;
  std::vector<double> z_lower_, z_upper_, z_best_;
  double width_ = 0.0;      // widest side of the box in z
  double steepest_ = 0.0;   // largest |df/dz_i| at the start among coordinates that can descend
  double factor_ = 1.0;     // what f is multiplied with for NLopt
  double highest_ = 0.0;    // accepted value
  bool exhausted_ = false;  // max_evaluations reached
  bool broken_ = false;     // NLopt proposed a point that is not finite
  std::exception_ptr thrown_;
  MinimizerResult result_;
};

}  // namespace

const char* GetName(MinimizerStop stop) {
  switch (stop) {
    case MinimizerStop::kConverged:
      return "converged";
    case MinimizerStop::kEvaluations:
      return "evaluations";
    case MinimizerStop::kStalled:
      return "stalled";
  }
  return "";
}

void CheckMinimizerAlgorithm(const std::string& algorithm) {
  if (IsEvolutionStrategy(algorithm)) return;
  const nlopt_algorithm number = nlopt_algorithm_from_string(algorithm.c_str());
  if (static_cast<int>(number) < 0) {
    throw std::invalid_argument("\"" + algorithm + "\" is no NLopt algorithm, nor " + kEvolution + " or " +
                                kEvolutionAlongGradient + "; write NLopt's names as LD_LBFGS, LN_BOBYQA, …");
  }
  const bool has_letters = algorithm.size() > 3 && algorithm[2] == '_';
  if (!has_letters || algorithm.find("AUGLAG") != std::string::npos || algorithm.find("MLSL") != std::string::npos) {
    throw std::invalid_argument("\"" + algorithm + "\" needs a second, local algorithm; choose one that works alone");
  }
  if (!RunsOnUnitBox(number, 1) || !RunsOnUnitBox(number, 2)) {
    throw std::invalid_argument("\"" + algorithm +
                                "\" is missing from this NLopt or cannot minimise over one coordinate");
  }
}

bool UsesGradient(const std::string& algorithm) {
  return algorithm == kEvolutionAlongGradient || (algorithm.size() > 2 && algorithm.substr(1, 2) == "D_");
}

Objective EachAlone(std::function<ObjectiveValue(const std::vector<double>& x)> f) {
  return [f = std::move(f)](std::span<const std::vector<double>> points) {
    std::vector<ObjectiveValue> values;
    for (const std::vector<double>& x : points) values.push_back(f(x));
    return values;
  };
}

MinimizerResult Minimize(const Objective& f, const MinimizerProblem& problem, const MinimizerOptions& options) {
  CheckProblem(problem, options);
  const bool uses_gradient = UsesGradient(options.algorithm);
  const std::size_t n = problem.start.size();
  CheckValue(problem.start_value, n, uses_gradient);
  const Objective checked = [&](std::span<const std::vector<double>> points) {
    std::vector<ObjectiveValue> values = f(points);
    if (values.size() != points.size()) throw std::invalid_argument("Minimize: not one value a point");
    for (const ObjectiveValue& value : values) {
      if (value.accepted) CheckValue(value, n, uses_gradient);
    }
    return values;
  };
  if (IsEvolutionStrategy(options.algorithm)) return MinimizeByEvolution(checked, problem, options);
  return Search(checked, problem, options).Run();
}

}  // namespace knap
