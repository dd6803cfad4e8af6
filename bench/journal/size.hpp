// Bytes of a sample in the journal.
#pragma once

#include <string>
#include <vector>

#include "plant.hpp"

namespace takt::bench {

struct Size {
    std::string plant;            ///< variables and rate
    double samples_a_record = 0;  ///< mean
    std::vector<double> bytes;    ///< of a sample, by Kind; record, names and checksum included
};

[[nodiscard]] std::vector<Size> measure_sizes();

}  // namespace takt::bench
