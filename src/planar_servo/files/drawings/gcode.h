#pragma once

#include <string>
#include <string_view>

#include "planar_servo/files/drawings/drawing.h"

namespace planar {

/// Returns whether a text begins as such programs do: with %, a comment in brackets or behind a
/// semicolon, or a word of G, M, N or F.
bool is_gcode(std::string_view text);

/// Reads a program in G-code [NIST RS-274]: G0 to G3 with I J or R, G4 P (seconds), G17, G20, G21,
/// G90, G91, F, M0 as an end, M1, M2, M30, N, comments and %. Its motions are one stroke, and the
/// ends of them points. Without G20 and G21 numbers are millimetres. Words that set what holds
/// anyway (G40, G49, G54, G80, G94) are taken. Throws InputError naming SOURCE:LINE of everything
/// else.
Drawing read_gcode(const std::string& text, const std::string& source);

}  // namespace planar
