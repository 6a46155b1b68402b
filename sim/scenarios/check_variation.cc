#include "sim/scenarios/check_variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "sim/scenarios/apply_variation.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr std::size_t kMostKeysForAllCorners = 8;
constexpr std::size_t kMostKeysForPairs = 64;
// A point between the ends that no round number of steps hits by chance: the golden section.
constexpr double kBetween = 0.38196601125010515;

// What a distribution reaches, and the fields that say so.
struct Reach {
  double lower = 0.0, upper = 0.0;
  std::string lower_field, upper_field;
};

Reach CalcReach(const Variation& variation, const std::string& path) {
  if (const auto* uniform = std::get_if<UniformDistribution>(&variation.distribution)) {
    return {uniform->lower, uniform->upper, path + ".lower", path + ".upper"};
  }
  const NormalDistribution& normal = std::get<NormalDistribution>(variation.distribution);
  const double reach = normal.truncate_at * normal.std;
  return {normal.mean - reach, normal.mean + reach, path + ".std", path + ".std"};
}

// Numbers that a rule of check_values.cc ties together lie in one element: a body, a term of the loss, the contacts.
std::string GetElement(const std::string& key) {
  const std::size_t section_end = key.find_first_of(".[");
  const std::string section = key.substr(0, section_end);
  if (section != "bodies" && section != "loss") return section;
  return key.substr(0, key.find('.', section_end + 1));
}

// Tries draws on a scene that is valid as its file has it.
class DrawTrial {
 public:
  DrawTrial(const Scene& scene, FieldLog& log) : scene_(scene), numbers_(scene_), log_(log) {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      reaches_.push_back(CalcReach(scene_.variation[i], fmt::format("variation[{}]", i)));
    }
  }

  void Run() {
    bool refused = false;
    for (std::size_t i = 0; i < numbers_.size(); ++i) refused = TryAlone(i) || refused;
    if (refused) return;
    std::map<std::string, std::vector<std::size_t>> elements;
    for (std::size_t i = 0; i < numbers_.size(); ++i) elements[GetElement(scene_.variation[i].key)].push_back(i);
    for (const auto& [name, keys] : elements) TryTogether(keys);
  }

 private:
  // Whether one is refused, which is reported.
  bool TryAlone(std::size_t i) {
    const Reach& reach = reaches_[i];
    const double between = reach.lower + kBetween * (reach.upper - reach.lower);
    const std::pair<double, std::string> trials[] = {{reach.lower, reach.lower_field},
                                                     {reach.upper, reach.upper_field},
                                                     {between, fmt::format("variation[{}].key", i)}};
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
        numbers_.Set(keys[k], is_upper(k) ? reaches_[keys[k]].upper : reaches_[keys[k]].lower);
      }
      const std::optional<DrawRefusal> refusal = numbers_.FindRefusal();
      if (!refusal) continue;
      refused = true;
      std::vector<std::string> fields;
      for (std::size_t k = 0; k < keys.size(); ++k) {
        const std::vector<std::size_t>& concerned = refusal->variations;
        if (std::find(concerned.begin(), concerned.end(), keys[k]) == concerned.end()) continue;
        fields.push_back(is_upper(k) ? reaches_[keys[k]].upper_field : reaches_[keys[k]].lower_field);
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
  std::vector<Reach> reaches_;
};

class VariationChecker {
 public:
  VariationChecker(const Scene& scene, FieldLog& log) : scene_(scene), log_(log) {}

  void Check() {
    Scene scene = scene_;  // keys point into it
    const std::vector<NumericKey> keys = ListNumericKeys(scene);
    for (std::size_t i = 0; i < scene_.variation.size(); ++i) {
      const Variation& variation = scene_.variation[i];
      const std::string path = fmt::format("variation[{}]", i);
      for (std::size_t earlier = 0; earlier < i; ++earlier) {
        if (scene_.variation[earlier].key != variation.key) continue;
        Report({path + ".key"}, fmt::format("already varies, see variation[{}]", earlier));
        break;
      }
      const auto key =
          std::find_if(keys.begin(), keys.end(), [&](const NumericKey& k) { return k.path == variation.key; });
      if (key != keys.end()) CheckDistribution(variation, *key, path);
    }
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  void CheckDistribution(const Variation& variation, const NumericKey& key, const std::string& path) {
    const std::string allowed = DescribeRange(key.range, key.dimension);
    if (const auto* uniform = std::get_if<UniformDistribution>(&variation.distribution)) {
      const std::string lower = path + ".lower";
      const std::string upper = path + ".upper";
      if (uniform->lower > uniform->upper) {
        Report({lower, upper}, fmt::format("must be at most upper, {}", FormatQuantity(uniform->upper, key.dimension)));
      }
      if (!key.range.Contains(uniform->lower)) Report({lower, path + ".key"}, "the key must be " + allowed);
      if (!key.range.Contains(uniform->upper)) Report({upper, path + ".key"}, "the key must be " + allowed);
    } else if (const auto* normal = std::get_if<NormalDistribution>(&variation.distribution)) {
      const double reach = normal->truncate_at * normal->std;
      if (!key.range.Contains(normal->mean - reach) || !key.range.Contains(normal->mean + reach)) {
        Report({path + ".mean", path + ".std", path + ".truncate_at", path + ".key"},
               fmt::format("draws reach from {} to {}, but the key must be {}",
                           FormatQuantity(normal->mean - reach, key.dimension),
                           FormatQuantity(normal->mean + reach, key.dimension), allowed));
      }
    }
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
