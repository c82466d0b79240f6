#include "planar_servo/base/io/yaml_writer.h"

#include <fmt/format.h>
#include <yaml-cpp/emitter.h>
#include <yaml-cpp/emittermanip.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/checksum.h"

namespace planar {
namespace {

/// Returns the shortest decimal text that reads back as the same double, or `.nan` or `.inf` as
/// YAML has it.
std::string exact_text(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  return fmt::format("{}", value);
}

/// Returns whether YAML 1.1, which other readers follow, reads the word as a truth value or as
/// null.
bool is_word_of_yaml(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr const char* kWords[] = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  return std::find(std::begin(kWords), std::end(kWords), text) != std::end(kWords);
}

/// Returns whether every reader reads the unquoted text as a text. yaml-cpp knows what else needs
/// quotes.
bool is_plain_text(const std::string& text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
         !is_word_of_yaml(text);
}

void put_text(YAML::Emitter& yaml, const std::string& text) {
  if (!is_plain_text(text)) yaml << YAML::DoubleQuoted;
  yaml << text;
}

void put_row(YAML::Emitter& yaml, const std::vector<double>& values) {
  yaml << YAML::Flow << YAML::BeginSeq;
  for (const double value : values) yaml << exact_text(value);
  yaml << YAML::EndSeq;
}

}  // namespace

struct YamlWriter::Impl {
  YAML::Emitter yaml;

  /// Returns the emitter, ready for the value at `key`.
  YAML::Emitter& at(const std::string& key) {
    yaml << YAML::Key;
    put_text(yaml, key);
    return yaml << YAML::Value;
  }
  /// Begins a list with one item a line; an empty one is `[]` on the line of its key.
  YAML::Emitter& begin_list(const std::string& key, bool empty) {
    return at(key) << (empty ? YAML::Flow : YAML::Block) << YAML::BeginSeq;
  }
};

YamlWriter::YamlWriter() : impl_(std::make_unique<Impl>()) {
  impl_->yaml << YAML::BeginMap;
}

YamlWriter::YamlWriter(const std::string& kind, const std::string& program) : YamlWriter() {
  add("format", "planar-servo/" + kind + "/1");
  add("program", program + " " PLANAR_VERSION);
  add("created", utc_now());
}

YamlWriter::~YamlWriter() = default;

std::string YamlWriter::text() const {
  return with_checksum(std::string(impl_->yaml.c_str()) + '\n');
}

YamlWriter& YamlWriter::add(const std::string& key, double value) {
  impl_->at(key) << exact_text(value);
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, int value) {
  impl_->at(key) << value;
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, bool value) {
  impl_->at(key) << value;
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::string& value) {
  put_text(impl_->at(key), value);
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const char* value) {
  return add(key, std::string(value));
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<double>& values) {
  put_row(impl_->at(key), values);
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<std::vector<double>>& rows) {
  YAML::Emitter& yaml = impl_->begin_list(key, rows.empty());
  for (const std::vector<double>& row : rows) put_row(yaml, row);
  yaml << YAML::EndSeq;
  return *this;
}

YamlWriter& YamlWriter::add(const std::string& key, const std::vector<std::string>& values) {
  YAML::Emitter& yaml = impl_->at(key) << YAML::Flow << YAML::BeginSeq;
  for (const std::string& value : values) put_text(yaml, value);
  yaml << YAML::EndSeq;
  return *this;
}

YamlWriter& YamlWriter::add_inputs(const std::vector<InputRecord>& inputs) {
  YAML::Emitter& yaml = impl_->begin_list("inputs", inputs.empty());
  const auto put = [&](const char* key, const std::string& text) {
    yaml << YAML::Key << key << YAML::Value;
    put_text(yaml, text);
  };
  for (const InputRecord& input : inputs) {
    yaml << YAML::Flow << YAML::BeginMap;
    put("name", input.name);
    put("sha256", input.sha256);
    if (!input.role.empty()) put("role", input.role);
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndSeq;
  return *this;
}

void YamlWriter::begin_map(const std::string& key) {
  impl_->at(key) << YAML::BeginMap;
}

void YamlWriter::end_map() {
  impl_->yaml << YAML::EndMap;
}

std::size_t YamlWriter::begin_list(const std::string& key, std::size_t size, bool /*fixed*/) {
  impl_->begin_list(key, false);
  return size;
}

void YamlWriter::begin_item(std::size_t /*i*/) {
  impl_->yaml << YAML::BeginMap;
}

void YamlWriter::end_list() {
  impl_->yaml << YAML::EndSeq;
}

std::vector<InputRecord> input_records(const std::vector<std::filesystem::path>& files) {
  std::vector<InputRecord> records;
  records.reserve(files.size());
  for (const auto& file : files)
    records.push_back({file.filename().string(), content_sha256(file), ""});
  return records;
}

}  // namespace planar
