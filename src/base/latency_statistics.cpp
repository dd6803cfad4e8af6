#include "takt/base/latency_statistics_definitions.hpp"

namespace takt {

template class BasicLatencyStatistics<Histogram>;

}  // namespace takt
