#include "planar_servo/offline/page_of_file.h"

#include <fmt/format.h>

#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace fs = std::filesystem;

void doubt_left_out(std::size_t left_out, std::size_t all, const std::string& words,
                    Verdict& verdict) {
  constexpr double kFew = 0.05;
  if (static_cast<double>(left_out) > kFew * static_cast<double>(all))
    verdict.doubt(
        fmt::format("{} of {} {} left out", left_out, all, words),
        "look at what was recorded of those that are named below, and record these places "
        "again");
}

HtmlPage page_about(const std::string& what, const fs::path& file, const Verdict& verdict) {
  HtmlPage page(what + ": " + file.filename().string());
  page.add_verdict(verdict);
  return page;
}

std::string ended_page(HtmlPage page, const ReportList& found, const fs::path& file,
                       const std::optional<std::vector<InputRecord>>& inputs) {
  page.add_heading("In numbers");
  page.add_html(found.html("What was found"));
  ReportList list;
  const auto add = [&](const std::string& name, const std::string& sha256) {
    list.row("files", {{"file", name}, {"SHA-256", sha256}});
  };
  add(file.filename().string() + ", shown here", content_sha256(file));
  for (const InputRecord& input : inputs ? *inputs : input_records(read_origins(file)))
    add(input.name, input.sha256);
  list.show("files", "Files");
  page.add_html("<details><summary>What this page was made from</summary>\n" +
                list.table_html("files") + "</details>\n");
  return page.text();
}

}  // namespace planar
