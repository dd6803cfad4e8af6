#include "takt/timing/histogram_definitions.hpp"

namespace takt::timing {

template class BasicHistogram<7, 40, 1, FixedCounts>;

}  // namespace takt::timing
