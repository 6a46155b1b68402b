#include "sim/scenarios/include_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "sim/scenarios/field_log.h"
#include "sim/scenarios/nearest_name.h"
#include "sim/scenarios/scenario_paths.h"
#include "sim/scenarios/scene.h"

namespace knap {
namespace {

using Kind = ConfigNode::Kind;

// The lists of an included file, and which keys of their elements hold names of bodies and ropes.
struct IncludedList {
  std::string_view key;
  std::array<std::string_view, 2> names;
};
constexpr IncludedList kLists[] = {
    {"bodies", {"name", "parent"}}, {"ropes", {"name", ""}}, {"contacts", {"bodies", ""}}, {"grips", {"body", "held"}}};

void SetFile(ConfigNode* node, int file) {
  node->position.file = file;
  for (ConfigNode& item : node->items) SetFile(&item, file);
  for (ConfigEntry& entry : node->entries) {
    entry.position.file = file;
    SetFile(&entry.value, file);
  }
}

ConfigNode MakeScalar(const ConfigPosition& position, std::string text) {
  ConfigNode node;
  node.kind = Kind::kScalar;
  node.position = position;
  node.text = std::move(text);
  return node;
}

class Includer {
 public:
  Includer(ConfigNode* root, const IncludeReader& read, std::vector<ConfigError>* errors)
      : root_(root), read_(read), errors_(errors) {}

  std::vector<std::string> Include() {
    const auto entry =
        std::find_if(root_->entries.begin(), root_->entries.end(), [](const auto& e) { return e.key == "include"; });
    if (entry == root_->entries.end()) return {};
    const ConfigNode list = std::move(entry->value);
    const ConfigPosition position = entry->position;
    root_->entries.erase(entry);
    if (list.kind != Kind::kList) {
      Fail(position, "include", "expected a list of sections with `file` and `name`");
    } else if (!read_) {
      Fail(position, "include", "files can be included by a scenario file alone");
    } else {
      for (std::size_t i = 0; i < list.items.size(); ++i) Add(list.items[i], fmt::format("include[{}]", i));
    }
    return std::move(files_);
  }

 private:
  void Fail(const ConfigPosition& position, const std::string& field, std::string message) {
    errors_->push_back({position, field, std::move(message)});
  }

  // Of a map whose keys are of `known`; false where it is none.
  bool CheckKeys(const ConfigNode& map, const std::string& path, const std::vector<std::string>& known) {
    if (map.kind != Kind::kMap) {
      Fail(map.position, path, "expected a section of keys");
      return false;
    }
    for (const ConfigEntry& entry : map.entries) {
      if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
      const std::string nearest = FindNearestName(entry.key, known);
      Fail(entry.position, path.empty() ? entry.key : path + "." + entry.key,
           nearest.empty() ? fmt::format("unknown key; expected one of: {}", fmt::join(known, ", "))
                           : fmt::format("unknown key; did you mean '{}'?", nearest));
    }
    return true;
  }

  // The scalar under a key; empty where there is none, which is reported.
  std::string TakeText(const ConfigNode& map, const std::string& path, const std::string& key) {
    const ConfigNode* node = map.Find(key);
    if (node != nullptr && node->kind == Kind::kScalar && !node->text.empty()) return node->text;
    Fail(node == nullptr ? map.position : node->position, path + "." + key, "missing; expected a text");
    return {};
  }

  void Add(const ConfigNode& entry, const std::string& path) {
    if (!CheckKeys(entry, path, {"file", "name", "parent", "position", "orientation_rpy"})) return;
    const std::string file = TakeText(entry, path, "file");
    name_ = TakeText(entry, path, "name");
    if (file.empty() || name_.empty()) return;
    const ConfigPosition at = entry.Find("file")->position;
    if (!IsScenarioFilePath(file)) {
      Fail(at, path + ".file",
           QuoteValue(file) + "expected a file below the scenario's folder, as a relative path without '..'");
      return;
    }
    ConfigNode root;
    try {
      const IncludedText text = read_(file);
      files_.push_back(text.name);
      std::vector<ConfigError> errors;
      root = ParseConfigTree(text.text, errors);
      for (ConfigError& error : errors) {
        error.position.file = static_cast<int>(files_.size()) - 1;
        errors_->push_back(std::move(error));
      }
    } catch (const std::runtime_error& error) {
      Fail(at, path + ".file", fmt::format("{}cannot be read: {}", QuoteValue(file), error.what()));
      return;
    }
    SetFile(&root, static_cast<int>(files_.size()) - 1);
    folder_ = file.substr(0, file.find_last_of('/') == file.npos ? 0 : file.find_last_of('/') + 1);
    AddCarrier(entry);
    Take(&root);
  }

  // The body that carries what the file hangs on the world.
  void AddCarrier(const ConfigNode& entry) {
    const ConfigPosition& at = entry.position;
    ConfigNode joint;
    joint.kind = Kind::kMap;
    joint.position = at;
    joint.entries.push_back({"type", at, MakeScalar(at, "fixed")});
    for (const char* key : {"position", "orientation_rpy"}) {
      if (const ConfigNode* value = entry.Find(key)) joint.entries.push_back({key, value->position, *value});
    }
    ConfigNode body;
    body.kind = Kind::kMap;
    body.position = at;
    body.entries.push_back({"name", at, *entry.Find("name")});
    if (const ConfigNode* parent = entry.Find("parent")) body.entries.push_back({"parent", parent->position, *parent});
    body.entries.push_back({"joint", at, std::move(joint)});
    GetList("bodies", at)->items.push_back(std::move(body));
  }

  ConfigNode* GetList(std::string_view key, const ConfigPosition& at) {
    if (ConfigNode* list = root_->Find(key)) return list;
    ConfigNode list;
    list.kind = Kind::kList;
    list.position = at;
    root_->entries.push_back({std::string(key), at, std::move(list)});
    return &root_->entries.back().value;
  }

  void Take(ConfigNode* root) {
    std::vector<std::string> known{"schema", "description"};
    for (const IncludedList& list : kLists) known.emplace_back(list.key);
    if (root->kind == Kind::kNull || !CheckKeys(*root, "", known)) return;
    const ConfigNode* schema = root->Find("schema");
    if (schema != nullptr && schema->text != fmt::format("{}", kSceneSchema)) {
      Fail(schema->position, "schema", fmt::format("{}expected {}", QuoteValue(schema->text), kSceneSchema));
    }
    for (const IncludedList& list : kLists) {
      ConfigNode* items = root->Find(list.key);
      if (items == nullptr) continue;
      if (items->kind != Kind::kList) {
        Fail(items->position, std::string(list.key), "expected a list");
        continue;
      }
      ConfigNode* target = GetList(list.key, items->position);
      for (ConfigNode& item : items->items) {
        for (const std::string_view key : list.names) Rename(item.Find(key));
        if (list.key == "bodies") CompleteBody(&item);
        target->items.push_back(std::move(item));
      }
    }
  }

  // A name or a list of names; the world keeps its own.
  void Rename(ConfigNode* node) const {
    if (node == nullptr) return;
    if (node->kind == Kind::kScalar && node->text != kWorldName) node->text = name_ + "_" + node->text;
    for (ConfigNode& item : node->items) Rename(&item);
  }

  void CompleteBody(ConfigNode* body) const {
    if (body->kind != Kind::kMap) return;
    if (ConfigNode* parent = body->Find("parent")) {
      if (parent->text == kWorldName) parent->text = name_;
    } else {
      body->entries.push_back({"parent", body->position, MakeScalar(body->position, name_)});
    }
    if (ConfigNode* shapes = body->Find("shapes")) {
      for (ConfigNode& shape : shapes->items) MoveFile(&shape);
    }
    ConfigNode* joint = body->Find("joint");
    ConfigNode* motion = joint == nullptr ? nullptr : joint->Find("motion");
    if (motion != nullptr) MoveFile(motion);
  }

  void MoveFile(ConfigNode* map) const {
    ConfigNode* file = map->Find("file");
    if (file != nullptr && file->kind == Kind::kScalar) file->text = folder_ + file->text;
  }

  ConfigNode* root_;
  const IncludeReader& read_;
  std::vector<ConfigError>* errors_;
  std::vector<std::string> files_;
  // Of the file that is being included.
  std::string name_;
  std::string folder_;
};

}  // namespace

std::vector<std::string> IncludeFiles(ConfigNode* root, const IncludeReader& read, std::vector<ConfigError>* errors) {
  return Includer(root, read, errors).Include();
}

}  // namespace knap
