#include "coordinator/optimizer/evolution_strategy.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "coordinator/random/counter_random.h"
#include "coordinator/random/exact_functions.h"

namespace knap {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kParents = kGeneration / 2;
constexpr std::size_t kStalledGenerations = 10;
// How far the points along the descent lie, in lengths that a sample has on average.
constexpr std::array<double, 2> kAlong = {1.0, 0.25};

// The tutorial's constants for n coordinates (its Table 1).
struct Rates {
  VectorXd weights;  // of the parents
  double mass = 0.0;
  double c_sigma, d_sigma, c_c, c_1, c_mu, expected_length;

  explicit Rates(int n) : weights(kParents) {
    for (int i = 0; i < kParents; ++i) weights(i) = CalcLogarithm(kParents + 0.5) - CalcLogarithm(i + 1.0);
    weights /= weights.sum();
    mass = 1.0 / weights.squaredNorm();
    c_sigma = (mass + 2.0) / (n + mass + 5.0);
    d_sigma = 1.0 + 2.0 * std::max(0.0, std::sqrt((mass - 1.0) / (n + 1.0)) - 1.0) + c_sigma;
    c_c = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
    c_1 = 2.0 / ((n + 1.3) * (n + 1.3) + mass);
    c_mu = std::min(1.0 - c_1, 2.0 * (0.25 + mass + 1.0 / mass - 2.0) / ((n + 2.0) * (n + 2.0) + mass));
    expected_length = std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
  }
};

// What lies beyond [0, 1] as in a mirror: the place inside, and +1 or −1 for the sense in which it moves.
std::pair<double, double> Fold(double y) {
  const double period = y - 2.0 * std::floor(0.5 * y);
  return period <= 1.0 ? std::pair(period, 1.0) : std::pair(2.0 - period, -1.0);
}

class Evolution {
 public:
  Evolution(const Objective& f, const MinimizerProblem& problem, const MinimizerOptions& options)
      : f_(f),
        problem_(problem),
        options_(options),
        along_gradient_(options.algorithm == kEvolutionAlongGradient),
        sigma_(options.first_step) {
    for (std::size_t i = 0; i < problem.start.size(); ++i) {
      if (problem.lower[i] < problem.upper[i]) free_.push_back(i);
    }
    result_ = {.x = problem.start, .value = problem.start_value.value, .evaluations = 1};
    const auto n = static_cast<Eigen::Index>(free_.size());
    mean_.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) mean_(k) = (problem.start[At(k)] - problem.lower[At(k)]) / GetSide(k);
    C_ = B_ = MatrixXd::Identity(n, n);
    spread_ = VectorXd::Ones(n);
    path_sigma_ = path_c_ = VectorXd::Zero(n);
    if (along_gradient_) SetDescent(CalcGradient(mean_, problem.start_value.gradient));
  }

  MinimizerResult Run() {
    if (free_.empty()) return result_;
    const Rates rates(static_cast<int>(free_.size()));
    for (std::uint64_t generation = 0; result_.evaluations < options_.max_evaluations; ++generation) {
      if (!TryGeneration(generation, rates)) break;  // the evaluations end within one
      if (HasConverged()) return result_;
    }
    result_.stop = MinimizerStop::kEvaluations;
    return result_;
  }

 private:
  std::size_t At(Eigen::Index k) const { return free_[static_cast<std::size_t>(k)]; }
  double GetSide(Eigen::Index k) const { return problem_.upper[At(k)] - problem_.lower[At(k)]; }

  std::vector<double> Place(const VectorXd& y) const {
    std::vector<double> x = problem_.start;
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      const std::size_t i = At(k);
      x[i] = std::clamp(problem_.lower[i] + Fold(y(k)).first * GetSide(k), problem_.lower[i], problem_.upper[i]);
    }
    return x;
  }

  // False where it was cut short, and then nothing moved.
  bool TryGeneration(std::uint64_t generation, const Rates& rates) {
    const Eigen::Index n = mean_.size();
    const int count = std::min(kGeneration, options_.max_evaluations - result_.evaluations);
    CounterRandom random(options_.seed, RandomStream::kGenerations, generation);
    MatrixXd steps(n, count);  // C^½ n_k
    std::vector<std::vector<double>> points;
    for (int k = 0; k < count; ++k) {
      VectorXd normal(n);
      for (double& z : normal) z = random.DrawNormal();
      steps.col(k) = B_ * spread_.cwiseProduct(normal);
      if (static_cast<std::size_t>(k) < kAlong.size() && descent_.size() > 0) {
        steps.col(k) = kAlong[static_cast<std::size_t>(k)] * std::sqrt(static_cast<double>(n)) * descent_;
      }
      points.push_back(Place(mean_ + sigma_ * steps.col(k)));
    }
    const std::vector<ObjectiveValue> values = f_(points);
    std::vector<int> order;  // the accepted, by value
    for (int k = 0; k < count; ++k) {
      const ObjectiveValue& value = values[static_cast<std::size_t>(k)];
      ++result_.evaluations;
      if (!value.accepted) {
        ++result_.rejected;
        continue;
      }
      order.push_back(k);
      if (value.value < result_.value) {
        result_.value = value.value;
        result_.x = points[static_cast<std::size_t>(k)];
      }
    }
    if (count < kGeneration) return false;
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return values[static_cast<std::size_t>(a)].value < values[static_cast<std::size_t>(b)].value;
    });
    best_values_.push_back(order.empty() ? std::numeric_limits<double>::infinity()
                                         : values[static_cast<std::size_t>(order.front())].value);
    const VectorXd slope = along_gradient_ ? CalcSlope(steps, values) : VectorXd();
    Adapt(rates, steps, order);
    if (along_gradient_) SetDescent(slope);
    return true;
  }

  void Adapt(const Rates& rates, const MatrixXd& steps, const std::vector<int>& order) {
    const auto parents = std::min<Eigen::Index>(kParents, static_cast<Eigen::Index>(order.size()));
    if (parents == 0) {  // nothing there is to be trusted: nearer to where something was
      sigma_ *= 0.5;
      return;
    }
    const double n = static_cast<double>(mean_.size());
    const double total = rates.weights.head(parents).sum();
    VectorXd shift = VectorXd::Zero(mean_.size());
    MatrixXd rank_mu = MatrixXd::Zero(mean_.size(), mean_.size());
    for (Eigen::Index i = 0; i < parents; ++i) {
      const double w = rates.weights(i) / total;
      const VectorXd step = steps.col(order[static_cast<std::size_t>(i)]);
      shift += w * step;
      rank_mu += w * step * step.transpose();
    }
    mean_ += sigma_ * shift;
    const VectorXd whitened = B_ * (B_.transpose() * shift).cwiseQuotient(spread_);
    path_sigma_ =
        (1.0 - rates.c_sigma) * path_sigma_ + std::sqrt(rates.c_sigma * (2.0 - rates.c_sigma) * rates.mass) * whitened;
    unfilled_ *= (1.0 - rates.c_sigma) * (1.0 - rates.c_sigma);
    const double length = path_sigma_.norm() / std::sqrt(1.0 - unfilled_);
    const bool is_short = length < (1.4 + 2.0 / (n + 1.0)) * rates.expected_length;
    path_c_ = (1.0 - rates.c_c) * path_c_;
    if (is_short) path_c_ += std::sqrt(rates.c_c * (2.0 - rates.c_c) * rates.mass) * shift;
    const double lost = is_short ? 0.0 : rates.c_1 * rates.c_c * (2.0 - rates.c_c);
    C_ = (1.0 - rates.c_1 - rates.c_mu + lost) * C_ + rates.c_1 * path_c_ * path_c_.transpose() + rates.c_mu * rank_mu;
    const double growth = rates.c_sigma / rates.d_sigma * (path_sigma_.norm() / rates.expected_length - 1.0);
    // A box and its mirror images have nothing new to show beyond their own size.
    sigma_ = std::min(sigma_ * CalcExponential(std::min(1.0, growth)), 1.0);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (C_ + C_.transpose()));
    B_ = eigen.eigenvectors();
    spread_ = eigen.eigenvalues().cwiseMax(1e-20).cwiseSqrt();
  }

  // The mean of a generation's gradients in y, each cut to the median of their lengths.
  VectorXd CalcSlope(const MatrixXd& steps, const std::vector<ObjectiveValue>& values) const {
    std::vector<VectorXd> gradients;
    std::vector<double> lengths;
    for (Eigen::Index k = 0; k < steps.cols(); ++k) {
      const ObjectiveValue& value = values[static_cast<std::size_t>(k)];
      if (!value.accepted) continue;
      gradients.push_back(CalcGradient(mean_ + sigma_ * steps.col(k), value.gradient));
      lengths.push_back(gradients.back().norm());
    }
    VectorXd mean = VectorXd::Zero(mean_.size());
    if (gradients.empty()) return mean;
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    for (const VectorXd& g : gradients) mean += g * (g.norm() > *middle ? *middle / g.norm() : 1.0);
    return mean;
  }

  VectorXd CalcGradient(const VectorXd& y, const std::vector<double>& gradient) const {
    VectorXd out(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) out(i) = Fold(y(i)).second * GetSide(i) * gradient[At(i)];
    return out;
  }

  // −C g/√(gᵀ C g), one standard deviation long.
  void SetDescent(const VectorXd& slope) {
    const VectorXd direction = C_ * slope;
    const double size = std::sqrt(slope.dot(direction));
    descent_ = size > 0.0 && std::isfinite(size) ? VectorXd(-direction / size) : VectorXd();
  }

  bool HasConverged() const {
    const double widest = sigma_ * std::sqrt(C_.diagonal().maxCoeff());
    double step = 0.0;
    for (Eigen::Index k = 0; k < mean_.size(); ++k) {
      step = std::max(step, sigma_ * std::sqrt(C_(k, k)) * GetSide(k) / problem_.scale[At(k)]);
    }
    if (step < options_.step_tolerance || widest < 1e-14) return true;
    if (best_values_.size() < kStalledGenerations || options_.value_tolerance == 0.0) return false;
    const auto [least, most] = std::minmax_element(best_values_.end() - kStalledGenerations, best_values_.end());
    return *most - *least <= options_.value_tolerance * std::abs(*least);
  }

  const Objective& f_;
  const MinimizerProblem& problem_;
  const MinimizerOptions& options_;
  const bool along_gradient_;
  std::vector<std::size_t> free_;  // coordinates that are not held
  VectorXd mean_;
  double sigma_;
  MatrixXd C_, B_;  // C = B diag(spread²) Bᵀ
  VectorXd spread_;
  VectorXd path_sigma_, path_c_;
  double unfilled_ = 1.0;            // share of path_sigma_'s variance that its start at zero still lacks
  VectorXd descent_;                 // along which some points of the next generation lie; none where nothing falls
  std::vector<double> best_values_;  // of each generation
  MinimizerResult result_;
};

}  // namespace

bool IsEvolutionStrategy(const std::string& algorithm) {
  return algorithm == kEvolution || algorithm == kEvolutionAlongGradient;
}

MinimizerResult MinimizeByEvolution(const Objective& f, const MinimizerProblem& problem,
                                    const MinimizerOptions& options) {
  return Evolution(f, problem, options).Run();
}

}  // namespace knap
