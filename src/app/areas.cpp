#include "takt/app/areas.hpp"

namespace takt::app {

using wire::Area;
using wire::Function;

std::string_view area_word(Area area) {
    switch (area) {
        case Area::coil: return "coils";
        case Area::discrete_input: return "discrete";
        case Area::input_register: return "input";
        case Area::holding_register: break;
    }
    return "holding";
}

Function read_function(Area area) {
    switch (area) {
        case Area::coil: return Function::read_coils;
        case Area::discrete_input: return Function::read_discrete_inputs;
        case Area::input_register: return Function::read_input_registers;
        case Area::holding_register: break;
    }
    return Function::read_holding_registers;
}

}  // namespace takt::app
