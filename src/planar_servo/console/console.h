#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace planar {

/// The addresses by which a browser on this computer opens a console, each with its token.
struct ConsoleAddresses {
  std::string operate, read;
};

/// Where a console listens. Beyond this computer it needs a certificate and its key, PEM files.
struct ConsoleListening {
  int port{0};  ///< 0 for a free one
  std::string address{"127.0.0.1"};
  std::filesystem::path certificate{}, key{};
  std::filesystem::path token_file{};  ///< see new_tokens()
  std::vector<std::string> origins{};  ///< see ConsoleSite
};

/// One program that owns a cell and serves a page and an API at which it is worked.
class Console {
 public:
  /// Opens the cell's devices and listens. `interrupted` is asked all the time. Throws InputError
  /// for a cell that cannot be used, a port that is taken, an address of other computers without a
  /// certificate, a token_file that will not do, and a cell that another console serves.
  Console(const std::filesystem::path& cell_file, const ConsoleListening& listening,
          std::function<bool()> interrupted);
  ~Console();

  ConsoleAddresses addresses() const;
  /// Answers until `interrupted` returns true. The arm is at rest then. When a step of the work has
  /// made new files, the cell is opened anew. Throws InputError where it cannot be.
  void serve();

 private:
  struct Kept;
  struct Parts;
  /// Returns true when the files are to be read anew.
  bool serve_these_files();

  std::unique_ptr<Kept> kept_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planar
