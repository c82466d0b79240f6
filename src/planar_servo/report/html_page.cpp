#include "planar_servo/report/html_page.h"

#include <fmt/format.h>

namespace planar {
namespace {

constexpr char kStyle[] =
    R"(body{font:16px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;
padding:0 1rem;color:#1a1a1a;background:#fff}h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2rem}
table{border-collapse:collapse;margin:1rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:600;padding:.3rem 0}
th,td{padding:.25rem .8rem;border-bottom:1px solid #ddd;text-align:right}
th:first-child,td:first-child{text-align:left}td:first-child{white-space:nowrap}svg{max-width:100%;height:auto}
figure{margin:1.5rem 0}figcaption{margin-bottom:.4rem}
.verdict{border-left:.5rem solid #2e7d32;background:#f1f7f1;padding:.6rem 1rem;margin:1rem 0}
.verdict p,.verdict ul{margin:.2rem 0}.verdict.bad{border-color:#b3541e;background:#fbf3ee}
@media print{body{margin:0}h2,svg{break-inside:avoid}})";

constexpr char kGenerator[] = "<meta name=\"generator\" content=\"planar-servo\"/>\n";

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

namespace {

/// Returns text for a paragraph, in which lines stay lines and a figure keeps its per cent sign.
std::string flowing(const std::string& text) {
  std::string html = html_escaped(text);
  while (!html.empty() && html.back() == '\n') html.pop_back();
  for (std::size_t at = html.find('\n'); at != std::string::npos; at = html.find('\n', at + 5))
    html.replace(at, 1, "<br/>");
  for (std::size_t at = html.find(" %"); at != std::string::npos; at = html.find(" %", at))
    html.replace(at, 1, "&#160;");
  return html;
}

}  // namespace

HtmlPage::HtmlPage(const std::string& title)
    : title_(title), body_(fmt::format("<h1>{}</h1>\n", html_escaped(title))) {}

void HtmlPage::add_heading(const std::string& text) {
  body_ += fmt::format("<h2>{}</h2>\n", html_escaped(text));
}

void HtmlPage::add_paragraph(const std::string& text) {
  body_ += fmt::format("<p>{}</p>\n", flowing(text));
}

void HtmlPage::add_verdict(const Verdict& verdict) {
  std::string sentence, remedies;
  for (const Verdict::Fault& fault : verdict.faults) {
    sentence += (sentence.empty() ? "" : "; ") + fault.what;
    remedies += fmt::format("<li>{}.</li>", flowing(fault.remedy));
  }
  const bool good = verdict.faults.empty();
  body_ +=
      fmt::format("<div class=\"verdict{}\"><p><b>{}</b> {}.</p>{}</div>\n", good ? "" : " bad",
                  good ? "Good:" : "To be mended:", flowing(good ? verdict.good : sentence),
                  good ? "" : "<ul>" + remedies + "</ul>");
}

std::string HtmlPage::text() const {
  return fmt::format(
      "<!DOCTYPE html>\n<!-- format: planar-servo/page/1 -->\n<html lang=\"en\">\n<head>\n<meta "
      "charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "{}<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      kGenerator, html_escaped(title_), kStyle + style_, body_);
}

}  // namespace planar
