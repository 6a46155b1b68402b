#include "coordinator/report/report_page.h"

#include <stdexcept>

#include "coordinator/report/page_text.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

void Replace(const std::string& mark, const std::string& text, std::string* page) {
  const std::size_t at = page->find(mark);
  if (at == std::string::npos) throw std::logic_error("the report's page has no " + mark);
  page->replace(at, mark.size(), text);
}

// `may_fetch`: what its policy allows beside its own text.
std::string MakePageThat(const std::string& may_fetch, const nlohmann::ordered_json& data) {
  std::string text = MakeJsonText(data, -1);
  // In a script element an end tag, or the beginning of a comment, would be taken for markup.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  std::string page = GetPageHtml();
  Replace("<!--knap:fetch-->", may_fetch, &page);
  Replace("<!--knap:style-->", "<style>\n" + GetPageStyle() + "</style>", &page);
  Replace("<!--knap:data-->", "<script type=\"application/json\" id=\"data\">" + text + "</script>", &page);
  Replace("<!--knap:script-->", "<script>\n" + GetPageScript() + "</script>", &page);
  return page;
}

}  // namespace

std::string MakePage(const nlohmann::ordered_json& data) { return MakePageThat("", data); }

std::string MakeLivePage(const nlohmann::ordered_json& data) { return MakePageThat("connect-src 'self'; ", data); }

}  // namespace knap
