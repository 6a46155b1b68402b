#include "coordinator/learning/variation_draws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <sstream>

#include "coordinator/random/exact_functions.h"

namespace knap {
namespace {

constexpr double kShownDeviations = 3.0;  // of a normal number that is not truncated closer

template <typename... Parts>
std::string Say(const Parts&... parts) {
  std::ostringstream text;
  text.precision(17);
  (text << ... << parts);
  return text.str();
}

bool AreFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

// A unit quaternion, w first.
using Quaternion = std::array<double, 4>;

// Roll, pitch and yaw of its rotation.
void AddAngles(const Quaternion& q, std::vector<double>* values) {
  const auto [w, x, y, z] = q;
  const double r00 = 1.0 - 2.0 * (y * y + z * z), r10 = 2.0 * (x * y + w * z), r20 = 2.0 * (x * z - w * y);
  const double r21 = 2.0 * (y * z + w * x), r22 = 1.0 - 2.0 * (x * x + y * y);
  values->push_back(CalcArcTangent(r21, r22));
  values->push_back(CalcArcTangent(-r20, std::sqrt(r00 * r00 + r10 * r10)));
  values->push_back(CalcArcTangent(r10, r00));
}

// A point of the unit ball of n dimensions, by rejection; its square norm.
double DrawInBall(std::size_t n, CounterRandom& random, std::vector<double>* point) {
  while (true) {
    point->clear();
    double norm2 = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      point->push_back(random.DrawUniform(-1.0, 1.0));
      norm2 += point->back() * point->back();
    }
    if (norm2 <= 1.0) return norm2;
  }
}

// What each kind of draw is: its faults, one number a name, and ranges.
struct Faults {
  std::size_t count;  // of names
  const std::string& name;

  std::string CheckCount(std::size_t wanted) const {
    return count == wanted ? "" : Say("variation ", name, ": ", count, " names for ", wanted, " numbers");
  }
  std::string operator()(const UniformDraw& d) const {
    if (std::isfinite(d.lower) && std::isfinite(d.upper) && d.lower <= d.upper) return CheckCount(1);
    return Say("variation ", name, ": uniform on [", d.lower, ", ", d.upper,
               "]; expected finite values with lower <= upper");
  }
  std::string operator()(const NormalDraw& d) const {
    if (!(std::isfinite(d.mean) && std::isfinite(d.standard_deviation) && d.standard_deviation >= 0.0)) {
      return Say("variation ", name, ": normal with mean ", d.mean, " and standard deviation ", d.standard_deviation,
                 "; expected finite values and a standard deviation >= 0");
    }
    if (d.truncate_at > 0.0) return CheckCount(1);
    return Say("variation ", name, ": normal truncated at ", d.truncate_at, " standard deviations; expected > 0");
  }
  std::string operator()(const LogUniformDraw& d) const {
    if (d.lower > 0.0 && std::isfinite(d.upper) && d.lower <= d.upper) return CheckCount(1);
    return Say("variation ", name, ": log-uniform on [", d.lower, ", ", d.upper,
               "]; expected finite values with 0 < lower <= upper");
  }
  std::string operator()(const ChoiceDraw& d) const {
    if (!d.values.empty() && AreFinite(d.values)) return CheckCount(1);
    return Say("variation ", name, ": a choice among ", d.values.size(), " values; expected finite ones, at least one");
  }
  std::string operator()(const BallDraw& d) const {
    if (AreFinite(d.center) && std::isfinite(d.radius) && d.radius >= 0.0) return CheckCount(d.center.size());
    return Say("variation ", name, ": a ball of radius ", d.radius, "; expected finite values >= 0");
  }
  std::string operator()(const OrientationDraw&) const { return CheckCount(3); }
  std::string operator()(const TurnDraw& d) const {
    const bool has_axis = d.axis[0] != 0.0 || d.axis[1] != 0.0 || d.axis[2] != 0.0;
    if (has_axis && std::isfinite(d.lower) && std::isfinite(d.upper) && d.lower <= d.upper) return CheckCount(3);
    return Say("variation ", name, ": a turn by [", d.lower, ", ", d.upper,
               "]; expected an axis and finite values with lower <= upper");
  }
  std::string operator()(const CorrelatedDraw& d) const {
    const std::size_t n = d.mean.size();
    const bool fits = d.standard_deviation.size() == n && d.factor.size() == n && AreFinite(d.mean) &&
                      AreFinite(d.standard_deviation) && d.truncate_at > 0.0;
    if (fits) return CheckCount(n);
    return Say("variation ", name, ": ", n, " means, ", d.standard_deviation.size(), " deviations, ", d.factor.size(),
               " rows of correlations; expected equal numbers of finite values");
  }
  std::string operator()(const RowDraw& d) const {
    if (d.rows.empty()) return Say("variation ", name, ": a table without a row");
    for (const std::vector<double>& row : d.rows) {
      const std::string fault = CheckCount(row.size());
      if (!fault.empty()) return fault;
      if (!AreFinite(row)) return Say("variation ", name, ": a table with a number that is not finite");
    }
    return {};
  }
};

struct Draws {
  CounterRandom& random;
  std::vector<double>* values;

  void operator()(const UniformDraw& d) const { values->push_back(random.DrawUniform(d.lower, d.upper)); }
  void operator()(const NormalDraw& d) const {
    values->push_back(d.mean + d.standard_deviation * random.DrawTruncatedNormal(d.truncate_at));
  }
  void operator()(const LogUniformDraw& d) const {
    const double x = CalcExponential(random.DrawUniform(CalcLogarithm(d.lower), CalcLogarithm(d.upper)));
    values->push_back(std::clamp(x, d.lower, d.upper));
  }
  void operator()(const ChoiceDraw& d) const { values->push_back(d.values[random.DrawBelow(d.values.size())]); }
  void operator()(const BallDraw& d) const {
    std::vector<double> point;
    DrawInBall(d.center.size(), random, &point);
    for (std::size_t i = 0; i < point.size(); ++i) values->push_back(d.center[i] + d.radius * point[i]);
  }
  // Marsaglia's: two points of discs, the second stretched, are a point of the sphere of four dimensions.
  void operator()(const OrientationDraw&) const {
    std::vector<double> a, b;
    const double a2 = DrawInBall(2, random, &a);
    double b2 = 0.0;
    while (b2 == 0.0) b2 = DrawInBall(2, random, &b);
    const double stretch = std::sqrt((1.0 - a2) / b2);
    AddAngles({a[0], a[1], stretch * b[0], stretch * b[1]}, values);
  }
  void operator()(const TurnDraw& d) const {
    double sine = 0.0, cosine = 0.0;
    CalcSineCosine(0.5 * random.DrawUniform(d.lower, d.upper), &sine, &cosine);
    const auto [x, y, z] = d.axis;
    const double s = sine / std::sqrt(x * x + y * y + z * z);
    AddAngles({cosine, s * x, s * y, s * z}, values);
  }
  void operator()(const CorrelatedDraw& d) const {
    std::vector<double> z(d.mean.size()), own(d.mean.size());
    bool inside = false;
    while (!inside) {
      inside = true;
      for (std::size_t i = 0; i < z.size(); ++i) {
        z[i] = random.DrawNormal();
        own[i] = 0.0;
        for (std::size_t j = 0; j <= i; ++j) own[i] += d.factor[i][j] * z[j];
        inside = inside && std::abs(own[i]) <= d.truncate_at;
      }
    }
    for (std::size_t i = 0; i < z.size(); ++i) values->push_back(d.mean[i] + d.standard_deviation[i] * own[i]);
  }
  void operator()(const RowDraw& d) const {
    const std::vector<double>& row = d.rows[random.DrawBelow(d.rows.size())];
    values->insert(values->end(), row.begin(), row.end());
  }
};

struct Ranges {
  std::vector<DrawRange>* ranges;

  void AddAround(double mean, double deviation, double truncate_at) const {
    const double half = std::min(truncate_at, kShownDeviations) * deviation;
    ranges->push_back({mean - half, mean + half});
  }
  void AddAngleRanges() const {
    for (const double most : {1.0, 0.5, 1.0}) ranges->push_back({-most * std::numbers::pi, most * std::numbers::pi});
  }
  void operator()(const UniformDraw& d) const { ranges->push_back({d.lower, d.upper}); }
  void operator()(const LogUniformDraw& d) const { ranges->push_back({d.lower, d.upper}); }
  void operator()(const NormalDraw& d) const { AddAround(d.mean, d.standard_deviation, d.truncate_at); }
  void operator()(const ChoiceDraw& d) const {
    const auto [least, most] = std::minmax_element(d.values.begin(), d.values.end());
    ranges->push_back({*least, *most});
  }
  void operator()(const BallDraw& d) const {
    for (const double c : d.center) ranges->push_back({c - d.radius, c + d.radius});
  }
  void operator()(const OrientationDraw&) const { AddAngleRanges(); }
  void operator()(const TurnDraw&) const { AddAngleRanges(); }
  void operator()(const CorrelatedDraw& d) const {
    for (std::size_t i = 0; i < d.mean.size(); ++i) AddAround(d.mean[i], d.standard_deviation[i], d.truncate_at);
  }
  void operator()(const RowDraw& d) const {
    for (std::size_t i = 0; i < d.rows.front().size(); ++i) {
      DrawRange range{d.rows.front()[i], d.rows.front()[i]};
      for (const std::vector<double>& row : d.rows) {
        range = {std::min(range.lower, row[i]), std::max(range.upper, row[i])};
      }
      ranges->push_back(range);
    }
  }
};

}  // namespace

std::string FindDrawFault(const VariationKeys& keys) {
  return std::visit(Faults{keys.names.size(), keys.names.front()}, keys.distribution);
}

void DrawVariation(const VariationKeys& keys, CounterRandom& random, std::vector<double>* values) {
  std::visit(Draws{random, values}, keys.distribution);
}

void AddDrawRanges(const VariationKeys& keys, std::vector<DrawRange>* ranges) {
  std::visit(Ranges{ranges}, keys.distribution);
}

}  // namespace knap
