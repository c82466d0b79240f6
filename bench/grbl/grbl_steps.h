#pragma once

#include <filesystem>
#include <string>

namespace planar {

/// Sends real firmware random moves and compares the steps that its stepper interrupt has made with
/// those commanded. A simulator that stops on its way is started anew, and the moves of that piece
/// do not count. Returns whether so many moves were made, all with the right steps.
bool compare_steps(const std::string& name, const std::filesystem::path& simulator, int moves);

}  // namespace planar
