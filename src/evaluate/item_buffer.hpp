// Truth from one viewpoint: which triangle each pixel sees, by rays in strict doubles. Shares no code with any
// rasteriser, so that a projection bug cannot hide itself.
#pragma once

#include "rays/tracer.hpp"
