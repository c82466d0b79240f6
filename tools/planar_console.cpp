#include "planar_servo/console/console.h"

#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-console", "planar-console --cell cell.yaml [--port N]",
                        R"(to operate: http://127.0.0.1:8377/?token=1f0c5a9e
to look on: http://127.0.0.1:8377/?token=8b2d7741
Ctrl-C ends it)"};

struct Options {
  std::filesystem::path cell;
  int port{8377};
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_value(app, "--port", options.port, "N",
            "port of 127.0.0.1 on which the page is served; 0 takes a free one")
      ->check(within(0, 65535))
      ->capture_default_str();
}

Outcome serve(const Options& options) {
  heed_interrupts();
  Console console(options.cell, options.port, interrupted);
  const ConsoleAddresses addresses = console.addresses();
  say("to operate: {}\nto look on: {}\nCtrl-C ends it\n", addresses.operate, addresses.read);
  std::fflush(stdout);
  console.serve();
  return {};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::serve);
}
