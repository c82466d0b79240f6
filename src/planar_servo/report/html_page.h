#pragma once

#include <string>

namespace planar {

/// Replaces `&`, `<`, `>` and quotes by HTML entities.
std::string html_escaped(const std::string& text);

/// Builds one self-contained page from style, text, tables and inline SVG.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  void add_heading(const std::string& text);
  /// Adds a paragraph; line ends in the text stay line ends on the page.
  void add_paragraph(const std::string& text);
  /// Adds a piece that is HTML already: a table or an SVG figure.
  void add_html(const std::string& html) { body_ += html; }

  std::string text() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace planar
