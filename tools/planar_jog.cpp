#include "jog_session.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/jog/arm_command.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-jog",
    "planar-jog --cell cell.yaml [--teach targets.csv]\n"
    "       printf 'enable\\njoint 2 -10\\nteach A\\n' | planar-jog --cell cell.yaml --teach "
    "targets.csv",
    "joints 0.000 70.000 10.000 deg, end point (402.605, -281.908) mm, phi -10.000 deg\n"
    "taught A at (401.981, -284.091) mm as seen"};

struct Options {
  std::filesystem::path cell, teach;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_value(app, "--teach", options.teach, "targets.csv",
            "table of targets to append taught places to");
  app.footer(std::string("Commands, one a line:\n") + arm_command_help() +
             "\nAt a terminal Enter stops an arm that moves. In a pipe the first failure ends it.");
}

Outcome jog(const Options& options) {
  return jog_by_lines(read_cell(options.cell), options.teach);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::jog);
}
