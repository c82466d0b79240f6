#pragma once

#include <string>

namespace planar {

/// `&`, `<`, `>` and quotes as HTML entities.
std::string html_escaped(const std::string& text);

/// One self-contained page: style, text, tables and inline SVG, no other file.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  void add_heading(const std::string& text);
  /// Line ends in the text stay line ends on the page.
  void add_paragraph(const std::string& text);
  /// A piece that is HTML already: a table or an SVG figure.
  void add_html(const std::string& html) { body_ += html; }

  std::string text() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace planar
