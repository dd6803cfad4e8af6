#include "takt/timing/latency_statistics_definitions.hpp"

namespace takt::timing {

template class BasicLatencyStatistics<Histogram>;

}  // namespace takt::timing
