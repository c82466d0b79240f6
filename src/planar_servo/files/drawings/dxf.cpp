#include "planar_servo/files/drawings/dxf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {
namespace {

/// Ends nearer to one another meet: drawings round their numbers.
constexpr double kMeet_m = 0.01 * kMillimetre;

/// Returns the unit of this number in $INSUNITS; empty for none.
std::optional<double> unit_of(int number) {
  const std::map<int, double> units{
      {1, kInch}, {2, 12.0 * kInch}, {4, kMillimetre}, {5, 10.0 * kMillimetre}, {6, 1.0}};
  const auto found = units.find(number);
  return found == units.end() ? std::nullopt : std::optional(found->second);
}

/// Returns a number that stands for a choice; 0, which is none, where there is no such number.
int whole(const std::optional<double>& number) {
  constexpr double kMost = 1e6;
  return number && std::abs(*number) < kMost ? static_cast<int>(*number) : 0;
}

/// What is drawn, but not gone.
bool is_lettering(const std::string& entity) {
  constexpr const char* kLettering[] = {"TEXT", "MTEXT", "DIMENSION", "LEADER", "ATTDEF", "HATCH"};
  return std::find(std::begin(kLettering), std::end(kLettering), entity) != std::end(kLettering);
}

/// A code and what it stands for, on the two lines that end at `line`.
struct Group {
  int code;
  std::string text;
  int line;
};

/// One entity of a drawing, with its groups in their order.
struct Entity {
  std::string kind;
  int line;
  std::vector<Group> groups{};
};

/// Splits a file into its groups. Throws InputError where a code is no number.
std::vector<Group> groups_of(const std::string& text, const std::string& file) {
  std::vector<Group> groups;
  std::istringstream lines(text);
  std::string code, value;
  for (int line = 2; std::getline(lines, code) && std::getline(lines, value); line += 2) {
    constexpr double kMostCode = 1071.0;
    const auto number = finite_number(trimmed(code));
    if (!number || std::abs(*number) > kMostCode)
      throw InputError({fmt::format("'{}' is no group code", trimmed(code)),
                        "save the drawing as ASCII DXF; a binary one is not read",
                        fmt::format("{}:{}", file, line - 1)});
    groups.push_back({static_cast<int>(*number), in_utf8(trimmed(value)), line});
  }
  return groups;
}

/// Collects the pieces of a drawing, in its own unit.
class DxfPieces {
 public:
  DxfPieces(std::string file, const std::vector<std::string>& layers)
      : file_(std::move(file)), layers_(layers.begin(), layers.end()) {}

  std::vector<Stroke> strokes;
  std::vector<DrawnPlace> points;
  std::optional<int> unit;
  std::set<std::string> layers_seen;
  std::map<std::string, int> left_out;  ///< counts by kind
  Faults faults;

  void take(const std::vector<Group>& groups) {
    std::string section;
    std::optional<Entity> entity;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      const Group& group = groups[i];
      if (group.code == 0 && entity) add(*std::exchange(entity, std::nullopt));
      if (group.code == 0 && group.text == "SECTION" && i + 1 < groups.size())
        section = groups[i + 1].text;
      else if (group.code == 0 && group.text == "ENDSEC")
        section.clear();
      else if (group.code == 0 &&
               (section == "ENTITIES" || (section == "TABLES" && group.text == "LAYER")))
        entity = Entity{group.text, group.line};
      else if (entity)
        entity->groups.push_back(group);
      else if (section == "HEADER" && group.text == "$INSUNITS" && i + 1 < groups.size())
        unit = whole(finite_number(groups[i + 1].text));
    }
    if (entity || !section.empty())
      faults.add({"ends within a section", "it is torn: save it again", file_});
  }

 private:
  void refuse(const Entity& entity, const std::string& fault, const std::string& remedy,
              Cause cause = Cause::kInvalid) {
    faults.add({fault, remedy, fmt::format("{}:{}", file_, entity.line), cause}, entity.kind);
  }

  void add(const Entity& entity) {
    constexpr int kLayer = 8, kInvisible = 60, kOnPaper = 67;
    if (entity.kind == "LAYER") return add_layer(entity);
    // The corners of a polyline and their end belong to it, whatever they say.
    if (entity.kind == "VERTEX" || entity.kind == "SEQEND") return add_corner(entity);
    const std::string layer = text_of(entity, kLayer).value_or("0");
    layers_seen.insert(layer);
    if (!layers_.empty() && layers_.count(layer) == 0) return;
    const auto says = [&](int code) { return number_of(entity, code).value_or(0.0) != 0.0; };
    if (is_lettering(entity.kind) || says(kOnPaper)) {
      ++left_out[entity.kind];
    } else if (says(kInvisible)) {
      ++left_out["invisible " + entity.kind];
    } else if (layers_.empty() && hidden_layers_.count(layer) != 0) {
      ++left_out[fmt::format("{} on the layer {}, which is off or frozen", entity.kind, layer)];
    } else if (!is_level(entity)) {
      refuse(entity, fmt::format("a {} is drawn from below or aslant", entity.kind),
             "its extrusion does not point up: flatten the drawing");
    } else if (!add_known(entity)) {
      refuse(entity, fmt::format("a {} on the layer {} is not read", entity.kind, layer),
             "explode it, draw it as points, lines, arcs, circles or polylines, or choose other "
             "layers");
    }
  }

  /// Notes a layer that does not show what is drawn on it.
  void add_layer(const Entity& entity) {
    constexpr int kName = 2, kColor = 62, kFrozen = 1;
    const bool is_off = number_of(entity, kColor).value_or(0.0) < 0.0;
    if (is_off || (whole(number_of(entity, kFlags)) & kFrozen) != 0)
      hidden_layers_.insert(text_of(entity, kName).value_or(""));
  }

  /// Lines and points state places of the drawing whatever their extrusion is; others lie across
  /// it.
  bool is_level(const Entity& entity) {
    constexpr int kUpwards = 230;
    constexpr double kLevel = 1.0 - 1e-6;
    return entity.kind == "LINE" || entity.kind == "POINT" ||
           number_of(entity, kUpwards).value_or(1.0) > kLevel;
  }

  /// Returns whether the entity is of a kind that is read.
  bool add_known(const Entity& entity) {
    constexpr int kBegin = 50, kEnd = 51;
    if (entity.kind == "POINT") {
      points.push_back({fmt::format("P{}", points.size() + 1), place(entity, 10)});
    } else if (entity.kind == "LINE") {
      strokes.push_back({{"", place(entity, 10)}, {"", place(entity, 11)}});
    } else if (entity.kind == "CIRCLE") {
      add_round(place(entity, 10), radius_of(entity), 0.0, 2.0 * kPi);
    } else if (entity.kind == "ARC") {
      const double begin = needed(entity, kBegin) * kDegree;
      double sweep = std::fmod(needed(entity, kEnd) * kDegree - begin, 2.0 * kPi);
      if (sweep <= 0.0) sweep += 2.0 * kPi;
      add_round(place(entity, 10), radius_of(entity), begin, sweep);
    } else if (entity.kind == "LWPOLYLINE") {
      begin_polyline(entity);
      add_corners(entity);
      end_polyline();
    } else if (entity.kind == "POLYLINE") {
      begin_polyline(entity);
    } else {
      return false;
    }
    return true;
  }

  void add_round(const Eigen::Vector2d& center, double radius, double begin, double sweep) {
    const auto at = [&](double angle) {
      return Eigen::Vector2d(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    };
    Stroke stroke{{"", at(begin)}};
    add_arc(stroke, center, sweep, {"", at(begin + sweep)});
    strokes.push_back(std::move(stroke));
  }

  void begin_polyline(const Entity& entity) {
    constexpr int kClosed = 1, kMeshes = 16 + 64;
    const int flags = whole(number_of(entity, kFlags));
    if ((flags & kMeshes) != 0) refuse(entity, "a POLYLINE is a mesh", "draw it by lines");
    polyline_.emplace();
    bulge_ = 0.0;
    is_closed_ = (flags & kClosed) != 0;
  }

  /// Takes a corner of a POLYLINE, or its end.
  void add_corner(const Entity& entity) {
    if (!polyline_) return;
    if (entity.kind == "SEQEND") return end_polyline();
    constexpr int kFrameOfSpline = 16;  // control points; the curve's own points follow
    if ((whole(number_of(entity, kFlags)) & kFrameOfSpline) != 0) return;
    join(place(entity, 10));
    bulge_ = number_of(entity, kBulge).value_or(0.0);
  }

  /// Takes the corners that stand within a LWPOLYLINE, each with its bulge behind it.
  void add_corners(const Entity& entity) {
    std::optional<double> x;
    for (const Group& group : entity.groups) {
      if (group.code == 10) x = read(group);
      if (group.code == 20 && x) join({*x, read(group)});
      if (group.code == 20) bulge_ = 0.0;
      if (group.code == kBulge) bulge_ = read(group);
    }
  }

  /// Continues the polyline to its next corner, on an arc where the one before it bulges.
  void join(const Eigen::Vector2d& corner) {
    std::optional<Eigen::Vector2d> via;
    if (!polyline_->empty() && bulge_ != 0.0) {
      const Eigen::Vector2d from = polyline_->back().p, chord = corner - from;
      via = from + 0.5 * chord + 0.5 * bulge_ * Eigen::Vector2d(chord.y(), -chord.x());
    }
    polyline_->push_back({"", corner, via});
  }

  void end_polyline() {
    if (is_closed_ && polyline_->size() > 1) join(polyline_->front().p);
    if (polyline_->size() > 1) strokes.push_back(std::move(*polyline_));
    polyline_.reset();
  }

  double read(const Group& group) {
    const auto number = finite_number(group.text);
    if (!number)
      faults.add({fmt::format("'{}' is no number", group.text), "save the drawing again",
                  fmt::format("{}:{}", file_, group.line)});
    return number.value_or(0.0);
  }

  static std::optional<std::string> text_of(const Entity& entity, int code) {
    const auto found = std::find_if(entity.groups.begin(), entity.groups.end(),
                                    [&](const Group& group) { return group.code == code; });
    return found == entity.groups.end() ? std::nullopt : std::optional(found->text);
  }

  std::optional<double> number_of(const Entity& entity, int code) {
    const auto found = std::find_if(entity.groups.begin(), entity.groups.end(),
                                    [&](const Group& group) { return group.code == code; });
    return found == entity.groups.end() ? std::nullopt : std::optional(read(*found));
  }

  double needed(const Entity& entity, int code) {
    const auto number = number_of(entity, code);
    if (!number)
      refuse(entity, fmt::format("a {} lacks its group {}", entity.kind, code),
             "save the drawing again", Cause::kMissing);
    return number.value_or(0.0);
  }

  double radius_of(const Entity& entity) {
    const double radius = needed(entity, 40);
    if (!(radius > 0.0) && number_of(entity, 40))
      refuse(entity, fmt::format("a {} has the radius {:g}", entity.kind, radius), "leave it out");
    return radius;
  }

  /// Returns the place whose x has this code, and whose y the one ten above it.
  Eigen::Vector2d place(const Entity& entity, int code) {
    return {needed(entity, code), needed(entity, code + 10)};
  }

  static constexpr int kBulge = 42, kFlags = 70;

  std::string file_;
  std::set<std::string> layers_, hidden_layers_;
  std::optional<Stroke> polyline_;
  bool is_closed_{false};
  double bulge_{0.0};  ///< of the corner added last
};

Stroke reversed(const Stroke& stroke) {
  Stroke back(stroke.rbegin(), stroke.rend());
  for (std::size_t i = 0; i < back.size(); ++i)
    back[i].via = i == 0 ? std::nullopt : stroke[stroke.size() - i].via;
  return back;
}

/// Puts a piece that meets the stroke's beginning before it. Returns whether there was one.
bool grows_backwards(Stroke& stroke, std::vector<Stroke>& pieces) {
  const auto meets = [&](const Eigen::Vector2d& p) {
    return (p - stroke.front().p).norm() < kMeet_m;
  };
  const auto before = std::find_if(pieces.begin(), pieces.end(), [&](const Stroke& piece) {
    return meets(piece.back().p) || meets(piece.front().p);
  });
  if (before == pieces.end()) return false;
  Stroke piece = meets(before->back().p) ? std::move(*before) : reversed(*before);
  pieces.erase(before);
  piece.insert(piece.end(), stroke.begin() + 1, stroke.end());
  stroke = std::move(piece);
  return true;
}

/// Orders pieces so that each begins as near as possible to where the one before it ends, and joins
/// those that meet.
std::vector<Stroke> joined(std::vector<Stroke> pieces) {
  std::vector<Stroke> strokes;
  while (!pieces.empty()) {
    auto next = pieces.begin();
    bool is_turned = false;
    double least = HUGE_VAL;
    for (auto piece = pieces.begin(); !strokes.empty() && piece != pieces.end(); ++piece)
      for (const bool turned : {false, true}) {
        const Eigen::Vector2d begin = turned ? piece->back().p : piece->front().p;
        const double gap = (begin - strokes.back().back().p).norm();
        if (gap >= least) continue;
        least = gap;
        next = piece;
        is_turned = turned;
      }
    const bool meets = least < kMeet_m;
    if (!meets && !strokes.empty() && grows_backwards(strokes.back(), pieces)) continue;
    Stroke piece = is_turned ? reversed(*next) : std::move(*next);
    pieces.erase(next);
    if (meets)
      strokes.back().insert(strokes.back().end(), piece.begin() + 1, piece.end());
    else
      strokes.push_back(std::move(piece));
  }
  return strokes;
}

void scale(std::vector<DrawnPlace>& places, double unit_m) {
  for (DrawnPlace& place : places) {
    place.p *= unit_m;
    if (place.via) *place.via *= unit_m;
  }
}

/// Returns the unit that a person names, or else the header's. Remarks where they differ.
double unit_of(const DxfPieces& pieces, const DrawingSettings& settings, const std::string& file,
               std::vector<std::string>& remarks) {
  const auto stated = pieces.unit ? unit_of(*pieces.unit) : std::nullopt;
  if (settings.unit_m) {
    if (stated && *stated != *settings.unit_m)
      remarks.push_back(
          fmt::format("its header names a unit of {:g} mm; {:g} mm are taken as asked", mm(*stated),
                      mm(*settings.unit_m)));
    return *settings.unit_m;
  }
  if (!stated)
    throw InputError({pieces.unit && *pieces.unit != 0
                          ? fmt::format("its unit is number {} of $INSUNITS", *pieces.unit)
                          : std::string("its header names no unit ($INSUNITS)"),
                      "say it with --drawing-unit, such as mm or inch", file,
                      pieces.unit.value_or(0) != 0 ? Cause::kInvalid : Cause::kMissing});
  return *stated;
}

void require_layers(const DxfPieces& pieces, const DrawingSettings& settings,
                    const std::string& file) {
  for (const std::string& layer : settings.layers)
    if (pieces.layers_seen.count(layer) == 0)
      throw InputError({fmt::format("nothing is drawn on a layer '{}'", layer),
                        fmt::format("there are {}", fmt::join(pieces.layers_seen, ", ")), file,
                        Cause::kMissing});
}

}  // namespace

Drawing read_dxf(const std::filesystem::path& path, const DrawingSettings& settings) {
  const std::string file = path.string();
  DxfPieces pieces(file, settings.layers);
  pieces.take(groups_of(read_file(path), file));
  pieces.faults.throw_if_any();
  if (pieces.layers_seen.empty())
    throw InputError(
        {"has no entities", "save the drawing as ASCII DXF with its model", file, Cause::kMissing});
  require_layers(pieces, settings, file);
  Drawing drawing;
  const double unit_m = unit_of(pieces, settings, file, drawing.remarks);
  for (Stroke& stroke : pieces.strokes) scale(stroke, unit_m);
  scale(pieces.points, unit_m);
  drawing.strokes = joined(std::move(pieces.strokes));
  drawing.points = std::move(pieces.points);
  for (const auto& [kind, count] : pieces.left_out)
    drawing.remarks.push_back(fmt::format("left out: {} {}", count, kind));
  return drawing;
}

}  // namespace planar
