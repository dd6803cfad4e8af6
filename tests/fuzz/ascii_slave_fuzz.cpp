// A ASCII slave on a line where anything is said; what is checked stands in serial_slave.hpp.
#include "serial_slave.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace takt;
    fuzz::SerialSlaveScript(wire::Framing::ascii, fuzz::Input({data, size})).play();
    return 0;
}
