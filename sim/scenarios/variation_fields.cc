#include "sim/scenarios/variation_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {
namespace {

constexpr std::string_view kExample = "of the number that varies, such as `bodies.pea.initial.position[0]`";

void VisitKey(FieldVisitor& v, Variation& x) {
  x.keys.resize(1);
  v.Text({.key = "key", .doc = kExample, .role = TextRole::kNumericKey}, x.keys[0]);
}

// `count` of them; 0: any number from 1 on.
void VisitKeys(FieldVisitor& v, std::size_t count, std::string_view doc, Variation& x) {
  const auto visit = [](FieldVisitor& w, std::string& key) { w.Text({.role = TextRole::kNumericKey}, key); };
  if (count == 0) {
    v.LeafList({.key = "keys", .doc = doc}, x.keys, 1, visit);
    return;
  }
  x.keys.resize(count);
  v.FixedList({.key = "keys", .doc = doc}, x.keys, visit);
}

// The numbers of a distribution have the dimension of the first key.
const std::string& GetFirst(const Variation& x) {
  static const std::string kNone;
  return x.keys.empty() ? kNone : x.keys.front();
}

void VisitTruncation(FieldVisitor& v, double& truncate_at) {
  v.Number({.key = "truncate_at",
            .doc = "largest distance from the mean, in standard deviations",
            .required = false,
            .range = {0.0, 10.0, true}},
           truncate_at);
}

void VisitNumbers(FieldVisitor& v, std::string_view key, std::string_view doc, const Variation& x, const Range& range,
                  std::vector<double>& numbers) {
  v.LeafList({.key = key, .doc = doc}, numbers, 1, [&x, range](FieldVisitor& w, double& number) {
    w.Number({.dimension_of = &GetFirst(x), .range = range}, number);
  });
}

void VisitDistribution(FieldVisitor& v, Variation& x, UniformDistribution& d) {
  VisitKey(v, x);
  v.Number({.key = "lower", .doc = "least value", .dimension_of = &GetFirst(x)}, d.lower);
  v.Number({.key = "upper", .doc = "largest value", .dimension_of = &GetFirst(x)}, d.upper);
}

void VisitDistribution(FieldVisitor& v, Variation& x, NormalDistribution& d) {
  VisitKey(v, x);
  v.Number({.key = "mean", .doc = "of the values", .dimension_of = &GetFirst(x)}, d.mean);
  v.Number({.key = "std",
            .doc = "standard deviation before truncation",
            .dimension_of = &GetFirst(x),
            .range = kNonNegative},
           d.std);
  VisitTruncation(v, d.truncate_at);
}

void VisitDistribution(FieldVisitor& v, Variation& x, LogUniformDistribution& d) {
  VisitKey(v, x);
  v.Number({.key = "lower", .doc = "least value", .dimension_of = &GetFirst(x), .range = kPositive}, d.lower);
  v.Number({.key = "upper", .doc = "largest value", .dimension_of = &GetFirst(x), .range = kPositive}, d.upper);
}

void VisitDistribution(FieldVisitor& v, Variation& x, ChoiceDistribution& d) {
  VisitKey(v, x);
  VisitNumbers(v, "values", "that may be drawn", x, kAnyNumber, d.values);
}

template <class RoundDistribution>
void VisitRound(FieldVisitor& v, Variation& x, RoundDistribution& d) {
  v.Numbers({.key = "center", .doc = "of the points", .dimension_of = &GetFirst(x)}, d.center);
  v.Number({.key = "radius", .doc = "around it", .dimension_of = &GetFirst(x), .range = kNonNegative}, d.radius);
}

void VisitDistribution(FieldVisitor& v, Variation& x, DiscDistribution& d) {
  VisitKeys(v, 2, "two, of one unit", x);
  VisitRound(v, x, d);
}

void VisitDistribution(FieldVisitor& v, Variation& x, BallDistribution& d) {
  VisitKeys(v, 3, "three, of one unit", x);
  VisitRound(v, x, d);
}

constexpr std::string_view kAngles =
    "roll, pitch and yaw, such as `bodies.box.initial.orientation_rpy[0]` and the others";

void VisitDistribution(FieldVisitor& v, Variation& x, OrientationDistribution&) { VisitKeys(v, 3, kAngles, x); }

void VisitDistribution(FieldVisitor& v, Variation& x, TurnDistribution& d) {
  VisitKeys(v, 3, kAngles, x);
  v.Numbers({.key = "axis", .doc = "about which it turns"}, d.axis);
  v.Number({.key = "lower", .doc = "least angle", .dimension = kAngle}, d.lower);
  v.Number({.key = "upper", .doc = "largest angle", .dimension = kAngle}, d.upper);
}

void VisitDistribution(FieldVisitor& v, Variation& x, CorrelatedDistribution& d) {
  VisitKeys(v, 0, "of one unit", x);
  VisitNumbers(v, "mean", "one for each key", x, kAnyNumber, d.mean);
  VisitNumbers(v, "std", "standard deviations before truncation, one for each key", x, kNonNegative, d.std);
  v.LeafList({.key = "correlation",
              .doc = "of each pair of keys: of the first with all later ones, then of the second, and so on"},
             d.correlation, 0, [](FieldVisitor& w, double& number) {
               w.Number({.range = {-1.0, 1.0}}, number);
             });
  VisitTruncation(v, d.truncate_at);
}

void VisitDistribution(FieldVisitor& v, Variation& x, TableDistribution& d) {
  VisitKeys(v, 0, "the names of columns", x);
  v.Text({.key = "file",
          .doc = "CSV: a line of column names, then rows of numbers in SI units, one of which is drawn",
          .role = TextRole::kFile},
         d.file);
}

}  // namespace

void VisitFields(FieldVisitor& v, Variation& x) {
  v.OneOf({.key = "distribution",
           .doc = "of one number: uniform, normal, log_uniform (its logarithm is uniform), choice (one of a list); of "
                  "several together: a point of a disc or ball, an orientation (any, or a turn about an axis), "
                  "correlated normal numbers, a row of a table"},
          x.distribution,
          {"uniform", "normal", "log_uniform", "choice", "disc", "ball", "orientation", "turn", "correlated", "table"},
          [&x](FieldVisitor& w, auto& distribution) { VisitDistribution(w, x, distribution); });
}

std::vector<std::string> ListVariedKeys(const std::vector<Variation>& variation) {
  std::vector<std::string> keys;
  for (const Variation& x : variation) keys.insert(keys.end(), x.keys.begin(), x.keys.end());
  return keys;
}

Eigen::MatrixXd MakeCorrelationMatrix(const CorrelatedDistribution& distribution) {
  const auto n = static_cast<Eigen::Index>(distribution.mean.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i + 1; j < n; ++j) matrix(i, j) = matrix(j, i) = distribution.correlation[next++];
  }
  return matrix;
}

}  // namespace knap
