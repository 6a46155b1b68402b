// How structs describe their fields once, for everyone who walks over them: reading, writing, finding numbers by path,
// documentation.
//
// A struct T has a function VisitFields(FieldVisitor&, T&) that calls the visitor once for each field. A field is a
// leaf (Number, Integer, Text, Choice), a section (a map of fields), or a sequence of either. A std::variant is an
// Alternatives: the key `type` of the current section chooses which further fields the section has.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/scenarios/units.h"

namespace knap {

// Numbers x with lower ≤ x ≤ upper, or lower < x where `above`.
struct Range {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool above = false;

  bool Contains(double x) const { return (above ? x > lower : x >= lower) && x <= upper; }
};

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr Range kAnyNumber{};
inline constexpr Range kPositive{0.0, kInfinity, true};
inline constexpr Range kNonNegative{0.0, kInfinity, false};

// "more than 0", "from 0 m to 1 m"; empty for kAnyNumber. Bounds are in SI.
std::string DescribeRange(const Range& range, const Dimension& dimension);

// What a text stands for, and so what it may be.
enum class TextRole {
  kProse,    // anything
  kName,     // letters, digits, _; no digit first
  kNewBody,  // a name that bodies are known by from here on; likewise below
  kNewParameter,
  kNewGroup,
  kBody,  // the name of a body
  kBodyOrWorld,
  kNewRope,
  kBodyOrRope,
  kNewSignal,
  kSignal,
  kParameter,
  kGroup,
  kFile,        // a path relative to the scenario file, without ".."
  kNumericKey,  // the path of a number of the scene
};

struct FieldInfo {
  std::string_view key = {};                  // empty: the element of a sequence itself
  std::string_view doc = {};                  // one line for the reader of the documentation
  bool required = true;                       // else the file may leave it out, and the value that is there stays
  Dimension dimension = {};                   // of a Number
  bool dimension_known = true;                // else a Number may have any
  std::string_view dimension_is_of = {};      // for the documentation, where the dimension depends on something
  const std::string* dimension_of = nullptr;  // set: a Number has the dimension of the number at this path instead
  Range range = {};                           // of a Number or Integer
  bool read_once = false;                     // a Number that no variation may change
  TextRole role = TextRole::kProse;           // of a Text
  bool recursive = false;                     // the elements of a Sequence are such as this one stands in
};

// One of several names.
struct ChoiceAccess {
  std::span<const std::string_view> names;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

class FieldVisitor;

// A map of fields that may be absent.
struct SectionAccess {
  bool optional = false;          // absence means something; else the section is always there
  std::function<bool()> present;  // always true unless optional
  std::function<void()> make;     // makes an optional section present, with its defaults
  std::function<void(FieldVisitor&)> visit;
};

struct SequenceAccess {
  bool of_sections = false;
  std::size_t min_size = 0;
  std::size_t max_size = std::numeric_limits<std::size_t>::max();
  std::function<std::size_t()> size;
  std::function<void(std::size_t)> resize;       // only to sizes within the bounds
  std::function<std::string(std::size_t)> name;  // of element i; empty where elements have none
  std::function<void(FieldVisitor&, std::size_t)> visit;
};

class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  virtual void Number(const FieldInfo& info, double& value) = 0;
  virtual void Integer(const FieldInfo& info, std::int64_t& value) = 0;
  virtual void Text(const FieldInfo& info, std::string& value) = 0;
  virtual void Choice(const FieldInfo& info, const ChoiceAccess& choice) = 0;
  virtual void Section(const FieldInfo& info, const SectionAccess& section) = 0;
  virtual void Sequence(const FieldInfo& info, const SequenceAccess& sequence) = 0;
  // The fields of the chosen alternative stand in the same section as the choice itself, which is required.
  virtual void Alternatives(const FieldInfo& info, const ChoiceAccess& choice,
                            const std::function<void(FieldVisitor&)>& visit) = 0;

  // The rest puts C++ types into these terms.

  template <class Enum>
  void EnumField(const FieldInfo& info, Enum& value, std::span<const std::string_view> names) {
    Choice(info, {names, [&value] { return static_cast<std::size_t>(value); },
                  [&value](std::size_t i) { value = static_cast<Enum>(i); }});
  }

  template <class T>
  void Struct(const FieldInfo& info, T& value) {
    Group(info, [&value](FieldVisitor& v) { VisitFields(v, value); });
  }

  // A section that is always there, of whatever fields visit(visitor) visits.
  template <class Visit>
  void Group(const FieldInfo& info, const Visit& visit) {
    Section(info, {false, [] { return true; }, [] {}, visit});
  }

  template <class T>
  void OptionalStruct(const FieldInfo& info, std::optional<T>& value) {
    OptionalStruct(info, value, [](FieldVisitor& v, T& present) { VisitFields(v, present); });
  }

  // The same for a struct whose fields need more than itself: visit(visitor, struct).
  template <class T, class Visit>
  void OptionalStruct(const FieldInfo& info, std::optional<T>& value, const Visit& visit) {
    Section(info, {true, [&value] { return value.has_value(); }, [&value] { value.emplace(); },
                   [&value, visit](FieldVisitor& v) { visit(v, *value); }});
  }

  template <class T>
  void StructList(const FieldInfo& info, std::vector<T>& items, std::size_t min_size = 0) {
    StructList(info, items, min_size, [](FieldVisitor& v, T& item) { VisitFields(v, item); });
  }

  // The same for structs whose fields need more than themselves: visit(visitor, struct).
  template <class T, class Visit>
  void StructList(const FieldInfo& info, std::vector<T>& items, std::size_t min_size, const Visit& visit) {
    SequenceAccess access;
    access.of_sections = true;
    access.min_size = min_size;
    access.size = [&items] { return items.size(); };
    access.resize = [&items](std::size_t n) { items.resize(n); };
    access.name = [&items](std::size_t i) -> std::string {
      static_cast<void>(i);
      if constexpr (requires { items[i].name; }) {
        return items[i].name;
      } else {
        return {};
      }
    };
    access.visit = [&items, visit](FieldVisitor& v, std::size_t i) {
      v.Group({}, [&items, &visit, i](FieldVisitor& w) { visit(w, items[i]); });
    };
    Sequence(info, access);
  }

  // A list of leaves with a fixed size: an Eigen vector or a std::array.
  template <class Items, class VisitLeaf>
  void FixedList(const FieldInfo& info, Items& items, const VisitLeaf& visit_leaf) {
    const std::size_t size = static_cast<std::size_t>(items.size());
    VisitLeaves(info, items, size, size, visit_leaf);
  }

  // A list of leaves of any size from min_size on.
  template <class T, class VisitLeaf>
  void LeafList(const FieldInfo& info, std::vector<T>& items, std::size_t min_size, const VisitLeaf& visit_leaf) {
    VisitLeaves(info, items, min_size, std::numeric_limits<std::size_t>::max(), visit_leaf);
  }

  // A vector of numbers with one dimension and range.
  template <class Vector>
  void Numbers(const FieldInfo& info, Vector& vector) {
    FixedList(info, vector, [info](FieldVisitor& v, double& x) {
      FieldInfo element = info;
      element.key = {};
      v.Number(element, x);
    });
  }

  // `names` are those of the variant's alternatives, in their order; `info.key` is "type" or another key.
  template <class... Types>
  void OneOf(const FieldInfo& info, std::variant<Types...>& value, const std::string_view (&names)[sizeof...(Types)]) {
    OneOf(info, value, names, [](FieldVisitor& v, auto& alternative) { VisitFields(v, alternative); });
  }

  // The same, for alternatives whose fields need more than themselves: visit_alternative(visitor, alternative).
  template <class... Types, class VisitAlternative>
  void OneOf(const FieldInfo& info, std::variant<Types...>& value, const std::string_view (&names)[sizeof...(Types)],
             const VisitAlternative& visit_alternative) {
    Alternatives(info,
                 {names, [&value] { return value.index(); },
                  [&value](std::size_t i) {
                    using Variant = std::variant<Types...>;
                    static constexpr std::array<void (*)(Variant&), sizeof...(Types)> kMake{
                        [](Variant& v) { v.template emplace<Types>(); }...};
                    if (value.index() != i) kMake[i](value);
                  }},
                 [&value, visit_alternative](FieldVisitor& v) {
                   std::visit([&v, &visit_alternative](auto& alternative) { visit_alternative(v, alternative); },
                              value);
                 });
  }

 private:
  template <class Items, class VisitLeaf>
  void VisitLeaves(const FieldInfo& info, Items& items, std::size_t min_size, std::size_t max_size,
                   const VisitLeaf& visit_leaf) {
    SequenceAccess access;
    access.min_size = min_size;
    access.max_size = max_size;
    access.size = [&items] { return static_cast<std::size_t>(items.size()); };
    access.resize = [&items](std::size_t n) {
      static_cast<void>(n);
      if constexpr (requires { items.push_back(items[0]); }) items.resize(n);
    };
    access.name = [](std::size_t) { return std::string(); };
    access.visit = [&items, visit_leaf](FieldVisitor& v, std::size_t i) {
      using Index = decltype(items.size());
      visit_leaf(v, items[static_cast<Index>(i)]);
    };
    Sequence(info, access);
  }
};

}  // namespace knap
