#include "planar_servo/io/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/format/checksum.h"

namespace planar {
namespace {

/// The reader takes up to 140 times a file's size in memory: 2 GB for this. The largest map that is
/// written, a field of 200 places with its covariance, has 10 MB.
constexpr double kMost_MB = 16.0;

void require_moderate_size(const std::filesystem::path& path) {
  std::error_code error;
  const double size_MB = static_cast<double>(std::filesystem::file_size(path, error)) / 1e6;
  if (error || size_MB <= kMost_MB) return;
  throw InputError(fmt::format(
      "{}: has {:.1f} MB; {:g} MB are the most, because reading takes 140 times as much "
      "memory; make a map of fewer places",
      path.string(), size_MB, kMost_MB));
}

std::string shown(const YAML::Node& node) {
  if (node.IsNull()) return "empty";
  return node.IsScalar() ? "'" + node.Scalar() + "'" : node.IsMap() ? "a map" : "a list";
}

std::optional<double> finite_number(const YAML::Node& node) {
  double value = 0.0;
  if (node.IsScalar() && YAML::convert<double>::decode(node, value) && std::isfinite(value))
    return value;
  return std::nullopt;
}

}  // namespace

struct YamlDocument::Impl {
  struct VisitedMap {
    YAML::Node node;
    std::vector<std::string> asked;
    bool any_key{false};
  };

  std::filesystem::path path;
  YAML::Node root;
  bool strict{true};
  Faults faults;
  std::map<std::string, VisitedMap> visited;  // by the map's place in the file

  void add_fault(const YAML::Mark& mark, const std::string& message) {
    faults.add(fmt::format("{}:{}:{}: {}", path.string(), mark.line + 1, mark.column + 1, message));
  }
  VisitedMap& visit(const std::string& place, const YAML::Node& node) {
    VisitedMap& map = visited[place];
    map.node.reset(node);
    return map;
  }
  void visit(const std::string& place, const YAML::Node& node, const std::string& key) {
    VisitedMap& map = visit(place, node);
    if (std::find(map.asked.begin(), map.asked.end(), key) == map.asked.end())
      map.asked.push_back(key);
  }
  void add_key_faults();
};

struct YamlNode::Impl {
  std::shared_ptr<YamlDocument::Impl> document;
  YAML::Node node;    // undefined when the key is missing: every access is then harmless
  std::string place;  // such as "drives[1].gear_ratio"; empty at the root

  bool present() const { return node.IsDefined(); }
  std::string place_of(const std::string& key) const {
    return place.empty() ? key : fmt::format("{}.{}", place, key);
  }
  std::string title() const { return place.empty() ? "the file" : place; }
  void fault(const std::string& message) const {
    if (present()) document->add_fault(node.Mark(), message);
  }

  bool require_map() const {
    if (!present()) return false;
    if (!node.IsMap())
      fault(fmt::format("{} is {}; a map of keys is needed", title(), shown(node)));
    return node.IsMap();
  }

  YAML::Node find(const std::string& key) const {
    document->visit(place, node, key);
    for (const auto& entry : node)
      if (entry.first.Scalar() == key) return entry.second;
    return YAML::Node(YAML::NodeType::Undefined);
  }

  YAML::Node require(const std::string& key) const {
    if (!require_map()) return YAML::Node(YAML::NodeType::Undefined);
    YAML::Node found = find(key);
    if (!found.IsDefined()) fault(fmt::format("{} lacks the key '{}'", title(), key));
    return found;
  }

  /// Returns whether the node is a list of `size` items, or of any number of them when `size` is 0.
  /// When it is not, adds a fault, in which `needed` follows "a list".
  bool require_list(std::size_t size, const std::string& needed) const {
    if (!present()) return false;
    if (node.IsSequence() && (size == 0 || node.size() == size)) return true;
    const std::string found =
        node.IsSequence() ? fmt::format("a list of {}", node.size()) : shown(node);
    fault(fmt::format("{} is {}; a list{} is needed", title(), found, needed));
    return false;
  }

  /// Returns the number, or adds a fault when it is not one in the range. `title_of_value` is
  /// called for a fault only.
  template <typename Title>
  std::optional<double> number(const YAML::Node& value, const Range& range,
                               const Title& title_of_value) const {
    const std::optional<double> found = finite_number(value);
    if (found && range.holds(*found)) return found;
    document->add_fault(value.Mark(), fmt::format("{} is {}; {} is needed", title_of_value(),
                                                  found ? fmt::format("{}", *found) : shown(value),
                                                  found ? range.text() : "a finite number"));
    return std::nullopt;
  }

  std::string item_title(std::size_t i) const { return fmt::format("{}[{}]", title(), i); }

  YamlNode wrap(const YAML::Node& child, const std::string& child_place) const {
    return YamlNode(std::make_shared<Impl>(Impl{document, child, child_place}));
  }
};

void YamlDocument::Impl::add_key_faults() {
  for (const auto& [place, map] : visited) {
    if (!map.node.IsMap()) continue;
    std::set<std::string> seen;
    for (const auto& entry : map.node) {
      const std::string key = entry.first.Scalar();
      const std::string name = place.empty() ? key : fmt::format("{}.{}", place, key);
      if (!seen.insert(key).second)
        add_fault(entry.first.Mark(), fmt::format("the key '{}' stands twice", name));
      if (strict && !map.any_key &&
          std::find(map.asked.begin(), map.asked.end(), key) == map.asked.end())
        add_fault(entry.first.Mark(), fmt::format("unknown key '{}'; allowed are {}", name,
                                                  fmt::join(map.asked, ", ")));
    }
  }
}

YamlNode YamlNode::child(const std::string& key) const {
  return impl_->wrap(impl_->require(key), impl_->place_of(key));
}

bool YamlNode::has(const std::string& key) const {
  return impl_->present() && impl_->node.IsMap() && impl_->find(key).IsDefined();
}

void YamlNode::allow(const std::string& key) const {
  has(key);
}

void YamlNode::allow_all() const {
  if (impl_->present()) impl_->document->visit(impl_->place, impl_->node).any_key = true;
}

double YamlNode::number(const std::string& key, const Range& range) const {
  return child(key).as_number(range).value_or(range.harmless());
}

std::string YamlNode::text(const std::string& key) const {
  return child(key).as_text();
}

std::string YamlNode::choice(const std::string& key,
                             const std::vector<std::string>& allowed) const {
  return child(key).as_choice(allowed).value_or(allowed.front());
}

std::vector<double> YamlNode::numbers(const std::string& key, std::size_t size) const {
  return child(key).as_numbers(size).value_or(std::vector<double>(size, 0.0));
}

std::vector<YamlNode> YamlNode::list(const std::string& key, std::size_t size) const {
  return child(key).as_list(size).value_or(std::vector<YamlNode>());
}

std::optional<double> YamlNode::as_number(const Range& range) const {
  if (!impl_->present()) return std::nullopt;
  return impl_->number(impl_->node, range, [&] { return title(); });
}

std::optional<std::string> YamlNode::as_choice(const std::vector<std::string>& allowed) const {
  if (!impl_->present()) return std::nullopt;
  const YAML::Node& node = impl_->node;
  if (node.IsScalar() && std::count(allowed.begin(), allowed.end(), node.Scalar()) != 0)
    return node.Scalar();
  add_fault(
      fmt::format("{} is {}; allowed are {}", title(), shown(node), fmt::join(allowed, ", ")));
  return std::nullopt;
}

std::optional<std::vector<double>> YamlNode::as_numbers(std::size_t size,
                                                        const Range& range) const {
  const std::string count = size == 0 ? " of numbers" : fmt::format(" of {} numbers", size);
  if (!impl_->require_list(size, count)) return std::nullopt;
  return as_row(std::vector<Range>(impl_->node.size(), range));
}

std::optional<std::vector<double>> YamlNode::as_row(const std::vector<Range>& ranges) const {
  if (!impl_->require_list(ranges.size(), fmt::format(" of {} numbers", ranges.size())))
    return std::nullopt;
  std::vector<double> numbers;
  bool well_formed = true;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const std::optional<double> number =
        impl_->number(impl_->node[i], ranges[i], [&] { return impl_->item_title(i); });
    well_formed = well_formed && number.has_value();
    numbers.push_back(number.value_or(0.0));
  }
  return well_formed ? std::make_optional(numbers) : std::nullopt;
}

std::string YamlNode::as_text() const {
  if (!impl_->present()) return "";
  if (impl_->node.IsScalar()) return impl_->node.Scalar();
  add_fault(fmt::format("{} is {}; a text is needed", title(), shown(impl_->node)));
  return "";
}

std::optional<std::vector<YamlNode>> YamlNode::as_list(std::size_t size) const {
  const std::string count = size == 0 ? "" : fmt::format(" of {} items", size);
  if (!impl_->require_list(size, count)) return std::nullopt;
  std::vector<YamlNode> items;
  for (std::size_t i = 0; i < impl_->node.size(); ++i)
    items.push_back(impl_->wrap(impl_->node[i], impl_->item_title(i)));
  return items;
}

std::string YamlNode::title() const {
  return impl_->title();
}

void YamlNode::add_fault(const std::string& message) const {
  impl_->fault(message);
}

YamlDocument YamlDocument::parse(const std::filesystem::path& path, const std::string& text) {
  auto impl = std::make_shared<Impl>();
  impl->path = path;
  try {
    impl->root = YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw InputError(fmt::format("{}:{}:{}: is not YAML: {}", path.string(), e.mark.line + 1,
                                 e.mark.column + 1, e.msg));
  }
  if (!impl->root.IsMap())
    throw InputError(fmt::format("{}: is {}; a YAML map of keys is needed", path.string(),
                                 text.empty() ? "empty" : "not a map"));
  return YamlDocument(impl);
}

YamlDocument YamlDocument::read(const std::filesystem::path& path, const std::string& kind) {
  require_moderate_size(path);
  const std::string text = read_file(path);
  YamlDocument document = parse(path, text);
  const std::string format = "planar-servo/" + kind + "/1";
  const YAML::Node found = document.impl_->root["format"];
  if (!found.IsDefined() || !found.IsScalar() || found.Scalar() != format)
    throw InputError(
        fmt::format("{}:1:1: is {}; it needs the line 'format: {}'", path.string(),
                    found.IsDefined() ? "of format " + shown(found) : "without a format", format));
  require_unchanged(path, text);
  for (const char* key : {"format", "program", "created", "inputs"}) document.root().allow(key);
  if (has_checksum(kind))
    for (const char* key : {"checksum", "edited_by_hand"}) document.root().allow(key);
  return document;
}

YamlDocument YamlDocument::read_lenient(const std::filesystem::path& path) {
  require_moderate_size(path);
  const std::string text = read_file(path);
  YamlDocument document = parse(path, text);
  require_unchanged(path, text);
  document.impl_->strict = false;
  return document;
}

YamlNode YamlDocument::root() const {
  return YamlNode(std::make_shared<YamlNode::Impl>(YamlNode::Impl{impl_, impl_->root, ""}));
}

const std::filesystem::path& YamlDocument::path() const {
  return impl_->path;
}

void YamlDocument::throw_if_faulty() const {
  impl_->add_key_faults();
  impl_->visited.clear();
  impl_->faults.throw_if_any();
}

}  // namespace planar
