// A sample scene with one edit, and the place of the error that the edit should cause.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/scenarios/parse_scene.h"

namespace knap {

struct EditedScene {
  std::string text;
  std::string place;  // "line:column" of the mark
};

// Replaces the only occurrence of `original` in `base`; '@' in `edited` marks the place and is taken out.
inline EditedScene EditScene(std::string_view base, std::string_view original, std::string_view edited) {
  const std::size_t at = base.find(original);
  if (at == base.npos || base.find(original, at + 1) != base.npos) {
    throw std::logic_error("not exactly once in the sample: " + std::string(original));
  }
  EditedScene scene;
  scene.text = std::string(base.substr(0, at)) + std::string(edited) + std::string(base.substr(at + original.size()));
  const std::size_t mark = scene.text.find('@');
  if (mark == std::string::npos) return scene;
  scene.text.erase(mark, 1);
  const auto before = scene.text.begin() + static_cast<std::ptrdiff_t>(mark);
  const auto line = 1 + std::count(scene.text.begin(), before, '\n');
  const std::size_t line_begin = mark == 0 ? std::string::npos : scene.text.rfind('\n', mark - 1);
  const std::size_t column = line_begin == std::string::npos ? mark + 1 : mark - line_begin;
  scene.place = std::to_string(line) + ":" + std::to_string(column);
  return scene;
}

struct SceneErrorCase {
  const char* name;
  const char* original;
  const char* edited;
  const char* error;  // what follows "f.yaml:line:column: "
};

inline std::string ParseEditedScene(const EditedScene& scene) {
  return ParseScene(scene.text, "f.yaml").FormatErrors();
}

}  // namespace knap
