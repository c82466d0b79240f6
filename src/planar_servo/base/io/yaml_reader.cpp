#include "planar_servo/base/io/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"

namespace planar {
namespace {

/// The reader takes up to 140 times a file's size in memory: 2 GB for this. The largest map that is
/// written, a field of 200 places with its covariance, has 10 MB.
constexpr double kMostMegabytes = 16.0;

std::string moderate_text(const std::filesystem::path& path) {
  std::error_code error;
  const double size_MB = static_cast<double>(std::filesystem::file_size(path, error)) / 1e6;
  if (error || size_MB <= kMostMegabytes) return read_file(path);
  throw InputError(
      {fmt::format(
           "has {:.1f} MB; {:g} MB are the most, because reading takes 140 times as much memory",
           size_MB, kMostMegabytes),
       "make a map of fewer places", path});
}

std::string shown(const YAML::Node& node) {
  if (node.IsNull()) return "empty";
  return node.IsScalar() ? "'" + node.Scalar() + "'" : node.IsMap() ? "a map" : "a list";
}

std::string shown(const std::filesystem::path& path, const YAML::Mark& mark) {
  return fmt::format("{}:{}:{}", path.string(), mark.line + 1, mark.column + 1);
}

std::string name_in_map(const std::string& map, const std::string& key) {
  return map.empty() ? key : fmt::format("{}.{}", map, key);
}

std::optional<double> finite_number(const YAML::Node& node) {
  double value = 0.0;
  if (node.IsScalar() && YAML::convert<double>::decode(node, value) && std::isfinite(value))
    return value;
  return std::nullopt;
}

YAML::Node map_in(const std::filesystem::path& path, const std::string& text) {
  YAML::Node root;
  try {
    root.reset(YAML::Load(text));
  } catch (const YAML::Exception& e) {
    throw InputError({"is not YAML: " + e.msg, "", shown(path, e.mark)});
  }
  if (root.IsMap()) return root;
  throw InputError(
      {text.empty() ? "is empty" : "is not a map", "a YAML map of keys is needed", path});
}

void require_format(const std::filesystem::path& path, const YAML::Node& root,
                    const std::string& kind) {
  const std::string format = "planar-servo/" + kind + "/1";
  const YAML::Node found = root["format"];
  if (found.IsDefined() && found.IsScalar() && found.Scalar() == format) return;
  throw InputError({found.IsDefined() ? "is of format " + shown(found) : "is without a format",
                    fmt::format("it needs the line 'format: {}'", format), path.string() + ":1:1",
                    found.IsDefined() ? Cause::kForeign : Cause::kMissing});
}

}  // namespace

struct YamlReader::Impl {
  /// A value of the file.
  struct Place {
    YAML::Node node;   // undefined when its key is missing: every access is then harmless
    std::string name;  // such as "drives[1].gear_ratio"; empty at the root

    bool present() const { return node.IsDefined(); }
    std::string title() const { return name.empty() ? "the file" : name; }
    std::string item_title(std::size_t i) const { return fmt::format("{}[{}]", title(), i); }
    Place item(std::size_t i) const { return {node[i], item_title(i)}; }
  };
  struct VisitedMap {
    YAML::Node node;
    std::vector<std::string> asked;
    bool any_key{false};
  };

  Impl(const std::filesystem::path& file, bool is_ours) : path(file), strict(is_ours) {}

  std::filesystem::path path;
  bool strict;
  Faults faults;
  std::map<std::string, VisitedMap> visited;  // by the map's place in the file
  std::vector<Place> maps;                    // the last is being visited, the others contain it
  std::vector<Place> lists;

  void add_fault(const YAML::Mark& mark, const Refusal& refusal) {
    faults.add(refusal.at(shown(path, mark)));
  }
  void fault(const Place& place, const Refusal& refusal) {
    if (place.present()) add_fault(place.node.Mark(), refusal);
  }

  VisitedMap& visit(const Place& map) {
    VisitedMap& visit = visited[map.name];
    visit.node.reset(map.node);
    return visit;
  }

  bool is_in_map() const { return maps.back().present() && maps.back().node.IsMap(); }

  /// Returns the value of a key of the map that is being visited.
  YAML::Node find(const std::string& key) {
    const Place& map = maps.back();
    std::vector<std::string>& asked = visit(map).asked;
    if (std::find(asked.begin(), asked.end(), key) == asked.end()) asked.push_back(key);
    for (const auto& entry : map.node)
      if (entry.first.Scalar() == key) return entry.second;
    return YAML::Node(YAML::NodeType::Undefined);
  }

  /// Returns the value of a required key of the map that is being visited.
  Place at(const std::string& key) {
    const Place& map = maps.back();
    const std::string name = name_in_map(map.name, key);
    if (!is_in_map()) {
      fault(map, {map.title() + " is " + shown(map.node), "a map of keys is needed"});
      return {YAML::Node(YAML::NodeType::Undefined), name};
    }
    Place value{find(key), name};
    if (!value.present())
      fault(map, {fmt::format("{} lacks the key '{}'", map.title(), key), "", "", Cause::kMissing});
    return value;
  }

  /// Returns whether the value is a list of `size` items, or of any number of them when `size` is
  /// 0. When it is not, adds a fault, in which `needed` follows "a list".
  bool is_list(const Place& place, std::size_t size, const std::string& needed) {
    if (!place.present()) return false;
    const YAML::Node& node = place.node;
    if (node.IsSequence() && (size == 0 || node.size() == size)) return true;
    fault(place,
          {fmt::format("{} is {}", place.title(),
                       node.IsSequence() ? fmt::format("a list of {}", node.size()) : shown(node)),
           fmt::format("a list{} is needed", needed)});
    return false;
  }

  bool is_list_of_items(const Place& place, std::size_t size) {
    return is_list(place, size, size == 0 ? "" : fmt::format(" of {} items", size));
  }

  /// Returns the number, or adds a fault when it is not one in the range. `title` is called for a
  /// fault only.
  template <typename Title>
  std::optional<double> number(const YAML::Node& value, const Range& range, const Title& title) {
    const std::optional<double> found = finite_number(value);
    if (found && range.holds(*found)) return found;
    add_fault(value.Mark(),
              {fmt::format("{} is {}", title(), found ? fmt::format("{}", *found) : shown(value)),
               (found ? range.text() : "a finite number") + " is needed"});
    return std::nullopt;
  }

  /// Reads a list of `size` numbers, or of any number of them when `size` is 0. All lie in the one
  /// range, or each in its own.
  bool row(const Place& place, std::vector<double>& field, std::size_t size,
           const std::vector<Range>& ranges) {
    if (!is_list(place, size, size == 0 ? " of numbers" : fmt::format(" of {} numbers", size)))
      return false;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < place.node.size(); ++i) {
      const auto title = [&] { return place.item_title(i); };
      const Range& range = ranges[ranges.size() == 1 ? 0 : i];
      if (const auto found = number(place.node[i], range, title)) numbers.push_back(*found);
    }
    if (numbers.size() != place.node.size()) return false;
    field = std::move(numbers);
    return true;
  }

  std::optional<std::string> word(const Place& place, const std::vector<std::string>& allowed) {
    if (!place.present()) return std::nullopt;
    const YAML::Node& node = place.node;
    if (node.IsScalar() &&
        (allowed.empty() || std::count(allowed.begin(), allowed.end(), node.Scalar()) != 0))
      return node.Scalar();
    const std::string needed = allowed.empty()
                                   ? "a text is needed"
                                   : fmt::format("allowed are {}", fmt::join(allowed, ", "));
    fault(place, {place.title() + " is " + shown(node), needed});
    return std::nullopt;
  }

  void add_key_faults() {
    for (const auto& [place, map] : visited) {
      if (!map.node.IsMap()) continue;
      std::set<std::string> seen;
      for (const auto& entry : map.node) {
        const std::string key = entry.first.Scalar();
        const std::string name = name_in_map(place, key);
        if (!seen.insert(key).second)
          add_fault(entry.first.Mark(),
                    {fmt::format("the key '{}' stands twice", name), "", "", Cause::kExists});
        if (strict && !map.any_key &&
            std::find(map.asked.begin(), map.asked.end(), key) == map.asked.end())
          add_fault(entry.first.Mark(),
                    {fmt::format("unknown key '{}'", name),
                     fmt::format("allowed are {}", fmt::join(map.asked, ", "))});
      }
    }
  }
};

YamlReader::YamlReader(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(path, false)) {
  const std::string text = moderate_text(path);
  impl_->maps.push_back({map_in(path, text), ""});
  require_unchanged(path, text);
}

YamlReader::YamlReader(const std::filesystem::path& path, const std::string& kind)
    : impl_(std::make_unique<Impl>(path, true)) {
  const std::string text = moderate_text(path);
  impl_->maps.push_back({map_in(path, text), ""});
  require_format(path, impl_->maps.back().node, kind);
  require_unchanged(path, text);
  for (const char* key : {"format", "program", "created", "inputs"}) given(key);
  if (has_checksum(kind))
    for (const char* key : {"checksum", "edited_by_hand"}) given(key);
}

YamlReader::~YamlReader() = default;

const std::filesystem::path& YamlReader::path() const {
  return impl_->path;
}

void YamlReader::throw_if_faulty() {
  impl_->add_key_faults();
  impl_->visited.clear();
  impl_->faults.throw_if_any();
}

bool YamlReader::given(const std::string& key, bool /*wanted*/) {
  return impl_->is_in_map() && impl_->find(key).IsDefined();
}

std::vector<std::string> YamlReader::names_in(const std::string& key) {
  const Impl::Place map = impl_->at(key);
  std::vector<std::string> names;
  if (!map.present() || !map.node.IsMap())
    impl_->fault(map, {map.title() + " is " + shown(map.node), "a map of keys is needed"});
  else
    for (const auto& entry : map.node) names.push_back(entry.first.Scalar());
  return names;
}

void YamlReader::allow_rest() {
  const Impl::Place& map = impl_->maps.back();
  if (map.present()) impl_->visit(map).any_key = true;
}

bool YamlReader::check(bool kept, const Refusal& refusal, const std::string& key) {
  if (!kept) impl_->fault(key.empty() ? impl_->maps.back() : impl_->at(key), refusal);
  return kept;
}

bool YamlReader::word(const std::string& key, std::string& field,
                      const std::vector<std::string>& allowed) {
  const std::optional<std::string> found = impl_->word(impl_->at(key), allowed);
  if (found || allowed.empty()) field = found.value_or("");
  return found.has_value();
}

bool YamlReader::words(const std::string& key, std::vector<std::string>& field, std::size_t size,
                       const std::vector<std::string>& allowed) {
  const Impl::Place list = impl_->at(key);
  if (!impl_->is_list_of_items(list, size)) return false;
  field.clear();
  for (std::size_t i = 0; i < list.node.size(); ++i)
    if (auto text = impl_->word(list.item(i), allowed)) field.push_back(std::move(*text));
  return field.size() == list.node.size();
}

bool YamlReader::number_in_file(const std::string& key, double& field, const Range& range) {
  const Impl::Place value = impl_->at(key);
  if (!value.present()) return false;
  const auto found = impl_->number(value.node, range, [&] { return value.title(); });
  field = found.value_or(field);
  return found.has_value();
}

bool YamlReader::numbers_in_file(const std::string& key, std::vector<double>& field,
                                 std::size_t size, const std::vector<Range>& ranges) {
  return impl_->row(impl_->at(key), field, size, ranges);
}

bool YamlReader::rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                              std::size_t size, const std::vector<Range>& ranges) {
  const Impl::Place list = impl_->at(key);
  if (!impl_->is_list_of_items(list, size)) return false;
  field.clear();
  for (std::size_t i = 0; i < list.node.size(); ++i)
    if (std::vector<double> row; impl_->row(list.item(i), row, ranges.size(), ranges))
      field.push_back(std::move(row));
  return field.size() == list.node.size();
}

void YamlReader::begin_map(const std::string& key) {
  impl_->maps.push_back(impl_->at(key));
}

std::size_t YamlReader::begin_list(const std::string& key, std::size_t size, bool fixed) {
  impl_->lists.push_back(impl_->at(key));
  const Impl::Place& list = impl_->lists.back();
  return impl_->is_list_of_items(list, fixed ? size : 0) ? list.node.size() : 0;
}

void YamlReader::begin_item(std::size_t i) {
  impl_->maps.push_back(impl_->lists.back().item(i));
}

void YamlReader::end_map() {
  impl_->maps.pop_back();
}

void YamlReader::end_list() {
  impl_->lists.pop_back();
}

}  // namespace planar
