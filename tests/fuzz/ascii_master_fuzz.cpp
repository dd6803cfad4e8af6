// A master (ASCII) with devices that answer arbitrary bytes; master.hpp has the checks.
#include "master.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace takt;
    fuzz::MasterScript(wire::Framing::ascii, fuzz::Input({data, size})).play();
    return 0;
}
