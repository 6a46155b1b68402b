#include "sim/scenarios/parse_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "sim/scenarios/check_scene.h"
#include "sim/scenarios/default_step.h"
#include "sim/scenarios/nearest_name.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/scenario_paths.h"
#include "sim/scenarios/scene_fields.h"
#include "sim/scenarios/section_keys.h"

namespace knap {
namespace {

std::string DescribeNames(const std::string& given, std::span<const std::string> names) {
  const std::string nearest = FindNearestName(given, names);
  if (!nearest.empty()) return fmt::format("did you mean '{}'?", nearest);
  return fmt::format("expected {}{}", names.size() > 1 ? "one of: " : "", fmt::join(names, ", "));
}

std::string DescribeCount(std::size_t min_size, std::size_t max_size) {
  if (min_size == max_size) return fmt::format("exactly {} elements", min_size);
  return fmt::format("at least {} element{}", min_size, min_size == 1 ? "" : "s");
}

bool IsName(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !text.empty() && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

// What a role that defines or uses names calls them; empty for other roles.
std::string_view CalcNoun(TextRole role) {
  switch (role) {
    case TextRole::kNewBody:
    case TextRole::kBody:
    case TextRole::kBodyOrWorld:
      return "body";
    case TextRole::kNewRope:
      return "rope";
    case TextRole::kBodyOrRope:
      return "body or rope";
    case TextRole::kNewParameter:
    case TextRole::kParameter:
      return "parameter";
    case TextRole::kNewGroup:
    case TextRole::kGroup:
      return "vertex group";
    case TextRole::kNewSignal:
    case TextRole::kSignal:
      return "signal";
    default:
      return {};
  }
}

// Fills a scene from a tree.
class SceneReader final : public FieldVisitor {
 public:
  SceneReader(const ConfigNode& root, ParseResult& result) : result_(result), log_(result.log) {
    frames_.push_back({&root, "", {}, false});
  }

  // False when the tree is no map of keys at all; the scene then says nothing.
  bool Read() {
    if (frames_.back().node->kind != ConfigNode::Kind::kMap) {
      log_.Fail("", frames_.back().node->position, "expected a scenario: keys with values");
      return false;
    }
    if (IsOfAnEarlierSchema()) return false;
    VisitFields(*this, result_.scene);
    CheckUnknownKeys();
    CheckReferences();
    return true;
  }

  void Number(const FieldInfo& info, double& value) override {
    Dimension dimension = info.dimension;
    bool dimension_known = info.dimension_known;
    if (info.dimension_of != nullptr) {
      const NumericKey* key = FindKey(*info.dimension_of);
      dimension_known = key != nullptr;
      if (dimension_known) dimension = key->dimension;
    }
    const std::string range = DescribeRange(info.range, dimension);
    const std::string expected = DescribeQuantity(dimension) + (range.empty() ? "" : ", " + range);
    const ConfigNode* node = TakeScalar(info, expected);
    if (node == nullptr) return;
    const std::optional<Quantity> quantity = ParseQuantity(node->text);
    if (dimension_known && (!quantity || quantity->dimension != dimension)) {
      Fail("expected " + expected);
    } else if (!quantity) {
      Fail("expected a number, with its unit");
    } else if (!info.range.Contains(quantity->value)) {
      Fail("must be " + range);
    } else {
      value = quantity->value;
    }
  }

  void Integer(const FieldInfo& info, std::int64_t& value) override {
    const std::string range = DescribeRange(info.range, kDimensionless);
    const std::string expected = "an integer" + (range.empty() ? "" : ", " + range);
    const ConfigNode* node = TakeScalar(info, expected);
    if (node == nullptr) return;
    const std::optional<std::int64_t> integer = ParseInteger(node->text);
    if (!integer) {
      Fail("expected " + expected);
    } else if (!info.range.Contains(static_cast<double>(*integer))) {
      Fail("must be " + range);
    } else {
      value = *integer;
    }
  }

  void Text(const FieldInfo& info, std::string& value) override {
    const std::string_view noun = CalcNoun(info.role);
    const ConfigNode* node = TakeScalar(info, noun.empty() ? "a text" : fmt::format("the name of a {}", noun));
    if (node == nullptr) return;
    switch (info.role) {
      case TextRole::kProse:
        break;
      case TextRole::kName:
      case TextRole::kNewBody:
      case TextRole::kNewRope:
      case TextRole::kNewParameter:
      case TextRole::kNewGroup:
      case TextRole::kNewSignal:
        if (!Define(info.role, node->text)) return;
        break;
      case TextRole::kBody:
      case TextRole::kBodyOrWorld:
      case TextRole::kBodyOrRope:
      case TextRole::kParameter:
      case TextRole::kGroup:
      case TextRole::kSignal:
        references_.push_back({info.role, node->text, path_, node->position});
        break;
      case TextRole::kFile:
        if (!IsScenarioFilePath(node->text)) {
          Fail(
              "expected a file below the scenario's folder, as a relative path without '..', such as "
              "'meshes/tool.obj'");
          return;
        }
        result_.files.push_back({path_, node->text});
        break;
      case TextRole::kNumericKey:
        CheckNumericKey(node->text);
        break;
    }
    value = node->text;
  }

  void Choice(const FieldInfo& info, const ChoiceAccess& choice) override { ReadChoice(info, choice); }

  void Section(const FieldInfo& info, const SectionAccess& section) override {
    const ConfigNode* node = Take(info, "a section of keys");
    if (node == nullptr) {
      if (info.required) Taint();
      return;
    }
    if (section.optional) section.make();
    if (node->kind != ConfigNode::Kind::kMap) {
      Fail("expected a section " + DescribeKeys(section));
      Taint();
      return;
    }
    frames_.push_back({node, path_, {}, false});
    section.visit(*this);
    CheckUnknownKeys();
    frames_.pop_back();
  }

  void Sequence(const FieldInfo& info, const SequenceAccess& sequence) override {
    const ConfigNode* node = Take(info, "a list in [ ], " + DescribeCount(sequence.min_size, sequence.max_size));
    if (node == nullptr) return;
    const std::string count = DescribeCount(sequence.min_size, sequence.max_size);
    if (node->kind != ConfigNode::Kind::kList) {
      Fail(fmt::format("expected a list{}", sequence.min_size > 0 ? " of " + count : ""));
      return;
    }
    const std::size_t size = node->items.size();
    if (size < sequence.min_size || size > sequence.max_size) {
      Fail(fmt::format("has {} element{}, expected {}", size, size == 1 ? "" : "s", count));
      return;
    }
    sequence.resize(size);
    const std::string path = path_;
    for (std::size_t i = 0; i < size; ++i) {
      frames_.push_back({&node->items[i], path + CalcElementStep(*node, i), {}, false});
      sequence.visit(*this, i);
      frames_.pop_back();
    }
  }

  void Alternatives(const FieldInfo& info, const ChoiceAccess& choice,
                    const std::function<void(FieldVisitor&)>& visit) override {
    if (ReadChoice(info, choice)) {
      visit(*this);
    } else {
      Taint();
    }
  }

 private:
  // What such a file says in keys of its own would come out as a list of unknown ones.
  bool IsOfAnEarlierSchema() {
    const ConfigNode* schema = frames_.back().node->Find("schema");
    if (schema == nullptr || schema->kind != ConfigNode::Kind::kScalar) return false;
    const std::optional<std::int64_t> number = ParseInteger(schema->text);
    if (!number || *number < 1 || *number >= kSceneSchema) return false;
    log_.Fail(
        "schema", schema->position,
        fmt::format("value '{}': a file of an earlier format; this one is {}: docs/migrating.md tells what became "
                    "of its keys",
                    schema->text, kSceneSchema));
    return true;
  }

  // A section, or an element of a list, being read.
  struct Frame {
    const ConfigNode* node;
    std::string path;
    std::vector<std::string> known;  // keys that the section may have
    bool tainted;                    // `known` is incomplete, because a choice failed
  };

  struct Reference {
    TextRole role;
    std::string name;
    std::string path;
    ConfigPosition position;
  };

  // Finds the field in the current section and makes it the current one. Null when it is absent, which is reported if
  // it is required.
  const ConfigNode* Take(const FieldInfo& info, const std::string& expected) {
    Frame& frame = frames_.back();
    node_ = frame.node;
    path_ = frame.path;
    if (!info.key.empty()) {
      frame.known.emplace_back(info.key);
      path_ += path_.empty() ? "" : ".";
      path_ += info.key;
      node_ = frame.node->Find(info.key);
      if (node_ == nullptr) {
        if (info.required) log_.Fail(path_, frame.node->position, "missing; expected " + expected);
        return nullptr;
      }
    }
    if (node_->kind == ConfigNode::Kind::kNull) {
      log_.Fail(path_, node_->position, "has no value; expected " + expected);
      return nullptr;
    }
    log_.Note(path_, node_->position, node_->text);
    return node_;
  }

  const ConfigNode* TakeScalar(const FieldInfo& info, const std::string& expected) {
    const ConfigNode* node = Take(info, expected);
    if (node == nullptr || node->kind == ConfigNode::Kind::kScalar) return node;
    Fail(fmt::format("is a {}, expected {}", node->kind == ConfigNode::Kind::kList ? "list" : "section", expected));
    return nullptr;
  }

  // The current field is wrong.
  void Fail(const std::string& message) { log_.Fail(path_, node_->position, QuoteValue(node_->text) + message); }

  // The keys of the section around may depend on the choice too, as a body's `initial` does on its joint.
  void Taint() {
    frames_.back().tainted = true;
    if (frames_.size() > 1) frames_[frames_.size() - 2].tainted = true;
  }

  bool ReadChoice(const FieldInfo& info, const ChoiceAccess& choice) {
    const std::vector<std::string> names(choice.names.begin(), choice.names.end());
    const ConfigNode* node = TakeScalar(info, fmt::format("one of: {}", fmt::join(names, ", ")));
    if (node == nullptr) return !info.required && frames_.back().node->Find(info.key) == nullptr;
    const auto found = std::find(names.begin(), names.end(), node->text);
    if (found == names.end()) {
      const std::string nearest = FindNearestName(node->text, names);
      Fail(fmt::format("expected one of: {}{}", fmt::join(names, ", "),
                       nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest)));
      return false;
    }
    choice.set(static_cast<std::size_t>(found - names.begin()));
    return true;
  }

  bool Define(TextRole role, const std::string& name) {
    if (!IsName(name)) {
      Fail("expected a name of letters, digits and _ that does not begin with a digit");
      return false;
    }
    const std::string_view noun = CalcNoun(role);
    if (noun.empty()) return true;
    if (role == TextRole::kNewBody && name == kWorldName) {
      Fail("is the name of the world, which every scene has");
      return false;
    }
    std::vector<std::string>& names = names_[noun];
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      Fail(fmt::format("another {} has this name", noun));
      return false;
    }
    names.push_back(name);
    if (role != TextRole::kNewBody && role != TextRole::kNewRope) return true;
    // Bodies and ropes are named side by side.
    std::vector<std::string>& both = names_[CalcNoun(TextRole::kBodyOrRope)];
    if (std::find(both.begin(), both.end(), name) != both.end()) {
      Fail("a body has this name");
      return false;
    }
    both.push_back(name);
    return true;
  }

  void CheckUnknownKeys() {
    const Frame& frame = frames_.back();
    if (frame.tainted) return;
    for (const ConfigEntry& entry : frame.node->entries) {
      if (std::find(frame.known.begin(), frame.known.end(), entry.key) != frame.known.end()) continue;
      const std::string path = frame.path + (frame.path.empty() ? "" : ".") + entry.key;
      log_.Fail(path, entry.position, "unknown key; " + DescribeNames(entry.key, frame.known));
    }
  }

  void CheckReferences() {
    for (const Reference& reference : references_) {
      const std::string_view noun = CalcNoun(reference.role);
      std::vector<std::string> names = names_[noun];
      if (names.empty() && reference.role == TextRole::kSignal) {
        log_.Fail(reference.path, reference.position,
                  fmt::format("{}no such {}; there are none", QuoteValue(reference.name), noun));
      }
      if (names.empty()) continue;  // that none is defined has been reported
      if (reference.role == TextRole::kBodyOrWorld) names.insert(names.begin(), kWorldName);
      if (std::find(names.begin(), names.end(), reference.name) != names.end()) continue;
      log_.Fail(
          reference.path, reference.position,
          fmt::format("{}no such {}; {}", QuoteValue(reference.name), noun, DescribeNames(reference.name, names)));
    }
  }

  // What has been read so far can be named.
  const NumericKey* FindKey(const std::string& path) {
    keys_ = ListNumericKeys(result_.scene);
    const auto found = std::find_if(keys_.begin(), keys_.end(), [&](const NumericKey& k) { return k.path == path; });
    return found == keys_.end() ? nullptr : &*found;
  }

  void CheckNumericKey(const std::string& key) {
    if (const NumericKey* number = FindKey(key)) {
      if (!MayVary(*number))
        Fail(
            "may not vary; numbers of gravity, bodies (but unit and pose of a mesh), contacts, grips, signals, loss "
            "and success may");
      return;
    }
    // They are read after the signals.
    if (path_.starts_with("signals.") && (key.starts_with("loss.") || key.starts_with("success."))) {
      Fail("numbers of the loss and of success cannot be watched; make the goal a part of a signal");
      return;
    }
    // "bodies.pea.initial.position[0]" cannot be found when the pea's joint is wrong: one error is enough.
    const std::size_t element = key.find('.', key.find('.') == key.npos ? 0 : key.find('.') + 1);
    if (log_.HasFailedNear(key.substr(0, element))) return;
    std::vector<std::string> candidates;
    for (const NumericKey& k : keys_) {
      if (MayVary(k)) candidates.push_back(k.path);
    }
    const std::string nearest = FindNearestName(key, candidates);
    Fail("the scene has no such number" + (nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest)));
  }

  ParseResult& result_;
  FieldLog& log_;
  std::vector<Frame> frames_;
  const ConfigNode* node_ = nullptr;  // of the current field
  std::string path_;                  // of the current field
  std::map<std::string_view, std::vector<std::string>> names_;
  std::vector<Reference> references_;
  std::vector<NumericKey> keys_;
};

}  // namespace

ParseResult ParseScene(const std::string& text, const std::string& file_name, std::span<const std::string> overrides,
                       const IncludeReader& read) {
  ParseResult result;
  result.file_name = file_name;
  result.overrides.assign(overrides.begin(), overrides.end());
  std::vector<ConfigError> errors;
  ConfigNode root = ParseConfigTree(text, errors);
  // What a text that is no YAML says about a scene would be guesswork.
  const bool readable = root.kind != ConfigNode::Kind::kNull || errors.empty();
  if (readable && root.kind == ConfigNode::Kind::kNull) root.kind = ConfigNode::Kind::kMap;
  if (readable) result.included = IncludeFiles(&root, read, &errors);
  if (readable) ApplyOverrides(root, overrides, errors);
  result.log = FieldLog(std::move(errors));
  if (!readable) return result;
  if (SceneReader(root, result).Read()) {
    Rollout& rollout = result.scene.rollout;
    if (rollout.step == 0.0) {
      rollout.step = CalcDefaultStep(result.scene);
      if (rollout.integrator != Integrator::kTrBdf2) {
        const std::string paths[] = {"rollout.step", "rollout"};
        result.log.Report(paths, "must be more than 0 s: bdf1 and bdf2 take fixed steps");
      }
    }
    CheckScene(result.scene, result.log);
  }
  return result;
}

}  // namespace knap
