#pragma once

#include <cctype>
#include <string>
#include <vector>

namespace planar::test {

/// Returns what keeps a text from being well-formed XML: tags that do not close in order, a bare
/// '&' or '<', an entity that XML does not have. Empty when nothing does.
inline std::string fault_of_xml(const std::string& text) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '&') {
      const std::string entity = text.substr(i, text.find(';', i) - i + 1);
      bool known = entity.rfind("&#", 0) == 0;
      for (const char* name : {"&amp;", "&lt;", "&gt;", "&quot;"}) known = known || entity == name;
      if (!known) return "bare & at " + text.substr(i, 20);
    }
    if (text[i] != '<') continue;
    const std::size_t end = text.find('>', i);
    if (end == std::string::npos) return "a tag without an end";
    const std::string tag = text.substr(i + 1, end - i - 1);
    i = end;
    if (tag[0] == '!' || tag.back() == '/') continue;
    const std::string name = tag.substr(tag[0] == '/' ? 1 : 0, tag.find(' ') - (tag[0] == '/'));
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0)
      return "no tag: <" + tag;
    if (tag[0] != '/') {
      open.push_back(name.substr(0, name.find(' ')));
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

/// Returns whether a page or figure needs nothing from outside: no address but the name of SVG.
inline bool is_self_contained(std::string text) {
  const std::string name_of_svg = "http://www.w3.org/2000/svg";
  for (std::size_t at = text.find(name_of_svg); at != std::string::npos;
       at = text.find(name_of_svg))
    text.erase(at, name_of_svg.size());
  for (const char* outside : {"http", "src=", "href=", "url(", "<script", "@import"})
    if (text.find(outside) != std::string::npos) return false;
  return true;
}

}  // namespace planar::test
