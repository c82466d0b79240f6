#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace planar {

/// Says what may be given for a value: one of these words, or a file or folder of these kinds. Free
/// text, such as a number, has none of them.
struct Values {
  std::vector<std::string> words;
  std::vector<std::string> files;  ///< patterns of names, such as "*.yaml"; "*" for any file
  bool folders{false};
};

/// Describes an option, a flag, or an argument that has no name.
struct Argument {
  std::vector<std::string> names;  ///< such as "-o" and "--out"; empty for one without a name
  std::string value;               ///< what its value is called; empty for a flag
  std::string text;                ///< what it means
  std::string rule;                ///< such as "required; 1 to 100"; empty where there is none
  Values values;
  bool repeats{false};  ///< it may have several values
};

/// Describes a program or one of its subcommands as its options were declared, for completion and
/// manual. Hidden options are left out.
struct Usage {
  std::string name;
  std::string sentence;
  std::vector<Argument> options;
  std::vector<Argument> places;  ///< arguments without names, in their order
  std::vector<Usage> commands;
  std::string footer;     ///< lines that --help ends with; empty where there are none
  bool passes_on{false};  ///< its arguments are those of the program `planar-NAME`
};

Usage usage_of(const CLI::App& app);

}  // namespace planar
