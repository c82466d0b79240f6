#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <thread>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/record/recorder.h"
#include "support/line_server.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"
#include "support/tracker_player.h"

namespace planar {
namespace {

using Write = std::function<void(const std::string&)>;

/// A tracker's program beside a virtual cell: it writes lines, while the cell's own programs listen
/// to `heard` for them.
class PlayedTracker final : public Tracker {
 public:
  PlayedTracker(Tracker& truth, std::shared_ptr<Tracker> heard, Write write)
      : truth_(truth), heard_(std::move(heard)), write_(std::move(write)) {}

  TrackerAnswer measure_tool(const std::string& place) override {
    const test::TrackerPlayer player(
        [&] { return line(truth_.measure_tool(place).reading, "tool"); }, write_);
    return heard_->measure_tool(place);
  }
  TrackerAnswer measure_monument(const std::string& id) override {
    const test::TrackerPlayer player([&] { return line(truth_.measure_monument(id).reading, id); },
                                     write_);
    return heard_->measure_monument(id);
  }
  void await_tool() override {
    const test::TrackerPlayer player([&] { return line(truth_.measure_tool("").reading, "tool"); },
                                     write_);
    heard_->await_tool();
  }
  int readings_per_monument() const override { return heard_->readings_per_monument(); }

 private:
  static std::string line(const TrackerReading& reading, const std::string& name) {
    const Eigen::Vector3d p_mm = reading.p_L / kMillimetre;
    return fmt::format("{:.3f};{:.4f};{:.4f};{:.4f};{}\n", reading.t_s, p_mm.x(), p_mm.y(),
                       p_mm.z(), name);
  }

  Tracker& truth_;
  std::shared_ptr<Tracker> heard_;
  Write write_;
};

/// The devices of a virtual cell but for the tracker.
class PlayedDevices final : public CellDevices {
 public:
  PlayedDevices(const CellSettings& virtual_cell, const CellSettings& cell, const Write& write)
      : whole_(open_cell(virtual_cell)),
        tracker_(whole_->tracker(), cell.tracker.kind->open(cell), write) {}

  Clock& clock() override { return whole_->clock(); }
  FrameSource& camera() override { return whole_->camera(); }
  DriveGroup& drives() override { return whole_->drives(); }
  Tracker& tracker() override { return tracker_; }
  BoardPresenter* board_presenter() override { return whole_->board_presenter(); }
  std::shared_ptr<Judge> truth() override { return nullptr; }

 private:
  std::unique_ptr<CellDevices> whole_;
  PlayedTracker tracker_;
};

struct TrackedBench {
  test::TemporaryFolder folder;
  CellSettings virtual_cell = read_cell(test::paper_cell_file());

  CellSettings cell_with(const std::string& keys) const {
    const std::string names =
        ", columns: {t: '1', x: '2', y: '3', z: '4', id: '5'}, separator: ';', ";
    return read_cell(
        folder.write("cell.yaml", test::replaced(read_file(test::paper_cell_file()), "tracker: {",
                                                 "tracker: {" + keys + names)));
  }
  RecordRequest request(const CellSettings& cell, const std::string& name) const {
    RecordRequest request{cell, {}, folder.path() / name};
    for (int i = 0; i < 4; ++i)
      request.plan.push_back({"t" + std::to_string(i), Purpose::kTrain,
                              TipPose{0.3 * rotation2d(0.5 * i + 1.0).col(0), 0.0}});
    request.plan.push_back({"u0", Purpose::kPose, TipPose{{-0.2, 0.2}, 0.0}});
    return request;
  }
  /// Holds a recording against one with the virtual tracker.
  void require_same_pairs(const std::filesystem::path& recording) {
    const auto own = open_cell(virtual_cell);
    const RecordRequest other = request(virtual_cell, "virtual");
    record(other, *own);
    std::map<std::string, Eigen::Vector3d> read;
    for (const TrackerRow& row : read_tracker(other.recording / "tracker.csv"))
      read.emplace(row.id, row.p_L);
    const std::vector<TrackerRow> rows = read_tracker(recording / "tracker.csv");
    CHECK(rows.size() == 3 + 4 + 3);  // monuments, places, monuments
    for (const TrackerRow& row : rows) {
      CAPTURE(row.id);
      CHECK((row.p_L - read.at(row.id)).norm() < 6.0 * virtual_cell.tracker.sigma_m);
    }
    const auto frames = read_frames(recording), others = read_frames(other.recording);
    REQUIRE(frames.size() == others.size());
    for (std::size_t i = 0; i < frames.size(); ++i) CHECK(frames[i].id == others[i].id);
  }
};

TEST_CASE("A cell whose tracker writes a file is recorded as one with a virtual tracker") {
  TrackedBench bench;
  const auto file = bench.folder.write("stream.txt", "");
  const CellSettings cell = bench.cell_with("source: file, path: stream.txt");
  std::ofstream out(file, std::ios::app);
  PlayedDevices devices(bench.virtual_cell, cell,
                        [&](const auto& line) { out << line << std::flush; });
  const RecordRequest request = bench.request(cell, "file");
  CHECK(record(request, devices).skipped.empty());
  bench.require_same_pairs(request.recording);
}

TEST_CASE("A cell whose tracker serves lines on a port is recorded as one with a virtual tracker") {
  TrackedBench bench;
  test::LineServer server;
  const CellSettings cell = bench.cell_with("source: tcp, address: '" + server.address() + "'");
  std::thread accepting([&] { server.accept_one(); });
  PlayedDevices devices(bench.virtual_cell, cell, [&](const auto& line) { server.send(line); });
  accepting.join();
  const RecordRequest request = bench.request(cell, "tcp");
  CHECK(record(request, devices).skipped.empty());
  bench.require_same_pairs(request.recording);
}

}  // namespace
}  // namespace planar
