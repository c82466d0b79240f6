#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"

namespace planar {

/// Replaces `&`, `<`, `>` and quotes by HTML entities.
std::string html_escaped(const std::string& text);
/// Returns the same of a text for people, in which a figure keeps its per cent sign beside it.
std::string html_text(const std::string& text);

/// Says in one sentence whether a result is good, and what to do where it is not.
struct Verdict {
  std::string good;  ///< what is said when there is no fault; a clause without a full stop
  std::vector<Refusal> faults{};  ///< clauses without a full stop
  std::string found{};  ///< said in either case, such as an accuracy; sentences but the last stop

  void doubt(const std::string& fault, const std::string& remedy) {
    faults.push_back({fault, remedy});
  }
};

/// Builds one self-contained page from style, text, tables and inline SVG, which is well-formed XML
/// as well. It is made for keyboards and screen readers, too; bench/report/look.py has the rules.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  /// Adds a heading and returns its id. The title has level 1; a level may rise by one at most.
  std::string add_heading(const std::string& text, int level = 2);
  /// Adds links to all headings that follow.
  void add_contents();
  /// Adds a paragraph; line ends in the text stay line ends on the page.
  void add_paragraph(const std::string& text);
  /// Adds a heading, HTML and a paragraph about it.
  void add_section(const std::string& heading, const std::string& html, const std::string& words);
  /// Adds the verdict's sentence, and the remedies as a list.
  void add_verdict(const Verdict& verdict);
  /// Adds a piece that is HTML already: a table or an SVG plot.
  void add_html(const std::string& html) { body_ += html; }
  /// Adds rules of CSS, which overrule those that every page has.
  void add_style(const std::string& css) { style_ += css; }

  std::string text() const;

 private:
  struct Heading {
    int level;
    std::string text, id;
  };

  std::string contents() const;

  std::string title_;
  std::string style_;
  std::string body_;
  std::vector<Heading> headings_;
  std::optional<std::size_t> contents_at_;  ///< in the body
  std::size_t first_in_contents_{0};
};

}  // namespace planar
