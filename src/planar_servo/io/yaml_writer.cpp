#include "planar_servo/io/yaml_writer.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/sha256.h"

namespace planar {
namespace {

std::string row_text(const std::vector<double>& values) {
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const double value : values) texts.push_back(exact_text(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

/// SHA-256 of the file without its `created:` line, in which two identical runs differ.
std::string input_hash(const std::filesystem::path& path) {
  std::ifstream in = open_file(path);
  Sha256 hash;
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind("created:", 0) == 0) continue;
    hash.add(line);
    if (!in.eof()) hash.add("\n");
  }
  return hash.digits();
}

}  // namespace

std::string exact_text(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  return fmt::format("{}", value);
}

std::string yaml_text(const std::string& value) {
  constexpr char kPlain[] =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+ ()";
  const bool plain = !value.empty() && value.find_first_not_of(kPlain) == std::string::npos &&
                     std::isalpha(static_cast<unsigned char>(value[0])) != 0 && value.back() != ' ';
  if (plain) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else
      quoted += c;
  }
  return quoted + '"';
}

YamlWriter YamlWriter::with_header(const std::string& kind, const std::string& program) {
  YamlWriter writer;
  writer.add("format", "planar-servo/" + kind + "/1");
  writer.add("program", program + " " PLANAR_VERSION);
  writer.add("created", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))));
  return writer;
}

void YamlWriter::begin_line(const std::string& key) {
  text_.append(2 * static_cast<std::size_t>(depth_), ' ');
  text_ += key + ":";
}

YamlWriter& YamlWriter::begin_map(const std::string& key) {
  begin_line(key);
  text_ += '\n';
  ++depth_;
  return *this;
}

YamlWriter& YamlWriter::end_map() {
  --depth_;
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, double value) {
  begin_line(key);
  text_ += ' ' + exact_text(value) + '\n';
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, int value) {
  begin_line(key);
  text_ += fmt::format(" {}\n", value);
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, bool value) {
  begin_line(key);
  text_ += value ? " true\n" : " false\n";
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::string& value) {
  begin_line(key);
  text_ += ' ' + yaml_text(value) + '\n';
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const char* value) {
  return add(key, std::string(value));
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<double>& values) {
  begin_line(key);
  text_ += ' ' + row_text(values) + '\n';
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<std::vector<double>>& rows) {
  begin_line(key);
  if (rows.empty()) text_ += " []";
  text_ += '\n';
  for (const std::vector<double>& row : rows)
    text_ +=
        std::string(static_cast<std::size_t>(2 * depth_ + 2), ' ') + "- " + row_text(row) + '\n';
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<std::string>& values) {
  begin_line(key);
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const std::string& value : values) texts.push_back(yaml_text(value));
  text_ += fmt::format(" [{}]\n", fmt::join(texts, ", "));
  return *this;
}

YamlWriter& YamlWriter::add_inputs(const std::vector<std::filesystem::path>& paths) {
  begin_line("inputs");
  if (paths.empty()) text_ += " []";
  text_ += '\n';
  for (const auto& path : paths)
    text_ += fmt::format("{:{}}- {{name: {}, sha256: {}}}\n", "", 2 * depth_ + 2,
                         yaml_text(path.filename().string()), yaml_text(input_hash(path)));
  return *this;
}

}  // namespace planar
