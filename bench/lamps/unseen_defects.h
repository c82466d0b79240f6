#pragma once

#include <vector>

#include "lamps/lamp_families.h"

namespace planar::bench {

/// Returns lamps with defects that were written without being tried on the method that they judge:
/// - scratched: a dark scratch across the disc and specks of dust on it;
/// - reflection: a second, dimmer disc of another size over part of the rim;
/// - smeared: moved along a line during the exposure; its centre is that of the middle of the move.
std::vector<LampFamily> unseen_families();

}  // namespace planar::bench
