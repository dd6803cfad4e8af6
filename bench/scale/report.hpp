// Prints the measurements as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "measure.hpp"
#include "program.hpp"

namespace takt::bench {

void print(std::size_t devices, const ScaleMeasured& m);
void print(const ProgramMeasured& m);
nlohmann::json to_json(std::size_t devices, const ScaleMeasured& m);
nlohmann::json to_json(const ProgramMeasured& m);

}  // namespace takt::bench
