#pragma once

#include <stdexcept>
#include <string>

namespace planar {

/// Names a program and says in one sentence what it does: `planar NAME` runs planar-NAME.
struct Command {
  const char* name;
  const char* sentence;
};

/// Lists the programs in the order of the work.
constexpr Command kCommands[] = {
    {"next", "Says what of a cell's work is done, what is next, and the command for it."},
    {"doctor", "Checks a cell's file and devices and says how to mend each fault."},
    {"board",
     "Draws a calibration board, or where lamps and reflector go on the tool, to print at true "
     "scale."},
    {"jog", "Moves a cell by hand: enables, homes, jogs, shows the exposure and teaches targets."},
    {"console", "Serves a page and an API at which a cell is worked, on this computer."},
    {"plan", "Proposes where to read the tracker next, and says what accuracy to expect."},
    {"record", "Drives a cell through a plan and records frames and tracker readings."},
    {"calibrate-camera", "Calibrates a camera from pictures of a flat grid of dots or squares."},
    {"locate-lamps",
     "Finds lamps in images and measures their centres, on the cell's plane where it has one."},
    {"pair-tracker",
     "Pairs what the camera saw with what a laser tracker measured; finds workplane and tool."},
    {"fit-error-map", "Fits a map of the vision error to pairs of vision and tracker positions."},
    {"check-error-map", "Judges an error map on pairs that it was not fitted to."},
    {"export-map", "Writes an error map as a grid that other programs read."},
    {"calibrate-arm",
     "Finds links, zeros and eccentricities of an arm from a tracker's readings of its tool."},
    {"check-cell",
     "Moves a little, visits places of the calibration again, and says what has changed since."},
    {"find-work",
     "Finds a workpiece by its marks, so that targets and paths may be those of its drawing."},
    {"teach-tool",
     "Finds where a tool's tip is, by bringing it to one mark in several directions, and whether "
     "it still is there."},
    {"servo",
     "Positions the end point at targets, or leads it along a path, by vision and logs every "
     "step."},
    {"certify",
     "Says how accurate a calibrated cell is, by ISO 9283 and over its workspace, on a page to "
     "sign."},
    {"virtual-cell", "Makes virtual cells, and serves them as real ones."},
    {"experiment",
     "Runs the paper's whole experiment on a virtual or a real cell: our chain, the paper's and "
     "ViSP's side by side."},
};

constexpr char kProgramPrefix[] = "planar-";

/// The program that runs the others, and what it does.
constexpr Command kLauncher{"planar", "Runs the programs by their names, and lists them."};

/// Returns what a program of the list does.
inline std::string sentence_of(const std::string& program) {
  if (program == kLauncher.name) return kLauncher.sentence;
  for (const Command& command : kCommands)
    if (program == std::string(kProgramPrefix) + command.name) return command.sentence;
  throw std::logic_error(program + " is not in the list of commands");
}

}  // namespace planar
