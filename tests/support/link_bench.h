#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "support/eventually.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar::test {

using LinkTargets = std::array<std::int32_t, 3>;

inline void make_ready(LinkedDrives& drives) {
  drives.energize();
  for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
}

inline bool all_rest(LinkedDrives& drives) {
  return eventually([&] { return !drives.status()[0].moving; });
}

inline LinkTargets positions(LinkedDrives& drives) {
  const auto status = drives.status();
  return {status[0].position_pulses, status[1].position_pulses, status[2].position_pulses};
}

/// Lets a socket listen on a free port of this computer alone, and returns the port.
inline int listening_port(int listener) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(bind(listener, reinterpret_cast<sockaddr*>(&address), size) == 0);
  REQUIRE(listen(listener, 8) == 0);
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

/// Returns how many faults a test injects: as many as LINK_FAULTS says, or `few`.
inline int faults_to_inject(int few) {
  const char* const wanted = std::getenv("LINK_FAULTS");
  return wanted != nullptr ? std::atoi(wanted) : few;
}

/// What became of an arm that a fault has struck.
struct Struck {
  std::string said;    ///< the first fault that was told, or nothing
  bool rests{false};   ///< as far as it is known
  bool certain{true};  ///< its positions
};

/// Waits for the end of a move that something strikes, and for a rest.
inline Struck wait_for_fault(LinkedDrives& drives) {
  Struck struck;
  struck.rests = eventually([&] {
    const auto status = drives.status();
    for (const DriveStatus& drive : status)
      if (struck.said.empty() && !drive.faults.empty()) struck.said = drive.faults.front();
    return !status[0].moving;
  });
  for (const DriveStatus& drive : drives.status()) {
    struck.certain = struck.certain && drive.position_certain;
    if (struck.said.empty() && !drive.faults.empty()) struck.said = drive.faults.front();
  }
  return struck;
}

/// Writes the paper's cell with drives of these keys, one text for each joint.
inline std::filesystem::path cell_with_drives(const TemporaryFolder& folder,
                                              const std::array<std::string, 3>& drives) {
  std::string text = read_file(paper_cell_file());
  const auto change = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
  };
  change("source: virtual",
         "source: aravis, id: x, exposure_us: 1000, gain_db: 0, pixel_format: Mono8, trigger: "
         "software, packet_size: 1500");
  for (const std::string& keys : drives)
    change("kind: virtual,", "home: {reference: taught, at_deg: 10}, " + keys + ",");
  return folder.write("cell.yaml", text);
}

}  // namespace planar::test
