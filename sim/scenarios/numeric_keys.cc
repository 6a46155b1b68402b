#include "sim/scenarios/numeric_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "sim/scenarios/scene_fields.h"

namespace knap {
namespace {

class NumberCollector final : public FieldVisitor {
 public:
  std::vector<NumericKey> TakeKeys() { return std::move(keys_); }

  void Number(const FieldInfo& info, double& value) override {
    Step step(*this, info.key);
    keys_.push_back({path_, &value, info.dimension, info.range, info.read_once});
  }
  void Integer(const FieldInfo&, std::int64_t&) override {}
  void Text(const FieldInfo&, std::string&) override {}
  void Choice(const FieldInfo&, const ChoiceAccess&) override {}
  void Section(const FieldInfo& info, const SectionAccess& section) override {
    if (!section.present()) return;
    Step step(*this, info.key);
    section.visit(*this);
  }
  void Sequence(const FieldInfo& info, const SequenceAccess& sequence) override {
    Step step(*this, info.key);
    const std::size_t own_size = path_.size();
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const std::string name = sequence.name(i);
      path_ += name.empty() ? fmt::format("[{}]", i) : "." + name;
      sequence.visit(*this, i);
      path_.resize(own_size);
    }
  }
  void Alternatives(const FieldInfo&, const ChoiceAccess&, const std::function<void(FieldVisitor&)>& visit) override {
    visit(*this);
  }

 private:
  // Lengthens the path by a key while it lives.
  class Step {
   public:
    Step(NumberCollector& owner, std::string_view key) : owner_(owner), size_(owner.path_.size()) {
      if (key.empty()) return;
      if (size_ > 0) owner_.path_ += '.';
      owner_.path_ += key;
    }
    ~Step() { owner_.path_.resize(size_); }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    NumberCollector& owner_;
    std::size_t size_;
  };

  std::string path_;
  std::vector<NumericKey> keys_;
};

}  // namespace

std::vector<NumericKey> ListNumericKeys(Scene& scene) {
  NumberCollector collector;
  VisitFields(collector, scene);
  return collector.TakeKeys();
}

std::vector<NumericKey> ListWorldKeys(World& world) {
  NumberCollector collector;
  VisitWorld(collector, world);
  return collector.TakeKeys();
}

std::vector<double*> FindNumericKeys(Scene& scene, std::span<const std::string> paths) {
  const std::vector<NumericKey> keys = ListNumericKeys(scene);
  std::vector<double*> values;
  values.reserve(paths.size());
  for (const std::string& path : paths) {
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const NumericKey& k) { return k.path == path; });
    if (found == keys.end()) throw std::invalid_argument(fmt::format("the scene has no number '{}'", path));
    values.push_back(found->value);
  }
  return values;
}

bool MayVary(const NumericKey& key) {
  if (key.read_once) return false;
  const std::string_view path = key.path;
  const std::string_view section = path.substr(0, path.find_first_of(".["));
  return section == "gravity" || section == "gravity_direction" || section == "bodies" || section == "contacts" ||
         section == "grips" || section == "signals" || section == "loss" || section == "success" ||
         section == "perturbation";
}

}  // namespace knap
