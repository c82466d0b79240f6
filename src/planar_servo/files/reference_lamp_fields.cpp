#include "planar_servo/files/reference_lamp_fields.h"

#include <fmt/format.h>

#include <fstream>
#include <locale>
#include <sstream>

#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

constexpr char kReference[] = "# reference lamp: ";

}  // namespace

void list_reference_lamps(Fields& fields, std::vector<ReferenceLamp>& lamps) {
  if (!fields.given("reference_lamps", !lamps.empty())) return;
  fields.maps("reference_lamps", lamps, [&](ReferenceLamp& lamp) {
    fields.text("id", lamp.id);
    fields.number("u_px", lamp.uv_px.x());
    fields.number("v_px", lamp.uv_px.y());
    fields.number("sigma_px", lamp.sigma_px, 1.0, Range::positive());
  });
}

std::vector<std::string> lamp_remarks(const std::vector<Origin>& origins,
                                      const std::vector<ReferenceLamp>& lamps) {
  std::vector<std::string> remarks = csv_remarks(origins);
  remarks.reserve(remarks.size() + lamps.size());
  for (const ReferenceLamp& lamp : lamps)
    remarks.push_back(fmt::format("{}{} {} {} {}", kReference, lamp.uv_px.x(), lamp.uv_px.y(),
                                  lamp.sigma_px, lamp.id));
  return remarks;
}

std::vector<ReferenceLamp> read_reference_remarks(const std::filesystem::path& path) {
  std::ifstream in = open_file(path);
  std::vector<ReferenceLamp> lamps;
  for (std::string line; std::getline(in, line) && !line.empty() && line[0] == '#';) {
    if (line.rfind(kReference, 0) != 0) continue;
    std::istringstream fields(line.substr(std::size(kReference) - 1));
    fields.imbue(std::locale::classic());
    ReferenceLamp lamp;
    if (fields >> lamp.uv_px.x() >> lamp.uv_px.y() >> lamp.sigma_px &&
        std::getline(fields >> std::ws, lamp.id))
      lamps.push_back(lamp);
  }
  return lamps;
}

}  // namespace planar
