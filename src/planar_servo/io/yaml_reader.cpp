#include "planar_servo/io/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string shown(const YAML::Node& node) {
  if (node.IsNull()) return "empty";
  return node.IsScalar() ? "'" + node.Scalar() + "'" : node.IsMap() ? "a map" : "a list";
}

/// "a number from 0 to 1"; a bound that no file reaches is not told.
template <typename Number>
std::string range_text(const char* what, Number lower, Number upper) {
  if (upper >= std::numeric_limits<Number>::max())
    return fmt::format("{} of at least {}", what, lower);
  return fmt::format("{} from {} to {}", what, lower, upper);
}

constexpr double kSmallestPositive = 1e-9;

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
    return place.empty() ? key : place + "." + key;
  }
  std::string title() const { return place.empty() ? "the file" : place; }
  void fault(const std::string& message) const {
    if (present()) document->add_fault(node.Mark(), message);
  }
  void fault_at(const YAML::Node& where, const std::string& message) const {
    document->add_fault(where.Mark(), message);
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

  std::optional<double> finite_number(const YAML::Node& value, const std::string& name) const {
    double number = 0.0;
    if (value.IsScalar() && YAML::convert<double>::decode(value, number) && std::isfinite(number))
      return number;
    fault_at(value, fmt::format("{} is {}; a finite number is needed", name, shown(value)));
    return std::nullopt;
  }

  std::optional<std::vector<double>> finite_numbers(const YAML::Node& value,
                                                    const std::string& name,
                                                    std::size_t size) const {
    if (!value.IsSequence() || (size != 0 && value.size() != size)) {
      const std::string count = size == 0 ? "" : fmt::format("{} ", size);
      fault_at(value, fmt::format("{} is {}; a list of {}numbers is needed", name,
                                  value.IsSequence() ? fmt::format("a list of {}", value.size())
                                                     : shown(value),
                                  count));
      return std::nullopt;
    }
    std::vector<double> numbers;
    bool finite = true;
    for (const auto& item : value) {
      const std::optional<double> number = finite_number(item, name);
      finite = finite && number.has_value();
      numbers.push_back(number.value_or(0.0));
    }
    return finite ? std::make_optional(numbers) : std::nullopt;
  }

  std::optional<int> whole_number(const YAML::Node& value, const std::string& name) const {
    double number = 0.0;
    constexpr double kLargest = std::numeric_limits<int>::max();
    if (value.IsScalar() && YAML::convert<double>::decode(value, number) &&
        number == std::trunc(number) && std::abs(number) <= kLargest)
      return static_cast<int>(number);
    fault_at(value, fmt::format("{} is {}; a whole number is needed", name, shown(value)));
    return std::nullopt;
  }

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
      const std::string name = place.empty() ? key : place + "." + key;
      if (!seen.insert(key).second)
        add_fault(entry.first.Mark(), fmt::format("the key '{}' stands twice", name));
      if (strict && !map.any_key &&
          std::find(map.asked.begin(), map.asked.end(), key) == map.asked.end())
        add_fault(entry.first.Mark(),
                  fmt::format("unknown key '{}'; allowed are {}", name, joined(map.asked)));
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

double YamlNode::number(const std::string& key) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return 0.0;
  return impl_->finite_number(value, impl_->place_of(key)).value_or(0.0);
}

double YamlNode::number_in(const std::string& key, double lower, double upper) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return lower;
  const std::optional<double> number = impl_->finite_number(value, impl_->place_of(key));
  if (number && *number >= lower && *number <= upper) return *number;
  if (number)
    impl_->fault_at(value, fmt::format("{} is {}; {} is needed", impl_->place_of(key), *number,
                                       range_text("a number", lower, upper)));
  return lower;
}

double YamlNode::positive(const std::string& key, double upper) const {
  const double harmless = std::min(1.0, upper);
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return harmless;
  const std::optional<double> number = impl_->finite_number(value, impl_->place_of(key));
  if (number && *number >= kSmallestPositive && *number <= upper) return *number;
  const std::string limit = upper < kUnbounded ? fmt::format(" of at most {}", upper) : "";
  if (number)
    impl_->fault_at(value, fmt::format("{} is {}; a positive number{} is needed",
                                       impl_->place_of(key), *number, limit));
  return harmless;
}

int YamlNode::whole_number(const std::string& key) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return 0;
  return impl_->whole_number(value, impl_->place_of(key)).value_or(0);
}

int YamlNode::whole_number_in(const std::string& key, int lower, int upper) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return lower;
  const std::optional<int> number = impl_->whole_number(value, impl_->place_of(key));
  if (number && *number >= lower && *number <= upper) return *number;
  if (number)
    impl_->fault_at(value, fmt::format("{} is {}; {} is needed", impl_->place_of(key), *number,
                                       range_text("a whole number", lower, upper)));
  return lower;
}

std::string YamlNode::text(const std::string& key) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return "";
  if (value.IsScalar()) return value.Scalar();
  impl_->fault_at(value,
                  fmt::format("{} is {}; a text is needed", impl_->place_of(key), shown(value)));
  return "";
}

std::string YamlNode::choice(const std::string& key,
                             const std::vector<std::string>& allowed) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return allowed.front();
  if (value.IsScalar() && std::count(allowed.begin(), allowed.end(), value.Scalar()) != 0)
    return value.Scalar();
  impl_->fault_at(value, fmt::format("{} is {}; allowed are {}", impl_->place_of(key), shown(value),
                                     joined(allowed)));
  return allowed.front();
}

std::vector<double> YamlNode::numbers(const std::string& key, std::size_t size) const {
  const YAML::Node value = impl_->require(key);
  if (!value.IsDefined()) return std::vector<double>(size, 0.0);
  return impl_->finite_numbers(value, impl_->place_of(key), size)
      .value_or(std::vector<double>(size, 0.0));
}

std::vector<YamlNode> YamlNode::list(const std::string& key, std::size_t size) const {
  const YAML::Node value = impl_->require(key);
  std::vector<YamlNode> items;
  if (!value.IsDefined()) return items;
  if (!value.IsSequence() || (size != 0 && value.size() != size)) {
    const std::string count = size == 0 ? "" : fmt::format(" of {} items", size);
    impl_->fault_at(
        value,
        fmt::format("{} is {}; a list{} is needed", impl_->place_of(key),
                    value.IsSequence() ? fmt::format("a list of {}", value.size()) : shown(value),
                    count));
    return items;
  }
  for (std::size_t i = 0; i < value.size(); ++i)
    items.push_back(impl_->wrap(value[i], fmt::format("{}[{}]", impl_->place_of(key), i)));
  return items;
}

std::optional<std::vector<double>> YamlNode::as_numbers(std::size_t size) const {
  if (!impl_->present()) return std::nullopt;
  return impl_->finite_numbers(impl_->node, impl_->title(), size);
}

std::string YamlNode::as_text() const {
  if (!impl_->present()) return "";
  if (impl_->node.IsScalar()) return impl_->node.Scalar();
  impl_->fault(fmt::format("{} is {}; a text is needed", impl_->title(), shown(impl_->node)));
  return "";
}

std::vector<std::string> YamlNode::keys() const {
  std::vector<std::string> names;
  if (!impl_->require_map()) return names;
  for (const auto& entry : impl_->node) names.push_back(entry.first.Scalar());
  return names;
}

void YamlNode::add_fault(const std::string& message) const {
  impl_->fault(message);
}

YamlDocument YamlDocument::parse(const std::filesystem::path& path) {
  auto impl = std::make_shared<Impl>();
  impl->path = path;
  const std::string text = read_file(path);
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
  YamlDocument document = parse(path);
  const std::string format = "planar-servo/" + kind + "/1";
  const YAML::Node found = document.impl_->root["format"];
  if (!found.IsDefined() || !found.IsScalar() || found.Scalar() != format)
    throw InputError(
        fmt::format("{}:1:1: is {}; 'format: {}' must be its first line", path.string(),
                    found.IsDefined() ? "of format " + shown(found) : "without a format", format));
  for (const char* key : {"format", "program", "created", "inputs"}) document.root().allow(key);
  return document;
}

YamlDocument YamlDocument::read_lenient(const std::filesystem::path& path) {
  YamlDocument document = parse(path);
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
