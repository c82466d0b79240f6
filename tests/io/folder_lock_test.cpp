#include "planar_servo/base/io/atomic_file.h"

#include <catch2/catch.hpp>
#include <optional>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A folder is one program's at a time, and free again afterwards") {
  const test::TemporaryFolder folder;
  std::optional<FolderLock> first(folder.path());
  CHECK_THROWS_MATCHES(FolderLock(folder.path()), InputError,
                       Refused(Cause::kBusy, folder.path().string()));
  first.reset();
  CHECK_NOTHROW(FolderLock(folder.path()));
  CHECK(std::filesystem::is_empty(folder.path()));
  CHECK_THROWS_AS(FolderLock(folder / "absent"), InputError);
}

}  // namespace
}  // namespace planar
