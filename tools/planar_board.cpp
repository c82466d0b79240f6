#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/paper/drawings.h"
#include "program.h"

namespace planar {
namespace {

constexpr char kTool[] = "tool";

const ProgramText kText{
    "planar-board",
    "planar-board circles|acircles|chessboard:COLSxROWS:PITCHmm [--page A4|A3|WIDTHxHEIGHTmm]\n"
    "                    -o board.svg|board.pdf\n"
    "       planar-board tool --cell cell.yaml [--reflector-mm X,Y] [--ball-mm D] [--page PAGE]\n"
    "                    -o mount.svg|mount.pdf",
    R"(page                210 x 297 mm
board               11 x 11 dots, 15 mm apart
dots                6 mm wide
rulers              100 and 100 mm)"};

struct Options {
  std::string what, page;
  std::filesystem::path output, cell;
  std::vector<double> reflector_mm{0.0, -20.0};
  double ball_mm{38.1};
};

void add_options(CLI::App& app, Options& options) {
  add_required(
      app, "board", options.what, "BOARD|tool",
      "a board, such as circles:11x11:50mm (count dots, or a chessboard's inner corners), or "
      "the word tool");
  add_required(app, "-o,--out", options.output, "FILE.svg|FILE.pdf", "the drawing to write");
  add_value(app, "--page", options.page, "PAGE",
            "A4, A3 or WIDTHxHEIGHTmm; by default just as large as needed");
  CLI::Option* cell = add_value(app, "--cell", options.cell, "cell.yaml",
                                "the cell whose tool is drawn, by its `lamps`");
  add_default(
      app, "--reflector-mm", options.reflector_mm, "X,Y",
      "the reflector beside the end point: x along the arrow from lamp 1 to lamp 2, y to its "
      "left as seen from above")
      ->delimiter(',')
      ->expected(2)
      ->check(within(-1000.0, 1000.0))
      ->needs(cell);
  add_default(app, "--ball-mm", options.ball_mm, "D", "diameter of the reflector")
      ->check(within(1.0, 200.0))
      ->needs(cell);
}

Outcome draw_tool(const Options& options, PageFormat format) {
  if (options.cell.empty())
    throw InputError(Refusal{"tool needs --cell", "name the cell whose lamps are to be mounted"});
  const ToolMount mount{
      read_cell(options.cell).lamps.layout,
      Eigen::Vector2d(options.reflector_mm[0], options.reflector_mm[1]) * kMillimetre,
      options.ball_mm * kMillimetre};
  const ToolPage drawn = tool_page(mount, options.page);
  write_file(options.output, page_text(drawn.page, format));
  return told(tool_page_list(drawn));
}

Outcome draw_board(const Options& options, PageFormat format) {
  if (!options.cell.empty())
    throw InputError(Refusal{"--cell is for the word tool", "leave it out to draw a board"});
  const BoardPage drawn = board_page(options.what, options.page);
  write_file(options.output, page_text(drawn.page, format));
  return told(board_page_list(drawn));
}

Outcome draw(const Options& options) {
  const PageFormat format = page_format(options.output);
  require_writable(options.output, kPaperKind);
  return options.what == kTool ? draw_tool(options, format) : draw_board(options, format);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::draw);
}
