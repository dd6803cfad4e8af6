// A slave (RTU) on a line with arbitrary bytes; serial_slave.hpp has the checks.
#include "serial_slave.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace takt;
    fuzz::SerialSlaveScript(wire::Framing::rtu, fuzz::Input({data, size})).play();
    return 0;
}
