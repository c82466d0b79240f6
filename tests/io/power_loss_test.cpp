#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <map>

#include "planar_servo/base/io/atomic_file.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

ino_t inode_of(const fs::path& path) {
  struct stat status {};
  stat(path.c_str(), &status);
  return status.st_ino;
}

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What a disk holds for sure: of each file what it held when it was last synced, and the names
/// that a folder had when it was.
struct Disk {
  std::map<ino_t, std::string> files;
  std::map<fs::path, std::map<std::string, ino_t>> folders;

  void sync(const fs::path& path) {
    if (!fs::is_directory(path)) {
      files[inode_of(path)] = text_of(path);
      return;
    }
    auto& names = folders[path] = {};
    for (const auto& entry : fs::directory_iterator(path))
      names[entry.path().filename().string()] = inode_of(entry.path());
  }
  bool has(const fs::path& path) const {
    const auto folder = folders.find(path.parent_path());
    return folder != folders.end() && folder->second.count(path.filename().string()) != 0;
  }
  /// Returns what a file holds after a loss of power: nothing where it was never synced.
  std::string after_loss(const fs::path& path) const {
    REQUIRE(has(path));
    const auto file = files.find(folders.at(path.parent_path()).at(path.filename().string()));
    return file == files.end() ? "" : file->second;
  }
};

Disk disk;

}  // namespace
}  // namespace planar

/// Stands in for the one of the C library in this program.
extern "C" int fsync(int file) {
  planar::disk.sync(planar::fs::read_symlink("/proc/self/fd/" + std::to_string(file)));
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace planar {
namespace {

TEST_CASE("After a loss of power a file that was written is there, and whole") {
  const test::TemporaryFolder folder;
  const std::string first = "format: planar-servo/map/1\na: 1\n";
  const std::string second = "format: planar-servo/map/1\na: 2\n";
  write_file(folder / "map.yaml", first);
  CHECK(disk.after_loss(folder / "map.yaml") == first);
  write_file(folder / "map.yaml", second);
  CHECK(disk.after_loss(folder / "map.yaml") == second);
}

TEST_CASE("After a loss of power a row that was to last is there, with all before it") {
  const test::TemporaryFolder folder;
  make_folder(folder / "a/run");
  GrowingFile table(folder / "a/run/results.csv", "id\n");
  CHECK(disk.after_loss(folder / "a/run/results.csv") == "id\n");
  table.append("a\n");
  CHECK(disk.after_loss(folder / "a/run/results.csv") == "id\n");
  table.append("b\n", Durability::kPowerLoss);
  CHECK(disk.after_loss(folder / "a/run/results.csv") == "id\na\nb\n");
  CHECK(disk.has(folder / "a"));
  CHECK(disk.has(folder / "a/run"));
}

}  // namespace
}  // namespace planar
