#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace planar {

/// A serial port of this machine whose other end is held here. It has a name of its own that
/// outlasts the line, as the names under /dev/serial/by-id do.
class PtyPort {
 public:
  /// `name` is where to put the link to the port; an earlier link is replaced. Throws InputError
  /// when that is impossible or a file is there.
  explicit PtyPort(std::filesystem::path name) : name_(std::move(name)) { plug_in(); }
  ~PtyPort() { unplug(); }
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;

  std::string name() const { return name_.string(); }
  /// Returns what has come within the time; empty when nothing has, or the line is closed.
  std::string read(double timeout_s);
  void write(std::string_view bytes);
  /// Returns this side's descriptors, for a program that is to speak on the line.
  int inner() const { return inner_; }
  int outer() const { return outer_; }

  /// Ends the line, as by unplugging, and plugs in another one.
  void unplug();
  void plug_in();

 private:
  std::filesystem::path name_;
  int inner_{-1}, outer_{-1};
};

}  // namespace planar
