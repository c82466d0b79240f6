#include "planar_servo/experiment/campaign/campaign_rows.h"

#include <fmt/format.h>

#include <sstream>

#include "planar_servo/core/error.h"
#include "planar_servo/experiment/begun_experiment.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

constexpr char kRowFormat[] = "planar-servo/campaign/1";
constexpr char kFirstRow[] = "{\"format\":\"planar-servo/campaign/1\"";  // as it begins
/// What is claimed to write to the file: a number beyond all seeds.
constexpr std::uint64_t kWriting = std::uint64_t{1} << 32;

std::string line_of(const nlohmann::json& json) {
  return json.dump() + "\n";
}

}  // namespace

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
          fmt::format("{}: does not begin as the rows of a campaign do, with the format {}; "
                      "name another folder",
                      file_.string(), kRowFormat));
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
  std::ifstream in = open_file(file_);
  in.seekg(static_cast<std::streamoff>(read_));
  std::ostringstream rest;
  rest << in.rdbuf();
  const std::string text = rest.str();
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    if (lines_++ > 0) take_line(text.substr(begin, end - begin));
    read_ += end + 1 - begin;
  }
}

void CampaignRows::take_line(const std::string& line) {
  nlohmann::json row = nlohmann::json::parse(line, nullptr, false);
  if (!row.is_object() || !row.contains("seed") || !row["seed"].is_number_unsigned())
    throw InputError(
        fmt::format("{}:{}: is no row of a campaign, an object of JSON with the number 'seed'; "
                    "remove the line to have its seed run again",
                    file_.string(), lines_));
  const auto seed = row["seed"].get<std::uint32_t>();
  rows_.emplace(seed, std::move(row));
}

}  // namespace planar
