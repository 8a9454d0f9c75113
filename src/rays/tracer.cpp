#include "rays/tracer.hpp"
