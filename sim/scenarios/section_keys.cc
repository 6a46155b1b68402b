#include "sim/scenarios/section_keys.h"

#include <fmt/format.h>

namespace knap {

namespace {

class KeyCollector final : public FieldVisitor {
 public:
  std::vector<std::string> keys;

  void Number(const FieldInfo& info, double&) override { Note(info); }
  void Integer(const FieldInfo& info, std::int64_t&) override { Note(info); }
  void Text(const FieldInfo& info, std::string&) override { Note(info); }
  void Choice(const FieldInfo& info, const ChoiceAccess&) override { Note(info); }
  void Section(const FieldInfo& info, const SectionAccess&) override { Note(info); }
  void Sequence(const FieldInfo& info, const SequenceAccess&) override { Note(info); }

  // What the others are follows from this one.
  void Alternatives(const FieldInfo& info, const ChoiceAccess& choice,
                    const std::function<void(FieldVisitor&)>&) override {
    keys.push_back(fmt::format("{} ({})", info.key, fmt::join(choice.names, ", ")));
  }

 private:
  void Note(const FieldInfo& info) {
    keys.push_back(info.required ? std::string(info.key) : fmt::format("[{}]", info.key));
  }
};

}  // namespace

std::string DescribeKeys(const SectionAccess& section) {
  KeyCollector collector;
  section.visit(collector);
  const std::vector<std::string>& keys = collector.keys;
  if (keys.size() == 1) return "with the key " + keys.front();
  std::string text = "with the keys ";
  for (std::size_t i = 0; i < keys.size(); ++i) {
    text += i == 0 ? "" : i + 1 == keys.size() ? " and " : ", ";
    text += keys[i];
  }
  return text;
}

}  // namespace knap
