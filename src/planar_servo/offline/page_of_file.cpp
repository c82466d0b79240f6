#include "planar_servo/offline/page_of_file.h"

#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/report/report_list.h"

namespace planar {
namespace fs = std::filesystem;

HtmlPage page_about(const std::string& what, const fs::path& file) {
  return HtmlPage(what + ": " + file.filename().string());
}

void add_provenance(HtmlPage& page, const fs::path& file, const std::vector<InputRecord>& inputs) {
  TextTable table("Files", {"file", "SHA-256"});
  table.add_row({file.filename().string() + ", shown here", content_sha256(file)});
  for (const InputRecord& input : inputs) table.add_row({input.name, input.sha256});
  page.add_html("<details><summary>What this page was made from</summary>\n" + table.html() +
                "</details>\n");
}

void add_provenance(HtmlPage& page, const fs::path& file) {
  add_provenance(page, file, input_records(read_origins(file)));
}

}  // namespace planar
