#include "takt/base/histogram_definitions.hpp"

namespace takt {

template class BasicHistogram<7, 40, 1, FixedCounts>;

}  // namespace takt
