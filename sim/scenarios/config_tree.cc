#include "sim/scenarios/config_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>

#include "sim/scenarios/nearest_name.h"

namespace knap {
namespace {

ConfigPosition MakePosition(const YAML::Mark& mark) {
  ConfigPosition position;
  position.line = mark.line + 1;
  position.column = mark.column + 1;
  return position;
}

// Builds the tree from yaml-cpp's events. Its own Node type would hide duplicate keys and the marks of keys.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::vector<ConfigError>& errors) : errors_(errors) {}

  ConfigNode TakeRoot() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Add(ConfigNode::Kind::kNull, mark, "?", anchor, "null");
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    Refuse(mark, "aliases (*name) are not part of the scenario format");
    Add(ConfigNode::Kind::kNull, mark, "?", 0, "");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Add(ConfigNode::Kind::kScalar, mark, tag, anchor, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(ConfigNode::Kind::kList, mark, tag, anchor);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Open(ConfigNode::Kind::kMap, mark, tag, anchor);
  }
  void OnMapEnd() override { Close(); }

 private:
  // A container under construction; a map takes a key, then the key's value.
  struct Frame {
    ConfigNode node;
    bool has_key = false;
    std::string key;
    ConfigPosition key_position;
  };

  void Refuse(const YAML::Mark& mark, std::string message) {
    errors_.push_back({MakePosition(mark), "", std::move(message)});
  }

  ConfigNode Make(ConfigNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) Refuse(mark, "anchors (&name) are not part of the scenario format");
    if (!tag.empty() && tag != "?" && tag != "!") {
      Refuse(mark, fmt::format("tag '{}': tags are not part of the scenario format", tag));
    }
    ConfigNode node;
    node.kind = kind;
    node.position = MakePosition(mark);
    return node;
  }

  void Add(ConfigNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
           const std::string& text) {
    ConfigNode node = Make(kind, mark, tag, anchor);
    node.text = text;
    Place(std::move(node));
  }

  void Open(ConfigNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    Frame frame;
    frame.node = Make(kind, mark, tag, anchor);
    frames_.push_back(std::move(frame));
  }

  void Close() {
    ConfigNode node = std::move(frames_.back().node);
    frames_.pop_back();
    Place(std::move(node));
  }

  void Place(ConfigNode node) {
    if (frames_.empty()) {
      root_ = std::move(node);
      return;
    }
    Frame& frame = frames_.back();
    if (frame.node.kind == ConfigNode::Kind::kList) {
      frame.node.items.push_back(std::move(node));
    } else if (!frame.has_key) {
      if (node.kind == ConfigNode::Kind::kList || node.kind == ConfigNode::Kind::kMap) {
        errors_.push_back({node.position, "", "a key must be a name, not a list or a map"});
      }
      frame.has_key = true;
      frame.key = std::move(node.text);
      frame.key_position = node.position;
    } else {
      frame.has_key = false;
      if (const ConfigNode* first = frame.node.Find(frame.key)) {
        errors_.push_back({frame.key_position, CalcKeyPath(),
                           fmt::format("duplicate key, first given in line {}", first->position.line)});
        return;
      }
      frame.node.entries.push_back({frame.key, frame.key_position, std::move(node)});
    }
  }

  // The path of the key at hand. A list's element counts by its name when that has been read already.
  std::string CalcKeyPath() const {
    std::string path;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const Frame& frame = frames_[i];
      if (frame.node.kind == ConfigNode::Kind::kMap) {
        if (!path.empty()) path += '.';
        path += frame.key;
        continue;
      }
      const ConfigNode* name = i + 1 < frames_.size() ? frames_[i + 1].node.Find("name") : nullptr;
      path += name != nullptr ? "." + name->text : fmt::format("[{}]", frame.node.items.size());
    }
    return path;
  }

  std::vector<ConfigError>& errors_;
  std::vector<Frame> frames_;
  ConfigNode root_;
};

void SetPosition(ConfigNode& node, const ConfigPosition& position) {
  node.position = position;
  for (ConfigNode& item : node.items) SetPosition(item, position);
  for (ConfigEntry& entry : node.entries) {
    entry.position = position;
    SetPosition(entry.value, position);
  }
}

}  // namespace

const ConfigNode* ConfigNode::Find(std::string_view key) const {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const ConfigEntry& e) { return e.key == key; });
  return found == entries.end() ? nullptr : &found->value;
}

ConfigNode* ConfigNode::Find(std::string_view key) {
  return const_cast<ConfigNode*>(static_cast<const ConfigNode*>(this)->Find(key));
}

std::string CalcElementStep(const ConfigNode& list, std::size_t i) {
  const ConfigNode* name = list.items[i].Find("name");
  if (name != nullptr && name->kind == ConfigNode::Kind::kScalar) return "." + name->text;
  return fmt::format("[{}]", i);
}

ConfigNode ParseConfigTree(const std::string& text, std::vector<ConfigError>& errors) {
  TreeBuilder builder(errors);
  ConfigNode root;
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    const bool has_document = parser.HandleNextDocument(builder);
    TreeBuilder second(errors);
    if (has_document && parser.HandleNextDocument(second)) {
      errors.push_back({second.TakeRoot().position, "", "a scenario file holds one YAML document, this is a second"});
    }
    root = builder.TakeRoot();
  } catch (const YAML::Exception& e) {
    errors.push_back({MakePosition(e.mark), "", fmt::format("not valid YAML: {}", e.msg)});
  }
  return root;
}

namespace {

// One override on its way into the tree.
class Override {
 public:
  Override(std::string_view text, int index, std::vector<ConfigError>& errors) : text_(text), errors_(errors) {
    position_.override_index = index;
  }

  void Apply(ConfigNode& root) {
    const std::size_t equals = text_.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      Fail("", "expected KEY=VALUE, such as 'learning.batch=10'");
      return;
    }
    ConfigNode* target = FindTarget(root, text_.substr(0, equals));
    if (target == nullptr) return;
    const std::string value(text_.substr(equals + 1));
    std::vector<ConfigError> value_errors;
    ConfigNode node = ParseConfigTree(value, value_errors);
    for (const ConfigError& error : value_errors) Fail(error.field, error.message);
    SetPosition(node, position_);
    if (value_errors.empty()) *target = std::move(node);
  }

 private:
  void Fail(const std::string& field, std::string message) {
    errors_.push_back({position_, field, std::move(message)});
  }

  // Walks along `path`, adding what maps lack.
  ConfigNode* FindTarget(ConfigNode& root, std::string_view path) {
    ConfigNode* node = &root;
    std::size_t pos = 0;
    while (node != nullptr && pos < path.size()) {
      const std::string_view walked = path.substr(0, pos);
      if (path[pos] == '[') {
        const std::size_t close = path.find(']', pos);
        const std::string_view index = path.substr(pos + 1, close == path.npos ? path.npos : close - pos - 1);
        if (close == path.npos || index.empty() || index.size() > 6 ||
            index.find_first_not_of("0123456789") != index.npos) {
          Fail(std::string(path), "expected an index such as [0]");
          return nullptr;
        }
        node = FindByIndex(*node, std::stoul(std::string(index)), walked);
        pos = close + 1;
      } else {
        if (path[pos] == '.' && pos > 0) ++pos;
        const std::size_t end = std::min(path.find_first_of(".[", pos), path.size());
        if (end == pos) {
          Fail(std::string(path), "expected a key such as 'learning.batch'");
          return nullptr;
        }
        node = FindByName(*node, path.substr(pos, end - pos), walked);
        pos = end;
      }
    }
    return node;
  }

  ConfigNode* FindByIndex(ConfigNode& node, std::size_t index, std::string_view walked) {
    if (node.kind == ConfigNode::Kind::kList && index < node.items.size()) return &node.items[index];
    Fail(std::string(walked), node.kind == ConfigNode::Kind::kList
                                  ? fmt::format("has {} elements, there is no [{}]", node.items.size(), index)
                                  : fmt::format("is not a list, there is no [{}]", index));
    return nullptr;
  }

  ConfigNode* FindByName(ConfigNode& node, std::string_view name, std::string_view walked) {
    if (node.kind == ConfigNode::Kind::kList) {
      std::vector<std::string> steps;
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        steps.push_back(CalcElementStep(node, i));
        if (steps[i].front() == '.') steps[i].erase(0, 1);
        if (steps[i] == name) return &node.items[i];
      }
      const std::string nearest = FindNearestName(name, steps);
      Fail(std::string(walked), fmt::format("has no element '{}'; {}", name,
                                            nearest.empty() ? fmt::format("it has: {}", fmt::join(steps, ", "))
                                                            : fmt::format("did you mean '{}'?", nearest)));
      return nullptr;
    }
    if (node.kind == ConfigNode::Kind::kScalar) {
      Fail(std::string(walked), fmt::format("is the value '{}', it has no key '{}'", node.text, name));
      return nullptr;
    }
    if (ConfigNode* found = node.Find(name)) return found;
    if (node.kind == ConfigNode::Kind::kNull) node.kind = ConfigNode::Kind::kMap;
    ConfigEntry entry;
    entry.key = name;
    entry.position = position_;
    entry.value.position = position_;
    node.entries.push_back(std::move(entry));
    return &node.entries.back().value;
  }

  std::string_view text_;
  ConfigPosition position_;
  std::vector<ConfigError>& errors_;
};

}  // namespace

void ApplyOverrides(ConfigNode& root, std::span<const std::string> overrides, std::vector<ConfigError>& errors) {
  for (std::size_t i = 0; i < overrides.size(); ++i) {
    Override(overrides[i], static_cast<int>(i), errors).Apply(root);
  }
}

std::string FormatErrors(std::vector<ConfigError> errors, const std::string& file_name,
                         std::span<const std::string> overrides, std::span<const std::string> included) {
  std::stable_sort(errors.begin(), errors.end(),
                   [](const ConfigError& a, const ConfigError& b) { return a.position < b.position; });
  std::string text;
  for (const ConfigError& error : errors) {
    const ConfigPosition& at = error.position;
    const std::string& file = at.file < 0 ? file_name : included[static_cast<std::size_t>(at.file)];
    std::string line = at.override_index < 0
                           ? fmt::format("{}:{}:{}: ", file, at.line, at.column)
                           : fmt::format("command line: {}: ", overrides[static_cast<std::size_t>(at.override_index)]);
    if (!error.field.empty()) line += error.field + ": ";
    line += error.message;
    std::replace(line.begin(), line.end(), '\n', ' ');  // of what it quotes
    text += line + "\n";
  }
  return text;
}

}  // namespace knap
