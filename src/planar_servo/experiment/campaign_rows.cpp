#include "planar_servo/experiment/campaign_rows.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <sstream>
#include <system_error>

#include "planar_servo/core/error.h"
#include "planar_servo/experiment/begun_experiment.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

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
/// What is claimed to write to the file: a number beyond all seeds.
constexpr std::uint64_t kWriting = std::uint64_t{1} << 32;

std::string line_of(const nlohmann::json& json) {
  return json.dump() + "\n";
}

}  // namespace

Claims::Claims(const std::filesystem::path& file)
    : path_(file), file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (file_ < 0)
    throw InputError(
        {"cannot be opened to read and write: " + std::generic_category().message(errno),
         "name a place where you may write", file});
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
                      "name a place on another one", path_});
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
           "name another folder", file_});
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
    throw InputError({"is no row of a campaign, an object of JSON with the number 'seed'",
                      "remove the line to have its seed run again",
                      fmt::format("{}:{}", file_.string(), lines_)});
  const auto seed = row["seed"].get<std::uint32_t>();
  rows_.emplace(seed, std::move(row));
}

}  // namespace planar
