#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "planar_servo/io/claims.h"

namespace planar {

/// The rows of a campaign in one file of JSON lines, which several programs fill at the same time.
/// The first line says what the campaign is made with; every other one holds the figures of a seed
/// and the seed under `seed`, in the order in which they were found.
class CampaignRows {
 public:
  /// Begins the file, or goes on with it and cuts off a torn last line. Throws InputError when it
  /// was begun with something else, naming what differs, and when it is no file of a campaign.
  CampaignRows(const std::filesystem::path& file, const nlohmann::json& made_with);

  /// Returns whether a seed has its row, from whichever program.
  bool has(std::uint32_t seed);
  /// Returns the right to add the row of a seed, or nothing when another program has it.
  std::optional<Claim> try_claim(std::uint32_t seed) { return claims_.try_claim(seed); }
  /// The same; waits until no other program has it.
  Claim claim(std::uint32_t seed) { return claims_.claim(seed); }

  /// Adds the row of a seed. Throws WorkError when it cannot be written.
  void append(std::uint32_t seed, nlohmann::json figures);

  /// Returns every row read so far, by seed.
  const std::map<std::uint32_t, nlohmann::json>& rows() const { return rows_; }

 private:
  void read_new_rows();
  void take_line(const std::string& line);

  std::filesystem::path file_;
  Claims claims_;
  std::size_t read_{0};  ///< bytes, which end with a whole line
  std::size_t lines_{0};
  std::map<std::uint32_t, nlohmann::json> rows_;
};

}  // namespace planar
