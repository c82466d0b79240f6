#include "planar_servo/report/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

namespace planar {
namespace {

constexpr char kStyle[] =
    R"(body{font:16px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;
padding:0 1rem;color:#1a1a1a;background:#fff;overflow-wrap:break-word}
h1{font-size:1.6rem}h2{font-size:1.3rem;margin-top:2.2rem}h3{font-size:1.05rem;margin:1.6rem 0 0}
p,li,figcaption,.verdict{max-width:48rem}
a{color:#0b4f8a}:focus-visible{outline:3px solid #0b4f8a;outline-offset:2px}
td,th{overflow-wrap:anywhere}.wide{overflow-x:auto}.wide :is(td,th){overflow-wrap:normal}
table{border-collapse:collapse;margin:1rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:600;padding:.3rem 0}
th,td{padding:.25rem .8rem;border-bottom:1px solid #ddd;text-align:right}
thead th{vertical-align:bottom}tbody th{font-weight:400}
th:first-child,td:first-child,.facts td,.words :is(th,td):last-child{text-align:left}.facts :is(th,td){vertical-align:top}
svg{max-width:100%;height:auto}figure{margin:1.5rem 0}figcaption{margin-bottom:.4rem}
.panels{display:flex;flex-wrap:wrap;margin:1rem 0}.panels svg{display:block}nav>ul{columns:22rem}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr));gap:0 1.5rem}
.figures .broad{grid-column:1/-1}
.verdict{border-left:.5rem solid #2e7d32;background:#f1f7f1;padding:.6rem 1rem;margin:1rem 0}
.verdict p,.verdict ul{margin:.2rem 0}.verdict.bad{border-color:#b3541e;background:#fbf3ee}
@media print{body{margin:0}h2,h3{break-after:avoid}svg,tr,figure{break-inside:avoid}
.wide{overflow:visible}})";

constexpr std::pair<char, const char*> kEntities[] = {
    {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};

/// Returns text for a paragraph, in which lines stay lines.
std::string flowing(const std::string& text) {
  std::string html = html_text(text);
  while (!html.empty() && html.back() == '\n') html.pop_back();
  for (std::size_t at = html.find('\n'); at != std::string::npos; at = html.find('\n', at + 5))
    html.replace(at, 1, "<br/>");
  return html;
}

/// Returns the words of a heading for its id.
std::string words_of_id(const std::string& text) {
  std::string id;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      id += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!id.empty() && id.back() != '-')
      id += '-';
  }
  if (!id.empty() && id.back() == '-') id.pop_back();
  return id;
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const auto entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                     [&](const auto& each) { return each.first == c; });
    escaped += entity == std::end(kEntities) ? std::string(1, c) : entity->second;
  }
  return escaped;
}

std::string html_text(const std::string& text) {
  std::string html = html_escaped(text);
  for (std::size_t at = html.find(" %"); at != std::string::npos; at = html.find(" %", at))
    html.replace(at, 1, "&#160;");
  return html;
}

HtmlPage::HtmlPage(const std::string& title)
    : title_(title), body_(fmt::format("<h1>{}</h1>\n", html_escaped(title))) {}

std::string HtmlPage::add_heading(const std::string& text, int level) {
  std::string id = fmt::format("{}-{}", words_of_id(text), headings_.size() + 1);
  body_ += fmt::format("<h{0} id=\"{1}\">{2}</h{0}>\n", level, id, html_escaped(text));
  headings_.push_back({level, text, id});
  return id;
}

void HtmlPage::add_contents() {
  contents_at_ = body_.size();
  first_in_contents_ = headings_.size();
}

std::string HtmlPage::contents() const {
  std::string list;
  int level = 1;
  const auto change_to = [&](int next) {
    for (; level < next; ++level) list += "<ul>\n<li>";
    for (; level > next; --level) list += "</li>\n</ul>";
  };
  for (std::size_t i = first_in_contents_; i < headings_.size(); ++i) {
    const auto& [next, text, id] = headings_[i];
    if (next <= level) {
      change_to(next);
      list += "</li>\n<li>";
    }
    change_to(next);
    list += fmt::format("<a href=\"#{}\">{}</a>", id, html_escaped(text));
  }
  change_to(1);
  return "<nav aria-label=\"On this page\">\n" + list + "\n</nav>\n";
}

void HtmlPage::add_paragraph(const std::string& text) {
  body_ += fmt::format("<p>{}</p>\n", flowing(text));
}

void HtmlPage::add_section(const std::string& heading, const std::string& html,
                           const std::string& words) {
  add_heading(heading);
  add_html(html);
  add_paragraph(words);
}

void HtmlPage::add_verdict(const Verdict& verdict) {
  std::string sentence, remedies;
  for (const Refusal& fault : verdict.faults) {
    sentence += (sentence.empty() ? "" : "; ") + fault.fault;
    remedies += fmt::format("<li>{}.</li>", flowing(fault.remedy));
  }
  const bool good = verdict.faults.empty();
  const std::string found = verdict.found.empty() ? "" : flowing(verdict.found) + '.';
  body_ += fmt::format(
      "<div class=\"verdict{}\"><p><b>{}</b> {}.</p>{}{}</div>\n", good ? "" : " bad",
      good ? "Good:" : "To be mended:", flowing(good ? verdict.good : sentence),
      good ? "" : "<ul>" + remedies + "</ul>", found.empty() ? "" : "<p>" + found + "</p>");
}

std::string HtmlPage::text() const {
  std::string body = body_;
  if (contents_at_) body.insert(*contents_at_, contents());
  return fmt::format(
      "<!DOCTYPE html>\n<!-- format: planar-servo/page/1 -->\n<html lang=\"en\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<meta name=\"generator\" content=\"planar-servo\"/>\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</"
      "html>\n",
      html_escaped(title_), kStyle + style_, body);
}

}  // namespace planar
