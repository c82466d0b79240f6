#include "planar_servo/files/drawings/gcode.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {
namespace {

/// The radii of an arc's ends may differ by so much, as in LinuxCNC: programs round their numbers.
constexpr double kRadii_m = 5e-6, kRadiiShare = 1e-3;
constexpr double kMinute_s = 60.0;
/// Feeds that differ by a smaller share are one, rounded in another unit.
constexpr double kSameFeed = 1e-4;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Returns a line without its comments: what stands in brackets, and behind a semicolon. Empty
/// where a bracket stays open.
std::optional<std::string> without_comments(const std::string& line) {
  std::string code;
  bool inside = false;
  for (const char letter : line) {
    if (letter == ';' && !inside) break;
    if (letter == '(') inside = true;
    if (!inside && std::isspace(static_cast<unsigned char>(letter)) == 0)
      code += static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    if (letter == ')') inside = false;
  }
  return inside ? std::nullopt : std::optional(code);
}

struct Word {
  char letter;
  double number;
};

/// A program that is read line by line, with what its words have set so far.
class GcodeProgram {
 public:
  explicit GcodeProgram(const std::string& source) : source_(source) {}

  void take(const std::string& line) {
    ++line_;
    if (ended_) return;
    const std::optional<std::string> code = without_comments(line);
    if (!code) return refuse("a comment stays open", "close it by ) in its own line");
    if (code->empty() || code == "%") return;
    const std::vector<Word> words = words_of(*code);
    numbers_.clear();
    name_ = fmt::format("line {}", line_);
    dwells_ = blends_ = false;
    for (const Word& word : words) take_word(word);
    if (numbers_.count('P') != 0 && !dwells_ && !blends_)
      refuse("has P without G4", "P is a time to wait");
    if (dwells_)
      rest();
    else if (numbers_.count('X') + numbers_.count('Y') + numbers_.count('I') + numbers_.count('J') +
                 numbers_.count('R') >
             0)
      move();
    for (const Word& word : words) stopped_ |= word.letter == 'M' && word.number == 0.0;
  }

  Drawing finish() {
    faults_.throw_if_any();
    Drawing drawing;
    if (!states_unit_)
      drawing.remarks.emplace_back(
          "says neither G20 nor G21: its numbers are taken as millimetres");
    drawing.points = std::move(points_);
    if (!stroke_.empty()) drawing.strokes.push_back(std::move(stroke_));
    drawing.speed_m_s = feed_m_s_;
    return drawing;
  }

 private:
  void refuse(const std::string& fault, const std::string& remedy, Cause cause = Cause::kInvalid) {
    faults_.add({fault, remedy, fmt::format("{}:{}", source_, line_), cause});
  }

  std::vector<Word> words_of(const std::string& code) {
    std::vector<Word> words;
    for (std::size_t at = code[0] == '/' ? 1 : 0; at < code.size();) {
      const char letter = code[at];
      const std::size_t end =
          std::min(code.size(), code.find_first_not_of("+-.0123456789", at + 1));
      const std::string number = code.substr(at + 1, end - at - 1);
      const auto value = finite_number(number);
      if (std::isupper(static_cast<unsigned char>(letter)) == 0 || !value) {
        refuse(fmt::format("'{}' is no word of a letter and a number", code.substr(at, end - at)),
               "variables and expressions are not read: let your program write plain numbers");
        return {};
      }
      words.push_back({letter, *value});
      at = end;
    }
    return words;
  }

  void take_word(const Word& word) {
    const auto [letter, number] = word;
    if (letter == 'N') {
      name_ = fmt::format("N{:g}", number);
    } else if (letter == 'G') {
      take_g(number);
    } else if (letter == 'M') {
      take_m(number);
    } else if (letter == 'F') {
      take_feed(number);
    } else if (std::strchr("XYIJRP", letter) != nullptr) {
      if (!numbers_.emplace(letter, number).second)
        refuse(fmt::format("has {} twice", letter), "say it once a line", Cause::kExists);
    } else if (letter == 'Z') {
      refuse("moves Z, and a planar arm has none", "write the program for two axes");
    } else if (letter != 'O' && !(letter == 'K' && number == 0.0)) {  // O is a program's name
      refuse(fmt::format("{}{:g} means nothing here", letter, number),
             "take it out, or let your program write plain motion");
    }
  }

  void take_g(double number) {
    constexpr double kMost = 100.0;  // there is no G-code of more than two digits
    const int tenths =
        number >= 0.0 && number < kMost ? static_cast<int>(std::lround(10.0 * number)) : -1;
    const auto is = [&](std::initializer_list<int> codes) {
      return std::count(codes.begin(), codes.end(), tenths) != 0;
    };
    if (is({0, 10, 20, 30})) {
      motion_ = tenths / 10;
    } else if (tenths == 40) {
      dwells_ = true;
    } else if (is({200, 210})) {
      unit_m_ = tenths == 200 ? kInch : kMillimetre;
      states_unit_ = true;
    } else if (is({900, 910})) {
      absolute_ = tenths == 900;
    } else if (is({640})) {
      blends_ = true;
    } else if (!is({170, 400, 490, 540, 610, 800, 911, 940})) {
      refuse(fmt::format("G{:g} is not known", number),
             "there are G0 to G4, G17, G20, G21, G90 and G91");
    }
  }

  void take_m(double number) {
    if (number == 2.0 || number == 30.0)
      ended_ = true;
    else if (number == 5.0 || number == 9.0)
      switched_off_ = !stroke_.empty();
    else if (number != 0.0 && number != 1.0)
      refuse(fmt::format("M{:g} is not known", number),
             "there are M0, M1, M2 and M30: what switches anything must be left out");
  }

  void take_feed(double number) {
    const double feed_m_s = number * unit_m_ / kMinute_s;
    if (!(number > 0.0))
      refuse(fmt::format("F{:g} is no feed", number), "it is in units a minute and positive");
    else if (feed_m_s_ && std::abs(*feed_m_s_ - feed_m_s) > kSameFeed * feed_m_s)
      refuse(fmt::format("the feed changes from {:g} to {:g} mm/s", mm(*feed_m_s_), mm(feed_m_s)),
             "a path has one speed: divide the program, or leave F out", Cause::kContradiction);
    else
      feed_m_s_ = feed_m_s;
  }

  std::optional<double> number(char letter) const {
    const auto found = numbers_.find(letter);
    return found == numbers_.end() ? std::nullopt : std::optional(found->second * unit_m_);
  }

  void rest() {
    const auto seconds = numbers_.find('P');
    constexpr double kLongest_s = 3600.0;
    if (numbers_.size() > 1)
      return refuse("waits and moves at once", "give G4 a line of its own", Cause::kContradiction);
    if (seconds == numbers_.end() || !(seconds->second >= 0.0 && seconds->second <= kLongest_s))
      return refuse("G4 needs P, a time of at most an hour in seconds", "such as G4 P0.5");
    if (!stroke_.empty()) stroke_.back().rest_s += seconds->second;
  }

  void move() {
    if (!motion_)
      return refuse("moves, but no G0 to G3 says how", "begin with G0 or G1", Cause::kMissing);
    const Eigen::Vector2d end = end_of_motion();
    if (stroke_.empty() && (*motion_ > 1 || !absolute_ || !number('X') || !number('Y')))
      return refuse("begins nowhere", "let the first motion be G0 or G1 with G90, X and Y",
                    Cause::kMissing);
    if (*motion_ > 1) return move_on_arc(end);
    if (number('I') || number('J') || number('R'))
      return refuse("is straight, but has I, J or R", "take G2 or G3 for an arc",
                    Cause::kContradiction);
    if (!stroke_.empty() && (end - stroke_.back().p).norm() < kSamePoint_m) return;
    refuse_after_interruption();
    stroke_.push_back({"", end});
    add_point(end);
  }

  Eigen::Vector2d end_of_motion() const {
    const Eigen::Vector2d from = stroke_.empty() ? Eigen::Vector2d(0.0, 0.0) : stroke_.back().p;
    const double x = number('X').value_or(absolute_ ? from.x() : 0.0);
    const double y = number('Y').value_or(absolute_ ? from.y() : 0.0);
    return absolute_ ? Eigen::Vector2d(x, y) : Eigen::Vector2d(from + Eigen::Vector2d(x, y));
  }

  void move_on_arc(const Eigen::Vector2d& end) {
    const Eigen::Vector2d from = stroke_.back().p;
    const auto center =
        number('R') ? center_by_radius(from, end, *number('R')) : center_by_offset(from, end);
    if (!center) return;
    const Eigen::Vector2d radius = from - *center, last = end - *center;
    refuse_after_interruption();
    const double sense = *motion_ == 3 ? 1.0 : -1.0;  // G3 turns from x to y
    double sweep = std::atan2(cross2d(radius, last), radius.dot(last));
    if (sense * sweep <= 0.0 || (end - from).norm() < kSamePoint_m) sweep += sense * 2.0 * kPi;
    add_arc(stroke_, *center, sweep, {"", end});
    add_point(end);
  }

  /// M5 and M9 stand at the ends of a program for what it never switches on; between motions they
  /// mean that something does. At M0 a person is to be waited for, which nothing here can.
  void refuse_after_interruption() {
    if (std::exchange(stopped_, false))
      refuse("moves after M0, at which no person is waited for here",
             "divide the program where a person is to be waited for");
    if (std::exchange(switched_off_, false))
      refuse("moves after M5 or M9, which switch off what nothing here has switched on",
             "what switches anything between motions must be left out");
  }

  /// Keeps the end of a motion under the program's own name for it.
  void add_point(const Eigen::Vector2d& p) {
    const std::string line = fmt::format("line {}", line_);
    points_.push_back({names_.insert(name_).second ? name_ : line, p});
  }

  std::optional<Eigen::Vector2d> center_by_offset(const Eigen::Vector2d& from,
                                                  const Eigen::Vector2d& end) {
    const Eigen::Vector2d offset(number('I').value_or(0.0), number('J').value_or(0.0));
    const double first_m = offset.norm(), last_m = (end - from - offset).norm();
    if (first_m < kSamePoint_m) {
      refuse("is an arc without I, J or R, or of no radius", "name its centre or radius");
      return std::nullopt;
    }
    if (std::abs(first_m - last_m) > std::max(kRadii_m, kRadiiShare * first_m)) {
      refuse(fmt::format("the arc's radius is {:.4f} mm at its beginning and {:.4f} mm at its end",
                         mm(first_m), mm(last_m)),
             "both must be the same; I and J are counted from the beginning",
             Cause::kContradiction);
      return std::nullopt;
    }
    return from + offset;
  }

  std::optional<Eigen::Vector2d> center_by_radius(const Eigen::Vector2d& from,
                                                  const Eigen::Vector2d& end, double radius_m) {
    const Eigen::Vector2d chord = end - from;
    const double half_m = 0.5 * chord.norm(), r_m = std::abs(radius_m);
    if (half_m < 0.5 * kSamePoint_m || r_m < half_m * (1.0 - kRadiiShare)) {
      refuse(fmt::format("no arc of radius {:.4f} mm joins places {:.4f} mm apart", mm(r_m),
                         mm(2.0 * half_m)),
             "name its centre by I and J");
      return std::nullopt;
    }
    const double beside_m = std::sqrt(std::max(0.0, r_m * r_m - half_m * half_m));
    const Eigen::Vector2d left = Eigen::Vector2d(-chord.y(), chord.x()) / chord.norm();
    // The centre of a short arc to the left (G3) lies to the left; a negative R asks for the long
    // one.
    const double side = (*motion_ == 3) == (radius_m > 0.0) ? 1.0 : -1.0;
    return from + 0.5 * chord + side * beside_m * left;
  }

  std::string source_;
  int line_{0};
  std::string name_;
  std::map<char, double> numbers_;
  bool dwells_{false}, blends_{false}, ended_{false}, absolute_{true}, states_unit_{false};
  bool stopped_{false};       ///< by M0
  bool switched_off_{false};  ///< since the last motion
  std::optional<int> motion_;
  double unit_m_{kMillimetre};
  std::optional<double> feed_m_s_;
  Stroke stroke_;
  std::vector<DrawnPlace> points_;
  std::set<std::string> names_;
  Faults faults_;
};

}  // namespace

bool is_gcode(std::string_view text) {
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    text.remove_prefix(kByteOrderMark.size());
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == text.npos) return false;
  const char first = text[begin], second = begin + 1 < text.size() ? text[begin + 1] : '\0';
  return std::strchr("%(;", first) != nullptr ||
         (std::strchr("GMNOF", std::toupper(static_cast<unsigned char>(first))) != nullptr &&
          std::isdigit(static_cast<unsigned char>(second)) != 0);
}

Drawing read_gcode(const std::string& text, const std::string& source) {
  GcodeProgram program(source);
  std::istringstream lines(text);
  if (text.rfind(kByteOrderMark, 0) == 0) lines.ignore(kByteOrderMark.size());
  for (std::string line; std::getline(lines, line);) program.take(line);
  return program.finish();
}

}  // namespace planar
