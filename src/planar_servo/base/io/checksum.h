#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "planar_servo/base/core/error.h"

namespace planar {

/// Returns the SHA-256 of the bytes [FIPS 180-4] as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);

/// Returns the SHA-256 of a file without its line `created:`, in which two identical runs differ,
/// and without those that only seal it, `checksum:` and `edited_by_hand:`. Throws InputError when
/// it cannot be read.
std::string content_sha256(const std::filesystem::path& path);

/// Returns the same for a file that has this text.
std::string content_sha256_of(const std::string& text);

/// Returns whether files of this kind are calibration files, which have a checksum.
bool has_checksum(std::string_view kind);

/// Returns the text of a calibration file with the line `checksum:` of all its other lines but
/// `created:`; a text of another kind as it is.
std::string with_checksum(const std::string& text);

/// Returns a refusal when the text of this file is no longer that of its checksum.
std::optional<Refusal> later_change(const std::filesystem::path& path, const std::string& text);

/// Throws InputError with later_change(), and says in the log when a calibration file has no
/// checksum.
void require_unchanged(const std::filesystem::path& path, const std::string& text);

/// Gives a calibration file that was edited by hand its checksum, and the line `edited_by_hand:`
/// with the time. Returns false, and leaves the file, when its checksum is right already. Throws
/// InputError for a file of another kind.
bool seal_by_hand(const std::filesystem::path& path);

}  // namespace planar
