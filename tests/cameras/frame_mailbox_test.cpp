#include "planar_servo/hardware/cameras/frame_mailbox.h"

#include <catch2/catch.hpp>
#include <future>

#include "planar_servo/base/core/clock.h"
#include "support/eventually.h"

namespace planar {
namespace {

const cv::Rect kRegion{0, 0, 64, 64};
constexpr double kNoLimit_s = 1e6;
constexpr double kPatience_s = 5.0;  // far more than any hand-over takes

double now_s() {
  return SteadyClock().now_s();
}

Frame frame_at(double t_s, std::uint64_t id) {
  return {cv::Mat(kRegion.size(), CV_8UC1, cv::Scalar(7)), kRegion, t_s, id};
}

std::future<FrameResult> ask(FrameMailbox& mailbox, double timeout_s) {
  return std::async(std::launch::async, [&mailbox, timeout_s] { return mailbox.next(timeout_s); });
}

/// Waits until somebody waits for a frame.
void wait_for_wish(FrameMailbox& mailbox) {
  REQUIRE(test::eventually([&] {
    const double before_s = now_s();
    mailbox.sleep_until(before_s + 0.5, mailbox.region());
    return now_s() < before_s + 0.5;
  }));
}

TEST_CASE("A frame is handed over only when its exposure began after it was asked for") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  const double before_s = now_s();
  CHECK_FALSE(mailbox.note_good(before_s, kRegion));  // nobody asks
  auto asked = ask(mailbox, kPatience_s);
  wait_for_wish(mailbox);
  CHECK_FALSE(mailbox.note_good(before_s, kRegion));
  mailbox.deliver(frame_at(before_s, 1));
  const double after_s = now_s();
  CHECK(mailbox.note_good(after_s, kRegion));
  mailbox.deliver(frame_at(after_s, 2));
  const FrameResult result = asked.get();
  REQUIRE(result.status == FrameStatus::kOk);
  CHECK(result.frame.id == 2);
  CHECK(mailbox.counts().complete == 3);
}

/// Hands over frame 1 and keeps frame 2, which nobody has asked for yet.
void hand_over_and_keep(FrameMailbox& mailbox) {
  auto asked = ask(mailbox, kPatience_s);
  wait_for_wish(mailbox);
  mailbox.deliver(frame_at(now_s(), 1));
  REQUIRE(asked.get().status == FrameStatus::kOk);
  const double began_s = now_s();
  REQUIRE(mailbox.note_good(began_s, kRegion));
  mailbox.deliver(frame_at(began_s, 2));
}

TEST_CASE("The frame that follows is kept until it is asked for, and no later one") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  hand_over_and_keep(mailbox);
  CHECK_FALSE(mailbox.note_good(now_s(), kRegion));
  const FrameResult following = mailbox.following(0.0);
  REQUIRE(following.status == FrameStatus::kOk);
  CHECK(following.frame.id == 2);
  CHECK(mailbox.following(0.0).status == FrameStatus::kTimeout);
}

TEST_CASE("A frame that was kept serves neither a new request nor another region") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  hand_over_and_keep(mailbox);
  SECTION("from now on") {
    CHECK(mailbox.next(0.0).status == FrameStatus::kTimeout);
  }
  SECTION("of another region") {
    mailbox.ask_region(kRegion + cv::Point(8, 0));
    CHECK(mailbox.following(0.0).status == FrameStatus::kTimeout);
  }
}

TEST_CASE("A frame of a region that is no longer asked for is not handed over") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  const cv::Rect moved = kRegion + cv::Point(8, 0);
  mailbox.ask_region(moved);
  auto asked = ask(mailbox, kPatience_s);
  wait_for_wish(mailbox);
  CHECK_FALSE(mailbox.note_good(now_s(), kRegion));
  CHECK(mailbox.note_good(now_s(), moved));
  mailbox.deliver(frame_at(now_s(), 1));
  CHECK(asked.get().status == FrameStatus::kOk);
}

TEST_CASE("When no frame can be handed over, the status says why") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  CHECK(mailbox.next(0.0).status == FrameStatus::kTimeout);
  for (const FrameStatus trouble : {FrameStatus::kIncomplete, FrameStatus::kFrozen}) {
    auto asked = ask(mailbox, 0.2);
    wait_for_wish(mailbox);
    mailbox.note_bad(trouble);
    CHECK(asked.get().status == trouble);
  }
  CHECK(mailbox.counts().incomplete == 1);
  CHECK(mailbox.counts().frozen == 1);
  auto asked = ask(mailbox, kPatience_s);
  wait_for_wish(mailbox);
  mailbox.lose("the cable is out");
  CHECK(asked.get().status == FrameStatus::kLost);
}

TEST_CASE("The camera is at fault from the age limit until the next good frame") {
  constexpr double kLimit_s = 0.05;
  FrameMailbox mailbox(kRegion, kLimit_s);
  CHECK_FALSE(mailbox.fault());
  CHECK(test::eventually([&] { return mailbox.fault().has_value(); }));
  CHECK(mailbox.age_s() > kLimit_s);
  mailbox.note_bad(FrameStatus::kFrozen);
  CHECK_THAT(mailbox.fault().value_or(""),
             Catch::Contains("no good frame for") && Catch::Contains("it repeats one picture"));
  mailbox.note_bad(FrameStatus::kIncomplete);
  CHECK_THAT(mailbox.fault().value_or(""), Catch::Contains("parts of its frames are missing"));
  mailbox.note_good(now_s(), kRegion);
  CHECK_FALSE(mailbox.fault());
}

TEST_CASE("A stream that is being started is excused for its time") {
  FrameMailbox mailbox(kRegion, 0.0);
  mailbox.excuse(kPatience_s);
  CHECK_FALSE(mailbox.fault());
  CHECK(mailbox.age_s() == 0.0);
}

TEST_CASE("A lost camera is at fault, with the reason, until it is found") {
  FrameMailbox mailbox(kRegion, kNoLimit_s);
  mailbox.lose("the cable is out");
  CHECK(mailbox.fault() == std::string("the cable is out"));
  mailbox.find();
  CHECK_FALSE(mailbox.fault());
  CHECK(mailbox.counts().reopened == 1);
}

}  // namespace
}  // namespace planar
