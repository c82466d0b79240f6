#include "planar_servo/jog/command_line.h"

#include <algorithm>

namespace planar {
namespace {

/// Returns the beginning that all of these lines have in common.
std::string common_beginning(const std::vector<std::string>& lines) {
  std::string common = lines.front();
  for (const std::string& line : lines) {
    const auto differ = std::mismatch(common.begin(), common.end(), line.begin(), line.end());
    common.erase(differ.first, common.end());
  }
  return common;
}

bool continues_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;  // of UTF-8
}

}  // namespace

void CommandLine::begin() {
  text_.clear();
  choices_.clear();
  recalled_ = entered_.size();
}

CommandLine::State CommandLine::take(const std::string& key) {
  choices_.clear();
  if (key == "\x1b") return State::kLeft;
  if (key == "\n" || key == "\r") {
    if (!text_.empty()) entered_.push_back(text_);
    return State::kEntered;
  }
  if (key == "\t")
    complete();
  else if (key == "\x7f" || key == "\b")
    erase_last();
  else if (key == "\x15")  // Ctrl-U
    text_.clear();
  else if (key == "\x1b[A")
    recall(-1);
  else if (key == "\x1b[B")
    recall(1);
  else if (static_cast<unsigned char>(key[0]) >= ' ')
    text_ += key;
  return State::kOpen;
}

void CommandLine::complete() {
  std::vector<std::string> lines = completions_(text_);
  if (lines.empty()) return;
  text_ = lines.size() == 1 ? lines.front() + ' ' : common_beginning(lines);
  if (lines.size() > 1) choices_ = std::move(lines);
}

void CommandLine::erase_last() {
  while (!text_.empty() && continues_character(text_.back())) text_.pop_back();
  if (!text_.empty()) text_.pop_back();
}

void CommandLine::recall(std::ptrdiff_t step) {
  const auto wanted = static_cast<std::ptrdiff_t>(recalled_) + step;
  if (wanted < 0 || wanted > static_cast<std::ptrdiff_t>(entered_.size())) return;
  recalled_ = static_cast<std::size_t>(wanted);
  text_ = recalled_ < entered_.size() ? entered_[recalled_] : "";
}

}  // namespace planar
