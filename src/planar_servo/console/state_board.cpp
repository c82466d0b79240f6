#include "planar_servo/console/state_board.h"

#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/console/json_values.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns whether a path may begin behind this letter.
bool ends_word(char letter) {
  return std::isalnum(static_cast<unsigned char>(letter)) == 0 &&
         std::string_view("/._-~").find(letter) == std::string_view::npos;
}

std::string prefix_of(const fs::path& folder) {
  const std::string quoted = nlohmann::json((folder / "").string()).dump();
  return quoted.substr(1, quoted.size() - 2);
}

using nlohmann::ordered_json;

constexpr std::size_t kEventsKept = 400;
/// A reader gets a state no more and no less often than this.
constexpr double kStateEvery_s = 0.2, kHeartbeat_s = 1.0;

ordered_json or_null(const std::string& text) {
  return text.empty() ? ordered_json(nullptr) : ordered_json(text);
}

ordered_json arm_json(const ArmState& arm) {
  const auto& at = arm.stand;
  const auto null = ordered_json(nullptr);
  return {{"enabled", arm.enabled},
          {"homed", at.has_value()},
          {"joints_deg", at ? json_numbers(at->theta / kDegree) : null},
          {"elbow_mm", at ? json_mm(at->elbow_B) : null},
          {"tip_mm", at ? json_mm(at->tip.p) : null},
          {"phi_deg", at ? json_number(at->tip.phi / kDegree) : null},
          {"to_do", or_null(arm.to_do)}};
}

ordered_json lamp_json(const LampState& lamp) {
  return {{"x_px", json_number(lamp.uv_px.x())},
          {"y_px", json_number(lamp.uv_px.y())},
          {"edge_px", json_number(lamp.edge_px)},
          {"saturated", lamp.saturated}};
}

ordered_json fixed_lamp_json(const FixedLampState& lamp) {
  return {{"id", lamp.id},
          {"x_px", json_number(lamp.uv_px.x())},
          {"y_px", json_number(lamp.uv_px.y())},
          {"moved_px", json_number(lamp.moved_px)}};
}

ordered_json job_json(const JobState& job) {
  return {{"id", job.id},
          {"kind", job.kind},
          {"name", job.name},
          {"done", job.done},
          {"all", job.all},
          {"left_s", job.left_s ? json_number(*job.left_s) : ordered_json(nullptr)},
          {"ended", or_null(job.ended)},
          {"ok", job.ended.empty() ? ordered_json(nullptr) : ordered_json(job.ok)},
          {"cause", job.cause ? ordered_json(to_text(*job.cause)) : ordered_json(nullptr)}};
}

ordered_json point_json(const Eigen::Vector2d& p) {
  return {{"x_mm", json_number(mm(p.x()))}, {"y_mm", json_number(mm(p.y()))}};
}

ordered_json recording_json(const RecordingState& recording) {
  const auto place_json = [](const RecordingState::Place& place) {
    ordered_json json = point_json(place.p_B);
    json["mark"] = name_in(kPlaceMarks, place.mark);
    return json;
  };
  const auto monument_json = [](const auto& monument) {
    ordered_json json{{"id", monument.first}};
    json.update(point_json(monument.second));
    return json;
  };
  return {{"title", recording.title},
          {"now", recording.now},
          {"counts", recording.counts},
          {"places", json_list(recording.places, place_json)},
          {"monuments", json_list(recording.monuments, monument_json)},
          {"here_mm", recording.here_B ? json_mm(*recording.here_B) : ordered_json(nullptr)}};
}

}  // namespace

/// The longest comes first: it may hold another one.
CellNames::CellNames(const fs::path& cell_file) {
  for (const fs::path& file : {fs::weakly_canonical(cell_file), fs::absolute(cell_file), cell_file})
    if (file.has_parent_path()) prefixes_.push_back(prefix_of(file.parent_path()));
}

std::string CellNames::in(std::string text) const {
  for (const std::string& prefix : prefixes_)
    for (std::size_t at = 0; (at = text.find(prefix, at)) != std::string::npos;) {
      if (at > 0 && !ends_word(text[at - 1]))
        ++at;
      else
        text.erase(at, prefix.size());
    }
  return text;
}

std::uint64_t StateBoard::change(const std::function<void(CellState&)>& change) {
  const std::lock_guard<std::mutex> lock(mutex_);
  change(state_);
  changed_.notify_all();
  return ++version_;
}

std::uint64_t StateBoard::note(Doing doing, const std::string& text) {
  return change([&](CellState& state) {
    if (state.doing != doing || state.since_s == 0.0) state.since_s = clock_.now_s();
    state.doing = doing;
    state.text = text;
  });
}

void StateBoard::tell(const char* event, const ordered_json& data) {
  const std::lock_guard<std::mutex> lock(mutex_);
  events_.emplace_back(++last_event_, event_text(event, data));
  if (events_.size() > kEventsKept) events_.pop_front();
  changed_.notify_all();
  told_.notify_all();
}

void StateBoard::tell_line(const char* level, const std::string& text) {
  tell("line", {{"t", utc_now()}, {"level", level}, {"text", text}});
}

CellState StateBoard::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

ordered_json StateBoard::json() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return json_locked();
}

std::string StateBoard::next(Reader& reader) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!closed_) {
    const double now_s = clock_.now_s();
    std::string text = unread_events(reader);
    const double age_s = now_s - reader.state_s;
    const bool news = reader.version != version_;
    if ((news && age_s >= kStateEvery_s) || age_s >= kHeartbeat_s) {
      reader.version = version_;
      reader.state_s = now_s;
      text += state_event();
    }
    if (!text.empty()) return text;
    // A state that comes too early wakes nobody again.
    if (news)
      told_.wait_for(lock, std::chrono::duration<double>(kStateEvery_s - age_s));
    else
      changed_.wait_for(lock, std::chrono::duration<double>(kHeartbeat_s - age_s));
  }
  return {};
}

void StateBoard::close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  changed_.notify_all();
  told_.notify_all();
}

void StateBoard::open() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = false;
  }
  change([](CellState& state) {
    ++state.opened;
    state.mover.clear();
  });
}

std::string StateBoard::unread_events(Reader& reader) const {
  std::string text;
  for (const auto& [number, event] : events_)
    if (number > reader.event) text += event;
  reader.event = last_event_;
  return text;
}

ordered_json StateBoard::json_locked() const {
  const CellState& state = state_;
  const double now_s = clock_.now_s();
  const auto null = ordered_json(nullptr);
  return {{"seq", version_},
          {"opened", state.opened},
          {"stops", state.stops},
          {"doing", name_in(kDoings, state.doing)},
          {"text", state.text},
          {"since_s", json_number(now_s - state.since_s)},
          {"held_by", or_null(state.held_by)},
          {"checking_mm", state.checking_B ? json_list(*state.checking_B, json_mm) : null},
          {"operator", or_null(state.mover)},
          {"arm", state.arm ? arm_json(*state.arm) : null},
          {"seen_mm", state.seen_B ? json_mm(*state.seen_B) : null},
          {"picture",
           {{"seq", state.picture},
            {"age_s", state.picture == 0 ? null : json_number(now_s - state.picture_s)}}},
          {"exposure",
           {{"exposure_us", json_number(state.exposure.time_s / kMicrosecond)},
            {"gain_db", json_number(state.exposure.gain_db)}}},
          {"lamps", state.lamps ? json_list(*state.lamps, lamp_json) : null},
          {"sharpness", state.edge_px ? ordered_json{{"edge_px", json_number(*state.edge_px)},
                                                     {"best_px", json_number(*state.best_edge_px)}}
                                      : null},
          {"fixed_lamps", json_list(state.fixed_lamps, fixed_lamp_json)},
          {"doubts", json_list(state.doubts, refusal_json)},
          {"job", state.job ? job_json(*state.job) : null},
          {"question",
           state.question ? ordered_json{{"id", state.question->id}, {"text", state.question->text}}
                          : null},
          {"advice", or_null(state.advice)},
          {"recording", state.recording ? recording_json(*state.recording) : null}};
}

std::string StateBoard::event_text(const char* event, const ordered_json& data) const {
  return fmt::format("event: {}\ndata: {}\n\n", event, named(json_text(data)));
}

const std::string& StateBoard::state_event() {
  const double now_s = clock_.now_s();
  if (text_version_ != version_ || now_s - text_s_ >= kStateEvery_s) {
    text_ = event_text("state", json_locked());
    text_version_ = version_;
    text_s_ = now_s;
  }
  return text_;
}

}  // namespace planar
