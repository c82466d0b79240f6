#include <algorithm>

#include "planar_servo/console/console.h"

#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-console",
    "planar-console --cell cell.yaml [--port N]\n"
    "                      [--listen ADDRESS --certificate FILE.pem --key FILE.pem]",
    R"(to operate: http://127.0.0.1:8377/?token=...
to look on: http://127.0.0.1:8377/?token=...
Ctrl-C ends it)"};

struct Options {
  std::filesystem::path cell;
  ConsoleListening listening{8377};
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_default(app, "--port", options.listening.port, "N",
              "port on which the page is served; 0 takes a free one")
      ->check(within(0, 65535));
  add_default(app, "--listen", options.listening.address, "ADDRESS",
              "address of this computer on which the page is served; others than 127.0.0.1 need a "
              "certificate and its key");
  add_value(app, "--certificate", options.listening.certificate, "FILE.pem",
            "serve by https with this certificate");
  add_value(app, "--origin", options.listening.origins, "ORIGIN",
            "address at which a proxy or tunnel shows the page, such as "
            "https://arm.example.org; may be given several times")
      ->check([](const std::string& origin) {
        const bool good = origin.rfind("http://", 0) == 0 || origin.rfind("https://", 0) == 0;
        return good && std::count(origin.begin(), origin.end(), '/') == 2
                   ? ""
                   : "'" + origin + "' is not SCHEME://HOST[:PORT] without a path";
      });
  add_value(app, "--key", options.listening.key, "FILE.pem", "the certificate's key");
}

Outcome serve(const Options& options) {
  heed_interrupts();
  Console console(options.cell, options.listening, interrupted);
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
