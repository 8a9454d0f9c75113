#include "evaluate/item_buffer.hpp"
