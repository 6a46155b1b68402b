#include "sim/scenarios/describe_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sim/contact/pair_rules.h"
#include "sim/scenarios/scene_fields.h"

namespace knap {
namespace {

struct Row {
  std::string key;
  std::string type;
  std::string fallback;  // "required", or what holds when the key is left out
  std::string doc;

  bool operator==(const Row&) const = default;
};

struct Table {
  std::string title;
  std::vector<Row> rows;
};

// Collects one table a section. Sections that are met again, in the bodies of other joints, add what is new in them.
class TableCollector final : public FieldVisitor {
 public:
  std::vector<Table> TakeTables() { return std::move(tables_); }

  void Number(const FieldInfo& info, double& value) override {
    const std::string range = DescribeRange(info.range, info.dimension);
    std::string type = "number";
    if (info.dimension_of != nullptr) {
      type = "number in the unit of the key";
    } else if (!info.dimension_is_of.empty()) {
      type = fmt::format("number in the unit of {}", info.dimension_is_of);
    } else if (info.dimension != kDimensionless) {
      type = fmt::format("number in {}", UnitName(info.dimension));
    }
    AddLeaf(info, range.empty() ? type : type + ", " + range,
            std::isfinite(value) ? FormatQuantity(value, info.dimension) : "none");
  }

  void Integer(const FieldInfo& info, std::int64_t& value) override {
    const std::string range = DescribeRange(info.range, kDimensionless);
    AddLeaf(info, range.empty() ? "integer" : "integer, " + range, fmt::format("{}", value));
  }

  void Text(const FieldInfo& info, std::string& value) override {
    AddLeaf(info, CalcTextType(info.role), value.empty() ? "empty" : value);
  }

  void Choice(const FieldInfo& info, const ChoiceAccess& choice) override {
    AddLeaf(info, fmt::format("one of {}", fmt::join(choice.names, ", ")), std::string(choice.names[choice.get()]));
  }

  void Section(const FieldInfo& info, const SectionAccess& section) override {
    if (!section.present()) section.make();
    if (info.key.empty()) {
      section.visit(*this);
      return;
    }
    const char* absent = section.optional ? "none" : "its defaults";
    AddRow(info, "section", info.required ? "required" : absent);
    Enter(
        JoinKey(info.key), [&] { section.visit(*this); }, info.doc);
  }

  void Sequence(const FieldInfo& info, const SequenceAccess& sequence) override {
    if (info.recursive) {
      AddRow(info, "list of sections such as this", info.required ? "required" : "empty");
      return;
    }
    const std::size_t given = sequence.size();
    if (given == 0) sequence.resize(std::max<std::size_t>(1, sequence.min_size));
    if (sequence.of_sections) {
      AddRow(info, "list of sections", info.required ? "required" : "empty");
      Enter(JoinKey(info.key) + "[]",
            [&] {
              for (std::size_t i = 0; i < sequence.size(); ++i) sequence.visit(*this, i);
            },
            {});
      return;
    }
    in_list_ = true;
    element_type_.clear();
    std::string values;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      sequence.visit(*this, i);
      values += (i == 0 ? "" : ", ") + element_value_;
    }
    in_list_ = false;
    const bool fixed = sequence.min_size == sequence.max_size;
    AddRow(info,
           fmt::format("list of {}: {}", fixed ? fmt::format("{}", sequence.min_size) : "any size", element_type_),
           info.required ? "required" : fmt::format("[{}]", values));
  }

  void Alternatives(const FieldInfo& info, const ChoiceAccess& choice,
                    const std::function<void(FieldVisitor&)>& visit) override {
    AddRow(info, fmt::format("one of {}", fmt::join(choice.names, ", ")), "required");
    const std::size_t chosen = choice.get();
    for (std::size_t i = 0; i < choice.names.size(); ++i) {
      choice.set(i);
      Enter(
          path_, [&] { visit(*this); }, fmt::format("{} {}", info.key, choice.names[i]));
    }
    choice.set(chosen);
  }

 private:
  static std::string CalcTextType(TextRole role) {
    switch (role) {
      case TextRole::kProse:
        return "text";
      case TextRole::kName:
      case TextRole::kNewBody:
      case TextRole::kNewRope:
      case TextRole::kNewParameter:
      case TextRole::kNewGroup:
      case TextRole::kNewSignal:
        return "name";
      case TextRole::kBody:
        return "name of a body";
      case TextRole::kBodyOrWorld:
        return "world or name of a body";
      case TextRole::kBodyOrRope:
        return "name of a body or rope";
      case TextRole::kParameter:
        return "name of a parameter";
      case TextRole::kGroup:
        return "name of a vertex group";
      case TextRole::kSignal:
        return "name of a signal";
      case TextRole::kFile:
        return "file, relative to the scenario's";
      case TextRole::kNumericKey:
        return "path of a number";
    }
    return {};
  }

  std::string JoinKey(std::string_view key) const {
    return fmt::format("{}{}{}", path_, path_.empty() ? "" : ".", key);
  }

  void AddLeaf(const FieldInfo& info, const std::string& type, const std::string& value) {
    if (in_list_) {
      element_type_ = type;
      element_value_ = value;
      return;
    }
    AddRow(info, type, info.required ? "required" : value);
  }

  void AddRow(const FieldInfo& info, const std::string& type, const std::string& fallback) {
    const auto table =
        std::find_if(tables_.begin(), tables_.end(), [this](const Table& t) { return t.title == title_; });
    Row row{std::string(info.key), type, fallback, std::string(info.doc)};
    if (table == tables_.end()) {
      tables_.push_back({title_, {std::move(row)}});
    } else if (std::find(table->rows.begin(), table->rows.end(), row) == table->rows.end()) {
      table->rows.push_back(std::move(row));
    }
  }

  // Visits a section under its path, with a remark that tells it from others with the same path.
  template <class Visit>
  void Enter(std::string path, const Visit& visit, std::string_view remark) {
    const std::string outer_path = std::exchange(path_, std::move(path));
    const std::string outer_title = title_;
    title_ = remark.empty() ? fmt::format("`{}`", path_) : fmt::format("`{}`: {}", path_, remark);
    visit();
    path_ = outer_path;
    title_ = outer_title;
  }

  std::string path_;
  std::string title_ = "The file";
  bool in_list_ = false;
  std::string element_type_;  // of a list of leaves, and the last element's value
  std::string element_value_;
  std::vector<Table> tables_;
};

std::string DescribePairs() {
  std::string text =
      "## Shapes that touch\n\n"
      "A contact is between every shape of the one body and every shape of the other. A mesh that is not convex "
      "touches as\n"
      "its convex pieces, and so does a designed one against another that is designed.\n\n| |";
  for (const std::string_view name : kTouchingKindNames) text += fmt::format(" {} |", name);
  text += "\n|---|";
  for (std::size_t i = 0; i < kTouchingKindNames.size(); ++i) text += "---|";
  text += '\n';
  for (std::size_t i = 0; i < kTouchingKindNames.size(); ++i) {
    text += fmt::format("| **{}** |", kTouchingKindNames[i]);
    for (std::size_t j = 0; j < kTouchingKindNames.size(); ++j) {
      const PairRule rule = FindPairRule(static_cast<TouchingKind>(i), static_cast<TouchingKind>(j));
      text += rule == PairRule::kNone ? " – |" : " yes |";
    }
    text += '\n';
  }
  return text;
}

// Of what is gone before the fields are read (include_files.h).
constexpr const char* kIncludes =
    "## `include[]`\n\n"
    "A scenario may take over the bodies, ropes, contacts and grips of other files, `knap import` writes such ones. "
    "All\n"
    "their names get `name` and an underscore in front; overrides and variations see `bodies.arm_hand.joint`. A file "
    "that\n"
    "is included has these four lists, `schema` and `description` and nothing else, and includes nothing itself. "
    "Files\n"
    "that it names are relative to its own folder.\n\n"
    "| key | value | if left out | meaning |\n|---|---|---|---|\n"
    "| `file` | file, relative to the scenario's | required | that is included |\n"
    "| `name` | name | required | of the body that carries what the file hangs on `world`, and first part of all names "
    "|\n"
    "| `parent` | world or name of a body | world | to which that body is fixed |\n"
    "| `position` | list of 3: number in m | [0 m, 0 m, 0 m] | of that body in the parent |\n"
    "| `orientation_rpy` | list of 3: number in rad | [0 rad, 0 rad, 0 rad] | likewise: roll, pitch, yaw |\n\n";

}  // namespace

std::string DescribeSceneFormat() {
  // One body for each joint: which initial state a body has depends on it.
  Scene scene;
  const auto add = [&](const auto& kind) { scene.bodies.emplace_back().joint.kind = kind; };
  add(FixedJoint{});
  add(RevoluteJoint{});
  add(PrismaticJoint{});
  add(BallJoint{});
  add(PlanarJoint{});
  add(FreeJoint{});
  TableCollector collector;
  VisitFields(collector, scene);
  std::string text =
      "# Scenario files\n\n"
      "The reference of the format, written by `knap validate --describe`. A scenario is one YAML file of maps, lists "
      "and\n"
      "scalars; `configs/pushing.yaml` is an example. Quantities carry their unit, such as `10 mm` or `-9.81 m/s^2`, "
      "and\n"
      "units combine names with `*`, `/` and integer powers; angles are in `rad` or `deg`. Names of files are relative "
      "to\n"
      "the scenario's folder; what is not there under `library/` is looked for in the nearest folder `library` above, "
      "which\n"
      "scenarios share. `knap validate FILE` reports everything that is wrong in a file, with line and column.\n\n";
  for (const Table& table : collector.TakeTables()) {
    text += fmt::format("## {}\n\n| key | value | if left out | meaning |\n|---|---|---|---|\n", table.title);
    for (const Row& row : table.rows) {
      text += fmt::format("| `{}` | {} | {} | {} |\n", row.key, row.type, row.fallback, row.doc);
    }
    text += '\n';
  }
  return text + kIncludes + DescribePairs();
}

}  // namespace knap
