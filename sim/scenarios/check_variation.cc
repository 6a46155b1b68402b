#include "sim/scenarios/check_variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "sim/math/overloaded.h"
#include "sim/scenarios/apply_variation.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr std::size_t kMostKeysForAllCorners = 8;
constexpr std::size_t kMostKeysForPairs = 64;
// A point between the ends that no round number of steps hits by chance: the golden section.
constexpr double kBetween = 0.38196601125010515;
constexpr double kPi = std::numbers::pi;

// What one varied number can be, and the fields that say so. Of numbers that are drawn together the corners of what
// each can be need not be draws; that they are allowed all the same is a little more than must be.
struct Reach {
  double lower = 0.0, upper = 0.0;
  std::string lower_field, upper_field, key_field;
};

// Of all numbers of one entry; none of a table, whose rows are tried where the file is read.
std::vector<Reach> ListReaches(const Variation& variation, const std::string& path) {
  std::vector<Reach> reaches;
  const bool is_single = variation.keys.size() == 1;
  const auto add = [&](double lower, double upper, const char* lower_field, const char* upper_field) {
    const std::string key = is_single ? path + ".key" : fmt::format("{}.keys[{}]", path, reaches.size());
    reaches.push_back({lower, upper, path + lower_field, path + upper_field, key});
  };
  const auto add_around = [&](const auto& center, double radius) {
    for (const double c : center) add(c - radius, c + radius, ".radius", ".radius");
  };
  const auto add_angles = [&] {
    for (const double most : {kPi, 0.5 * kPi, kPi}) add(-most, most, ".keys", ".keys");
  };
  std::visit(
      Overloaded{[&](const UniformDistribution& d) { add(d.lower, d.upper, ".lower", ".upper"); },
                 [&](const LogUniformDistribution& d) { add(d.lower, d.upper, ".lower", ".upper"); },
                 [&](const NormalDistribution& d) {
                   add(d.mean - d.truncate_at * d.std, d.mean + d.truncate_at * d.std, ".std", ".std");
                 },
                 [&](const ChoiceDistribution& d) {
                   const auto [least, most] = std::minmax_element(d.values.begin(), d.values.end());
                   add(*least, *most, ".values", ".values");
                 },
                 [&](const DiscDistribution& d) { add_around(d.center, d.radius); },
                 [&](const BallDistribution& d) { add_around(d.center, d.radius); },
                 [&](const OrientationDistribution&) { add_angles(); }, [&](const TurnDistribution&) { add_angles(); },
                 [&](const CorrelatedDistribution& d) {
                   for (std::size_t i = 0; i < d.mean.size(); ++i) {
                     const double reach = d.truncate_at * d.std[i];
                     add(d.mean[i] - reach, d.mean[i] + reach, ".std", ".std");
                   }
                 },
                 [](const TableDistribution&) {}},
      variation.distribution);
  return reaches;
}

// Numbers that a rule of check_values.cc ties together lie in one element: a body, a term of the loss, the contacts.
std::string GetElement(const std::string& key) {
  const std::size_t section_end = key.find_first_of(".[");
  const std::string section = key.substr(0, section_end);
  if (section != "bodies" && section != "loss" && section != "signals") return section;
  return key.substr(0, key.find('.', section_end + 1));
}

// Tries draws on a scene that is valid as its file has it.
class DrawTrial {
 public:
  DrawTrial(const Scene& scene, FieldLog& log) : scene_(scene), numbers_(scene_), log_(log) {
    for (std::size_t i = 0; i < scene_.variation.size(); ++i) {
      const Variation& variation = scene_.variation[i];
      const std::vector<Reach> reaches = ListReaches(variation, fmt::format("variation[{}]", i));
      for (std::size_t k = 0; k < variation.keys.size(); ++k) {
        keys_.push_back(variation.keys[k]);
        reaches_.push_back(k < reaches.size() ? std::optional(reaches[k]) : std::nullopt);
      }
    }
  }

  void Run() {
    bool refused = false;
    for (std::size_t i = 0; i < numbers_.size(); ++i) refused = (reaches_[i] && TryAlone(i)) || refused;
    if (refused) return;
    std::map<std::string, std::vector<std::size_t>> elements;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      if (reaches_[i]) elements[GetElement(keys_[i])].push_back(i);
    }
    for (const auto& [name, keys] : elements) TryTogether(keys);
  }

 private:
  // Whether one is refused, which is reported.
  bool TryAlone(std::size_t i) {
    const Reach& reach = *reaches_[i];
    const double between = reach.lower + kBetween * (reach.upper - reach.lower);
    const std::pair<double, std::string> trials[] = {
        {reach.lower, reach.lower_field}, {reach.upper, reach.upper_field}, {between, reach.key_field}};
    const double own = numbers_.Get(i);
    for (const auto& [value, field] : trials) {
      numbers_.Set(i, value);
      const std::optional<DrawRefusal> refusal = numbers_.FindRefusal();
      numbers_.Set(i, own);
      if (!refusal) continue;
      Report(*refusal, {field});
      return true;
    }
    return false;
  }

  void TryTogether(const std::vector<std::size_t>& keys) {
    if (keys.size() <= kMostKeysForAllCorners) {
      TryCorners(keys);
    } else if (keys.size() <= kMostKeysForPairs) {
      for (std::size_t a = 0; a < keys.size(); ++a) {
        for (std::size_t b = a + 1; b < keys.size(); ++b) {
          if (TryCorners({keys[a], keys[b]})) return;
        }
      }
    }
  }

  bool TryCorners(const std::vector<std::size_t>& keys) {
    std::vector<double> own;
    for (const std::size_t i : keys) own.push_back(numbers_.Get(i));
    bool refused = false;
    for (std::size_t corner = 0; corner < (std::size_t{1} << keys.size()) && !refused; ++corner) {
      const auto is_upper = [&](std::size_t k) { return ((corner >> k) & 1) != 0; };
      for (std::size_t k = 0; k < keys.size(); ++k) {
        numbers_.Set(keys[k], is_upper(k) ? reaches_[keys[k]]->upper : reaches_[keys[k]]->lower);
      }
      const std::optional<DrawRefusal> refusal = numbers_.FindRefusal();
      if (!refusal) continue;
      refused = true;
      std::vector<std::string> fields;
      for (std::size_t k = 0; k < keys.size(); ++k) {
        const std::vector<std::size_t>& concerned = refusal->variations;
        if (std::find(concerned.begin(), concerned.end(), keys[k]) == concerned.end()) continue;
        fields.push_back(is_upper(k) ? reaches_[keys[k]]->upper_field : reaches_[keys[k]]->lower_field);
      }
      Report(*refusal, fields);
    }
    for (std::size_t k = 0; k < keys.size(); ++k) numbers_.Set(keys[k], own[k]);
    return refused;
  }

  void Report(const DrawRefusal& refusal, const std::vector<std::string>& fields) {
    log_.Report(fields, "this can be drawn and is not allowed: " + refusal.message);
  }

  Scene scene_;  // of its own: draws are written into it
  VariedNumbers numbers_;
  FieldLog& log_;
  std::vector<std::string> keys_;              // of the numbers
  std::vector<std::optional<Reach>> reaches_;  // none of a table's
};

class VariationChecker {
 public:
  VariationChecker(const Scene& scene, FieldLog& log) : scene_(scene), log_(log) {}

  void Check() {
    Scene scene = scene_;  // keys point into it
    const std::vector<NumericKey> keys = ListNumericKeys(scene);
    std::map<std::string, std::size_t> seen;  // which entry varies a key
    for (std::size_t i = 0; i < scene_.variation.size(); ++i) {
      const Variation& variation = scene_.variation[i];
      const std::string path = fmt::format("variation[{}]", i);
      std::vector<const NumericKey*> numbers;
      for (std::size_t k = 0; k < variation.keys.size(); ++k) {
        const auto [earlier, is_new] = seen.try_emplace(variation.keys[k], i);
        if (!is_new)
          Report({DescribeKey(variation, path, k)}, fmt::format("already varies, see variation[{}]", earlier->second));
        const auto key =
            std::find_if(keys.begin(), keys.end(), [&](const NumericKey& n) { return n.path == variation.keys[k]; });
        if (key != keys.end()) numbers.push_back(&*key);
      }
      // What is no number has been reported.
      if (numbers.size() == variation.keys.size() && !numbers.empty()) CheckDistribution(variation, numbers, path);
    }
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  static std::string DescribeKey(const Variation& variation, const std::string& path, std::size_t k) {
    return variation.keys.size() == 1 ? path + ".key" : fmt::format("{}.keys[{}]", path, k);
  }

  void CheckDistribution(const Variation& variation, const std::vector<const NumericKey*>& numbers,
                         const std::string& path) {
    const Dimension& dimension = numbers.front()->dimension;
    const bool is_table = std::holds_alternative<TableDistribution>(variation.distribution);
    for (std::size_t k = 1; k < numbers.size(); ++k) {
      if (is_table || numbers[k]->dimension == dimension) continue;
      Report({DescribeKey(variation, path, k), path + ".keys"}, "must have the unit of the first key");
      return;
    }
    const auto check_order = [&](double lower, double upper, const Dimension& unit) {
      if (lower <= upper) return true;
      Report({path + ".lower", path + ".upper"}, fmt::format("must be at most upper, {}", FormatQuantity(upper, unit)));
      return false;
    };
    const auto check_angles = [&] {
      if (dimension != kAngle) Report({path + ".keys[0]", path + ".keys"}, "must be the angles of an orientation");
      return dimension == kAngle;
    };
    const bool is_sound =
        std::visit(Overloaded{[&](const UniformDistribution& d) { return check_order(d.lower, d.upper, dimension); },
                              [&](const LogUniformDistribution& d) { return check_order(d.lower, d.upper, dimension); },
                              [&](const OrientationDistribution&) { return check_angles(); },
                              [&](const TurnDistribution& d) {
                                const bool has_axis = d.axis.norm() > 0.0;
                                if (!has_axis) Report({path + ".axis"}, "must not be zero");
                                return has_axis && check_angles() && check_order(d.lower, d.upper, kAngle);
                              },
                              [&](const CorrelatedDistribution& d) { return CheckCorrelated(d, numbers.size(), path); },
                              [](const auto&) { return true; }},
                   variation.distribution);
    if (!is_sound) return;
    const std::vector<Reach> reaches = ListReaches(variation, path);
    for (std::size_t k = 0; k < reaches.size(); ++k) CheckReach(reaches[k], *numbers[k], path);
  }

  bool CheckCorrelated(const CorrelatedDistribution& d, std::size_t count, const std::string& path) {
    const auto check_count = [&](const char* field, std::size_t given, std::size_t wanted) {
      if (given == wanted) return true;
      Report({path + field, path + ".keys"},
             fmt::format("has {} numbers; {} are needed for {} keys", given, wanted, count));
      return false;
    };
    if (!check_count(".mean", d.mean.size(), count) || !check_count(".std", d.std.size(), count) ||
        !check_count(".correlation", d.correlation.size(), count * (count - 1) / 2)) {
      return false;
    }
    if (MakeCorrelationMatrix(d).llt().info() == Eigen::Success) return true;
    Report({path + ".correlation"}, "no numbers can have all these correlations");
    return false;
  }

  void CheckReach(const Reach& reach, const NumericKey& key, const std::string& path) {
    const std::string allowed = DescribeRange(key.range, key.dimension);
    const bool low = !key.range.Contains(reach.lower), high = !key.range.Contains(reach.upper);
    if (reach.lower_field == reach.upper_field) {
      if (!low && !high) return;
      Report(
          {reach.lower_field, path, reach.key_field},
          fmt::format("draws reach from {} to {}, but the key must be {}", FormatQuantity(reach.lower, key.dimension),
                      FormatQuantity(reach.upper, key.dimension), allowed));
      return;
    }
    if (low) Report({reach.lower_field, reach.key_field}, "the key must be " + allowed);
    if (high) Report({reach.upper_field, reach.key_field}, "the key must be " + allowed);
  }

  const Scene& scene_;
  FieldLog& log_;
};

}  // namespace

void CheckVariation(const Scene& scene, FieldLog& log) {
  VariationChecker(scene, log).Check();
  if (log.errors().empty() && !scene.variation.empty()) DrawTrial(scene, log).Run();
}

}  // namespace knap
