#include <antumbra/bake.hpp>
