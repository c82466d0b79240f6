#pragma once

#include "support/defective_lamp.h"
#include "support/rendered_lamp.h"

namespace planar::bench {

/// Least standard deviation, per axis in pixels, that an unbiased centre of this lamp can have when
/// centre, both axes with their direction (three numbers) and both levels are unknown: the root of
/// half the trace of the inverse Fisher information, noise as expose() has it and 1/12 for the
/// rounding. Pixels clipped at 255 say nothing.
double cramer_rao_px(const test::RenderedLamp& lamp, double background, const test::Sensor& sensor);

}  // namespace planar::bench
