#include <regex>

#include "planar_servo/base/core/error.h"
#include "planar_servo/console/console.h"

#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-console",
    "planar-console --cell cell.yaml [--listen ADDRESS[:PORT]] [--port N] [--token-file FILE]\n"
    "                      [--tls-cert FILE.pem --tls-key FILE.pem]",
    R"(to operate: http://127.0.0.1:8377/?token=...
to look on: http://127.0.0.1:8377/?token=...
Ctrl-C ends it)"};

constexpr int kPort = 8377, kMostPort = 65535;

struct Options {
  std::filesystem::path cell;
  std::string listen{"127.0.0.1"};
  std::optional<int> port;
  ConsoleListening listening;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_value(app, "--port", options.port, "N",
            "port on which the page is served; 0 takes a free one")
      ->default_str(std::to_string(kPort))
      ->check(within(0, kMostPort));
  add_default(app, "--listen", options.listen, "ADDRESS[:PORT]",
              "address of this computer on which the page is served, IPv6 in brackets; others than "
              "127.0.0.1 and [::1] need a certificate and its key");
  add_value(app, "--token-file", options.listening.token_file, "FILE",
            "operate by the token in the first line of this file, which stays the same over "
            "restarts; only its owner may read it");
  add_value(app, "--tls-cert", options.listening.certificate, "FILE.pem",
            "serve by https with this certificate");
  add_value(app, "--origin", options.listening.origins, "ORIGIN",
            "address at which a proxy or tunnel shows the page, such as "
            "https://arm.example.org; may be given several times")
      ->check([](const std::string& origin) {
        return std::regex_match(origin, std::regex("https?://[^/]*"))
                   ? ""
                   : "'" + origin + "' is not SCHEME://HOST[:PORT] without a path";
      });
  add_value(app, "--tls-key", options.listening.key, "FILE.pem", "the certificate's key");
}

/// Returns where --listen and --port say that the page is served.
ConsoleListening listening_of(const Options& options) {
  static const std::regex form(R"((\[([^\]]*:[^\]]*)\]|[^:\[\]]+)(:(\d{1,5}))?)");
  std::smatch parts;
  if (!std::regex_match(options.listen, parts, form) ||
      (parts[4].matched && std::stoi(parts[4]) > kMostPort))
    throw InputError({fmt::format("'{}' is not ADDRESS[:PORT]", options.listen),
                      "such as 192.168.7.2:8377, or [::1]:8377 for IPv6, with a port up to 65535",
                      "--listen"});
  ConsoleListening listening = options.listening;
  listening.address = parts[parts[2].matched ? 2 : 1];
  listening.port = parts[4].matched ? std::stoi(parts[4]) : options.port.value_or(kPort);
  if (listening.port != options.port.value_or(listening.port))
    throw InputError({fmt::format("names port {}, and --port {}", listening.port, *options.port),
                      "give the port once", "--listen", Cause::kContradiction});
  return listening;
}

Outcome serve(const Options& options) {
  heed_interrupts();
  Console console(options.cell, listening_of(options), interrupted);
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
