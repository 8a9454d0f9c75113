#include "rays/arbiter.hpp"
