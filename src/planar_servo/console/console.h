#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace planar {

/// The addresses by which a browser on this computer opens a console, each with its token.
struct ConsoleAddresses {
  std::string operate, read;
};

/// One program that owns a cell and serves a page and an API at which it is worked, on 127.0.0.1.
class Console {
 public:
  /// Opens the cell's devices and listens on `port`, or on a free one for 0. `interrupted` is asked
  /// all the time. Throws InputError for a cell that cannot be used, a port that is taken, and a
  /// cell that another console serves.
  Console(const std::filesystem::path& cell_file, int port, std::function<bool()> interrupted);
  ~Console();

  ConsoleAddresses addresses() const;
  /// Answers until `interrupted` returns true. The arm is at rest then.
  void serve();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planar
