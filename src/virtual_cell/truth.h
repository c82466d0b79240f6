#pragma once

// Filled by the room's author: struct Truth, what the virtual cell is in reality.
