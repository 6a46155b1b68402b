// The files of page/, compiled in, so that the program writes reports wherever it lies.
#pragma once

#include <string>

namespace knap {

std::string GetPageHtml();
std::string GetPageStyle();
std::string GetPageScript();  // all of them in the order of page/scripts.txt

}  // namespace knap
