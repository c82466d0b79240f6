#include "planar_servo/servo/tip_sensor.h"

namespace planar {

TipMeasurement failed_look(TipStatus status, const std::string& word, double t_s) {
  TipMeasurement measurement;
  measurement.status = status;
  measurement.word = word;
  measurement.t_s = t_s;
  return measurement;
}

}  // namespace planar
