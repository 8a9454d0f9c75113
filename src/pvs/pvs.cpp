#include <antumbra/pvs.hpp>
