#pragma once

#include <string>

namespace planar {

// The parts of a new cell file, in their order.

extern const char* const kNewCellHead;
extern const char* const kNewVirtualCamera;
extern const char* const kNewRealCamera;
extern const char* const kNewCellMiddle;
/// Returns the beginning of an item of `drives`. Joints count from 1.
std::string new_drive_head(int joint, const std::string& kind);
extern const char* const kNewMotor;
extern const char* const kNewServo;
extern const char* const kNewVirtualTracker;
extern const char* const kNewRealTracker;
extern const char* const kNewCellTail;
extern const char* const kNewTruth;

}  // namespace planar
