#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

// `rows` are the figures of experiment_list() with their `seed`, at least one.

/// Returns the median over the cells of every key that is a number in each; `targets` and `reached`
/// are sums instead. Beside them stand the worst mean, under `median_95` the distribution-free 95 %
/// interval of every median as far as there are enough cells, and under `cells` the rows.
nlohmann::json campaign_json(const std::vector<nlohmann::json>& rows);

/// Returns a row for each cell, the median with its interval and the worst.
std::string campaign_text(const std::vector<nlohmann::json>& rows);
std::string campaign_page(const std::vector<nlohmann::json>& rows, const std::string& cell_name);

/// A piece of the work that programs share; it is held until the last copy of this is destroyed or
/// the program ends, however that ends.
using Claim = std::shared_ptr<const void>;

/// Shares numbered pieces of work among programs, on one machine or on several with a common file
/// system: piece i is a lock on byte i of a file, which need not be that long. Two objects of one
/// program share like two programs. Nothing that a program leaves behind keeps others from a piece.
class Claims {
 public:
  /// Makes the file when it is absent. Throws InputError when it cannot be opened or made.
  explicit Claims(const std::filesystem::path& file);
  ~Claims();
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;

  // Both throw InputError when the file system has no locks.
  /// Returns a piece, or null when another program has it.
  Claim try_claim(std::uint64_t piece) { return claim(piece, false); }
  /// Waits until no other program has the piece.
  Claim claim(std::uint64_t piece) { return claim(piece, true); }

 private:
  Claim claim(std::uint64_t piece, bool waits);

  std::filesystem::path path_;
  int file_;
};

/// The rows of a campaign in one file of JSON lines, which several programs fill at the same time.
/// The first line says what the campaign is made with; every other one holds the figures of a seed
/// and the seed under `seed`, in the order in which they were found.
class CampaignRows {
 public:
  /// Begins the file, or continues with it and cuts off a torn last line. Throws InputError when it
  /// was begun with something else, naming what differs, and when it is no file of a campaign.
  CampaignRows(const std::filesystem::path& file, const nlohmann::json& made_with);

  /// Returns whether a seed has its row, from whichever program.
  bool has(std::uint32_t seed);

  /// Adds the row that `experiment` finds, unless the seed has one. One that another program is
  /// working on is waited for, and found here if that program ends without it; or it is left to it.
  template <typename Experiment>
  void find(std::uint32_t seed, bool waits, const Experiment& experiment) {
    if (has(seed)) return;
    const Claim claim = waits ? claims_.claim(seed) : claims_.try_claim(seed);
    if (claim && !has(seed)) append(seed, experiment(seed));
  }
  /// Adds the row of a seed. Throws WorkError when it cannot be written.
  void append(std::uint32_t seed, nlohmann::json figures);

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

/// The seeds of a campaign: `first`, `first` + 1, ...
struct SeedRange {
  std::uint32_t first{1};
  int count{1};
};

/// Has every seed's row added, in whatever order programs that share the campaign come to the
/// seeds, and returns the rows in the order of the seeds. `experiment` finds the figures of a seed
/// that has no row yet and that no other program is working on. What another program has begun is
/// waited for, and done here if that program ends without its row. Throws what `experiment` throws.
std::vector<nlohmann::json> work_through(
    CampaignRows& rows, const SeedRange& seeds,
    const std::function<nlohmann::json(std::uint32_t seed)>& experiment);

/// Runs the experiment on virtual cells that differ from the request's in their truth alone, which
/// `draw` of kCellKinds draws from the seeds; request.seed is not used. Rows go to `rows.jsonl` in
/// request.out. The folder `seed_N` of a cell, with a recording of about a gigabyte, lasts until
/// its row is there; what a killed program left of it is begun anew, so that the rows do not depend
/// on who found them and when. Throws what run_experiment() throws, and InputError when the folder
/// holds something else, or rows of another kind, when either the cell file or the kind alone has
/// reference lamps, and when the cell's links or sensor are not about those of the kind.
std::vector<nlohmann::json> run_campaign(const ExperimentRequest& request, const SeedRange& seeds,
                                         DrawTruth draw);

}  // namespace planar
