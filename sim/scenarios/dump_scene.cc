#include "sim/scenarios/dump_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/scene_fields.h"

namespace knap {
namespace {

constexpr int kIndent = 2;

// A YAML scalar that reads back as `text`: bare where that is safe everywhere, else in double quotes.
std::string QuoteText(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_plain = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '/' || c == '-';
  };
  const bool reserved = text == "null" || text == "Null" || text == "NULL";
  if (!text.empty() && !reserved && is_letter(text.front()) && std::all_of(text.begin(), text.end(), is_plain)) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned int>(static_cast<unsigned char>(c)));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

class SceneWriter final : public FieldVisitor {
 public:
  explicit SceneWriter(const std::vector<NumericKey>& keys) : keys_(keys) {}

  std::string TakeText() { return std::move(text_); }

  void Number(const FieldInfo& info, double& value) override {
    if (!std::isfinite(value)) return;  // a bound that is none
    Dimension dimension = info.dimension;
    if (info.dimension_of != nullptr) {
      const auto key =
          std::find_if(keys_.begin(), keys_.end(), [&](const NumericKey& k) { return k.path == *info.dimension_of; });
      if (key != keys_.end()) dimension = key->dimension;
    }
    Leaf(info, FormatQuantity(value, dimension));
  }
  void Integer(const FieldInfo& info, std::int64_t& value) override { Leaf(info, fmt::format("{}", value)); }
  void Text(const FieldInfo& info, std::string& value) override { Leaf(info, QuoteText(value)); }
  void Choice(const FieldInfo& info, const ChoiceAccess& choice) override {
    Leaf(info, std::string(choice.names[choice.get()]));
  }

  void Section(const FieldInfo& info, const SectionAccess& section) override {
    if (!section.present()) return;
    if (info.key.empty()) {
      section.visit(*this);
      return;
    }
    Begin(info.key);
    text_ += '\n';
    indent_ += kIndent;
    section.visit(*this);
    indent_ -= kIndent;
  }

  void Sequence(const FieldInfo& info, const SequenceAccess& sequence) override {
    Begin(info.key);
    const std::size_t size = sequence.size();
    if (sequence.of_sections && size > 0) {
      text_ += '\n';
      indent_ += 2 * kIndent;
      for (std::size_t i = 0; i < size; ++i) {
        element_begins_ = true;
        sequence.visit(*this, i);
      }
      indent_ -= 2 * kIndent;
      return;
    }
    text_ += " [";
    for (std::size_t i = 0; i < size; ++i) {
      if (i > 0) text_ += ", ";
      sequence.visit(*this, i);
    }
    text_ += "]\n";
  }

  void Alternatives(const FieldInfo& info, const ChoiceAccess& choice,
                    const std::function<void(FieldVisitor&)>& visit) override {
    Choice(info, choice);
    visit(*this);
  }

 private:
  // "  key:", or "- key:" for the first field of a list's element.
  void Begin(std::string_view key) {
    text_.append(static_cast<std::size_t>(element_begins_ ? indent_ - kIndent : indent_), ' ');
    if (element_begins_) text_ += "- ";
    element_begins_ = false;
    text_ += fmt::format("{}:", key);
  }

  void Leaf(const FieldInfo& info, const std::string& value) {
    if (info.key.empty()) {
      text_ += value;
      return;
    }
    Begin(info.key);
    text_ += fmt::format(" {}\n", value);
  }

  const std::vector<NumericKey>& keys_;
  std::string text_;
  int indent_ = 0;
  bool element_begins_ = false;
};

}  // namespace

std::string DumpScene(const Scene& scene) {
  Scene copy = scene;  // visitors may change what they visit, so they take no const scene
  const std::vector<NumericKey> keys = ListNumericKeys(copy);
  SceneWriter writer(keys);
  VisitFields(writer, copy);
  return writer.TakeText();
}

std::string DumpTask(const Scene& scene) {
  Scene copy = scene;
  const std::vector<NumericKey> keys = ListNumericKeys(copy);
  SceneWriter writer(keys);
  VisitTask(writer, copy);
  return writer.TakeText();
}

std::string DumpBodies(const std::vector<Body>& bodies) {
  std::vector<Body> copy = bodies;
  const std::vector<NumericKey> no_keys;
  SceneWriter writer(no_keys);
  VisitBodies(writer, copy);
  return writer.TakeText();
}

}  // namespace knap
