#include "planar_servo/hardware/cameras/frame_mailbox.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "planar_servo/base/core/clock.h"

namespace planar {
namespace {

double now_s() {
  return SteadyClock().now_s();
}

}  // namespace

FrameMailbox::FrameMailbox(const cv::Rect& region_px, double age_limit_s)
    : age_limit_s_(age_limit_s), region_px_(region_px), good_until_s_(now_s()) {}

void FrameMailbox::ask_region(const cv::Rect& region_px) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (region_px == region_px_) return;
  region_px_ = region_px;
  frame_.reset();
  wanted_since_s_.reset();
  changed_.notify_all();
}

FrameResult FrameMailbox::next(double timeout_s) {
  std::unique_lock<std::mutex> lock(mutex_);
  wanted_since_s_ = now_s();
  frame_.reset();
  return wait(lock, timeout_s);
}

FrameResult FrameMailbox::following(double timeout_s) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!wanted_since_s_) wanted_since_s_ = now_s();
  return wait(lock, timeout_s);
}

FrameResult FrameMailbox::wait(std::unique_lock<std::mutex>& lock, double timeout_s) {
  last_trouble_ = FrameStatus::kTimeout;
  waiting_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                    [&] { return frame_ || lost_; });
  waiting_ = false;
  if (!frame_) {
    wanted_since_s_.reset();
    return {lost_ ? FrameStatus::kLost : last_trouble_, {}};
  }
  FrameResult result{FrameStatus::kOk, std::move(*frame_)};
  frame_.reset();
  wanted_since_s_ = result.frame.t_s;
  return result;
}

std::optional<std::string> FrameMailbox::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (lost_) return reason_;
  const double age_s = age_locked_s();
  if (age_s <= age_limit_s_) return std::nullopt;
  return fmt::format("the camera has sent no good frame for {:.0f} ms{}", 1e3 * age_s,
                     last_status_ == FrameStatus::kFrozen ? ": it repeats one picture"
                     : last_status_ == FrameStatus::kIncomplete
                         ? ": parts of its frames are missing"
                         : "");
}

FrameCounts FrameMailbox::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

cv::Rect FrameMailbox::region() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return region_px_;
}

void FrameMailbox::sleep_until(double deadline_s, const cv::Rect& region_px) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(deadline_s - now_s()),
                    [&] { return woken_ || (waiting_ && !frame_) || region_px_ != region_px; });
}

void FrameMailbox::wake() {
  const std::lock_guard<std::mutex> lock(mutex_);
  woken_ = true;
  changed_.notify_all();
}

bool FrameMailbox::note_good(double began_s, const cv::Rect& region_px) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.complete;
  good_until_s_ = now_s();
  last_status_ = FrameStatus::kOk;
  return wanted_since_s_ && !frame_ && began_s >= *wanted_since_s_ && region_px == region_px_;
}

void FrameMailbox::deliver(const Frame& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!wanted_since_s_ || frame.t_s < *wanted_since_s_) return;  // the waiting caller has given up
  frame_ = frame;
  changed_.notify_all();
}

void FrameMailbox::note_bad(FrameStatus status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++(status == FrameStatus::kFrozen ? counts_.frozen : counts_.incomplete);
  last_trouble_ = last_status_ = status;
}

void FrameMailbox::excuse(double duration_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  good_until_s_ = std::max(good_until_s_, now_s() + duration_s);
}

void FrameMailbox::lose(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  lost_ = true;
  reason_ = reason;
  changed_.notify_all();
}

void FrameMailbox::find() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (lost_) ++counts_.reopened;
  lost_ = false;
  good_until_s_ = now_s();
}

double FrameMailbox::age_s() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return age_locked_s();
}

double FrameMailbox::age_locked_s() const {
  return std::max(0.0, now_s() - good_until_s_);
}

}  // namespace planar
