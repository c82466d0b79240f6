#include "planar_servo/experiment/campaign.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <numeric>
#include <system_error>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr double kConfidence = 0.95;

struct CampaignColumn {
  const char* title;
  const char* key;  ///< a key of experiment_list(), or of its part `part`
  const char* part{nullptr};
};

constexpr CampaignColumn kColumns[] = {
    {"before", "before_mean_mm_truth", "paper_chain"},
    {"paper's chain", "after_mean_mm_truth", "paper_chain"},
    {"ours", "after_mean_mm_truth"},
    {"ours, 95 %", "after_p95_mm_truth"},
    {"ours, max", "after_max_mm_truth"},
    {"predicted", "predicted_mean_mm"},
    {"predicted, 95 %", "predicted_p95_mm"},
};

double value_of(const nlohmann::json& row, const CampaignColumn& column) {
  return (column.part ? row.at(column.part) : row).at(column.key).get<double>();
}

std::vector<double> values_of(const std::vector<nlohmann::json>& rows,
                              const CampaignColumn& column) {
  return each(rows, [&](const nlohmann::json& row) { return value_of(row, column); });
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

std::string four_decimals(double value) {
  return fmt::format("{:.4f}", value);
}

std::string interval_text(const std::vector<double>& values) {
  const auto interval = median_interval(values, kConfidence);
  return interval ? fmt::format("{:.4f} to {:.4f}", interval->first, interval->second) : "–";
}

TextTable campaign_table(const std::vector<nlohmann::json>& rows) {
  ReportList list;
  const auto add = [&list](const std::string& name, const auto& text_of) {
    ReportList& row = list.row("cells");
    row.line("drawn cell", name);
    for (const CampaignColumn& column : kColumns) row.line(column.title, text_of(column));
  };
  for (const nlohmann::json& row : rows)
    add(fmt::format("seed {}", row.at("seed").get<std::uint32_t>()),
        [&](const auto& column) { return four_decimals(value_of(row, column)); });
  add("median", [&](const auto& of) { return four_decimals(median(values_of(rows, of))); });
  add("95 % interval of the median",
      [&](const auto& of) { return interval_text(values_of(rows, of)); });
  add("worst", [&](const auto& of) { return four_decimals(largest(values_of(rows, of))); });
  list.show("cells", "True positioning error in mm, mean of the control targets");
  return list.table("cells");
}

bool is_sum(const std::string& key) {
  return key == "targets" || key == "reached";
}

bool is_number_in_all(const std::string& key, const std::vector<nlohmann::json>& rows) {
  return std::all_of(rows.begin(), rows.end(), [&](const nlohmann::json& row) {
    return row.contains(key) && row[key].is_number();
  });
}

/// Returns the errors of one cell in words.
std::string campaign_row_text(const nlohmann::json& row) {
  std::vector<std::string> figures;
  for (const CampaignColumn& column : kColumns)
    figures.push_back(fmt::format("{} {}", column.title, four_decimals(value_of(row, column))));
  return fmt::format("{} mm", fmt::join(figures, "; "));
}

/// These locks belong to the opened file and not to the process, so that nobody else who closes the
/// same file in this program gives them back.
int set_lock(int file, std::uint64_t piece, short kind, bool wait) {
  struct flock range {};
  range.l_type = kind;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(piece);
  range.l_len = 1;
  while (fcntl(file, wait ? F_OFD_SETLKW : F_OFD_SETLK, &range) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

constexpr char kRowFormat[] = "planar-servo/campaign/1";
constexpr char kFirstRow[] = "{\"format\":\"planar-servo/campaign/1\"";  // as it begins
/// Claimed to write to the file: a number beyond all seeds.
constexpr std::uint64_t kWriting = std::uint64_t{1} << 32;

std::string line_of(const nlohmann::json& json) {
  return json.dump() + "\n";
}

nlohmann::json run_drawn_cell(const ExperimentRequest& request, std::uint32_t seed,
                              DrawTruth draw) {
  ExperimentRequest drawn = request;
  drawn.seed = seed;
  drawn.out = request.out / fmt::format("seed_{}", seed);
  fs::remove_all(drawn.out);
  make_folder(drawn.out);
  drawn.cell.truth = drawn.out / "truth.yaml";
  write_truth(*drawn.cell.truth, draw(seed));
  const auto devices = open_cell(drawn.cell);
  nlohmann::json figures = experiment_list(run_experiment(drawn, *devices)).json();
  fs::remove_all(drawn.out);
  return figures;
}

/// Throws unless the cell file names reference lamps where cells of this kind have them.
void require_same_lamps(const CellSettings& cell, const Truth& truth, const char* kind) {
  const bool drawn = !truth.reference_lamps.empty();
  if (drawn != cell.reference_lamps.empty()) return;
  throw InputError(
      {fmt::format("names {} reference_lamps, while cells of the kind {} have {}",
                   drawn ? "no" : "some", kind, drawn ? "some" : "none"),
       fmt::format("give the cell.yaml that planar-virtual-cell draw --like {} writes", kind),
       cell.file, Cause::kForeign});
}

/// Throws unless a drawn cell has about the links and the sensor that the cell file states.
void require_same_machine(const CellSettings& cell, const Truth& drawn) {
  constexpr double kAbout = 0.1;
  const Eigen::Vector2d links_m(drawn.arm.link_lengths_m.data());
  const Eigen::Vector2d sensor_px(cell.camera.width_px, cell.camera.height_px);
  const Eigen::Vector2d& stated_m = cell.arm.geometry.link_lengths_m;
  if ((links_m - stated_m).norm() < kAbout * stated_m.norm() &&
      (2.0 * drawn.camera.center_px - sensor_px).norm() < kAbout * sensor_px.norm())
    return;
  throw InputError(
      {fmt::format("states links of {:.0f} and {:.0f} mm and a sensor of {} x {} px; the cells "
                   "that --seeds draws have links of about {:.0f} and {:.0f} mm and a sensor of "
                   "about {:.0f} x {:.0f} px",
                   mm(stated_m[0]), mm(stated_m[1]), cell.camera.width_px, cell.camera.height_px,
                   mm(links_m[0]), mm(links_m[1]), 2.0 * drawn.camera.center_px.x(),
                   2.0 * drawn.camera.center_px.y()),
       "give a cell.yaml such as planar-virtual-cell draw writes", cell.file, Cause::kForeign});
}

}  // namespace

nlohmann::json campaign_json(const std::vector<nlohmann::json>& rows) {
  nlohmann::json json{{"seeds", rows.size()}, {"cells", rows}};
  nlohmann::json intervals = nlohmann::json::object();
  for (const auto& item : rows.front().items()) {
    const std::string& key = item.key();
    if (key == "seed" || !is_number_in_all(key, rows)) continue;
    const std::vector<double> values = values_of(rows, {"", key.c_str()});
    json[key] = is_sum(key) ? std::accumulate(values.begin(), values.end(), 0.0) : median(values);
    const auto interval = median_interval(values, kConfidence);
    if (interval && !is_sum(key)) intervals[key] = {interval->first, interval->second};
  }
  json["median_95"] = std::move(intervals);
  json["worst_after_mean_mm_truth"] = largest(values_of(rows, {"", "after_mean_mm_truth"}));
  return json;
}

std::string campaign_text(const std::vector<nlohmann::json>& rows) {
  return campaign_table(rows).plain_text();
}

std::string campaign_page(const std::vector<nlohmann::json>& rows, const std::string& cell_name) {
  HtmlPage page(
      fmt::format("The paper's experiment on {} cells drawn like {}", rows.size(), cell_name));
  page.add_html(campaign_table(rows).html());
  return page.text();
}

Claims::Claims(const std::filesystem::path& file)
    : path_(file), file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (file_ < 0)
    throw InputError(
        {"cannot be opened to read and write: " + std::generic_category().message(errno),
         "name a place where you may write", file, Cause::kSystem});
}

Claims::~Claims() {
  close(file_);
}

Claim Claims::claim(std::uint64_t piece, bool waits) {
  const int fault = set_lock(file_, piece, F_WRLCK, waits);
  if (fault == EAGAIN || fault == EACCES) return nullptr;
  if (fault != 0)
    throw InputError({"its file system has no locks, by which programs share work (" +
                          std::generic_category().message(fault) + ")",
                      "name a place on another one", path_, Cause::kSystem});
  return {this, [file = file_, piece](const void*) { set_lock(file, piece, F_UNLCK, false); }};
}

CampaignRows::CampaignRows(const std::filesystem::path& file, const nlohmann::json& made_with)
    : file_(file), claims_(file) {
  const Claim writing = claims_.claim(kWriting);
  drop_torn_line(file_, kFirstRow);
  const std::string text = read_file(file_);
  const std::string begun = text.substr(0, text.find('\n'));
  const nlohmann::json present{{"format", kRowFormat}, {"made_with", made_with}};
  if (begun.empty()) {
    GrowingFile(file_, "").append(line_of(present));
  } else {
    const nlohmann::json first = nlohmann::json::parse(begun, nullptr, false);
    if (!first.is_object() || first.value("format", "") != kRowFormat ||
        !first.contains("made_with"))
      throw InputError(
          {fmt::format("does not begin as the rows of a campaign do, with the format {}",
                       kRowFormat),
           "name another folder", file_, Cause::kForeign});
    require_same_making(file_, first["made_with"], made_with);
  }
  read_new_rows();
}

bool CampaignRows::has(std::uint32_t seed) {
  if (rows_.count(seed) == 0) read_new_rows();
  return rows_.count(seed) != 0;
}

void CampaignRows::append(std::uint32_t seed, nlohmann::json figures) {
  figures["seed"] = seed;
  const Claim writing = claims_.claim(kWriting);
  drop_torn_line(file_, kFirstRow);
  GrowingFile(file_, "").append(line_of(figures), Durability::kPowerLoss);
  read_new_rows();
}

void CampaignRows::read_new_rows() {
  const std::string all = read_file(file_);
  const std::string text = all.substr(std::min(read_, all.size()));
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    if (lines_++ > 0) take_line(text.substr(begin, end - begin));
    read_ += end + 1 - begin;
  }
}

void CampaignRows::take_line(const std::string& line) {
  nlohmann::json row = nlohmann::json::parse(line, nullptr, false);
  if (!row.is_object() || !row.contains("seed") || !row["seed"].is_number_unsigned())
    throw InputError({"is no row of a campaign, an object of JSON with the number 'seed'",
                      "remove the line to have its seed run again",
                      fmt::format("{}:{}", file_.string(), lines_)});
  const auto seed = row["seed"].get<std::uint32_t>();
  rows_.emplace(seed, std::move(row));
}

std::vector<nlohmann::json> work_through(
    CampaignRows& rows, const SeedRange& seeds,
    const std::function<nlohmann::json(std::uint32_t seed)>& experiment) {
  const auto seed_at = [&](int i) { return seeds.first + static_cast<std::uint32_t>(i); };
  for (const bool waits : {false, true})
    for (int i = 0; i < seeds.count; ++i) rows.find(seed_at(i), waits, experiment);
  std::vector<nlohmann::json> found;
  found.reserve(static_cast<std::size_t>(seeds.count));
  for (int i = 0; i < seeds.count; ++i) found.push_back(rows.rows().at(seed_at(i)));
  return found;
}

std::vector<nlohmann::json> run_campaign(const ExperimentRequest& request, const SeedRange& seeds,
                                         DrawTruth draw) {
  if (!request.cell.camera.kind->is_virtual())
    throw InputError({"is no virtual cell", "--seeds draws virtual cells: name one of their kind",
                      request.cell.file});
  const Truth first = draw(seeds.first);
  require_same_lamps(request.cell, first, name_in(kCellKinds, draw));
  require_same_machine(request.cell, first);
  if (fs::exists(request.out / "recording"))
    throw InputError({"holds a single experiment", "name another folder for the campaign",
                      request.out, Cause::kForeign});
  make_folder(request.out);
  nlohmann::json making = making_of_campaign(request);
  making["like"] = name_in(kCellKinds, draw);
  CampaignRows rows(request.out / "rows.jsonl", making);
  return work_through(rows, seeds, [&](std::uint32_t seed) {
    nlohmann::json figures = run_drawn_cell(request, seed, draw);
    spdlog::info(fmt::format("seed {}: {}", seed, campaign_row_text(figures)));
    return figures;
  });
}

}  // namespace planar
