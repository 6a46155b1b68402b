// One HTML file of the page's text, style and scripts (page/) around one JSON document.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace knap {

// `data` as page/README.md lists it.
std::string MakePage(const nlohmann::ordered_json& data);

// The same page, which asks where it came from for news.
std::string MakeLivePage(const nlohmann::ordered_json& data);

}  // namespace knap
